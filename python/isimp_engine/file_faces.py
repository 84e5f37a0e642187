"""The faces of a file, which may be polygons: the triangles of each, and a region for each."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ._core import triangulate


def cut(
    vertices: NDArray[np.float64], loops: NDArray[np.int32], loop_start: NDArray[np.int32]
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """The polygons cut into triangles, and the polygon of each; where all are triangles, `loops` itself."""
    count = len(loop_start)
    if len(loops) == 3 * count and np.array_equal(loop_start, np.arange(0, 3 * count, 3, dtype=np.int32)):
        return loops.reshape(count, 3), np.arange(count, dtype=np.int32)
    return triangulate(vertices, loops, loop_start)


def joined(
    parts: Sequence[tuple[NDArray[np.float64], NDArray[np.int32]]],
) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """The vertices (V, 3) and triangles (F, 3) of several meshes as one. Raises ValueError for too many vertices."""
    first = np.cumsum([0] + [len(vertices) for vertices, _ in parts])
    if first[-1] > np.iinfo(np.int32).max:
        raise ValueError(f"{first[-1]:,} vertices are too many")
    rows = [triangles + np.int32(base) for (_, triangles), base in zip(parts, first, strict=False)]
    vertices = np.concatenate([np.zeros((0, 3)), *(vertices for vertices, _ in parts)])
    return vertices, np.concatenate([np.zeros((0, 3), np.int32), *rows])


def largest_shares(
    face: NDArray[np.int32], region: NDArray[np.int32], area: NDArray[np.float64]
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Each face once, and the region with the most of its area, the lowest of equals."""
    pairs, place = np.unique(np.stack([face, region], axis=1), axis=0, return_inverse=True)
    total = np.bincount(place.ravel(), weights=area, minlength=len(pairs))
    order = np.lexsort((-pairs[:, 1], total, pairs[:, 0]))
    faces, regions = pairs[order].T
    last = np.append(faces[1:] != faces[:-1], True)
    return faces[last], regions[last]
