"""Makes a boundary representation of polygons, with true surfaces for round parts. Needs OpenCASCADE."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.gp import gp_Trsf, gp_Vec
from OCP.GProp import GProp_GProps
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS_Compound, TopoDS_Face, TopoDS_Shell, TopoDS_Solid

from ..._core import Job, Mesh, Partition, PolygonMesh
from . import seams
from .faces import Edge, Edges, FaceMaker
from .given import PLANES, Given, Surfaces, area_normal
from .kernel import NoFace
from .meeting import Curve, along, meet_at, touch
from .outlines import Outlines, outlines
from .shapes import Array, Plane, Surface, Torus, Turned, unit
from .triangles import ears

_GAP = 1e-3  # share of the diagonal: largest distance of a face from its shared edges
_SHARP = 2e-5  # share of the diagonal: planes of the scan with larger gaps are replaced by planes of polygons
_VOLUME = 0.015  # largest change of the volume by true surfaces, share of the scan's volume
_EXACT = 1e-7  # share of the diagonal: places at a smaller distance are equal
_FLAT = 2e-4  # share of the diagonal: a corner between two planes that is nearer to a line is left out
_TRIES = 12


@dataclass
class Made:
    """The shape, and the surfaces of the round parts."""

    shape: Any
    faces: int
    solids: int
    valid: bool
    volume: float | None
    gap: float  #: the largest distance of an edge from a face that it bounds, scene units
    surfaces: dict[int, str]  #: the kind of the surface of each round part that has one, by its number
    reasons: dict[int, str]  #: why other round parts are planes
    triangulated: int  #: number of triangulated polygons
    names: list[str]  #: of the faces, in the order of the shape


@dataclass
class _Choice:
    """The simplifications after failed attempts: parts and regions that can't be one face."""

    reasons: dict[int, str] = field(default_factory=dict)  # round part -> why it becomes planes
    own: set[int] = field(default_factory=set)  # regions with the planes of polygons in place of the scan's
    apart: set[int] = field(default_factory=set)  # regions with a plane for each polygon
    bent: set[int] = field(default_factory=set)  # polygons that become triangles

    def all_triangles(self, given: Given) -> None:
        """Make all polygons triangles. The result is always valid."""
        self.reasons |= {n: "the faces do not fit together" for n in given.patches if n not in self.reasons}
        self.bent = set(range(len(given.loops)))


def make(poly: PolygonMesh, part: Partition | None, mesh: Mesh | None, job: Job | None = None) -> Made:
    """Make the shape. A part that can't be one valid face is split into smaller parts, and finally into triangles."""
    given = Given(poly, part, mesh, job)
    surfaces = Surfaces(given)
    choice = _Choice(dict(surfaces.reasons), apart=set(surfaces.apart))
    for number in range(_TRIES):
        if number == _TRIES - 1:
            choice.all_triangles(given)
        given.poll()
        attempt = _Attempt(given, choice, surfaces)
        if not attempt.improve():
            break
    return attempt.result()


class _Attempt:
    """One attempt: its groups, their places, edges and faces."""

    def __init__(self, given: Given, choice: _Choice, surfaces: Surfaces) -> None:
        self._given, self._choice, self._surfaces = given, choice, surfaces
        self._limit = _GAP * given.size
        loops, keys, self._polygon = self._keys()
        starts = np.concatenate([[0], np.cumsum([len(loop) for loop in loops])])[:-1]
        self._out: Outlines = outlines(np.concatenate(loops), starts, np.array(keys, np.int64))
        self._key = {int(g): k for g, k in zip(self._out.of_polygon, keys, strict=True)}
        self._members: dict[int, list[int]] = {}
        for q, g in zip(self._polygon, self._out.of_polygon.tolist(), strict=True):
            self._members.setdefault(g, []).append(q)
        self._shape = {g: self._shape_of(g) for g in self._key}
        self._faces: dict[int, TopoDS_Face] = {}
        self._bad: dict[int, str] = {}
        self._valid = False
        self._edges: list[list[Edge]] = []
        self._run()

    def _keys(self) -> tuple[list[NDArray[np.int64]], list[int], list[int]]:
        """Return the polygons, bent ones as triangles, with the key of the group and the polygon of each."""
        given, choice = self._given, self._choice
        loops: list[NDArray[np.int64]] = []
        keys: list[int] = []
        polygons: list[int] = []
        for q, (loop, region) in enumerate(zip(given.loops, given.region.tolist(), strict=True)):
            number = given.patch_of.get(region)
            if q in choice.bent:
                parts = [loop[list(ear)] for ear in ears(given.places[loop])]
                first = 3 * PLANES + len(loops)
                these = [first + k for k in range(len(parts))]
            else:
                parts = [loop]
                own = self._surfaces.of(PLANES + region if number is None else number)
                if own in choice.reasons:
                    own = PLANES + region
                these = [2 * PLANES + q if own >= PLANES and region in choice.apart else own]
            loops += parts
            keys += these
            polygons += [q] * len(parts)
        return loops, keys, polygons

    def _shape_of(self, group: int) -> Surface | None:
        key = self._key[group]
        if key < PLANES:
            return self._surfaces.round[key]
        members = self._members[group]
        if key < 2 * PLANES and self._is_of_scan(group):
            return self._surfaces.planes[key - PLANES]
        return self._given.plane_of_polygons(members) if key < 3 * PLANES else None

    def _is_of_scan(self, group: int) -> bool:
        """Return whether a plane is fitted to the scan, not to the polygons."""
        return not {int(self._given.region[q]) for q in self._members[group]} & self._choice.own

    def _run(self) -> None:
        exact = _EXACT * self._given.size
        ends = self._meet()
        self._curves: list[Curve] = []
        for chain in self._out.chains:
            self._given.poll()
            sides = self._sides([chain.left, chain.right])
            free = any(g >= 0 and self._shape[g] is None for g in (chain.left, chain.right))
            if free and any(isinstance(s, Turned) for s in sides):
                for g in (chain.left, chain.right):
                    if isinstance(self._shape[g], Turned):
                        self._bad[g] = "an adjacent face is not planar"
                sides = []
            flat = 0.0 if free or not sides else _FLAT * self._given.size
            self._curves.append(along(chain, self._given.places, ends, sides, flat))
        self._framed: dict[int, Turned] = {}
        for g, shape in self._shape.items():
            if isinstance(shape, Turned) and g not in self._bad:
                self._frame(g, shape, exact)
        edges = Edges(exact)
        for k, (chain, curve) in enumerate(zip(self._out.chains, self._curves, strict=True)):
            self._given.poll()
            try:
                self._edges.append(edges.of(k, curve))
            except NoFace as problem:
                self._edges.append([])
                self._bad |= {g: str(problem) for g in (chain.left, chain.right) if g >= 0}
        for g in self._shape:
            self._given.poll()
            if g not in self._bad:
                self._face(g)

    def _sides(self, groups: list[int]) -> list[Surface]:
        """Return the surfaces of groups, each once."""
        found: list[Surface] = []
        for g in groups:
            shape = self._shape[g] if g >= 0 else None
            if shape is not None and all(shape is not other for other in found):
                found.append(shape)
        return found

    def _meet(self) -> dict[int, Array]:
        given = self._given
        touching: dict[int, list[tuple[Surface, Surface]]] = {}
        reach: dict[int, float] = {}
        for chain in self._out.chains:
            corners = given.places[chain.vertices]
            steps = np.linalg.norm(np.diff(corners, axis=0), axis=1)
            for v, step in ((chain.vertices[0], steps[0]), (chain.vertices[-1], steps[-1])):
                reach[v] = min(reach.get(v, np.inf), float(step))
            sides = self._sides([chain.left, chain.right])
            if len(sides) == 2 and touch(sides[0], sides[1], corners):
                for v in (chain.vertices[0], chain.vertices[-1]):
                    touching.setdefault(v, []).append((sides[0], sides[1]))
        found = {}
        for v, groups in self._out.junctions.items():
            given.poll()
            sides = self._sides(sorted(groups))
            found[v] = (
                meet_at(given.places[v], sides, touching.get(v, []), reach.get(v, 0.0)) if sides else given.places[v]
            )
        return found

    def _frame(self, group: int, shape: Turned, exact: float) -> None:
        loops = self._out.loops[group]
        corners = np.concatenate([self._given.places[self._given.loops[q]] for q in self._members[group]])
        framed = seams.framed(shape, loops, self._curves, corners.mean(axis=0))
        self._framed[group] = framed
        seams.cut(framed, loops, self._curves, exact)

    def _face(self, group: int) -> None:
        shape = self._shape[group]
        if shape is None:
            shape = self._triangle(group)
        elif isinstance(shape, Turned):
            shape = self._framed[group]
        loops = [
            [(edge, forward) for k, forward in loop for edge in (self._edges[k] if forward else self._edges[k][::-1])]
            for loop in self._out.loops[group]
        ]
        own = max((edge.off(shape) for loop in loops for edge, _ in loop), default=0.0)
        from_scan = PLANES <= self._key[group] < 2 * PLANES and self._is_of_scan(group)
        if from_scan and own > _SHARP * self._given.size:
            self._bad[group] = "it does not meet its neighbours"
            return
        if own > self._limit:
            self._bad[group] = f"its borders are {own:.2g} from it"
            return
        try:
            face = self._made(group, shape, loops)
        except NoFace as problem:
            self._bad[group] = str(problem) or "OpenCASCADE refuses it"
            return
        if not BRepCheck_Analyzer(face).IsValid():
            self._bad[group] = "its face is not valid"
            return
        self._faces[group] = face

    def _made(self, group: int, shape: Surface, loops: list[Any]) -> TopoDS_Face:
        if isinstance(shape, Plane):
            return FaceMaker(shape, self._limit).face(loops)
        turned = self._natural(group, shape) < 0
        if turned:
            loops = [[(edge, not forward) for edge, forward in loop[::-1]] for loop in loops]
        face = FaceMaker(shape, self._limit).face([_from_seam(shape, loop) for loop in loops])
        return face.Reversed() if turned else face

    def _natural(self, group: int, shape: Turned) -> float:
        """Return a positive number if the polygons face along the normal of the surface."""
        given, members = self._given, self._members[group]
        middles = np.array([given.places[given.loops[q]].mean(axis=0) for q in members])
        return float((shape.normal(middles) * np.array([given.normal[q] for q in members])).sum())

    def _triangle(self, group: int) -> Plane:
        corners = [
            self._curves[k].points if forward else self._curves[k].points[::-1]
            for k, forward in self._out.loops[group][0]
        ]
        points = np.concatenate([part[:-1] for part in corners])
        return Plane(points.mean(axis=0), unit(area_normal(points)))

    def improve(self) -> bool:
        """Simplify parts whose faces can't be made. Returns False if nothing remains to do."""
        choice, changed = self._choice, False
        if not self._bad:
            self._check()
        round_bad = {g: why for g, why in self._bad.items() if self._key[g] < PLANES}
        for g, why in round_bad.items():
            if self._key[g] not in choice.reasons:
                choice.reasons[self._key[g]] = why
                changed = True
        if changed:
            return True  # the neighbours may be valid after that
        for g in self._bad:
            region = {int(self._given.region[q]) for q in self._members[g]}
            if self._key[g] < 2 * PLANES and not region <= choice.own:
                choice.own |= region
                changed = True
            elif self._key[g] < 2 * PLANES and not region <= choice.apart and len(self._members[g]) > 1:
                choice.apart |= region
                changed = True
            elif self._key[g] < 3 * PLANES:
                new = set(self._members[g]) - choice.bent
                choice.bent |= new
                changed = changed or bool(new)
        if self._bad and not changed and len(choice.bent) < len(self._given.loops):
            choice.all_triangles(self._given)
            return True
        return changed

    def _parts(self) -> list[list[int]]:
        """Return the groups that have a face, in parts that are connected by edges."""
        parent = {g: g for g in self._faces}

        def root(g: int) -> int:
            while parent[g] != g:
                parent[g] = parent[parent[g]]
                g = parent[g]
            return g

        for chain in self._out.chains:
            if chain.left in parent and chain.right in parent:
                a, b = sorted((root(chain.left), root(chain.right)))
                parent[b] = a
        parts: dict[int, list[int]] = {}
        for g in self._faces:
            parts.setdefault(root(g), []).append(g)
        return list(parts.values())

    def _check(self) -> None:
        """Find faces that are valid alone but not in the whole shape."""
        shape, _, _ = self._whole
        check = BRepCheck_Analyzer(shape)
        self._valid = bool(check.IsValid())
        if self._valid:
            self._check_volume()
            return
        for g, face in self._faces.items():
            if not check.IsValid(face):
                self._bad[g] = "its face is not valid next to the others"
        if not self._bad:
            self._bad = {g: "the whole is not valid" for g in self._faces if self._key[g] < PLANES}

    def _check_volume(self) -> None:
        """Reject true surfaces if their volume differs more from the scan's than the volume of the polygons."""
        given, (_, _, volume) = self._given, self._whole
        if volume is None or not given.volume_of_scan or not given.volume:
            return
        off, plain = (abs(v / given.volume_of_scan - 1) for v in (volume, given.volume))
        if off > max(_VOLUME, plain):
            why = f"the volume would be off by {100 * off:.2g} %"
            self._bad = {g: why for g in self._faces if self._key[g] < PLANES}

    @cached_property
    def _whole(self) -> tuple[Any, int, float | None]:
        return _assembled([[self._faces[g] for g in part] for part in self._parts()], self._given.closed)

    def result(self) -> Made:
        given = self._given
        shape, solids, volume = self._whole
        move = gp_Trsf()
        move.SetTranslation(gp_Vec(*given.shift.tolist()))
        kinds = {}
        for number in given.patches:
            own = self._surfaces.of(number)
            if own in self._surfaces.round and own not in self._choice.reasons:
                kinds[number] = self._surfaces.round[own].kind
        reasons = {n: self._choice.reasons.get(self._surfaces.of(n), "") for n in given.patches if n not in kinds}
        gap = max((edge.tolerance for edges in self._edges for edge in edges), default=0.0)
        return Made(
            shape.Moved(TopLoc_Location(move)),
            len(self._faces),
            solids,
            self._valid,
            volume,
            gap,
            kinds,
            reasons,
            len(self._choice.bent),
            [self._name(group) for part in self._parts() for group in part],
        )

    def _name(self, group: int) -> str:
        """The face by the numbers in tables of sizes: `plane 3`, `cylinder D1 9.002`, `cone 2`."""
        if (number := self._key[group]) < PLANES:
            patch = self._given.patches[number]
            kind = self._surfaces.round[number].kind
            wide = kind in ("cylinder", "sphere") and patch["kind"] == kind
            return f"{kind} D{number} {2 * patch['radius']:.6g}" if wide else f"{kind} {number}"
        regions = sorted({int(self._given.region[q]) for q in self._members[group]})
        return f"plane {', '.join(map(str, regions))}"


def _from_seam(shape: Turned, loop: Any) -> Any:
    """Return the loop rotated to the vertex at the seam, if it has one."""
    starts = [edge.curve.Value(edge.first if forward else edge.last) for edge, forward in loop]
    places = np.array([[p.X(), p.Y(), p.Z()] for p in starts])
    off = np.abs(shape.angle(places))
    if isinstance(shape, Torus) and float(off.min()) > 0.02:
        off = np.abs(shape.along(places))
    k = int(off.argmin())
    return loop[k:] + loop[:k]


def _assembled(parts: list[list[TopoDS_Face]], closed: bool) -> tuple[Any, int, float | None]:
    """Return the shape, the number of solids, and their volume. Faces that enclose no solid become shells."""
    build = BRep_Builder()
    whole = TopoDS_Compound()
    build.MakeCompound(whole)
    shapes, solids, volume = [], 0, 0.0
    for some in parts:
        shell = TopoDS_Shell()
        build.MakeShell(shell)
        for face in some:
            build.Add(shell, face)
        if closed and BRep_Tool.IsClosed_s(shell):
            shell.Closed(True)
            solid = TopoDS_Solid()
            build.MakeSolid(solid)
            build.Add(solid, shell)
            found = GProp_GProps()
            BRepGProp.VolumeProperties_s(solid, found)
            if found.Mass() > 0:
                shapes.append(solid)
                solids, volume = solids + 1, volume + found.Mass()
                continue
        shapes.append(shell)
    for shape in shapes:
        build.Add(whole, shape)
    return shapes[0] if len(shapes) == 1 else whole, solids, volume if solids else None
