"""Finds the triangles that change their region as a corner of three or more regions is dragged. numpy only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

_REACH = 3.0  # length of a border that moves with its corner, in lengths of the drag


@dataclass(frozen=True)
class Around:
    """The surroundings of a corner: the visible triangles of its regions, and the borders of these regions."""

    centers: np.ndarray  #: (T, 3) of the triangles
    label: np.ndarray  #: (T,) regions of the triangles
    vertices: np.ndarray  #: (V, 3) of the scan
    edges: np.ndarray  #: (K, 2) vertices of the edges between two of these regions
    beside: np.ndarray  #: (K, 2) regions of the edges
    corner: int  #: the vertex where the regions meet


def swept(around: Around, drag: np.ndarray, sight: np.ndarray) -> dict[int, np.ndarray]:
    """Return the triangles that change their region as the corner moves, by their new region.

    Each border is replaced by a straight line from the moved corner to the border's first point beyond a limit, and
    the triangles between both lines change. Points are projected along the view direction.
    drag, sight: (3,) the drag and the view direction.
    """
    axes = np.linalg.svd(sight[None] / np.linalg.norm(sight))[2][1:].T
    place, step = around.vertices[around.corner] @ axes, drag @ axes
    far = _REACH * float(np.linalg.norm(step))
    at = around.centers @ axes
    near = np.linalg.norm(at - place, axis=1) <= far
    passed = []  # by border: the growing region, the shrinking region, and the triangles between the two lines
    for pair in np.unique(np.sort(around.beside, axis=1), axis=0):
        end = _along(around, pair, far, axes)
        if end is None:
            continue
        sides = [_cross(end - place, at[near & (around.label == region)] - place) for region in pair]
        if not all(map(len, sides)):
            continue
        ahead = int((sides[1].mean() - sides[0].mean()) * _cross(end - place, step) > 0)  # index of the shrinking one
        passed.append((pair[1 - ahead], pair[ahead], _in_triangle(at, place, place + step, end)))
    label = around.label.copy()
    for _ in passed:  # several borders may pass a triangle, one after another
        for taker, giver, inside in passed:
            label[inside & (label == giver)] = taker
    changed = np.flatnonzero(label != around.label)
    return {int(region): changed[label[changed] == region] for region in np.unique(label[changed])}


def _along(around: Around, pair: np.ndarray, far: float, axes: np.ndarray) -> np.ndarray | None:
    """Return (2,) the first point beyond `far` on a border from the corner, or its end; None without such a border."""
    edges = around.edges[(np.sort(around.beside, axis=1) == pair).all(axis=1)]
    place, now, seen = around.vertices[around.corner] @ axes, around.corner, {around.corner}
    while True:
        ends = edges[(edges == now).any(axis=1)]
        others = [int(b if a == now else a) for a, b in ends]
        ahead = [v for v in others if v not in seen]
        if not ahead or np.linalg.norm(around.vertices[now] @ axes - place) >= far:
            return None if now == around.corner else around.vertices[now] @ axes
        now = ahead[0]
        seen.add(now)


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    found: np.ndarray = a[0] * b[..., 1] - a[1] * b[..., 0]
    return found


def _in_triangle(at: np.ndarray, a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    sides = np.stack([_cross(q - p, at - p) for p, q in ((a, b), (b, c), (c, a))])
    found: np.ndarray = (sides >= 0).all(axis=0) | (sides <= 0).all(axis=0)
    return found
