"""The places of polygons' corners on the scan, to transfer colours, UVs and shapes."""

import numpy as np
from numpy.typing import NDArray

from .._core import InvalidInput, Job, Mesh, Partition, PolygonMesh, _closest_places, _source_corners


def corner_sources(
    mesh: Mesh,
    part: Partition,
    poly: PolygonMesh,
    vertices: NDArray[np.float64],
    triangles: NDArray[np.int32],
    job: Job | None = None,
    *,
    islands: NDArray[np.int32] | None = None,
    threads: int = 0,
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """(L,) triangle and (L, 3) weights of its corners: the place of the scan that each corner in `loops` is closest to.

    Only the polygon's own region counts, so that a thin arm takes nothing from its other side. A value of the scan's
    corners, (T, 3, n), is `numpy.einsum("lc,lcn->ln", weights, values[triangle])` at the polygons' corners.
    vertices, triangles: the input of the mesh. A triangle of -1: none is known.
    islands: (T,) int32, as `uv_islands` makes them: only the island that has most of the region's area counts, since
    values between two islands mean nothing.
    Raises InvalidInput (parts that do not belong together) or Cancelled.
    """
    source, on_source, _, _ = _source_corners(mesh, vertices, triangles, job)
    group = np.zeros(0, dtype=np.int32)
    if islands is not None:
        island = np.asarray(islands)
        if island.shape != (len(triangles),) or island.dtype.kind not in "iu":
            wanted = f"islands must have the shape ({len(triangles)},) and integers"
            raise InvalidInput(f"{wanted}, got {island.shape} and {island.dtype}")
        group = np.where(source >= 0, island[np.maximum(source, 0)], -1).astype(np.int32)
    face, weight = _closest_places(mesh, part, poly, (source >= 0).astype(np.uint8), group, threads, job)
    at = np.maximum(face, 0)
    own = np.stack([1 - weight.sum(axis=1), weight[:, 0], weight[:, 1]], axis=1)
    inner = np.stack([1 - on_source[at].sum(axis=2), on_source[at][:, :, 0], on_source[at][:, :, 1]], axis=2)
    weights = np.einsum("lk,lkc->lc", own, inner).astype(np.float32)
    triangle = np.where(face >= 0, source[at], -1).astype(np.int32)
    return triangle, weights


def uv_islands(triangles: NDArray[np.int32], uv: NDArray[np.float64]) -> NDArray[np.int32]:
    """(T,) int32 the island of a UV map of each triangle: the number of the first triangle in it.

    Triangles are of one island where they share an edge with the same UVs at both of its ends.
    triangles: (T, 3). uv: (T, 3, 2) of their corners. Raises InvalidInput (another shape). Cost: O(T log T).
    """
    triangles, uv = np.asarray(triangles), np.asarray(uv)
    count = len(triangles) if triangles.ndim else 0
    if triangles.shape != (count, 3) or triangles.dtype.kind not in "iu":
        wanted = "triangles must have the shape (T, 3) and integers"
        raise InvalidInput(f"{wanted}, got {triangles.shape} and {triangles.dtype}")
    if uv.shape != (count, 3, 2) or uv.dtype.kind not in "fiu":
        raise InvalidInput(f"uv must have the shape ({count}, 3, 2) and numbers, got {uv.shape} and {uv.dtype}")
    a, b = triangles, np.roll(triangles, -1, axis=1)
    p, q = uv, np.roll(uv, -1, axis=1)
    swap = a > b
    low, high = np.where(swap, b, a).ravel(), np.where(swap, a, b).ravel()
    ends = np.where(swap[:, :, None], np.concatenate([q, p], axis=2), np.concatenate([p, q], axis=2)).reshape(-1, 4)
    order = np.lexsort((*ends.T, high, low))
    same = (low[order][1:] == low[order][:-1]) & (high[order][1:] == high[order][:-1])
    same &= (ends[order][1:] == ends[order][:-1]).all(axis=1)
    face = order // 3
    one, other = face[:-1][same], face[1:][same]
    label = np.arange(count)
    while True:
        least = np.minimum(label[one], label[other])
        before = label.copy()
        np.minimum.at(label, label[one], least)
        np.minimum.at(label, label[other], least)
        label = label[label]
        if np.array_equal(before, label):
            return label.astype(np.int32)
