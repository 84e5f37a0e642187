"""Finds faces that a ray meets or a brush covers, by its own search structure. numpy only."""

from __future__ import annotations

import numpy as np

_LEAF = 64  # faces in a box of the lower level
_BRANCH = 64  # boxes in a box of the upper level


class Surface:
    """Triangles in two levels of boxes. A million faces take about half a second, a ray about a millisecond.

    area: the area of all triangles.
    """

    def __init__(self, vertices: np.ndarray, triangles: np.ndarray):
        """vertices (V, 3) float; triangles (T, 3) int, T at least 1. Faces that aren't finite are ignored."""
        corners = np.asarray(vertices, np.float32)[triangles]
        low, high = corners.min(axis=1), corners.max(axis=1)
        centers = (low + high) / 2
        self._order = _along_curve(centers)
        self._corner = corners[self._order]
        self._center = self._corner.mean(axis=1)
        edges = self._corner[:, 1:] - self._corner[:, :1]
        normal = np.cross(edges[:, 0], edges[:, 1])
        length = np.linalg.norm(normal, axis=1, keepdims=True)
        self._normal = np.divide(normal, length, out=np.zeros_like(normal), where=length > 0)
        self._leaves = _boxes(low[self._order], high[self._order], _LEAF)
        self._branches = _boxes(*self._leaves, _BRANCH)
        self.area = area(vertices, triangles)

    def cast(self, origin, direction) -> tuple[int, np.ndarray] | None:
        """Return (triangle, point) of the first hit of a ray, or None. Both sides of a triangle count."""
        origin, direction = np.asarray(origin, np.float64), np.asarray(direction, np.float64)
        leaves = self._within(lambda low, high: _meets(origin, direction, low, high))
        faces = _spread(leaves, _LEAF, len(self._order))
        if not len(faces):
            return None
        a, b, c = np.moveaxis(self._corner[faces].astype(np.float64), 1, 0)
        ab, ac, to = b - a, c - a, origin - a
        p = np.cross(direction, ac)
        with np.errstate(divide="ignore", invalid="ignore"):
            inverse = 1.0 / np.einsum("ij,ij->i", ab, p)
            u = np.einsum("ij,ij->i", to, p) * inverse
            q = np.cross(to, ab)
            v = q @ direction * inverse
            far = np.einsum("ij,ij->i", ac, q) * inverse
            hit = (u >= -1e-9) & (v >= -1e-9) & (u + v <= 1 + 1e-9) & (far >= 0) & np.isfinite(far)
        if not hit.any():
            return None
        first = np.flatnonzero(hit)[np.argmin(far[hit])]
        return int(self._order[faces[first]]), origin + far[first] * direction

    def ball(self, center, radius: float, facing=None) -> np.ndarray:
        """Return triangles whose center is within a radius, in rising order. facing: keeps only triangles facing it."""
        center = np.asarray(center, np.float64)
        leaves = self._within(lambda low, high: _near(center, radius, low, high))
        faces = _spread(leaves, _LEAF, len(self._order))
        inside = ((self._center[faces] - center) ** 2).sum(axis=1) <= radius * radius
        if facing is not None:
            inside &= self._normal[faces] @ np.asarray(facing, np.float64) < 0
        return np.sort(self._order[faces[inside]])

    def normal(self, triangle: int) -> np.ndarray:
        """Return (3,) the unit normal; zero for a triangle without area."""
        a, b, c = self._corner[np.flatnonzero(self._order == triangle)[0]].astype(np.float64)
        normal = np.cross(b - a, c - a)
        length = np.linalg.norm(normal)
        return normal / length if length > 0 else normal

    def _within(self, inside) -> np.ndarray:
        """Return the lower boxes that fulfil a condition together with their upper box."""
        branches = np.flatnonzero(inside(*self._branches))
        leaves = _spread(branches, _BRANCH, len(self._leaves[0]))
        return leaves[inside(self._leaves[0][leaves], self._leaves[1][leaves])]


def _along_curve(points: np.ndarray) -> np.ndarray:
    """Return the order of points along a Morton curve."""
    finite = np.isfinite(points).all(axis=1)
    low = points[finite].min(axis=0) if finite.any() else np.zeros(3)
    extent = float((points[finite] - low).max()) if finite.any() else 0.0
    cell = np.nan_to_num((points - low) * (1023.0 / extent if extent > 0 else 0.0)).clip(0, 1023).astype(np.uint32)
    code = np.zeros(len(points), np.uint32)
    for axis in range(3):
        bits = cell[:, axis]
        for shift, mask in ((16, 0x030000FF), (8, 0x0300F00F), (4, 0x030C30C3), (2, 0x09249249)):
            bits = (bits | bits << shift) & mask
        code |= bits << axis
    return np.argsort(code, kind="stable")


def _boxes(low: np.ndarray, high: np.ndarray, size: int) -> tuple[np.ndarray, np.ndarray]:
    start = np.arange(0, len(low), size)
    return np.fmin.reduceat(low, start), np.fmax.reduceat(high, start)


def _spread(groups: np.ndarray, size: int, count: int) -> np.ndarray:
    """Return the members of groups of `size` consecutive members, of `count` in total."""
    members = (groups[:, None] * size + np.arange(size)).ravel()
    return members[members < count]


def _meets(origin, direction, low, high) -> np.ndarray:
    """Return whether a ray meets each box."""
    with np.errstate(divide="ignore", invalid="ignore"):
        near, far = (low - origin) / direction, (high - origin) / direction
    begin, end = np.fmin(near, far), np.fmax(near, far)
    still = direction == 0
    if still.any():
        inside = (low[:, still] <= origin[still]) & (origin[still] <= high[:, still])
        begin[:, still] = np.where(inside, -np.inf, np.inf)
        end[:, still] = np.where(inside, np.inf, -1.0)
    first, last = begin.max(axis=1).clip(0), end.min(axis=1)
    return first <= last + 1e-6 * np.abs(last)


def _near(center, radius, low, high) -> np.ndarray:
    """Return whether each box is within a radius of a point."""
    away = np.maximum(np.maximum(low - center, center - high), 0.0)
    return (away**2).sum(axis=1) <= radius * radius * (1 + 1e-6)


def area(vertices: np.ndarray, triangles: np.ndarray) -> float:
    return float(0.5 * _lengths(_crosses(vertices, triangles)).sum())


def _crosses(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return (T, 3) normals twice as long as the areas, three times as fast as `np.cross`."""
    vertices = vertices.astype(np.float64)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    b -= a
    c -= a
    for k, (i, j) in enumerate(((1, 2), (2, 0), (0, 1))):
        a[:, k] = b[:, i] * c[:, j] - b[:, j] * c[:, i]
    return a


def _lengths(vectors: np.ndarray) -> np.ndarray:
    return np.sqrt(np.einsum("ij,ij->i", vectors, vectors))


def flatness(vertices: np.ndarray, triangles: np.ndarray, chosen: np.ndarray) -> tuple[float, float, float]:
    """Return (area, error, largest distance of a corner from the mean plane) of chosen triangles.

    The error is the sum of area times squared distance of the normal from the mean normal, like the engine's.
    """
    a, b, c = (vertices[triangles[chosen, k]].astype(np.float64) for k in range(3))
    cross = np.cross(b - a, c - a) / 2
    size = np.linalg.norm(cross, axis=1)
    total = float(size.sum())
    normal = cross.sum(axis=0)
    length = np.linalg.norm(normal)
    if total <= 0 or length <= 0:
        return total, 0.0, 0.0
    middle = (size[:, None] * (a + b + c) / 3).sum(axis=0) / total
    corners = np.concatenate([a, b, c]) - middle
    return total, max(0.0, 2 * float(total - length)), float(np.abs(corners @ (normal / length)).max())
