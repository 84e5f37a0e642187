"""Borders of tiles: matching edges, halos and T-junctions."""

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Keys = NDArray[np.uint64]
_MIX = (np.uint64(0x9E3779B97F4A7C15), np.uint64(0xBF58476D1CE4E5B9))


class Fringe(NamedTuple):
    """The data of a tile that other tiles need: its faces at its border vertices, and its border edges."""

    face: NDArray[np.int32]  #: (N,) positions in the order of Faces, rising
    record: NDArray[np.float32]  #: (N, 4) as in Faces
    neighbour: NDArray[np.int32]  #: (N, 3) as in Faces
    keys: Keys  #: (N, 3) keys of the places of the corners
    edge_face: NDArray[np.int32]  #: (B,) the face of each border edge
    edge_corner: NDArray[np.int8]  #: (B,) the corner at which it begins
    edge_keys: Keys  #: (B, 2) keys of the places of its ends


class Halo(NamedTuple):
    """The faces of other tiles that share a vertex with a tile."""

    record: NDArray[np.float32]  #: (H, 4)
    neighbour: NDArray[np.int32]  #: (F + H, 3) neighbours of the tile's own faces, then of the halo's faces
    tile: NDArray[np.int32]  #: (H,) their tile
    place: NDArray[np.int32]  #: (H,) their position in that tile's fringe
    touch_face: NDArray[np.int32]  #: (T,) own faces that share a vertex with another tile
    touch_tile: NDArray[np.int32]  #: (T,) that tile


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


def border_edges(neighbour: NDArray[np.int32]) -> tuple[NDArray[np.int32], NDArray[np.int8]]:
    """Return the faces and first corners of the edges that have one face."""
    face, corner = np.nonzero(neighbour < 0)
    return face.astype(np.int32), corner.astype(np.int8)


def fringe_of(
    record: NDArray[np.float32],
    neighbour: NDArray[np.int32],
    mesh_face: NDArray[np.int32],
    triangles: NDArray[np.int32],
    vertices: NDArray[np.float64],
) -> Fringe:
    """Return the fringe of a tile. record, neighbour, mesh_face: from its Faces. triangles, vertices: from its mesh."""
    face, corner = border_edges(neighbour)
    corners = triangles[mesh_face[face]]
    row = np.arange(len(face))
    ends = np.stack([corners[row, corner], corners[row, (corner + 1) % 3]], 1)
    near = np.zeros(len(vertices), bool)
    near[ends] = True
    touches = near[triangles[:, 0]]
    for k in (1, 2):
        touches |= near[triangles[:, k]]
    faces = np.flatnonzero(touches[mesh_face]).astype(np.int32)
    used, local = np.unique(triangles[mesh_face[faces]], return_inverse=True)
    keys = place_keys(vertices[used])[local.reshape(-1, 3)]
    names = place_keys(vertices[ends.ravel()]).reshape(-1, 2)
    return Fringe(faces, record[faces], neighbour[faces], keys, face, corner, names)


def neighbours_of(edge_keys: list[Keys]) -> list[list[int]]:
    """Return for each tile the tiles that share a place on their borders with it."""
    own = [np.unique(keys) for keys in edge_keys]
    key = np.concatenate(own)
    tile = np.repeat(np.arange(len(own)), [len(keys) for keys in own])
    order = np.argsort(key, kind="stable")
    key, tile = key[order], tile[order]
    found: list[set[int]] = [set() for _ in own]
    step = 1
    while step < len(key):  # equal keys are adjacent; the tiles that share a place give the length
        same = np.flatnonzero(key[step:] == key[:-step])
        if not len(same):
            break
        for a, b in np.unique(np.stack([tile[same], tile[same + step]], 1), axis=0):
            found[a].add(int(b))
            found[b].add(int(a))
        step += 1
    return [sorted(each) for each in found]


def halo_of(number: int, neighbour: NDArray[np.int32], own: Fringe, others: dict[int, Fringe]) -> Halo:
    """Return the halo of tile `number`, from its own fringe and the fringes of all tiles that share a border place."""
    count = len(neighbour)
    mine = np.unique(own.edge_keys)
    parts: list[tuple[NDArray[np.float32], NDArray[np.int32], NDArray[np.int32]]] = []
    tiles, touch_face, touch_tile = [], [], []
    edges = [(own.edge_face, own.edge_corner, own.edge_keys, number)]
    base = count
    for other in sorted(others):
        fringe = others[other]
        chosen = np.flatnonzero(np.isin(fringe.keys, mine).any(1)).astype(np.int32)
        faces = fringe.face[chosen]
        inside = _places(fringe.neighbour[chosen], faces, base)
        parts.append((fringe.record[chosen], inside, chosen))
        tiles.append(np.full(len(chosen), other, np.int32))
        known = np.isin(fringe.edge_face, faces)
        at = _places(fringe.edge_face[known], faces, base)
        edges.append((at, fringe.edge_corner[known], fringe.edge_keys[known], other))
        shared = np.isin(own.keys, np.intersect1d(mine, fringe.edge_keys)).any(1)
        touch_face.append(own.face[shared])
        touch_tile.append(np.full(int(shared.sum()), other, np.int32))
        base += len(chosen)
    whole = np.concatenate([neighbour, *(part[1] for part in parts)])
    at, corner, keys = (np.concatenate([edge[k] for edge in edges]) for k in range(3))
    tile = np.concatenate([np.full(len(edge[0]), edge[3], np.int32) for edge in edges])
    a, b = match(keys, tile).T
    whole[at[a], corner[a]] = at[b]
    whole[at[b], corner[b]] = at[a]
    record = np.concatenate([own.record[:0], *(part[0] for part in parts)])
    return Halo(record, whole, _joined(tiles), _joined([p[2] for p in parts]), _joined(touch_face), _joined(touch_tile))


def found_in(names: NDArray[Any], wanted: NDArray[Any]) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Return the positions of values in a rising list, and whether each value is in it. Empty list: positions are 0."""
    if not len(names):
        return np.zeros(wanted.shape, np.int64), np.zeros(wanted.shape, bool)
    at = np.minimum(np.searchsorted(names, wanted), len(names) - 1)
    return at, names[at] == wanted


def _joined(parts: list[NDArray[np.int32]]) -> NDArray[np.int32]:
    return np.concatenate([np.zeros(0, np.int32), *parts])


def _places(faces: NDArray[np.int32], among: NDArray[np.int32], base: int) -> NDArray[np.int32]:
    """Return `base` plus the position of each face in a rising list; -1 if the list does not contain it."""
    at, known = found_in(among, faces)
    return np.where(known, base + at, -1).astype(np.int32)


def frozen_of(halo: Halo, own: int, number: int, rank: NDArray[np.int64]) -> NDArray[np.uint8]:
    """Return (F + H,) flags of faces that stay: the halo, and own faces at a vertex of a tile with a higher rank."""
    frozen = np.zeros(own + len(halo.record), np.uint8)
    frozen[own:] = 1
    frozen[halo.touch_face[rank[halo.touch_tile] > rank[number]]] = 1
    return frozen


def ranks(tiles: int, round_number: int) -> NDArray[np.int64]:
    """Return the rank (T,) of each tile in a round. The order differs by round, and never depends on the workers."""
    with np.errstate(over="ignore"):
        key = (np.arange(tiles, dtype=np.uint64) + np.uint64(7919 * round_number + 1)) * _MIX[0]
        key ^= key >> np.uint64(31)
        key *= _MIX[1]
    order = np.argsort(key, kind="stable")
    rank = np.empty(tiles, np.int64)
    rank[order] = np.arange(tiles)
    return rank


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
