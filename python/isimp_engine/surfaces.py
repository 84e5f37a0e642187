"""Areas and connected pieces of triangle meshes, for all modules."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

_FAR = 1e3  # times the size: coordinates further from zero lose too many digits
_BLOCK = 1 << 14  # triangles at once, so that intermediate values stay in a cache


def areas(vertices: NDArray[Any], triangles: NDArray[Any]) -> NDArray[np.float64]:
    """(F,) areas of triangles (F, 3) of vertices (V, 3). Cost: O(F)."""
    found = np.empty(len(triangles))
    for begin in range(0, len(triangles), _BLOCK):
        corners = vertices[triangles[begin : begin + _BLOCK]].reshape(-1, 9).T
        corners = np.ascontiguousarray(corners, dtype=np.float64)
        (ux, uy, uz), (vx, vy, vz) = corners[3:6] - corners[:3], corners[6:] - corners[:3]
        x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        found[begin : begin + _BLOCK] = np.sqrt(x * x + y * y + z * z) / 2
    return found


def far_from_zero(points: NDArray[Any]) -> NDArray[np.float64]:
    """What to subtract from points (N, 3) for a file in single precision: whole numbers; 0 where they are near zero."""
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    return np.where(np.abs(middle) > _FAR * size, np.round(middle), 0.0)


def pieces(count: int, pairs: NDArray[Any]) -> NDArray[np.intp]:
    """(count,) the least element of the connected piece of each element. pairs: (E, 2) elements that are connected.

    Cost: O((count + E) log count), more for long paths.
    """
    piece = np.arange(count)
    while True:
        least = piece.copy()
        np.minimum.at(least, pairs[:, 0], piece[pairs[:, 1]])
        np.minimum.at(least, pairs[:, 1], piece[pairs[:, 0]])
        least = least[least]
        if np.array_equal(least, piece):
            return piece
        piece = least
