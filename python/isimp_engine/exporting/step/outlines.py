"""Groups polygons into faces of a boundary representation, and finds the chains of edges between the groups."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Chain:
    """Consecutive edges with one group at the left and one, or none, at the right. A closed chain ends at its begin."""

    vertices: list[int]  #: vertices of the polygons; a closed chain repeats the first one at its end
    left: int
    right: int  #: -1: none
    closed: bool


@dataclass(frozen=True)
class Outlines:
    """Connected groups of polygons and their borders."""

    of_polygon: NDArray[np.int64]  #: (Q,) the group of each polygon
    chains: list[Chain]
    loops: list[list[list[tuple[int, bool]]]]  #: loops of each group: chains, and whether they run forward
    junctions: dict[int, set[int]]  #: the groups at each vertex where chains end


class _Edges:
    """Half-edges of polygons, numbered by the corners where they begin."""

    def __init__(self, loops: NDArray[np.int64], start: NDArray[np.int64]) -> None:
        self.begin = loops
        self.after = np.arange(1, len(loops) + 1)
        if len(start):
            self.after[np.append(start[1:], len(loops)) - 1] = start
        self.end = loops[self.after]
        self.polygon = np.repeat(np.arange(len(start)), np.diff(start, append=len(loops)))
        count = int(loops.max(initial=0)) + 1
        keys, back = self.begin * count + self.end, self.end * count + self.begin
        order = np.argsort(keys, kind="stable")
        ordered = keys[order]
        low, high = np.searchsorted(ordered, back, "left"), np.searchsorted(ordered, back, "right")
        once = np.searchsorted(ordered, keys, "right") - np.searchsorted(ordered, keys, "left") == 1
        has = (high - low == 1) & once
        self.twin = np.full(len(loops), -1)
        self.twin[has] = order[low[has]]


def outlines(loops: NDArray[np.int64], start: NDArray[np.int64], key: NDArray[np.int64]) -> Outlines:
    """Return the groups of connected polygons with equal keys. loops, start: see PolygonMesh. key: (Q,)."""
    edges = _Edges(loops, start)
    group = _components(edges, key)
    twin_group = np.where(edges.twin >= 0, group[edges.polygon[edges.twin]], -1)
    own = group[edges.polygon]
    border = own != twin_group
    ends = _ends(edges, own, twin_group, border)
    chains: list[Chain] = []
    place: dict[int, tuple[int, int]] = {}  # half-edge -> its chain, and 1 if it runs along the chain, else -1
    runs: list[list[list[int]]] = [[] for _ in range(int(group.max(initial=-1)) + 1)]
    closed: set[int] = set()
    for loop in _loops(edges, own, border):
        cuts = [k for k, half in enumerate(loop) if int(edges.begin[half]) in ends]
        if not cuts:
            closed.add(loop[0])
            parts = [_from_least(loop, edges)]
            closed.add(parts[0][0])
        else:
            turned = loop[cuts[0] :] + loop[: cuts[0]]
            at = [k - cuts[0] for k in cuts] + [len(loop)]
            parts = [turned[a:b] for a, b in pairwise(at)]
        for part in parts:
            left, right = int(own[part[0]]), int(twin_group[part[0]])
            if right == -1 or left < right:
                for half in part:
                    place[half] = len(chains), 1
                    if edges.twin[half] >= 0:
                        place[int(edges.twin[half])] = len(chains), -1
                corners = [int(edges.begin[half]) for half in part] + [int(edges.end[part[-1]])]
                chains.append(Chain(corners, left, right, not cuts))
        runs[int(own[loop[0]])].append([part[0] for part in parts])
    borders = [[[(place[h][0], place[h][1] > 0) for h in loop] for loop in group_loops] for group_loops in runs]
    return Outlines(group, chains, borders, ends)


def _components(edges: _Edges, key: NDArray[np.int64]) -> NDArray[np.int64]:
    group = np.full(len(key), -1)
    has = edges.twin >= 0
    a, b = edges.polygon[has], edges.polygon[edges.twin[has]]
    same = key[a] == key[b]
    beside: list[list[int]] = [[] for _ in key]
    for p, q in zip(a[same].tolist(), b[same].tolist(), strict=True):
        beside[p].append(q)
    count = 0
    for first in range(len(key)):
        if group[first] >= 0:
            continue
        group[first], todo = count, [first]
        while todo:
            for q in beside[todo.pop()]:
                if group[q] < 0:
                    group[q] = count
                    todo.append(q)
        count += 1
    return group


def _ends(
    edges: _Edges, own: NDArray[np.int64], twin_group: NDArray[np.int64], border: NDArray[np.bool_]
) -> dict[int, set[int]]:
    """Return the vertices where chains end, with their groups: not two border edges of one pair of groups."""
    pairs: dict[int, list[tuple[int, int]]] = {}
    for half in np.flatnonzero(border).tolist():
        a, b = int(own[half]), int(twin_group[half])
        if b >= 0 and a > b:
            continue  # its twin counts
        for v in (int(edges.begin[half]), int(edges.end[half])):
            pairs.setdefault(v, []).append((a, b))
    ends = {v for v, found in pairs.items() if len(found) != 2 or found[0] != found[1]}
    at: dict[int, set[int]] = {v: set() for v in ends}
    for half in np.flatnonzero(border).tolist():
        for v in (int(edges.begin[half]), int(edges.end[half])):
            if v in ends:
                at[v].add(int(own[half]))
    return at


def _loops(edges: _Edges, own: NDArray[np.int64], border: NDArray[np.bool_]) -> list[list[int]]:
    seen = np.zeros(len(own), bool)
    found = []
    for first in np.flatnonzero(border).tolist():
        if seen[first]:
            continue
        loop, half = [], first
        while not seen[half]:
            seen[half] = True
            loop.append(half)
            half = int(edges.after[half])
            while not border[half]:
                half = int(edges.after[edges.twin[half]])
        found.append(loop)
    return found


def _from_least(loop: list[int], edges: _Edges) -> list[int]:
    """Return the loop rotated to its least vertex, so that both sides of a closed chain begin there."""
    first = min(range(len(loop)), key=lambda k: int(edges.begin[loop[k]]))
    return loop[first:] + loop[:first]
