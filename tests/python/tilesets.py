"""Scans in tiles, for tests: cut from small meshes, with borders that fit or do not."""

from pathlib import Path

import numpy as np

import meshfiles
import shapes


def hilly(n=48):
    """An open sheet of 2 n^2 faces with two levels, a slope and noise: borders of planes cross borders of tiles."""
    vertices, triangles = shapes.plane(n)
    x, y, _ = vertices.T
    noise = np.random.default_rng(4).normal(scale=0.05 / n, size=len(x))
    vertices[:, 2] = 0.25 * np.clip(6 * (x - 0.36), 0, 1) + 0.3 * np.abs(y - 0.57) + noise
    return vertices, triangles


def town(blocks=4, n=24):
    """A rough sheet of 2 (blocks n)^2 faces with a house on each block: many planes around a ground that all touch."""
    side = np.arange(blocks * n + 1.0)
    x, y = np.meshgrid(side, side, indexing="ij")
    u, v, key = x % n, y % n, (7 * (x // n) + 3 * (y // n)) % 5
    rough = np.sin(x * 12.9898 + y * 78.233) * 43758.5453
    inside = (u > 4) & (u < 20) & (v > 3) & (v < 19)
    z = np.where(inside, 4 + key + 0.6 * (8 - np.abs(u - 12)), 0.02 * x) + 0.15 * (rough - np.floor(rough) - 0.5)
    a = (np.arange(blocks * n)[:, None] * len(side) + np.arange(blocks * n)).ravel()
    b = a + len(side)
    triangles = np.concatenate([np.stack([a, b, b + 1], 1), np.stack([a, b + 1, a + 1], 1)]).astype(np.int32)
    return np.stack([x, y, z], -1).reshape(-1, 3), triangles


def cut(vertices, triangles, columns, rows=1):
    """Tiles by the middles of faces: (vertices, triangles, faces of the whole) of each."""
    middle = vertices[triangles].mean(1)
    low, high = vertices.min(0), vertices.max(0)
    share = (middle - low) / np.maximum(high - low, 1e-9)
    tile = np.minimum((share[:, 0] * columns).astype(int), columns - 1) * rows
    tile += np.minimum((share[:, 1] * rows).astype(int), rows - 1)
    parts = []
    for k in range(columns * rows):
        faces = np.flatnonzero(tile == k)
        used, local = np.unique(triangles[faces], return_inverse=True)
        parts.append((vertices[used], local.reshape(-1, 3).astype(np.int32), faces))
    return parts


def write(folder: Path, parts, writer=meshfiles.obj, suffix=".obj"):
    folder.mkdir(parents=True, exist_ok=True)
    for k, (vertices, triangles, _) in enumerate(parts):
        writer(folder / f"tile_{k:02d}{suffix}", vertices, triangles.tolist())
    return folder


def labels_of(folder: Path, parts, faces):
    """(F,) the labels of the whole mesh from the labels of the tiles."""
    label = np.full(faces, -9, np.int32)
    for k, (_, _, own) in enumerate(parts):
        array = np.load(folder / f"tile_{k:02d}.npy")
        assert (array.dtype, len(array)) == (np.int32, len(own))
        label[own] = array
    return label


def regions_are_connected(triangles, label):
    """Whether the faces of each region hang together by edges."""
    up = np.arange(len(triangles))

    def find(f):
        while up[f] != f:
            up[f] = up[up[f]]
            f = up[f]
        return f

    edges = {}
    for f, t in enumerate(triangles.tolist()):
        for a, b in ((t[0], t[1]), (t[1], t[2]), (t[2], t[0])):
            edges.setdefault((min(a, b), max(a, b)), []).append(f)
    for pair in edges.values():
        if len(pair) == 2 and label[pair[0]] == label[pair[1]]:
            up[find(pair[0])] = find(pair[1])
    roots = {(int(label[f]), find(f)) for f in range(len(triangles))}
    return len(roots) == len({region for region, _ in roots})
