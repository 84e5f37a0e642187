"""Barriers from a mesh: sharp edges, borders of a face attribute, marked edges.

All give (K, 2) int32 pairs of vertices, edges of the mesh, for the `barriers` of `partition` and of
`guided.partition_guided`; several are joined by `np.concatenate`.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._core import InvalidInput, Mesh

Pairs = NDArray[np.int32]


def sharp_edges(mesh: Mesh, angle: float) -> Pairs:
    """Edges at which the surface bends by more than `angle`, radians in [0, pi]. Faces without area bend nowhere."""
    if not 0 <= angle <= np.pi:
        raise InvalidInput(f"angle must be in [0, pi], got {angle}")
    edges, a, b = inner_edges(mesh)
    corners = mesh.vertices[mesh.triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(cross, axis=1)
    longest = np.square(corners - np.roll(corners, -1, axis=1)).sum(axis=2).max(axis=1)
    normal = cross / np.maximum(length, 1e-300)[:, None]
    whole = length > 1e-12 * longest
    cosine = np.einsum("kd,kd->k", normal[a], normal[b])
    sharp: NDArray[np.bool_] = whole[a] & whole[b] & (cosine < np.cos(angle))
    return edges[sharp]


def attribute_borders(mesh: Mesh, values: NDArray[Any], among: NDArray[np.bool_] | None = None) -> Pairs:
    """Edges between faces of different value: a material, a face set or any other attribute, one value a face.

    among: (F,) faces to look at; None: all.
    """
    values = np.asarray(values)
    if values.shape != (len(mesh.triangles),):
        raise InvalidInput(f"there must be one value for each of the {len(mesh.triangles)} faces, got {values.shape}")
    edges, a, b = inner_edges(mesh)
    between: NDArray[np.bool_] = values[a] != values[b]
    return edges[between if among is None else between & among[a] & among[b]]


def marked_edges(mesh: Mesh, edges: NDArray[Any]) -> Pairs:
    """What is left in the mesh of edges that were marked before `clean`: pairs of the caller's vertices.

    Edges that are gone, as their faces are, are left out.
    """
    marked = np.sort(np.asarray(edges, np.int64).reshape(-1, 2), axis=1)
    mine, _, _ = inner_edges(mesh)
    source = np.sort(mesh.source_vertex[mine].astype(np.int64), axis=1)
    base = 1 + source.max(initial=0)
    marked = marked[((marked >= 0) & (marked < base)).all(axis=1)]  # larger ones are gone, and would overflow below
    known = (source >= 0).all(axis=1)
    return mine[known & np.isin(source[:, 0] * base + source[:, 1], marked[:, 0] * base + marked[:, 1])]


def inner_edges(mesh: Mesh) -> tuple[Pairs, NDArray[np.intp], NDArray[np.intp]]:
    """Each edge between two faces: its vertices, and the two."""
    f = mesh.triangles
    ends = np.sort(np.stack([f, np.roll(f, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    order = np.lexsort((ends[:, 1], ends[:, 0]))
    same = (ends[order[1:]] == ends[order[:-1]]).all(axis=1)
    a, b = order[:-1][same], order[1:][same]
    return np.ascontiguousarray(ends[a], np.int32), a // 3, b // 3
