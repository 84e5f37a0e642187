"""Where on the scan the corners of polygons lie: what colours, UVs and shapes are carried over with."""

import numpy as np
from numpy.typing import NDArray

from .._core import Job, Mesh, Partition, PolygonMesh, _closest_places, _source_corners


def corner_sources(
    mesh: Mesh,
    part: Partition,
    poly: PolygonMesh,
    vertices: NDArray[np.float64],
    triangles: NDArray[np.int32],
    job: Job | None = None,
    *,
    threads: int = 0,
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """(L,) triangle and (L, 3) weights of its corners: the place of the scan that each corner in `loops` is closest to.

    Only the polygon's own region counts, so that a thin arm takes nothing from its other side. A value of the scan's
    corners, (T, 3, n), is `numpy.einsum("lc,lcn->ln", weights, values[triangle])` at the polygons' corners.
    vertices, triangles: what the mesh was made from. A triangle of -1: none is known.
    Raises InvalidInput (parts that do not belong together) or Cancelled.
    """
    source, on_source, _, _ = _source_corners(mesh, vertices, triangles, job)
    face, weight = _closest_places(mesh, part, poly, (source >= 0).astype(np.uint8), threads, job)
    at = np.maximum(face, 0)
    own = np.stack([1 - weight.sum(axis=1), weight[:, 0], weight[:, 1]], axis=1)
    inner = np.stack([1 - on_source[at].sum(axis=2), on_source[at][:, :, 0], on_source[at][:, :, 1]], axis=2)
    weights = np.einsum("lk,lkc->lc", own, inner).astype(np.float32)
    triangle = np.where(face >= 0, source[at], -1).astype(np.int32)
    return triangle, weights
