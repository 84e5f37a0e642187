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
    partition,
    polygonize,
    triangulate,
)

SLACK = 1.5  #: the polygons may be this many times further from the scan than its regions' planes
_FIRST, _LEAST, _STEP = 1.0, 0.2, 0.75  # shares of the bound that planes, borders and corners may use up
_CHUNK = 1 << 20

Points = NDArray[np.float64]


@dataclass(frozen=True)
class Within:
    """A partition and its polygons, and the largest distance of a vertex of the scan from them, scene units."""

    partition: Partition
    polygons: PolygonMesh
    distance: float
    tries: int


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


def partition_within(
    mesh: Mesh, options: PartitionOptions, meshing: MeshingOptions | None = None, job: Job | None = None, **guides: Any
) -> Within:
    """Regions and polygons such that no vertex of the scan is further than SLACK times options.bound from the polygons.

    Borders may leave their chords, polygons bend and corners move by half the bound; where that is not enough, all
    of it and the regions' own bound are lowered step by step. Raises InvalidInput if options has no bound.
    """
    bound = options.bound
    if bound is None:
        partition(mesh, options, job, **guides)  # says what is wrong with the rest
        raise ValueError("options.bound is not given")
    share, tries, best = _FIRST, 0, None
    while True:
        own = PartitionOptions(**(options.as_dict() | {"bound": share * bound}))
        part = partition(mesh, own, job, **guides)
        polygons = polygonize(mesh, part, _tight(mesh, part, share * bound, meshing), job)
        distance = float(np.nanmax(scan_distances(mesh, part, polygons, SLACK * bound)))
        tries += 1
        if best is None or distance < best.distance:
            best = Within(part, polygons, distance, tries)
        if distance <= SLACK * bound or share * _STEP < _LEAST:
            return Within(best.partition, best.polygons, best.distance, tries)
        share *= _STEP


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
