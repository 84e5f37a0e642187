"""Cuts non-planar polygons into triangles. Numpy only."""

import numpy as np

from .shapes import Array


def ears(points: Array) -> list[tuple[int, int, int]]:
    """Return triangles of a polygon, simple in the projection along its normal: ears, the roundest first."""
    area = np.cross(points - points[0], np.roll(points, -1, axis=0) - points[0]).sum(axis=0)
    axis = area / max(float(np.linalg.norm(area)), 1e-300)
    x = np.cross(axis, np.eye(3)[int(np.abs(axis).argmin())])
    flat = np.stack([points @ x, points @ np.cross(axis, x)], axis=1)
    left, found = list(range(len(points))), []
    while len(left) > 3:
        best, score = 0, -np.inf
        for k in range(len(left)):
            a, b, c = left[k - 1], left[k], left[(k + 1) % len(left)]
            value = _roundness(flat[[a, b, c]])
            if value > score and (value <= 0 or not _has_inside(flat, (a, b, c), left)):
                best, score = k, value
        found.append((left[best - 1], left[best], left[(best + 1) % len(left)]))
        left.pop(best)
    return [*found, (left[0], left[1], left[2])]


def _turn(a: Array, b: Array, c: Array) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


def _roundness(corners: Array) -> float:
    """Return the area over the longest edge squared, negative for a flipped triangle."""
    a, b, c = corners
    longest = max(float(((a - b) ** 2).sum()), float(((b - c) ** 2).sum()), float(((c - a) ** 2).sum()))
    return _turn(a, b, c) / max(longest, 1e-300)


def _has_inside(flat: Array, ear: tuple[int, int, int], left: list[int]) -> bool:
    a, b, c = flat[list(ear)]
    for k in left:
        if k in ear:
            continue
        p = flat[k]
        if _turn(a, b, p) >= 0 and _turn(b, c, p) >= 0 and _turn(c, a, p) >= 0:
            return True
    return False
