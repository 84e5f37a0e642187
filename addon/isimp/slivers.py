"""Chooses the neighbour that each small region is merged with. Numpy only."""

from __future__ import annotations

import numpy as np


def merges(
    label: np.ndarray, pairs: np.ndarray, area: np.ndarray, normal: np.ndarray, locked: np.ndarray, share: float
) -> list[tuple[int, int]]:
    """Return [(region to keep, region to merge into it)], the smallest first, with the numbers before all merges.

    label (F,) the region of each face, -1 for none; pairs (P, 2) faces that share an edge; area (R,) and normal (R, 3),
    the sum of the areas times the normals, of each region; locked: numbers of regions that must not change.
    A region below `share` of the mean area is merged into the neighbour with the most similar plane.
    """
    count = len(area)
    ends = label[pairs]
    ends = ends[(ends[:, 0] != ends[:, 1]) & (ends >= 0).all(axis=1) & ~np.isin(ends, locked).any(axis=1)]
    beside: list[set[int]] = [set() for _ in range(count)]
    for a, b in np.unique(np.sort(ends, axis=1), axis=0).tolist():
        beside[a].add(b)
        beside[b].add(a)
    is_there = area > 0
    small = np.flatnonzero(is_there & (area < share * area[is_there].mean())) if is_there.any() else np.empty(0, int)
    unit = normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    home = list(range(count))  # the region that each is merged into

    def root(region: int) -> int:
        while home[region] != region:
            region = home[region]
        return region

    found = []
    for region in sorted(small.tolist(), key=lambda each: (area[each], each)):
        if root(region) != region:  # merged already
            continue
        others = {root(other) for other in beside[region]} - {region}
        if others:
            onto = max(others, key=lambda other: (float(unit[other] @ unit[region]), -other))
            found.append((onto, region))
            home[region] = onto
    return found
