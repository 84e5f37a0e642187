"""Borders of tiles: matching edges and T-junctions."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Keys = NDArray[np.uint64]
_MIX = (np.uint64(0x9E3779B97F4A7C15), np.uint64(0xBF58476D1CE4E5B9))


def place_keys(points: NDArray[np.float64]) -> Keys:
    """Return 64-bit keys (N,) of places. Places that are equal, bit for bit, have the same key."""
    bits = np.ascontiguousarray(points + 0.0).view(np.uint64).reshape(-1, 3)  # -0 is 0
    key = np.zeros(len(bits), np.uint64)
    for k in range(3):
        key = (key ^ bits[:, k]) * _MIX[0]
        key ^= key >> np.uint64(29)
        key *= _MIX[1]
        key ^= key >> np.uint64(32)
    return key


def match(edge_keys: Keys, tile: NDArray[np.int32]) -> NDArray[np.int64]:
    """Return (M, 2) matching border edges of different tiles: exactly two with these ends, in opposite directions."""
    low, high = edge_keys.min(1), edge_keys.max(1)
    key = low * _MIX[0] ^ (high << np.uint64(17) | high >> np.uint64(47))
    order = np.argsort(key, kind="stable")
    key = key[order]
    first = np.flatnonzero(np.append(True, key[1:] != key[:-1])) if len(key) else np.zeros(0, np.int64)
    two = first[np.diff(np.append(first, len(key))) == 2]
    a, b = order[two], order[two + 1]
    fits = (edge_keys[a, 0] == edge_keys[b, 1]) & (edge_keys[a, 1] == edge_keys[b, 0]) & (tile[a] != tile[b])
    return np.stack([a[fits], b[fits]], 1)


def split_faces(
    triangles: NDArray[np.int32], face: NDArray[np.int32], corner: NDArray[np.int8], vertex: NDArray[np.int32]
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Insert vertices into border edges; returns the triangles, and the original face of each.

    face, corner: (J,) the edge of each vertex; vertices of one edge are in order along it. vertex: (J,) the vertices.
    """
    added: dict[int, list[tuple[int, int, int]]] = {}
    edges: dict[tuple[int, int], list[int]] = {}
    for f, k, v in zip(face.tolist(), corner.tolist(), vertex.tolist(), strict=True):
        edges.setdefault((f, k), []).append(v)
    for (f, k), points in edges.items():
        a, b = int(triangles[f, k]), int(triangles[f, (k + 1) % 3])
        parts = added.setdefault(f, [(int(triangles[f, 0]), int(triangles[f, 1]), int(triangles[f, 2]))])
        for place, (x, y, z) in enumerate(parts):
            for first, second, third in ((x, y, z), (y, z, x), (z, x, y)):
                if (first, second) == (a, b):
                    chain = [a, *points, b]
                    parts[place : place + 1] = [(p, q, third) for p, q in pairwise(chain)]
                    break
            else:
                continue
            break
    keep = np.ones(len(triangles), bool)
    keep[list(added)] = False
    source = np.flatnonzero(keep).astype(np.int32)
    fresh = [(t, f) for f in sorted(added) for t in added[f]]
    more = np.array([t for t, _ in fresh], np.int32).reshape(-1, 3)
    return np.concatenate([triangles[keep], more]), np.append(source, np.array([f for _, f in fresh], np.int32))
