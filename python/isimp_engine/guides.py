"""Barriers from a mesh: sharp edges, borders of a face attribute, marked edges.

All give (K, 2) int32 pairs of vertices, edges of the mesh, for the `barriers` of `partition` and of
`guided.partition_guided`; several are joined by `np.concatenate`.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._core import InvalidInput, Mesh, _inner_edges, _marked_edges, _shared_edges, _sharp_edges

Pairs = NDArray[np.int32]


def sharp_edges(mesh: Mesh, angle: float) -> Pairs:
    """Edges at which the surface bends by more than `angle`, radians in [0, pi]. Faces without area bend nowhere."""
    return _sharp_edges(mesh, angle)


def attribute_borders(mesh: Mesh, values: NDArray[Any], among: NDArray[np.bool_] | None = None) -> Pairs:
    """Edges between faces of different value: a material, a face set or any other attribute, one value a face.

    among: (F,) faces to compare; None: all.
    """
    values = np.asarray(values)
    if values.shape != (len(mesh.triangles),):
        raise InvalidInput(f"there must be one value for each of the {len(mesh.triangles)} faces, got {values.shape}")
    edges, a, b = inner_edges(mesh)
    between: NDArray[np.bool_] = values[a] != values[b]
    return edges[between if among is None else between & among[a] & among[b]]


def marked_edges(mesh: Mesh, edges: NDArray[Any]) -> Pairs:
    """The edges of the mesh that were marked before `clean`: pairs of the caller's vertices.

    Edges whose faces were removed are left out.
    """
    return _marked_edges(mesh, _as_pairs(edges))


def inner_edges(mesh: Mesh) -> tuple[Pairs, NDArray[np.intp], NDArray[np.intp]]:
    """Each edge between two faces: its vertices, and the two."""
    edges, a, b = _inner_edges(mesh)
    return edges, a.astype(np.intp), b.astype(np.intp)


def shared_edges(triangles: NDArray[np.integer[Any]]) -> tuple[NDArray[np.int32], Pairs]:
    """Pairs of triangles that share an edge, and that edge, for any triangles: no `Mesh` is needed.

    triangles: (T, 3) integers, none negative. Returns (E, 2) triangles, each column in one piece, and (E, 2) vertices.
    An edge with three triangles gives three pairs; of more than three, those next to and next but one to each other in
    order. Cost: O(T + largest vertex).
    """
    edges, face, beside = _shared_edges(triangles)
    return np.stack([face, beside]).T, edges


def _as_pairs(edges: NDArray[Any]) -> Pairs:
    """(K, 2) pairs of any integers as int32; a number that int32 can not hold is no vertex, and stays none."""
    info = np.iinfo(np.int32)
    return np.asarray(edges, np.int64).reshape(-1, 2).clip(info.min, info.max).astype(np.int32)
