"""A bound kept by the polygons too: how far the scan is from them, and how to make it less."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._core import (
    Job,
    Mesh,
    MeshingOptions,
    Partition,
    PartitionOptions,
    PolygonMesh,
    polygonize,
    triangulate,
)
from .guided import Guides, partition_guided

SLACK = 1.5  #: the polygons may be this many times further from the scan than its regions' planes
_SHARES = (1.0, 0.5, 0.25)  # of the bound that borders and corners may use up half of
_STEP, _LEAST = 0.75, 0.2  # how the regions' own bound is lowered, and to what share of the one asked for
_CHUNK = 1 << 20

Points = NDArray[np.float64]


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


def scan_distances(mesh: Mesh, part: Partition, polygons: PolygonMesh, enough: float = 0.0) -> Points:
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
        np.minimum.at(result, at, _to_triangles(mesh.vertices[at], corners[triangle]))
    for vertex in np.flatnonzero((result > enough) & np.isin(np.arange(len(result)), pairs[:, 0])):
        away = _to_triangles(np.broadcast_to(mesh.vertices[vertex], (len(corners), 3)), corners)
        result[vertex] = min(result[vertex], away.min())
    result[np.isinf(result)] = np.nan
    return result


def polygonize_within(
    mesh: Mesh, part: Partition, meshing: MeshingOptions | None = None, job: Job | None = None
) -> Within:
    """The polygons of a partition; with a bound such that the scan is within SLACK times it of them, if that can be.

    Borders may leave their chords, polygons bend and corners move by half the bound, and by less where that is not
    enough. Without a bound it is `polygonize`.
    """
    if part.bound is None:
        return Within(part, polygonize(mesh, part, meshing or MeshingOptions(), job), None, None, 1)
    allowed, best = SLACK * part.bound, None
    for tries, share in enumerate(_SHARES, 1):
        polygons = polygonize(mesh, part, _tight(mesh, part, share * part.bound, meshing), job)
        distance = float(np.nanmax(scan_distances(mesh, part, polygons, allowed)))
        if best is None or distance < best.distance:
            best = Within(part, polygons, distance, allowed, tries)
        if distance <= allowed:
            break
    return Within(best.partition, best.polygons, best.distance, allowed, tries)


def partition_within(
    mesh: Mesh,
    options: PartitionOptions,
    meshing: MeshingOptions | None = None,
    job: Job | None = None,
    guides: Guides | None = None,
) -> Within:
    """Regions and their polygons; with a bound such that the scan is within SLACK times it of them, if that can be.

    Where tighter polygons do not do, the regions' own bound is lowered step by step.
    """
    return Tries(mesh, options, meshing, guides).polygonize(job)


class Tries:
    """The same in two steps, for those who show or time them one by one."""

    def __init__(
        self,
        mesh: Mesh,
        options: PartitionOptions,
        meshing: MeshingOptions | None = None,
        guides: Guides | None = None,
    ) -> None:
        self._mesh, self._options, self._meshing, self._guides = mesh, options, meshing, guides
        self._part: Partition | None = None

    def partition(self, job: Job | None = None, share: float = 1.0) -> Partition:
        """The regions, with a share of the bound if there is one."""
        bound = self._options.bound
        own = {} if bound is None else {"bound": share * bound}
        options = PartitionOptions(**(self._options.as_dict() | own))
        self._part = partition_guided(self._mesh, options, job, self._guides)
        return self._part

    def polygonize(self, job: Job | None = None) -> Within:
        """The polygons, and the regions that they needed in the end."""
        bound, share, tries = self._options.bound, 1.0, 0
        found = best = polygonize_within(self._mesh, self._part or self.partition(job), self._meshing, job)
        if bound is None or found.distance is None:
            return found
        while True:
            tries += found.tries
            best = min(best, found, key=lambda one: one.distance)
            share *= _STEP
            if best.distance <= SLACK * bound or share < _LEAST:
                return Within(best.partition, best.polygons, best.distance, SLACK * bound, tries)
            found = polygonize_within(self._mesh, self.partition(job, share), self._meshing, job)


def _tight(mesh: Mesh, part: Partition, bound: float, given: MeshingOptions | None) -> MeshingOptions:
    """The options with which polygons stay near the planes of their regions; no looser than those given."""
    options = given or MeshingOptions()
    diagonal, region = mesh.report["diagonal"], np.sqrt(mesh.report["area"] / max(part.region_count, 1))
    lengths = {"chord_tolerance": bound / 2 / region, "reach": bound / 2 / diagonal, "flatness": bound / 2 / diagonal}
    tighter = {name: min(value, getattr(options, name)) for name, value in lengths.items()}
    return MeshingOptions(**(options.as_dict() | tighter | {"flatness_from": 0}))


def _products(vertex: NDArray[Any], begin: NDArray[Any], end: NDArray[Any]) -> Iterator[tuple[NDArray, NDArray]]:
    """Each vertex with each of its region's triangles, in pieces that fit into memory."""
    count = end - begin
    cuts = np.searchsorted(np.cumsum(count), np.arange(_CHUNK, count.sum() + _CHUNK, _CHUNK)) + 1
    for at in np.split(np.arange(len(vertex)), cuts[cuts < len(vertex)]):
        n = count[at]
        if n.sum():
            offset = np.arange(n.sum()) - np.repeat(np.cumsum(n) - n, n)
            yield np.repeat(vertex[at], n), np.repeat(begin[at], n) + offset


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
