"""Meshes to time: files, and meshes of a kind and a size, made:KIND:FACES, subdivided on request.

- torus     a closed ring with bumps of many sizes and a little noise, like a scan
- slivers   the same with triangles hundreds of times longer than wide
- plane     a flat square: all faces coplanar
- boxes     separate cubes of 12 faces
- plate     a plate with rows of square holes, and sheet its upper side alone; perforated: of round holes
- sponge    Menger's
- soup      triangles without neighbours that pass through each other
"""

import numpy as np

import isimp_engine as engine
from tests.shared import shapes


def torus(faces, stretch=2.5):
    """stretch: number of squares around the ring divided by the number around the tube."""
    nv = max(3, round((faces / 2 / stretch) ** 0.5))
    nu = max(3, faces // 2 // nv)
    u, v = (2 * np.pi * k.ravel() for k in np.meshgrid(np.arange(nu) / nu, np.arange(nv) / nv, indexing="ij"))
    r = 0.4 + 0.02 * 2 * np.pi * min(0.4 / nv, 1 / nu) * np.random.default_rng(1).random(nu * nv)  # a share of an edge
    for k in (2, 5, 11, 23):
        r += 0.08 / k * np.sin(k * u + 3) * np.cos((k - 1) * v + k)
    ring = 1 + r * np.cos(v)
    return np.stack([ring * np.cos(u), ring * np.sin(u), r * np.sin(v)], 1), shapes.torus(nu, nv)[1]


def side(faces, of_each):
    """The side of a square of things. of_each: the faces of one."""
    return max(1, round((faces / of_each) ** 0.5))


def boxes(faces):
    vertices, triangles = shapes.cube(1)
    number = np.arange(max(1, faces // 12))
    row = int(np.ceil(len(number) ** (1 / 3)))
    corner = 2.0 * np.stack([number % row, number // row % row, number // row**2], 1)
    return (corner[:, None] + vertices).reshape(-1, 3), (8 * number[:, None, None] + triangles).reshape(-1, 3)


def plate(faces):
    n = side(faces, 42)
    solid = np.ones((3 * n, 3 * n, 1), bool)
    solid[1::3, 1::3] = False
    vertices, triangles = shapes.voxels(solid)
    return vertices * [1, 1, 0.2], triangles


def sheet(faces):
    n = 3 * side(faces, 16)
    vertices, triangles = shapes.plane(n)
    x, y, _ = np.floor(n * vertices[triangles].mean(axis=1)).astype(int).T
    return n * vertices, triangles[(x % 3 != 1) | (y % 3 != 1)]


def perforated(faces):
    """Cells with a hole of 16 sides each, and a ring of squares around it; 160 faces a hole."""
    n, turn = side(faces, 160), 2 * np.pi * np.arange(16) / 16
    circle = np.stack([np.cos(turn), np.sin(turn)], 1)
    square = 1.5 * circle / np.abs(circle).max(axis=1, keepdims=True)
    rings = np.stack([circle, (circle + square) / 2, square])
    places = np.concatenate([np.dstack([rings, np.full((3, 16), z)]) for z in (0, 0.5)]).reshape(-1, 3)
    i, j = np.arange(16), (np.arange(16) + 1) % 16
    lines = [(0, 1), (1, 2), (5, 4), (4, 3), (3, 0)]  # rings below and above, and the wall of the hole
    cell = [np.stack([16 * a + i, 16 * a + j, 16 * b + j, 16 * b + i], 1) for a, b in lines]
    outer = np.stack([32 + i, 32 + j, 80 + j, 80 + i], 1)
    corner = 3.0 * np.stack([k.ravel() for k in np.meshgrid(np.arange(n), np.arange(n), [0], indexing="ij")], 1)
    points = (corner[:, None] + places).reshape(-1, 3)
    quads = np.concatenate([np.concatenate([*cell, outer]) + 96 * k for k in range(n * n)])
    middle = points[quads].mean(axis=1)
    rim = np.abs(middle[:, :2] - 1.5 * (n - 1)).max(axis=1) > 1.5 * n - 1e-6
    quads = quads[rim | (np.arange(len(quads)) % 96 < 80)]  # an outer wall only where no other cell is
    return shapes.welded(points, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))


def sponge(faces):
    n, at = 1, 144
    while 7 * at < faces:
        n, at = n + 1, 16 * at
    solid = np.ones((1, 1, 1), bool)
    cell = (np.indices((3, 3, 3)) == 1).sum(axis=0) < 2
    for _ in range(n):
        solid = np.kron(solid, cell)
    return shapes.voxels(solid)


def soup(faces):
    return np.random.default_rng(1).random((3 * faces, 3)), np.arange(3 * faces).reshape(-1, 3)


MADE = {
    "torus": torus,
    "slivers": lambda faces: torus(faces, 1000),
    "plane": lambda faces: shapes.plane(side(faces, 2)),
    "boxes": boxes,
    "plate": plate,
    "sheet": sheet,
    "perforated": perforated,
    "sponge": sponge,
    "soup": soup,
}


def subdivided(vertices, triangles):
    """One step of Loop's subdivision, borders as cubic B-splines. The mesh must be sound."""
    ends, index, used = np.unique(
        np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2), axis=0, return_inverse=True,
        return_counts=True,
    )  # fmt: skip
    count, rim = len(vertices), ends[used == 1]
    sums, valence = np.zeros((count, 3)), np.bincount(ends.ravel(), minlength=count)[:, None]
    np.add.at(sums, ends, vertices[ends[:, ::-1]])
    weight = (0.625 - (0.375 + 0.25 * np.cos(2 * np.pi / np.maximum(valence, 1))) ** 2) / np.maximum(valence, 1)
    moved = (1 - valence * weight) * vertices + weight * sums
    beside = np.zeros((count, 3))
    np.add.at(beside, rim, vertices[rim[:, ::-1]])
    moved[rim] = 0.75 * vertices[rim] + 0.125 * beside[rim]
    middle = vertices[ends].mean(axis=1)
    wings = np.zeros((len(ends), 3))
    edge = index.reshape(-1, 3)  # the edges of each face, from its corners on
    np.add.at(wings, edge, vertices[triangles[:, [2, 0, 1]]])
    middle = np.where((used == 2)[:, None], 0.75 * middle + 0.125 * wings, middle)
    (a, b, c), (x, y, z) = triangles.T, (count + edge).T
    faces = np.stack([np.stack(face, 1) for face in ((a, x, z), (b, y, x), (c, z, y), (x, y, z))], 1)
    return np.concatenate([moved, middle]), faces.reshape(-1, 3)


def load(name, loop=0):
    """Vertices and triangles of a file or of made:KIND:FACES; loop: steps of subdivision."""
    if name.startswith("made:"):
        kind, _, faces = name.removeprefix("made:").partition(":")
        if kind not in MADE or not faces.isdigit() or not 12 <= int(faces) <= 100_000_000:
            raise ValueError(f"{name}: wanted made:KIND:FACES with 12 to 100000000 faces and {', '.join(MADE)}")
        vertices, triangles = MADE[kind](int(faces))
    else:
        vertices, triangles = engine.read(name)
    for _ in range(loop):
        vertices, triangles = subdivided(vertices, triangles)
    return vertices, np.asarray(triangles, np.int32)
