"""Small regions and the neighbours that they become part of. Numpy only."""

from __future__ import annotations

import numpy as np


def merges(
    label: np.ndarray, pairs: np.ndarray, area: np.ndarray, normal: np.ndarray, locked: np.ndarray, share: float
) -> list[tuple[int, int]]:
    """[(region that stays, region that becomes part of it)], the smallest first; both as numbers of before.

    label (F,) the region of each face, -1 for none; pairs (P, 2) faces that share an edge; area (R,) and normal (R, 3),
    the sum of the areas times the normals, of each region; locked: numbers of regions that stay as they are.
    A region below `share` of the mean area becomes part of the neighbour whose plane is most like its own.
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
    home = list(range(count))  # the region that each has become part of

    def root(region: int) -> int:
        while home[region] != region:
            region = home[region]
        return region

    found = []
    for region in sorted(small.tolist(), key=lambda each: (area[each], each)):
        if root(region) != region:  # it has taken or joined others already
            continue
        others = {root(other) for other in beside[region]} - {region}
        if others:
            onto = max(others, key=lambda other: (float(unit[other] @ unit[region]), -other))
            found.append((onto, region))
            home[region] = onto
    return found
