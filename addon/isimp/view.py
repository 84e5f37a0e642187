"""Assigns colours to regions: neighbours differ, and a region keeps its colour. numpy only."""

from __future__ import annotations

import numpy as np

from .array_pool import ArrayPool, blocks, taken

# Twelve colours with the largest least distance in Oklab (.1), for full colour vision and the three dichromacies at
# once. Magenta is reserved for defects.
_BASE = (  # sRGB
    *("b55422", "556dc6", "94627f", "1896bc", "a09602", "9f9afc"),
    *("31bebe", "f3817e", "e9b443", "a6d6af", "c4fafd", "ece36d"),
)
_SHADE = 0.35  # factor for darker shades, used if neighbours have all twelve colours
NO_REGION = (0.21, 0.21, 0.21, 1.0)  # colour of faces outside regions


def _linear(code: str) -> list[float]:
    value = np.array([int(code[i : i + 2], 16) for i in (0, 2, 4)]) / 255.0
    linear: list[float] = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4).tolist()
    return linear


_LINEAR = np.array([_linear(code) for code in _BASE])
BASE_COLORS = len(_BASE)
#: (2 B, 4) float32, linear RGBA: the base colours, then their darker shades
PALETTE = np.ones((2 * BASE_COLORS, 4), np.float32)
PALETTE[:BASE_COLORS, :3] = _LINEAR
PALETTE[BASE_COLORS:, :3] = _LINEAR * _SHADE
#: (2 B + 1, 4) float32: PALETTE and NO_REGION
COLORS = np.vstack([PALETTE, np.array([NO_REGION], np.float32)])
#: (2 B + 1,) uint32: COLORS with one byte for each channel, in the order of memory
PACKED = (255 * COLORS).round().astype(np.uint8).view(np.uint32).ravel()


def connected(chosen: np.ndarray, pairs: np.ndarray, start: int) -> np.ndarray:
    """Return the chosen faces that are connected to `start` over shared edges. chosen: in rising order.

    Each round of union-find joins all adjacent trees, so that long paths take few rounds.
    """
    inside = np.zeros(max(int(chosen[-1]), int(pairs.max(initial=0))) + 1, bool)
    inside[chosen] = True
    a, b = np.searchsorted(chosen, pairs[inside[pairs[:, 0]] & inside[pairs[:, 1]]].T)
    root = np.arange(len(chosen))
    while len(a):
        root[np.maximum(a, b)] = np.minimum(a, b)
        while not np.array_equal(above := root[root], root):
            root = above
        a, b = root[a], root[b]
        apart = a != b
        a, b = a[apart], b[apart]
    found: np.ndarray = chosen[root == root[chosen == start][:1]]
    return found


def region_pairs(face_region: np.ndarray, face_pairs: np.ndarray) -> np.ndarray:
    """Return (K, 2) int32 regions that share an edge, each pair once, the lower first. face_pairs: (E, 2) faces."""
    a, b = face_region[face_pairs[:, 0]], face_region[face_pairs[:, 1]]
    border = np.flatnonzero(a != b)
    low, high = np.minimum(a[border], b[border]), np.maximum(a[border], b[border])
    key = np.unique((low.astype(np.int64) << 32 | high)[low >= 0])
    return np.stack([key >> 32, key & 0xFFFFFFFF], axis=1).astype(np.int32)


def border_pairs(face_region: np.ndarray, face_pairs: np.ndarray) -> np.ndarray:
    """Return (K,) the indices of pairs of faces in different regions. face_pairs: (E, 2) faces."""
    found = [np.empty(0, np.intp)]
    for block in blocks(len(face_pairs)):
        a, b = (face_region.take(faces) for faces in face_pairs[block].T)
        found.append(block.start + np.flatnonzero(a != b))
    return np.concatenate(found)


def assign_colors(count: int, pairs: np.ndarray, kept: np.ndarray | None = None) -> np.ndarray:
    """Return a colour for each region, so that regions that share an edge differ.

    count: number of regions. pairs: (K, 2) regions that share an edge. kept: (count,) the former colour of a region, -1
    for none. A region keeps it unless a neighbour of a lower number has the same colour.
    Returns (count,) int32 indices into PALETTE. Cost: O(count + K) with a small factor, in Python.
    """
    around: list[set[int]] = [set() for _ in range(count)]
    for a, b in pairs.tolist():
        around[a].add(b)
        around[b].add(a)
    fresh = [-1] * count
    color = list(fresh) if kept is None else kept.tolist()
    for region in range(count):
        if color[region] >= 0 and any(color[other] == color[region] for other in around[region] if other < region):
            color[region] = -1
    if not _fill(color, around):
        color = fresh
        _fill(color, around)
    return np.array(color, np.int32)


def _fill(color: list[int], around: list[set[int]]) -> bool:
    """Assigns the missing colours. Returns False if a region has the colour of a neighbour."""
    used = [0] * len(PALETTE)
    for value in color:
        if value >= 0:
            used[value] += 1
    clean = True
    for region in _smallest_last(color, around):
        taken = {color[other] for other in around[region]}
        near = {color[far] for other in around[region] for far in around[other]}
        # Priorities: unused by neighbours, a base colour, unused by neighbours' neighbours, used least.
        best = min(range(len(PALETTE)), key=lambda c: (c in taken, c >= BASE_COLORS, c in near, used[c], c))
        clean = clean and best not in taken
        color[region] = best
        used[best] += 1
    return clean


def _smallest_last(color: list[int], around: list[set[int]]) -> list[int]:
    """Return uncoloured regions in smallest-last order: greedy colouring needs at most six colours on a sphere."""
    open_regions = {region for region, value in enumerate(color) if value < 0}
    degree = {region: len(around[region] & open_regions) for region in open_regions}
    buckets: list[list[int]] = [[] for _ in range(max(degree.values(), default=0) + 1)]
    for region in sorted(open_regions, reverse=True):
        buckets[degree[region]].append(region)
    removed: list[int] = []
    lowest = 0
    while len(removed) < len(degree):
        while not buckets[lowest]:
            lowest += 1
        region = buckets[lowest].pop()
        if region not in open_regions or degree[region] != lowest:
            continue  # an outdated entry: the region is in a lower bucket, or removed
        open_regions.discard(region)
        removed.append(region)
        for other in around[region] & open_regions:
            degree[other] -= 1
            buckets[degree[other]].append(other)
        lowest = max(0, lowest - 1)
    return removed[::-1]


def face_colors(face_region: np.ndarray, region_color: np.ndarray) -> np.ndarray:
    """Return (F,) uint8 the row of COLORS of each face. region_color: (R,) indices into PALETTE."""
    return taken(np.append(region_color, len(PALETTE)).astype(np.uint8), face_region)  # -1 is the last


def corner_colors(table: np.ndarray, face_color: np.ndarray, corners: np.ndarray | int, pool: ArrayPool) -> np.ndarray:
    """Return the colour of each corner, face by face. table: COLORS or PACKED; corners: number of corners of a face."""
    count = int(corners.sum()) if isinstance(corners, np.ndarray) else corners * len(face_color)
    colors = pool.take((count, *table.shape[1:]), table.dtype)
    done = 0
    for block in blocks(len(face_color)):
        rows = np.repeat(face_color[block], corners[block] if isinstance(corners, np.ndarray) else corners)
        np.take(table, rows, axis=0, out=colors[done : done + len(rows)], mode="clip")  # other modes make a copy
        done += len(rows)
    return colors
