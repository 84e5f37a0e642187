"""A bound kept by the polygons too: how far the scan is from them, and how to make it less."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._core import (
    Cancelled,
    Job,
    Mesh,
    MeshingOptions,
    Partition,
    PartitionOptions,
    PolygonMesh,
    polygonize,
    triangulate,
)
from .guided import Guides, Part, partition_guided

SLACK = 1.5  #: the polygons may be this many times further from the scan than its regions' planes
_SHARES = (1.0, 0.5, 0.25)  # of the bound that borders and corners may use up half of
_STEP, _LEAST = 0.75, 0.2  # how the regions' own bound is lowered, and to what share of the one asked for
_CHUNK = 1 << 20
_GROUP, _BITS = 64, 7  # vertices that look for triangles together, and bits of the place that brings them together

Points = NDArray[np.float64]
Jobs = Callable[[float, float], AbstractContextManager[Job | None]]  # the job for the work between two shares of all


@dataclass(frozen=True)
class Within:
    """A partition and its polygons; with a bound, how far the scan is from them."""

    partition: Partition
    polygons: PolygonMesh
    distance: (
        float | None
    )  #: the largest distance of a vertex of the scan from the polygons, scene units; None: no bound
    allowed: float | None  #: what it must not be above: SLACK times the bound
    tries: int

    @property
    def report(self) -> dict[str, Any]:
        """The polygons' report; with a bound, `scan_distance` and `scan_distance_allowed` in it."""
        if self.distance is None:
            return self.polygons.report
        return self.polygons.report | {"scan_distance": self.distance, "scan_distance_allowed": self.allowed}


@dataclass(frozen=True)
class Made:
    """How a partition was made, so that it can be made anew with planes nearer to the scan; see partition_guided."""

    options: PartitionOptions
    guides: Guides | None = None
    part: Part | None = None

    def again(self, mesh: Mesh, share: float, job: Job | None) -> Partition:
        """The partition with a share of the bound."""
        options = self.options.as_dict()
        options["bound"] *= share
        return partition_guided(mesh, PartitionOptions(**options), job, self.guides, self.part)


def scan_distances(
    mesh: Mesh, part: Partition, polygons: PolygonMesh, enough: float = 0.0, job: Job | None = None
) -> Points:
    """How far each vertex of the scan is from the polygons; NaN where it is in no region.

    First from those of its own regions; where that is more than `enough`, from all: what is below it may be less still.
    """
    triangles, owner = triangulate(polygons.vertices, polygons.loops, polygons.loop_start)
    region = polygons.polygon_region[owner]
    order = np.argsort(region, kind="stable")
    corners = polygons.vertices[triangles[order]]
    first = np.searchsorted(region[order], np.arange(part.region_count + 1))
    kept = part.face_region >= 0
    pairs = np.stack([mesh.triangles[kept].ravel(), np.repeat(part.face_region[kept], 3)], axis=1)
    pairs = np.unique(pairs, axis=0)
    result = np.full(len(mesh.vertices), np.inf)
    for at, triangle in _products(pairs[:, 0], first[pairs[:, 1]], first[pairs[:, 1] + 1]):
        _poll(job)
        np.minimum.at(result, at, _to_triangles(mesh.vertices[at], corners[triangle]))
    seen = np.zeros(len(result), bool)
    seen[pairs[:, 0]] = True
    for at, triangle in _all_near(mesh.vertices, np.flatnonzero((result > enough) & seen), result, corners):
        _poll(job)
        np.minimum.at(result, at, _to_triangles(mesh.vertices[at], corners[triangle]))
    result[np.isinf(result)] = np.nan
    return result


def polygonize_within(
    mesh: Mesh,
    part: Partition,
    meshing: MeshingOptions | None = None,
    job: Job | None = None,
    made: Made | None = None,
    jobs: Jobs | None = None,
) -> Within:
    """The polygons of a partition; with a bound such that the scan is within SLACK times it of them, if that can be.

    Borders may leave their chords, polygons bend and corners move by half the bound, and by less where that is not
    enough. Where it still is not, and it is known how the partition was made, that is done anew with a lower bound.
    Without a bound it is `polygonize`.
    jobs: in place of `job`: gives a job for each part of the work, to show its progress.
    """
    stretches = _Stretches(jobs or (lambda begin, end: nullcontext(job)))
    if part.bound is None:
        with stretches.last() as own:
            return Within(part, polygonize(mesh, part, meshing or MeshingOptions(), own), None, None, 1)
    allowed, tries = SLACK * part.bound, 0
    best: Within | None = None
    least = np.inf
    for split in _ever_tighter(mesh, part, made, stretches):
        for share in _SHARES:
            tries += 1
            with stretches.half() as own:
                tight = _tight(mesh, split, share * (split.bound or part.bound), meshing)
                polygons = polygonize(mesh, split, tight, own)
                distance = float(np.nanmax(scan_distances(mesh, split, polygons, allowed, own)))
            if best is None or distance < least:
                best, least = Within(split, polygons, distance, allowed, tries), distance
            if distance <= allowed:
                return best
    assert best is not None  # the first try always sets it
    return replace(best, tries=tries)


def partition_within(
    mesh: Mesh,
    options: PartitionOptions,
    meshing: MeshingOptions | None = None,
    job: Job | None = None,
    guides: Guides | None = None,
) -> Within:
    """Regions and their polygons; with a bound such that the scan is within SLACK times it of them, if that can be."""
    made = Made(options, guides)
    return polygonize_within(mesh, partition_guided(mesh, options, job, guides), meshing, job, made)


class _Stretches:
    """Cuts work of which nobody knows how long it takes: each piece gets half of what is left to show."""

    def __init__(self, jobs: Jobs) -> None:
        self._jobs, self._done = jobs, 0.0

    def half(self) -> AbstractContextManager[Job | None]:
        begin, self._done = self._done, (1 + self._done) / 2
        return self._jobs(begin, self._done)

    def last(self) -> AbstractContextManager[Job | None]:
        return self._jobs(self._done, 1.0)


def _ever_tighter(mesh: Mesh, part: Partition, made: Made | None, stretches: _Stretches) -> Iterator[Partition]:
    """The partition, and if it is known how it was made, it again with ever less of its bound."""
    yield part
    share = _STEP
    while made is not None and share >= _LEAST:
        with stretches.half() as job:
            tighter = made.again(mesh, share, job)
        yield tighter
        share *= _STEP


def _poll(job: Job | None) -> None:
    if job is not None and job.cancelled:
        raise Cancelled


def _tight(mesh: Mesh, part: Partition, bound: float, given: MeshingOptions | None) -> MeshingOptions:
    """The options with which polygons stay near the planes of their regions; no looser than those given."""
    options = given or MeshingOptions()
    diagonal, region = mesh.report["diagonal"], np.sqrt(mesh.report["area"] / max(part.region_count, 1))
    lengths = {"chord_tolerance": bound / 2 / region, "reach": bound / 2 / diagonal, "flatness": bound / 2 / diagonal}
    tighter = {name: min(value, getattr(options, name)) for name, value in lengths.items()}
    return MeshingOptions(**(options.as_dict() | tighter | {"flatness_from": 0}))


def _products(
    vertex: NDArray[Any], begin: NDArray[Any], end: NDArray[Any]
) -> Iterator[tuple[NDArray[Any], NDArray[Any]]]:
    """Each vertex with each of its region's triangles, in pieces that fit into memory."""
    count = end - begin
    cuts = np.searchsorted(np.cumsum(count), np.arange(_CHUNK, count.sum() + _CHUNK, _CHUNK)) + 1
    for at in np.split(np.arange(len(vertex)), cuts[cuts < len(vertex)]):
        n = count[at]
        if n.sum():
            offset = np.arange(n.sum()) - np.repeat(np.cumsum(n) - n, n)
            yield np.repeat(vertex[at], n), np.repeat(begin[at], n) + offset


def _all_near(
    points: Points, which: NDArray[Any], known: Points, corners: Points
) -> Iterator[tuple[NDArray[Any], NDArray[Any]]]:
    """Some vertices with all triangles that may be nearer than what is known: those whose boxes come near enough."""
    if not len(which):
        return
    low, high = corners.min(axis=1), corners.max(axis=1)
    for group in np.split(which[_along_a_curve(points[which])], np.arange(_GROUP, len(which), _GROUP)):
        reach, place = known[group].max(), points[group]
        near = (low <= place.max(axis=0) + reach) & (high >= place.min(axis=0) - reach)
        found = np.flatnonzero(near.all(axis=1))
        for piece in np.split(found, np.arange(_CHUNK // _GROUP, len(found), _CHUNK // _GROUP)):
            yield np.repeat(group, len(piece)), np.tile(piece, len(group))


def _along_a_curve(points: Points) -> NDArray[np.intp]:
    """An order of points in which what is near is mostly near in space: Morton's."""
    span = max(float(np.ptp(points, axis=0).max()), 1e-300)
    cell = ((points - points.min(axis=0)) / span * ((1 << _BITS) - 1)).astype(np.int64)
    key = np.zeros(len(points), np.int64)
    for bit in range(_BITS):
        for axis in range(3):
            key |= (cell[:, axis] >> bit & 1) << (3 * bit + axis)
    return np.argsort(key, kind="stable")


def _to_triangles(p: Points, corners: Points) -> Points:
    """(K,) distance of each point from its triangle: to its plane where that is met inside, else to its sides."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    inside = length > 0
    nearest = np.full(len(p), np.inf)
    for start, end in ((a, b), (b, c), (c, a)):
        side = end - start
        square = np.einsum("kd,kd->k", side, side)
        along = np.einsum("kd,kd->k", p - start, side) / np.where(square > 0, square, 1)
        foot = start + np.clip(along, 0, 1)[:, None] * side
        nearest = np.minimum(nearest, np.linalg.norm(p - foot, axis=1))
        inside &= np.einsum("kd,kd->k", np.cross(side, p - start), normal) >= 0
    height = np.abs(np.einsum("kd,kd->k", p - a, normal)) / np.where(length > 0, length, 1)
    return np.where(inside, height, nearest)
