"""N-gons in glTF, which has triangles only: the extension FB_ngon_encoding.

Consecutive triangles with the same first vertex are one polygon: a fan around that vertex. A polygon without a corner
from which it is visible as a whole becomes several.
"""

import numpy as np
from numpy.typing import NDArray

NAME = "FB_ngon_encoding"
_THIN = 1e-6  # least area of a triangle of a fan, as a share of the polygon's area


def fans(
    places: NDArray[np.float64],
    loop_start: NDArray[np.int32],
    triangles: NDArray[np.int32],
    polygon: NDArray[np.int32],
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """(F, 3) triangles that fill polygons, as fans if the whole polygon is visible from a corner, and their polygons.

    places: (L, 3) of each corner, polygon after polygon. triangles, polygon: any triangulation by corners. Polygons
    without a fan keep their triangles; consecutive triangles begin at different corners.
    """
    ends = np.append(loop_start, len(places)).astype(np.int64)
    first, count = np.searchsorted(polygon, np.arange(len(loop_start) + 1)), np.diff(ends)
    made = []
    for q in range(len(loop_start)):
        own = triangles[first[q] : first[q + 1]]
        if count[q] > 3:
            k = _eye(places[ends[q] : ends[q + 1]])
            if k >= 0:
                ring = ends[q] + (k + np.arange(count[q])) % count[q]
                own = np.stack([np.full(count[q] - 2, ring[0]), ring[1:-1], ring[2:]], axis=1)
            else:
                own = _apart(own)
        made.append(own)
    found = np.concatenate(made) if made else np.zeros((0, 3))
    return found.astype(np.int32), np.repeat(np.arange(len(made), dtype=np.int32), [len(own) for own in made])


def _eye(corners: NDArray[np.float64]) -> int:
    """The first corner from which a fan fills the polygon; -1 if there is none."""
    count = len(corners)
    normal = np.cross(corners - corners[0], np.roll(corners, -1, axis=0) - corners[0]).sum(axis=0)
    whole = np.linalg.norm(normal)
    if not whole > 0:
        return -1
    for k in range(count):
        ring = np.roll(corners, -k, axis=0)
        parts = np.cross(ring[1:-1] - ring[0], ring[2:] - ring[0]) @ (normal / whole)
        if (parts > _THIN * whole).all():
            return k
    return -1


def _apart(triangles: NDArray[np.int32]) -> NDArray[np.int32]:
    """The same triangles, turned so that each begins at another corner than the one before it."""
    turned = triangles.copy()
    for i in range(1, len(turned)):
        if turned[i, 0] == turned[i - 1, 0]:
            turned[i] = np.roll(turned[i], -1)
    return turned


def decoded(triangles: NDArray[np.int32]) -> NDArray[np.int32]:
    """(F,) the polygon of each triangle, by the extension."""
    if not len(triangles):
        return np.zeros(0, np.int32)
    return np.concatenate([[0], np.cumsum(triangles[1:, 0] != triangles[:-1, 0])]).astype(np.int32)


def rings(triangles: NDArray[np.int32], polygon: NDArray[np.int32]) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """(loops, loop_start) of polygons that are fans: the second corner of each triangle, and the ends."""
    count = int(polygon.max(initial=-1)) + 1
    first = np.searchsorted(polygon, np.arange(count))
    size = np.bincount(polygon, minlength=count) + 2
    start = np.concatenate([[0], np.cumsum(size)[:-1]]).astype(np.int32) if count else np.zeros(0, np.int32)
    loops = np.empty(int(size.sum()), np.int32)
    loops[start] = triangles[first, 0]
    place = start[polygon] + 1 + np.arange(len(triangles)) - first[polygon]
    loops[place] = triangles[:, 1]
    loops[start + size - 1] = triangles[first + size - 3, 2]
    return loops, start
