"""Finds the triangles that change their region as the border between two regions is dragged. numpy only."""

from __future__ import annotations

import numpy as np

from . import view

_STRIP = 3.0  # width of the strip of the growing region to which moved triangles are connected, in edges


def one_border(edges: np.ndarray, vertex: int) -> np.ndarray:
    """Return the edges of the border that has a vertex. edges: (K, 2) vertices of all edges between two regions.

    Two regions may have several borders: one around a hole, or one on each side of a strip.
    """
    found: np.ndarray = edges[np.isin(edges[:, 0], view.connected(np.unique(edges), edges, vertex))]
    return found


def swept(
    centers: np.ndarray,
    is_taker: np.ndarray,
    border: np.ndarray,
    pairs: np.ndarray,
    drag: np.ndarray,
    sight: np.ndarray,
) -> np.ndarray:
    """Return the triangles that move to the growing region as the border is dragged, and a strip of its own triangles.

    Points are projected along the view direction. A triangle moves if it lies between a point of the border and the
    same point moved by the drag, and is connected to the strip.

    centers: (T, 3) of the visible triangles of both regions. is_taker: (T,) whether one is of the growing region.
    border: (K, 2, 3) the ends of the edges of `one_border`. pairs: (E, 2) of the T triangles that share an edge.
    drag, sight: (3,) the drag and the view direction. Returns (N,) numbers of triangles; empty if the border does not
    move into the neighbour.
    """
    sight = sight / np.linalg.norm(sight)
    along = drag - (drag @ sight) * sight
    length = float(np.linalg.norm(along))
    if length <= 0 or not len(border) or not len(centers):
        return np.empty(0, np.int64)
    along /= length
    axes = np.stack([along, np.cross(sight, along)], axis=1)
    line, at = border.mean(axis=1) @ axes, centers @ axes
    edge = float(np.median(np.linalg.norm((border[:, 0] - border[:, 1]) @ axes, axis=1)))
    order = np.argsort(line[:, 1], kind="stable")
    line = line[order]
    ahead = _ahead(at, line, edge)
    inside = np.where(is_taker, (ahead <= 0.5 * edge) & (ahead > -_STRIP * edge), (ahead > -edge) & (ahead <= length))
    chosen = np.flatnonzero(inside)
    home = chosen[is_taker[chosen]]
    if not len(home) or len(home) == len(chosen):
        return np.empty(0, np.int64)
    middle = 0.5 * (line[0, 1] + line[-1, 1])
    start = int(home[np.argmin(np.abs(at[home, 1] - middle))])
    return view.connected(chosen, pairs, start)


def _ahead(at: np.ndarray, line: np.ndarray, edge: float) -> np.ndarray:
    """Return (T,) the distance of each point ahead of the border along the drag; NaN past the ends of the border.

    line: (K, 2) points of the border, along the drag and across it, in rising order across.
    """
    after = np.clip(np.searchsorted(line[:, 1], at[:, 1]), 0, len(line) - 1)
    before = np.maximum(after - 1, 0)
    far = np.abs(line[[before, after], 1] - at[:, 1])
    nearest = np.where(far[0] <= far[1], before, after)
    ahead: np.ndarray = at[:, 0] - line[nearest, 0]
    ahead[np.minimum(far[0], far[1]) > 2 * edge] = np.nan
    return ahead
