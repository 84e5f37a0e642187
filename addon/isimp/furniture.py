"""Finds the regions of a room that are furniture: neither walls, floor and ceiling, nor pieces of these. numpy only."""

from __future__ import annotations

import numpy as np

_LEVEL, _ALIKE = 0.9, 0.9  # cosines: from which a plane counts as level, and as facing as another
_BEHIND = 0.05  # share of the area behind a level plane from which it is no floor and no ceiling
_ON = 0.02  # distance from a wall, as a share of the scan's diagonal, within which a region is a piece of it
_WALL_HEIGHT = 0.5  # share of the room's height that a wall spans


def furniture(vertices, triangles, label: np.ndarray, up, smallest: float) -> np.ndarray:
    """Return (R,) bool: the regions that are furniture.

    vertices (V, 3), triangles (T, 3), label (T,) the region of each triangle, -1 for none. up: (3,).
    smallest: the share of the area that a wall, a floor or a ceiling has at least.
    """
    count = int(label.max(initial=-1)) + 1
    if not count:
        return np.zeros(0, bool)
    corners = np.asarray(vertices, np.float64)[triangles[label >= 0]]
    of, up = label[label >= 0], np.asarray(up, np.float64) / np.linalg.norm(up)
    crossed = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(crossed, axis=1)
    area = np.bincount(of, size, count)

    def summed(values):
        return np.stack([np.bincount(of, values[:, k], count) for k in range(3)], axis=1).astype(np.float64)

    normal = summed(crossed)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    middle = summed(size[:, None] * corners.mean(axis=1)) / np.maximum(area, 1e-300)[:, None]
    reach = _ON * float(np.linalg.norm(np.ptp(corners.reshape(-1, 3), axis=0)))
    height = corners @ up
    low, high = np.full(count, np.inf), np.full(count, -np.inf)
    np.minimum.at(low, of, height.min(axis=1))
    np.maximum.at(high, of, height.max(axis=1))
    room = float(np.ptp(height))

    large = np.flatnonzero(area >= smallest * area.sum())
    shell = [region for region in large if _is_shell(region, normal, middle, area, up, reach, high - low, room)]
    is_piece = np.zeros(count, bool)
    for region in shell:
        away = np.abs((middle - middle[region]) @ normal[region])
        is_piece |= (away <= reach) & (normal @ normal[region] >= _ALIKE)
        is_piece[region] = True
    return (area > 0) & ~is_piece


def _is_shell(region: int, normal, middle, area, up, reach: float, tall, room: float) -> bool:
    """Return whether a large region is a floor, a ceiling or a roof, with nearly nothing behind it, or a high wall."""
    behind = (middle - middle[region]) @ normal[region] < -reach
    if area[behind].sum() <= _BEHIND * area.sum():
        return True
    return bool(abs(normal[region] @ up) < 1 - _LEVEL and tall[region] >= _WALL_HEIGHT * room)
