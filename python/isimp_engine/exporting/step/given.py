"""The input of a boundary representation: polygons and scan, and the surfaces of their parts. Numpy only."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..._core import Cancelled, Job, Mesh, Partition, PolygonMesh
from ...planes import is_held
from . import fitting
from .outlines import Outlines, outlines
from .shapes import Array, Plane, Turned, square_to, unit

PLANES = 1 << 32  # keys of round parts are below, keys of regions are from here on
_GAP = 5e-4  # share of the diagonal: regions this far from one plane may be one
_COPLANAR = float(np.cos(np.radians(1.5)))  # adjacent regions with a smaller angle may be one plane
_ON = 1.5  # regions nearer to a round part than this multiple of its deviation from the scan are part of it
_NEAR = 3e-4  # share of the diagonal: regions nearer than this are part of it too
_ALONG = 0.8  # least cosine of the angle between the normals of such a region and the round part
_MOST = 20000  # most vertices of a scan to which a surface is fitted
_FLAT = 1e-7  # share of the diagonal: polygons this near to a plane are in it
_SQUARE = float(np.cos(np.radians(0.6)))  # a plane within this angle of perpendicular to an axis becomes perpendicular


def poll(job: Job | None) -> None:
    """Raise Cancelled if a job was cancelled."""
    if job is not None and job.cancelled:
        raise Cancelled


class Given:
    """Arrays of the polygons and the scan, relative to their middle."""

    def __init__(self, poly: PolygonMesh, part: Partition | None, mesh: Mesh | None, job: Job | None = None) -> None:
        self._job = job
        at = np.asarray(poly.vertices, np.float64)
        self.shift = (at.min(axis=0) + at.max(axis=0)) / 2 if len(at) else np.zeros(3)
        self.places = at - self.shift
        self.size = float(np.linalg.norm(np.ptp(at, axis=0))) if len(at) else 1.0
        self.loops = np.split(np.asarray(poly.loops, np.int64), np.asarray(poly.loop_start)[1:])
        region = getattr(poly, "polygon_region", None)
        self.corners = np.asarray(poly.loops, np.int64)
        self.starts = np.asarray(poly.loop_start, np.int64)
        self.region = np.arange(len(self.loops)) if region is None or part is None else np.asarray(region, np.int64)
        self.polygons: dict[int, list[int]] = {}
        for q, r in enumerate(self.region.tolist()):
            self.polygons.setdefault(r, []).append(q)
        self.closed = bool(poly.report["closed"])
        self.part = part
        self.patches = {int(p["number"]): p for p in part.curved} if part is not None else {}
        self.patch_of = {int(r): n for n, p in self.patches.items() for r in p["regions"]}
        self._mesh = mesh
        self._faces: dict[int, NDArray[np.int64]] = {}
        if mesh is not None and part is not None:
            label = np.asarray(part.face_region)
            order = np.argsort(label, kind="stable")
            ends = np.searchsorted(label[order], np.arange(part.region_count + 1))
            self._faces = {r: order[ends[r] : ends[r + 1]] for r in range(part.region_count)}
        self.volume = _volume([self.places[loop] for loop in self.loops]) if self.closed else 0.0
        self.volume_of_scan = 0.0
        if mesh is not None and mesh.report["closed"]:
            corners = (np.asarray(mesh.vertices) - self.shift)[np.asarray(mesh.triangles)]
            self.volume_of_scan = float((corners[:, 0] * np.cross(corners[:, 1], corners[:, 2])).sum() / 6)
        self.normal = [area_normal(self.places[loop]) for loop in self.loops]

    def poll(self) -> None:
        """Raise Cancelled if the job was cancelled."""
        poll(self._job)

    def scanned(self, regions: list[int]) -> Array:
        """Return vertices of the scan in chosen regions, with border vertices; a sample if there are many."""
        self.poll()
        if self._mesh is None or not regions:
            return np.zeros((0, 3))
        faces = np.concatenate([self._faces[r] for r in regions])
        corners = np.asarray(self._mesh.triangles)[faces]
        corners = np.unique(corners)
        corners = corners[:: len(corners) // _MOST + 1]
        return np.asarray(np.asarray(self._mesh.vertices)[corners] - self.shift)

    def looks(self, regions: list[int]) -> Array:
        """Return the sum of the normals of the polygons of chosen regions."""
        return np.asarray(np.sum([self.normal[q] for r in regions for q in self.polygons[r]], axis=0))

    def plane_of_polygons(self, polygons: list[int]) -> Plane:
        """Return the plane of the corners of chosen polygons."""
        self.poll()
        corners = np.unique(np.concatenate([self.loops[q] for q in polygons]))
        return fitting.plane_of(self.places[corners], np.sum([self.normal[q] for q in polygons], axis=0))

    def area(self, regions: list[int]) -> float:
        """Return the area of the polygons of chosen regions."""
        return float(sum(np.linalg.norm(self.normal[q]) for r in regions for q in self.polygons.get(r, [])))

    def is_flat(self, polygons: list[int]) -> bool:
        """Return whether polygons are in one plane."""
        corners = self.places[np.concatenate([self.loops[q] for q in polygons])]
        return float(np.abs(self.plane_of_polygons(polygons).distance(corners)).max()) <= _FLAT * self.size

    def held(self, region: int) -> Plane | None:
        """Return the held plane of a region; None if it has none."""
        part = self.part
        if part is None or not len(part.region_held) or not len(part.region_offset):
            return None
        if not is_held(part.region_held)[region]:
            return None
        normal = np.asarray(part.region_normal[region], float)
        return Plane(float(part.region_offset[region]) * normal - self.shift, normal)


def area_normal(p: Array) -> Array:
    return np.asarray(np.cross(p - p[0], np.roll(p, -1, axis=0) - p[0]).sum(axis=0) / 2)


def _volume(polygons: list[Array]) -> float:
    return float(sum(p[0] @ area_normal(p) for p in polygons) / 3)


class Surfaces:
    """The surface of each round part and each region; parts and regions on one surface are joined."""

    def __init__(self, given: Given) -> None:
        self._given = given
        key = np.array([given.patch_of.get(int(r), PLANES + int(r)) for r in given.region], np.int64)
        found = outlines(given.corners, given.starts, key)
        self.round: dict[int, Turned] = {}
        self.reasons: dict[int, str] = {}
        self.same: dict[int, int] = {}  #: key of a joined part or region -> key of the one that it is joined to
        self.planes: dict[int, Plane] = {}
        self.apart: set[int] = set()  #: regions of flat polygons in several planes
        self._fixed: set[int] = set()  # regions of flat polygons, which keep their planes
        self._ends: dict[int, list[float]] = {}
        self._deviation: dict[int, float] = {}
        groups = {int(g): int(k) for g, k in zip(found.of_polygon, key, strict=True)}
        pairs = [(groups[c.left], groups[c.right]) for c in found.chains if c.right >= 0]
        beside = sorted({(min(pair), max(pair)) for pair in pairs})
        self._make_round(found, groups)
        self._join_round([pair for pair in beside if pair[1] < PLANES])
        self._absorb([pair for pair in beside if pair[1] >= PLANES])
        self._make_planes([pair for pair in beside if pair[0] < PLANES <= pair[1]])
        self._join_planes([pair for pair in beside if pair[0] >= PLANES])

    def of(self, number: int) -> int:
        """Return the key of the part or region that this one is joined to, or its own key."""
        while number in self.same:
            number = self.same[number]
        return number

    def _make_round(self, found: Outlines, groups: dict[int, int]) -> None:
        given = self._given
        for number, patch in given.patches.items():
            axis = unit(np.asarray(patch["axis"], float))
            about = Turned(np.asarray(patch["point"]) - given.shift, axis, square_to(axis))
            ends = []
            for group, own in groups.items():
                for loop in found.loops[group] if own == number else []:
                    ring = [
                        given.places[found.chains[k].vertices if forward else found.chains[k].vertices[::-1]]
                        for k, forward in loop
                    ]
                    points = np.concatenate(ring)
                    if int(np.rint((np.diff(np.unwrap(about.angle(points)))).sum() / 2 / np.pi)):
                        ends.append(float(about.polar(points)[1].mean()))
            made = fitting.round_of(patch, given.scanned(patch["regions"]), given.shift, ends)
            if isinstance(made, str):
                self.reasons[number] = made
            else:
                self.round[number], self._ends[number] = made, ends
                points = given.scanned(patch["regions"])
                self._deviation[number] = fitting.rms(made, points) if len(points) else 0.0

    def _join_round(self, beside: list[tuple[int, int]]) -> None:
        points = {n: self._given.scanned(p["regions"]) for n, p in self._given.patches.items()}
        for pair in beside:
            a, b = sorted(self.of(k) for k in pair)
            if a == b or a not in self.round or b not in self.round or not len(points[a]) or not len(points[b]):
                continue
            ends = self._ends[a], self._ends[b]
            made = fitting.joined(self.round[a], self.round[b], points[a], points[b], *ends)
            if made is None:
                continue
            self.same[b], (self.round[a], self._ends[a]) = a, made
            points[a] = np.concatenate([points[a], points[b]])
            self._deviation[a] = fitting.rms(self.round[a], points[a])

    def _absorb(self, beside: list[tuple[int, int]]) -> None:
        """Join regions to an adjacent round part if their scan is on its surface."""
        given, changed = self._given, True
        while changed:
            changed = False
            for pair in beside:
                own = [self.of(k) for k in pair]
                number, key = min(own), max(own)
                if (
                    number not in self.round
                    or key < PLANES
                    or given.held(key - PLANES)
                    or key - PLANES in given.patch_of
                ):
                    continue
                points = given.scanned([key - PLANES])
                if len(points) < 3:
                    continue
                surface, looks = self.round[number], unit(given.looks([key - PLANES]))
                near = max(_ON * self._deviation[number], _NEAR * given.size)
                aligned = np.abs(surface.normal(points) @ looks)
                if fitting.rms(surface, points) <= near and float(np.median(aligned)) > _ALONG:
                    self.same[key] = number
                    changed = True

    def _make_planes(self, beside: list[tuple[int, int]]) -> None:
        given = self._given
        near = {pair[1] - PLANES for pair in beside if self.of(pair[0]) in self.round}
        for region in sorted({int(r) for r in given.region}):
            polygons = given.polygons[region]
            if region not in near and all(given.is_flat([q]) for q in polygons):
                self._fixed.add(region)
                self.planes[region] = given.plane_of_polygons(polygons)
                if not given.is_flat(polygons):
                    self.apart.add(region)
                continue
            held = given.held(region)
            self.planes[region] = held or fitting.plane_of(self._points([region]), given.looks([region]))
        for number in self.round:
            if number not in self.same and self.round[number].kind != "sphere":
                ends = {key - PLANES for other, key in beside if self.of(other) == number and self.of(key) >= PLANES}
                self._make_square(number, sorted(ends))

    def _make_square(self, number: int, regions: list[int]) -> None:
        """Make planes nearly perpendicular to an axis exactly so. The axis follows a plane larger than its part."""
        given, shape = self._given, self.round[number]
        patches = [n for n in given.patches if self.of(n) == number]
        own = sum(given.area([int(r) for r in given.patches[n]["regions"]]) for n in patches)
        ends = [
            r for r in regions if abs(float(shape.axis @ self.planes[r].normal_)) >= _SQUARE and r not in given.patch_of
        ]
        ends.sort(key=lambda r: (-given.area([r]), r))
        if ends and given.area(ends[:1]) > own:
            normal = self.planes[ends[0]].normal_
            axis = normal * np.sign(normal @ shape.axis)
            self.round[number] = shape = replace(shape, axis=axis, x=square_to(axis))
        for region in ends:
            if not given.held(region):
                plane = self.planes[region]
                self.planes[region] = Plane(plane.point, shape.axis * np.sign(shape.axis @ plane.normal_))

    def _points(self, regions: list[int]) -> Array:
        """Return points on the plane of regions: of the scan, or for cells of round parts corners of polygons."""
        given = self._given
        points = given.scanned([r for r in regions if r not in given.patch_of])
        if len(points) >= 3:
            return points
        corners = np.concatenate([given.loops[q] for r in regions for q in given.polygons[r]])
        return np.asarray(given.places[np.unique(corners)])

    def _join_planes(self, beside: list[tuple[int, int]]) -> None:
        given = self._given
        members = {r: [r] for r in self.planes}
        for first, second in beside:
            a, b = sorted((self.of(first) - PLANES, self.of(second) - PLANES))
            if (
                a < 0
                or a == b
                or a in self._fixed
                or b in self._fixed
                or given.held(a)
                or given.held(b)
                or a in given.patch_of
                or b in given.patch_of
            ):
                continue
            one, two = self.planes[a], self.planes[b]
            if one.normal_ @ two.normal_ < _COPLANAR:
                continue
            corners = [
                given.places[np.concatenate([given.loops[q] for r in members[k] for q in given.polygons[r]])]
                for k in (a, b)
            ]
            far = max(float(np.abs(one.distance(corners[1])).max()), float(np.abs(two.distance(corners[0])).max()))
            if far > _GAP * given.size:
                continue
            members[a] += members.pop(b)
            self.same[PLANES + b] = PLANES + a
            made = fitting.plane_of(self._points(members[a]), given.looks(members[a]))
            snapped = next((p for p in (one, two) if abs(p.normal_ @ made.normal_) >= _SQUARE), None)
            self.planes[a] = Plane(made.point, snapped.normal_) if snapped else made
