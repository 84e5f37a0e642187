"""Smooths region borders on the faces of a scan. numpy only."""

from collections import deque
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Bools = NDArray[np.bool_]
Indices = NDArray[np.integer[Any]]
Labels = NDArray[np.int32]


def smoothed(
    label: Labels,
    pairs: Indices,
    inside: Bools,
    fixed: Bools,
    rounds: int,
    poll: Callable[[], None] = lambda: None,
) -> Labels:
    """Return labels after diffusion: each face has the region with the largest share in its neighbourhood.

    The indicator functions of the regions diffuse over faces that share an edge, by one ring in each round. Then each
    face gets the region with the largest value, so borders move by their curvature (Merriman, Bence, Osher 1992). In a
    tie a face keeps its region.

    label: (F,) region, -1 for none. pairs: (E, 2) faces that share an edge. inside: (F,) bool, faces that may change.
    fixed: (R,) bool, regions that must not change. poll: called every round; an exception ends the work.
    Cost: O(E) for each round, times the number of regions nearby.
    """
    near = inside.copy()
    for _ in range(rounds):  # the range of the diffusion
        poll()
        near[pairs[near[pairs].any(axis=1)].ravel()] = True
    pairs = pairs[near[pairs].all(axis=1)]
    faces, ends = np.unique(pairs, return_inverse=True)
    ends = ends.reshape(-1, 2)
    own = label[faces]
    movable = inside[faces] & (own >= 0)
    movable[movable] = ~fixed[own[movable]]
    regions, column = np.unique(own, return_inverse=True)
    takes = regions >= 0
    takes[takes] = ~fixed[regions[takes]]
    share = np.zeros((len(faces), len(regions)))
    share[np.arange(len(faces)), column] = 1.0
    around = np.maximum(np.bincount(ends.ravel(), minlength=len(faces)), 1)[:, None]
    start = share
    for _ in range(rounds):
        poll()
        sum_around = np.zeros_like(share)
        for here, there in (ends.T, ends.T[::-1]):
            for region in range(len(regions)):
                sum_around[:, region] += np.bincount(here, share[there, region], len(faces))
        share = 0.5 * share + 0.5 * sum_around / around
    share = np.where(takes, share, -1.0) + 1e-9 * start
    made = label.copy()
    made[faces[movable]] = regions[np.argmax(share[movable], axis=1)]
    return made


def shortened(label: Labels, pairs: Indices, length: NDArray[np.float64], inside: Bools, fixed: Bools) -> Labels:
    """Return labels in which no single face can move to an adjacent region and shorten the borders.

    This removes a tooth of one triangle, since two of its sides are longer than the third. length: (E,) of the edge of
    each pair. Other parameters: see `smoothed`. Cost: linear in the faces inside and the moves.
    """
    made = label.copy()
    touched = inside[pairs].any(axis=1)
    beside: dict[int, list[tuple[int, float]]] = {}
    for (here, there), long in zip(pairs[touched].tolist(), length[touched].tolist(), strict=True):
        for face, other in ((here, there), (there, here)):
            if inside[face]:
                beside.setdefault(face, []).append((other, long))
    at_border = (made[pairs[:, 0]] != made[pairs[:, 1]]) & touched
    waiting = deque(face for face in np.unique(pairs[at_border]).tolist() if face in beside)
    while waiting:
        face = waiting.popleft()
        own = int(made[face])
        along: dict[int, float] = {}
        for other, long in beside[face]:
            along[int(made[other])] = along.get(int(made[other]), 0.0) + long
        best = min(along, key=lambda region: (-along[region], region))
        gain = along[best] - along.get(own, 0.0)
        if min(own, best) >= 0 and not (fixed[own] or fixed[best]) and gain > 1e-6 * sum(along.values()):
            made[face] = best
            waiting.extend(other for other, _ in beside[face] if other in beside)
    return made


def reachable(wanted: Bools, home: Bools, pairs: Indices) -> Bools:
    """Return (F,) bool: the wanted faces that are connected to `home` over wanted faces. Both (F,) bool."""
    pairs = pairs[(wanted | home)[pairs].all(axis=1) & wanted[pairs].any(axis=1)]
    reached = home.copy()
    while True:
        ends = reached[pairs]
        fresh = pairs[ends[:, 0] != ends[:, 1]].ravel()
        if not len(fresh):
            return reached & wanted
        reached[fresh] = True
