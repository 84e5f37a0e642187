"""Finds the part of a scan around a place: a head, a hand, a tool, up to its neck."""

import heapq
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .surfaces import areas, pieces

WEIGHT = 4.0  #: the weight of the faces of a part: regions become denser like its root
_CELLS = 96  # in the scan's diagonal; distances are along cells, so that a million faces take a third of a second
_BINS, _SMOOTH = 120, 5  # bins of the distance, and the bins whose mean is the length of a contour
_NECK = 1.15  # a neck's contour is shorter than those before and after it by this factor
_AFTER = 1.8  # distance up to which the longer contour after a neck is searched, in distances of the neck
_LEAST, _MOST, _USUAL = 0.003, 0.25, 0.06  # shares of the area: of parts, and of one without a neck


class Distances:
    """Distances along a surface from a place, and how far its part reaches."""

    def __init__(self, vertices: NDArray[Any], triangles: NDArray[Any], place: tuple[float, ...]) -> None:
        """vertices (V, 3), triangles (T, 3), T at least 1. place: any point, in the space of the vertices."""
        cell, centers = _cells(vertices, triangles)
        of = cell[triangles[:, 0]]
        area = areas(vertices, triangles)
        start = int(np.argmin(np.linalg.norm(centers - np.asarray(place, np.float64), axis=1)))
        away = _along(_pairs(cell, triangles, centers), centers, start)
        self.away = away[of]  #: (T,) the distance of each triangle
        #: the distance of the part's neck, or of a disc of a usual area
        self.neck, self.has_neck = _neck(self.away, area)

    def inside(self, size: float) -> NDArray[np.bool_]:
        """Whether each triangle is in the part. size: 1 for up to its neck; more is larger."""
        found: NDArray[np.bool_] = self.away <= size * self.neck
        return found


def weights_of(vertices: NDArray[Any], triangles: NDArray[Any], places: tuple[tuple[float, ...], ...]) -> NDArray[Any]:
    """The weight of each triangle. places: (x, y, z, size) of each part, in the space of the vertices."""
    found = np.ones(len(triangles))
    for *place, size in places:
        found[Distances(vertices, triangles, tuple(place)).inside(size)] = WEIGHT
    return found


def _cells(vertices: NDArray[Any], triangles: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """The cell of a grid of each vertex, and the means of their vertices. Unused vertices count for nothing."""
    used = np.unique(triangles)
    low, high = vertices[used].min(axis=0), vertices[used].max(axis=0)
    side = max(float(np.linalg.norm(high - low)) / _CELLS, 1e-300)
    at = np.clip((vertices - low) / side, 0, 2 * _CELLS).astype(np.int64)
    number = (at[:, 0] * 256 + at[:, 1]) * 256 + at[:, 2]
    _, cell = np.unique(number, return_inverse=True)
    count = int(cell.max()) + 1
    many = np.maximum(np.bincount(cell[used], minlength=count), 1)[:, None]
    sums = [np.bincount(cell[used], vertices[used, k], count) for k in range(3)]
    return cell, np.stack(sums, axis=1) / many


def _pairs(cell: NDArray[Any], triangles: NDArray[Any], centers: NDArray[Any]) -> NDArray[Any]:
    """(E, 2) cells with an edge of the surface between them, and nearest cells of pieces that are apart."""
    ends = np.concatenate([cell[triangles[:, [0, 1]]], cell[triangles[:, [1, 2]]], cell[triangles[:, [2, 0]]]])
    ends = np.sort(ends[ends[:, 0] != ends[:, 1]], axis=1)
    count = len(centers)
    keys = np.unique(ends[:, 0] * count + ends[:, 1])
    pairs = np.stack([keys // count, keys % count], axis=1)
    piece = pieces(count, pairs)
    sizes = np.bincount(piece, minlength=count)
    main, bridges = int(np.argmax(sizes)), []
    inside = np.flatnonzero(piece == main)
    for other in np.flatnonzero(sizes):
        if other != main and sizes[other] > 1:
            cells = np.flatnonzero(piece == other)
            cells = cells[:: max(1, len(cells) // 64)]
            away = np.linalg.norm(centers[cells, None] - centers[None, inside], axis=2)
            a, b = np.unravel_index(int(np.argmin(away)), away.shape)
            bridges.append((cells[a], inside[b]))
        if len(bridges) >= 64:  # a scan of many crumbs
            break
    return np.concatenate([pairs, np.array(bridges, np.int64).reshape(-1, 2)])


def _along(pairs: NDArray[Any], centers: NDArray[Any], start: int) -> NDArray[Any]:
    """(cells,) the distance from a cell along pairs of cells; infinite where none leads to."""
    both = np.concatenate([pairs, pairs[:, ::-1]])
    both = both[np.argsort(both[:, 0], kind="stable")]
    first = np.searchsorted(both[:, 0], np.arange(len(centers) + 1)).tolist()
    ends = both[:, 1].tolist()
    length = np.linalg.norm(centers[both[:, 0]] - centers[both[:, 1]], axis=1).tolist()
    away = [np.inf] * len(centers)
    away[start], queue = 0.0, [(0.0, start)]
    while queue:
        far, here = heapq.heappop(queue)
        if far > away[here]:
            continue
        for k in range(first[here], first[here + 1]):
            there = far + length[k]
            if there < away[ends[k]]:
                away[ends[k]] = there
                heapq.heappush(queue, (there, ends[k]))
    return np.array(away)


def _neck(away: NDArray[Any], area: NDArray[Any]) -> tuple[float, bool]:
    """The distance of a part's neck, and whether there is one. Without: the distance of a usual area.

    At a neck the contour around the start is much shorter than before and after. The length of a contour is the
    derivative of the area by the distance.
    """
    known = np.isfinite(away)
    most = float(away[known].max(initial=0.0))
    if most <= 0:
        return 1.0, False
    part, edges = np.histogram(away[known], _BINS, (0.0, most), weights=area[known])
    share = np.cumsum(part) / max(float(area.sum()), 1e-300)
    length = np.convolve(part, np.ones(_SMOOTH) / _SMOOTH, "same")
    best, found = _NECK, None
    for k in range(_SMOOTH, _BINS - _SMOOTH):
        if not _LEAST < share[k] < _MOST:
            continue
        after = length[k : int(_AFTER * k) + _SMOOTH].max()
        ratio = min(length[:k].max(), after) / max(length[k], 1e-300)
        if ratio > best:
            best, found = ratio, k
    at = min(int(np.searchsorted(share, _USUAL)), _BINS - 1) if found is None else found
    return float(edges[at + 1]), found is not None
