"""Makes faces on surfaces of OpenCASCADE: wires of shared edges, with seams and poles of closed surfaces."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.gp import gp_Pnt
from OCP.TopAbs import TopAbs_FORWARD, TopAbs_REVERSED
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS_Edge, TopoDS_Face, TopoDS_Vertex, TopoDS_Wire

from . import kernel
from .kernel import NoFace, refused
from .meeting import Curve
from .shapes import Array, Cylinder, Plane, Surface, Torus, Turned

_CHECKS = 23  # points of an edge where its distance from a surface is measured
_LEAST = 1e-7  # the tolerance of an exact edge, OpenCASCADE's own
_AT_SEAM = 0.02  # radians: largest distance of the begin of a border from the seam, if it touches its neighbour
_ROUND = 2 * np.pi


@dataclass
class Edge:
    """An edge of the solid, from `begin` to `end`."""

    edge: TopoDS_Edge
    begin: TopoDS_Vertex
    end: TopoDS_Vertex
    curve: object
    first: float
    last: float
    tolerance: float
    count: int  #: number of points that the curve was made from

    def off(self, shape: Surface) -> float:
        """Return the largest distance of its curve from a surface."""
        t = np.array([self.first, self.last]) if self.count == 2 else np.linspace(self.first, self.last, _CHECKS)
        return float(np.abs(shape.distance(kernel.places(self.curve, t))).max())


class Edges:
    """Makes each vertex and edge once, so that faces share them."""

    def __init__(self, exact: float) -> None:
        self._exact = exact
        self._build = BRep_Builder()
        self._vertices: dict[tuple[int, int], TopoDS_Vertex] = {}

    def vertex(self, key: tuple[int, int], place: Array) -> TopoDS_Vertex:
        if key not in self._vertices:
            self._vertices[key] = made = TopoDS_Vertex()
            self._build.MakeVertex(made, gp_Pnt(*place.tolist()), _LEAST)
        return self._vertices[key]

    def of(self, number: int, curve: Curve) -> list[Edge]:
        """Return the edges of a chain, in order. Raises NoFace."""
        with refused():
            return self._of(number, curve)

    def _of(self, number: int, curve: Curve) -> list[Edge]:
        found = []
        for a, b in pairwise(curve.breaks):
            points = curve.points[a : b + 1]
            ends = []
            for k in (a, b):
                at = 0 if k == len(curve.points) - 1 and np.array_equal(curve.points[0], curve.points[k]) else k
                key = (-1, curve.ids[at]) if at in curve.ids else (number, at)
                ends.append(self.vertex(key, curve.points[k]))
            found.append(self._edge(points, curve, ends))
        return found

    def _edge(self, points: Array, curve: Curve, ends: list[TopoDS_Vertex]) -> Edge:
        if float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum()) <= self._exact:
            raise NoFace("an edge has no length")
        made, first, last = self._curve(points, curve)
        t = np.linspace(first, last, _CHECKS)
        at = kernel.places(made, t)
        gap = max([_LEAST, *(float(np.abs(side.distance(at)).max()) for side in curve.sides)])
        off = max(float(np.linalg.norm(at[0] - points[0])), float(np.linalg.norm(at[-1] - points[-1])))
        edge = TopoDS_Edge()
        self._build.MakeEdge(edge, made, gap)
        self._build.Add(edge, ends[0].Oriented(TopAbs_FORWARD))
        self._build.Add(edge, ends[1].Oriented(TopAbs_REVERSED))
        self._build.Range(edge, first, last)
        for end in ends:
            self._build.UpdateVertex(end, max(_LEAST, 1.01 * max(gap, off)))
        return Edge(edge, ends[0], ends[1], made, first, last, gap, len(points))

    def _curve(self, points: Array, curve: Curve) -> tuple[object, float, float]:
        if curve.straight or _is_line(points, self._exact):
            return kernel.line(points[0], points[-1])
        sides = sorted(curve.sides, key=lambda s: isinstance(s, Turned))
        gap = max(float(np.abs(s.distance(points)).max()) for s in sides)
        near = max(self._exact, gap)
        found = kernel.circle(points, near)
        if found is None and len(sides) == 2 and isinstance(sides[0], Plane) and isinstance(sides[1], Cylinder):
            found = kernel.ellipse(points, sides[1], sides[0], near)
        return found or kernel.spline(points)


def _is_line(points: Array, exact: float) -> bool:
    way = points[-1] - points[0]
    length = float(np.linalg.norm(way))
    if not length > 0:
        return False
    away = points - points[0]
    return float(np.linalg.norm(away - np.outer(away @ way / length**2, way), axis=1).max()) <= exact


@dataclass
class _Run:
    """An edge of a loop with its parameters on the surface, in the loop's direction."""

    edge: Edge
    forward: bool
    t: Array
    uv: Array


Loop = list[tuple[Edge, bool]]


class FaceMaker:
    """Makes one face from a surface and loops of edges, which run counter-clockwise about the normal.

    limit: largest distance of an edge from its image on the surface.
    """

    def __init__(self, shape: Surface, limit: float) -> None:
        self._shape = shape
        with refused():
            self._surface = kernel.surface_of(shape)
        self._limit = limit
        self._build = BRep_Builder()
        self._nowhere = TopLoc_Location()

    def face(self, loops: list[Loop]) -> TopoDS_Face:
        """Return the face. Raises NoFace."""
        with refused():
            return self._face(loops)

    def _face(self, loops: list[Loop]) -> TopoDS_Face:
        if isinstance(self._shape, Plane):
            return self._plane(self._shape, loops)
        if not loops and isinstance(self._shape, Torus):
            return BRepBuilderAPI_MakeFace(self._surface, _LEAST).Face()
        runs = [self._unrolled(loop) for loop in loops]
        wires = self._wires(runs)
        for loop in runs:
            for run in loop:
                self._pcurve(run)
        return self._assembled(wires)

    def _assembled(self, wires: list[TopoDS_Wire]) -> TopoDS_Face:
        face = TopoDS_Face()
        self._build.MakeFace(face, self._surface, self._nowhere, _LEAST)
        for wire in wires:
            self._build.Add(face, wire)
        return face

    def _plane(self, plane: Plane, loops: list[Loop]) -> TopoDS_Face:
        wires = [self._wire([(e.edge, forward) for e, forward in loop]) for loop in loops]
        areas = [_area(plane, loop) for loop in loops]
        if sum(area > 0 for area in areas) != 1:
            raise NoFace("its borders do not enclose one area")
        order = sorted(range(len(loops)), key=lambda k: -areas[k])
        return self._assembled([wires[k] for k in order])

    def _wire(self, edges: list[tuple[TopoDS_Edge, bool]]) -> TopoDS_Wire:
        wire = TopoDS_Wire()
        self._build.MakeWire(wire)
        for edge, forward in edges:
            self._build.Add(wire, edge.Oriented(TopAbs_FORWARD if forward else TopAbs_REVERSED))
        wire.Closed(True)
        return wire

    def _unrolled(self, loop: Loop) -> list[_Run]:
        shape, runs = self._shape, []
        assert isinstance(shape, Turned)
        last = None
        for edge, forward in loop:
            t = np.linspace(edge.first, edge.last, max(9, 2 * edge.count + 1))
            t = t if forward else t[::-1]
            p = kernel.places(edge.curve, t)
            uv = np.stack([shape.angle(p), shape.along(p)], axis=1)
            for k in (0, 1):
                if k == 1 and not isinstance(shape, Torus):
                    continue
                uv[:, k] = np.unwrap(uv[:, k])
                if last is not None:
                    uv[:, k] += _ROUND * np.rint((last[k] - uv[0, k]) / _ROUND)
            runs.append(_Run(edge, forward, t, uv))
            last = uv[-1]
        return runs

    def _wires(self, loops: list[list[_Run]]) -> list[TopoDS_Wire]:
        turns = [np.rint((loop[-1].uv[-1] - loop[0].uv[0]) / _ROUND).astype(int) for loop in loops]
        for loop, turn in zip(loops, turns, strict=True):
            if turn.any():
                loop[-1].uv[-1] = loop[0].uv[0] + _ROUND * turn
        round_u = [k for k, turn in enumerate(turns) if turn[0] and not turn[1]]
        round_v = [k for k, turn in enumerate(turns) if turn[1] and not turn[0]]
        around = round_u or round_v
        if any(abs(turn).max() > 1 for turn in turns) or (round_u and round_v) or any(t.all() for t in turns):
            raise NoFace("a border encloses it more than once")
        holes = [k for k in range(len(loops)) if k not in around]
        if around or not loops:
            outer = self._seamed([loops[k] for k in around], [turns[k] for k in around], 1 if round_v else 0)
        else:
            areas = [_flat_area(loop) for loop in loops]
            if sum(area > 0 for area in areas) != 1:
                raise NoFace("its borders do not enclose one area")
            first = int(np.argmax(areas))
            holes.remove(first)
            for run in loops[first]:
                run.uv = run.uv + self._to_middle(loops[first])
            outer = self._wire([(run.edge.edge, run.forward) for run in loops[first]])
        for k in holes:
            by = self._to_middle(loops[k])
            for run in loops[k]:
                run.uv = run.uv + by
        return [outer, *(self._wire([(run.edge.edge, run.forward) for run in loops[k]]) for k in holes)]

    def _to_middle(self, loop: list[_Run]) -> Array:
        """Return the shift by whole turns that moves a loop between 0 and a turn."""
        every = np.concatenate([run.uv for run in loop])
        middle = (every.min(axis=0) + every.max(axis=0)) / 2
        by = -_ROUND * np.floor(middle / _ROUND)
        return np.asarray(by * [1.0, 0.0])

    def _seamed(self, loops: list[list[_Run]], turns: list[Array], axis: int) -> TopoDS_Wire:
        """Return the wire of a face that encloses the axis: a seam, and two ends, each a border or a pole."""
        signs = [int(turn[axis]) for turn in turns]
        if len(set(signs)) != len(signs):
            raise NoFace("its borders run around it in the same direction")
        other = 1 - axis
        ends: dict[int, tuple[list[tuple[TopoDS_Edge, bool]], TopoDS_Vertex, float]] = {}
        for loop, sign in zip(loops, signs, strict=True):
            begin = loop[0].uv[0]
            first = 0.0 if sign > 0 else _ROUND
            by = np.zeros(2)
            by[axis] = first - begin[axis]
            whole = _ROUND * np.rint(by[axis] / _ROUND)
            if abs(by[axis] - whole) > _AT_SEAM:
                raise NoFace("its border does not begin at the seam")
            by[axis] = whole
            for run in loop:
                run.uv = run.uv + by
            loop[0].uv[0, axis], loop[-1].uv[-1, axis] = first, _ROUND - first
            start = loop[0].edge.begin if loop[0].forward else loop[0].edge.end
            ends[sign] = [(run.edge.edge, run.forward) for run in loop], start, float(loop[0].uv[0, other])
        # About u, the border with the positive turn is the lower one in v; about v it is the upper one in u.
        low, high = (1, -1) if axis == 0 else (-1, 1)
        for sign in (low, high):
            if sign not in ends:
                ends[sign] = self._pole(sign == low, axis)
        if ends[low][2] >= ends[high][2] and isinstance(self._shape, Torus):  # a torus is closed in both directions
            for run in loops[signs.index(high)]:
                run.uv[:, other] += _ROUND
            ends[high] = ends[high][0], ends[high][1], ends[high][2] + _ROUND
        a, b = ends[low], ends[high]
        if not a[2] < b[2]:
            raise NoFace("its borders are the wrong way round")
        seam = self._seam(a, b, axis)
        one, two = (a, b) if axis == 0 else (b, a)
        # Counter-clockwise: about u the lower border, up, the upper border, down; about v the right border, then back.
        return self._wire([*one[0], (seam, axis == 0), *two[0], (seam, axis != 0)])

    def _seam(
        self,
        low: tuple[list[tuple[TopoDS_Edge, bool]], TopoDS_Vertex, float],
        high: tuple[list[tuple[TopoDS_Edge, bool]], TopoDS_Vertex, float],
        axis: int,
    ) -> TopoDS_Edge:
        curve = self._surface.UIso(0.0) if axis == 0 else self._surface.VIso(0.0)
        seam = TopoDS_Edge()
        self._build.MakeEdge(seam, curve, _LEAST)
        self._build.Add(seam, low[1].Oriented(TopAbs_FORWARD))
        self._build.Add(seam, high[1].Oriented(TopAbs_REVERSED))
        there, back = (_ROUND, 0.0) if axis == 0 else (0.0, _ROUND)
        lines = [kernel.flat_line(x, x, axis == 1) for x in (there, back)]
        self._build.UpdateEdge(seam, lines[0], lines[1], self._surface, self._nowhere, _LEAST)
        self._build.Range(seam, low[2], high[2])
        for end, place in ((low, low[2]), (high, high[2])):
            p = curve.Value(place)
            off = p.Distance(BRep_Tool.Pnt_s(end[1]))
            self._build.UpdateVertex(end[1], max(_LEAST, 1.01 * off))
        return seam

    def _pole(self, at_low: bool, axis: int) -> tuple[list[tuple[TopoDS_Edge, bool]], TopoDS_Vertex, float]:
        assert isinstance(self._shape, Turned)
        v = self._shape.poles()[0 if at_low else 1]
        if v is None or axis == 1:
            raise NoFace("it is open where it has no border")
        vertex, edge = TopoDS_Vertex(), TopoDS_Edge()
        self._build.MakeVertex(vertex, self._surface.Value(0.0, v), _LEAST)
        self._build.MakeEdge(edge)
        self._build.UpdateEdge(edge, kernel.flat_line(0.0, v, True), self._surface, self._nowhere, _LEAST)
        self._build.Add(edge, vertex.Oriented(TopAbs_FORWARD))
        self._build.Add(edge, vertex.Oriented(TopAbs_REVERSED))
        self._build.Range(edge, 0.0, _ROUND)
        self._build.Degenerated(edge, True)
        return [(edge, at_low)], vertex, v

    def _pcurve(self, run: _Run) -> None:
        t, uv = (run.t, run.uv) if run.forward else (run.t[::-1], run.uv[::-1])
        edge = run.edge
        curve = kernel.flat_curve(uv, t, 1e-9)
        between = np.linspace(edge.first, edge.last, _CHECKS)
        off = np.linalg.norm(
            kernel.places(edge.curve, between) - kernel.places_on(self._surface, curve, between), axis=1
        )
        if float(off.max()) > self._limit:
            raise NoFace(f"its borders are {float(off.max()):.2g} from it")
        edge.tolerance = max(edge.tolerance, 1.05 * float(off.max()))
        self._build.UpdateEdge(edge.edge, curve, self._surface, self._nowhere, edge.tolerance)
        for end in (edge.begin, edge.end):
            self._build.UpdateVertex(end, 1.05 * edge.tolerance)


def _area(plane: Plane, loop: Loop) -> float:
    """Return the signed area that a loop in a plane encloses."""
    points = []
    for edge, forward in loop:
        t = np.linspace(edge.first, edge.last, 2 if edge.count == 2 else 2 * edge.count)
        points.append(kernel.places(edge.curve, t if forward else t[::-1])[:-1])
    p = np.concatenate(points)
    p = p - p[0]
    return float(np.cross(p, np.roll(p, -1, axis=0)).sum(axis=0) @ plane.normal_) / 2


def _flat_area(loop: list[_Run]) -> float:
    p = np.concatenate([run.uv[:-1] for run in loop])
    p = p - p[0]
    q = np.roll(p, -1, axis=0)
    return float((p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]).sum()) / 2
