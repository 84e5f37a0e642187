"""Small meshes whose right answers are known, as (vertices, triangles)."""

import numpy as np


def grid(n, corner, right, up):
    """n by n squares of two triangles each, from `corner` along two vectors; not welded to other parts."""
    corner, right, up = np.array(corner, float), np.array(right, float), np.array(up, float)
    i, j = np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij")
    vertices = corner + i.reshape(-1, 1) / n * right + j.reshape(-1, 1) / n * up
    a = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    b, c, d = a + n + 1, a + n + 2, a + 1
    return vertices, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]).astype(np.int32)


def joined(*meshes):
    """Several meshes as one, not welded."""
    starts = np.cumsum([0] + [len(v) for v, _ in meshes])
    triangles = [t + s for (_, t), s in zip(meshes, starts, strict=False)]
    return np.concatenate([v for v, _ in meshes]), np.concatenate(triangles).astype(np.int32)


def welded(vertices, triangles):
    """The same mesh with one vertex at each place."""
    kept, place = np.unique(np.round(vertices, 9), axis=0, return_inverse=True)
    return kept, place.ravel().astype(np.int32)[triangles]


def plane(n=4):
    """The unit square, open: 2 n^2 faces."""
    return grid(n, (0, 0, 0), (1, 0, 0), (0, 1, 0))


def cube(n=4):
    """The unit cube, closed: 12 n^2 faces, 6 n^2 + 2 vertices, true region of face f is f // (2 n^2)."""
    x, y, z = np.eye(3)
    sides = [(0 * x, y, x), (z, x, y), (0 * x, x, z), (y, z, x), (0 * x, z, y), (x, y, z)]
    return welded(*joined(*(grid(n, *side) for side in sides)))


def torus(nu=24, nv=12, radius=0.4):
    """A ring around the z axis, closed, genus 1: 2 nu nv faces."""
    u, v = np.meshgrid(np.arange(nu) * 2 * np.pi / nu, np.arange(nv) * 2 * np.pi / nv, indexing="ij")
    ring = 1 + radius * np.cos(v)
    vertices = np.stack([ring * np.cos(u), ring * np.sin(u), radius * np.sin(v)], -1).reshape(-1, 3)
    i, j = (a.ravel() for a in np.meshgrid(np.arange(nu), np.arange(nv), indexing="ij"))
    k, m = (i + 1) % nu, (j + 1) % nv
    a, b, c, d = i * nv + j, k * nv + j, k * nv + m, i * nv + m
    return vertices, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]).astype(np.int32)


def bent_pipe(rings=80, around=24):
    """A thin pipe whose bend grows along it, open at both ends, as a modeller draws it."""
    t = np.linspace(0, 1, rings)
    turn = 2 * np.pi * np.arange(around) / around
    round_it = 0.05 * np.stack([np.cos(turn), np.sin(turn), 0 * turn], -1)
    vertices = np.stack([t**2, 0 * t, 2 * t], 1)[:, None] + round_it[None]
    i, j = (k.ravel() for k in np.meshgrid(np.arange(rings - 1), np.arange(around), indexing="ij"))
    a, b = i * around + j, i * around + (j + 1) % around
    faces = np.concatenate([np.stack([a, b, b + around], 1), np.stack([a, b + around, a + around], 1)])
    return vertices.reshape(-1, 3), faces.astype(np.int32)


def bumpy(n=60, seed=1):
    """An open sheet with hills and noise, 2 n^2 faces: curved everywhere, so that partitioning has work to do."""
    vertices, triangles = plane(n)
    x, y, _ = vertices.T
    noise = np.random.default_rng(seed).normal(scale=0.05 / n, size=len(x))
    vertices[:, 2] = 0.2 * np.sin(7 * x) * np.cos(5 * y) + noise
    return vertices, triangles


def two_cubes(n=4):
    """Two unit cubes apart: two closed components."""
    vertices, triangles = cube(n)
    return joined((vertices, triangles), (vertices + [3, 0, 0], triangles))


def voxels(solid, noise=0.0):
    """The surface of a set of unit cubes, two triangles a square: any genus, nested and touching parts."""
    solid = np.pad(np.asarray(solid, bool), 1)
    squares = []
    for axis in range(3):
        across, along = np.roll(np.eye(3), -axis - 1, axis=0)[:2]
        for step in (1, -1):
            corner = np.argwhere(solid & ~np.roll(solid, -step, axis)) + (np.eye(3)[axis] if step == 1 else 0.0)
            square = np.stack([corner, corner + across, corner + across + along, corner + along], 1)
            squares.append(square if step == 1 else square[:, ::-1])
    squares = np.concatenate(squares)
    corners = np.concatenate([squares[:, [0, 1, 2]], squares[:, [0, 2, 3]]]).reshape(-1, 3)
    vertices, triangles = welded(corners, np.arange(len(corners)).reshape(-1, 3))
    return vertices + noise * np.random.default_rng(2).standard_normal(vertices.shape), triangles


def plate(columns, rows, thickness, size=3, gap=3):
    """A plate of voxels with square holes through it, one handle a hole."""
    step = size + gap
    solid = np.ones((columns * step + gap, rows * step + gap, thickness), bool)
    for i, j in np.ndindex(columns, rows):
        solid[gap + i * step : (i + 1) * step, gap + j * step : (j + 1) * step] = False
    return solid


def room(tunnels, noise=0.06):
    """A box with walls of three cells, a door, a window, and tunnels of one cell through a wall."""
    solid = np.ones((40, 40, 28), bool)
    solid[3:-3, 3:-3, 3:-3] = False
    solid[:3, 15:25, 6:20] = False
    solid[10:20, :3, 10:20] = False
    for k in range(tunnels):
        solid[-3:, 5 + 4 * (k % 8), 6 + 5 * (k // 8)] = False
    return voxels(solid, noise)


def mvs_house(scale=1, errors=True, noise=0.04):
    """A house with windows, a bay and a gable roof of cells, with the errors of photogrammetry.

    errors: whether there are tunnels of `scale` cells through the corners of the bay, pinholes, and specks around it.
    """
    wide, deep, high, eave = 60 * scale, 40 * scale, 44 * scale, 30 * scale
    solid = np.zeros((wide, deep, high), bool)
    solid[2 * scale : -2 * scale, 2 * scale : -2 * scale, : eave + 4 * scale] = True
    solid[40 * scale : 56 * scale, : 14 * scale, : 14 * scale] = True
    for x in range(6 * scale, 38 * scale, 8 * scale):
        for z in (5 * scale, 18 * scale):
            for y in (slice(2 * scale, 4 * scale), slice(-4 * scale, -2 * scale)):
                solid[x : x + 4 * scale, y, z : z + 7 * scale] = False
    if errors:
        edge = 56 * scale
        for z in range(2 * scale, 12 * scale, 2 * scale):
            at, into = slice(z, z + scale), slice(edge - 3 * scale, edge - 2 * scale)
            solid[into, : 3 * scale, at] = solid[into.start : edge, 2 * scale : 3 * scale, at] = False
            solid[into.start - 8 * scale : into.stop - 8 * scale, : 2 * scale, at] = False
            solid[into.start - 8 * scale : into.stop, scale : 2 * scale, at] = False
    vertices, triangles = voxels(solid, noise)
    up = vertices[:, 2] > eave
    lift = 0.55 * (deep / 2 - 2 * scale - np.abs(vertices[:, 1] - deep / 2))
    vertices[up, 2] += (vertices[up, 2] - eave) / (4 * scale) * lift[up]
    return _with_pinholes_and_specks(vertices, triangles, scale) if errors else (vertices, triangles)


def _with_pinholes_and_specks(vertices, triangles, scale):
    """40 fans of faces are missing, and 40 tetrahedra of .3 to 2 cells float near the surface."""
    rng = np.random.default_rng(4)
    gone = np.isin(triangles, rng.choice(len(vertices), 40, replace=False)).any(axis=1)
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    specks = [
        vertices[rng.integers(len(vertices))] + scale * (rng.normal(0, 1, 3) * 3 + rng.uniform(0.3, 2) * corners)
        for _ in range(40)
    ]
    more = np.concatenate([len(vertices) + 4 * k + faces for k in range(40)])
    return np.concatenate([vertices, *specks]), np.concatenate([triangles[~gone], more]).astype(np.int32)


def facade(columns=8, rows=5, depth=2, noise=0.0):
    """A wall, front only, with windows of 4 by 6 cells set back by `depth`: their sides are joined to it."""
    wide, high, gap = 4, 6, 4
    cells = np.ones((columns * (wide + gap) + gap, rows * (high + gap) + gap), bool)
    for i, j in np.ndindex(columns, rows):
        x, y = gap + i * (wide + gap), gap + j * (high + gap)
        cells[x : x + wide, y : y + high] = False
    solid = np.ones((*cells.shape, depth + 2), bool)
    solid[~cells, 2:] = False
    vertices, triangles = voxels(solid)
    inside = vertices[triangles].mean(axis=1)
    low, (x, y, z) = 1.0, vertices[triangles].max(axis=(0, 1))
    front = (inside[:, 2] > low) & (inside[:, :2] > 1).all(1) & (inside[:, 0] < x) & (inside[:, 1] < y)
    used, triangles = np.unique(triangles[front], return_inverse=True)
    vertices = vertices[used] + noise * np.random.default_rng(2).standard_normal((len(used), 3))
    return vertices - [0, 0, z], triangles.reshape(-1, 3).astype(np.int32)


def volume(vertices, triangles):
    """Signed volume: positive when a closed surface is oriented outwards."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def faces_outwards(vertices, polygon):
    """Whether a polygon of the unit cube faces away from its middle."""
    a, b, c = (np.asarray(vertices)[v] for v in polygon[:3])
    return bool(np.cross(b - a, c - a) @ (a - 0.5) > 0)


def smoothed(vertices, triangles, rounds):
    """Every vertex moved half-way to the mean of its neighbours, `rounds` times: edges and corners are rounded."""
    ends = np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    ends = np.unique(np.concatenate([ends, ends[:, ::-1]]), axis=0)
    for _ in range(rounds):
        total = np.zeros_like(vertices)
        np.add.at(total, ends[:, 0], vertices[ends[:, 1]])
        vertices = (vertices + total / np.bincount(ends[:, 0])[:, None]) / 2
    return vertices, triangles


def figure(n=24, noise=0.002, lump=0.0):
    """A bumpy closed figure that mirrors across x except for noise and a lump on one side: 12 n^2 faces.

    Its triangles do not mirror.
    """
    vertices, triangles = cube(n)
    vertices = np.tan((vertices - 0.5) * np.pi / 2)
    vertices /= np.linalg.norm(vertices, axis=1)[:, None]
    turn, _ = np.linalg.qr(np.array([[1.0, 2, 3], [-2, 1, 0.5], [0.3, -1, 2]]))
    vertices = vertices @ (turn * np.sign(np.linalg.det(turn))).T
    x, y, z = vertices.T
    bumps = 0.25 * np.sin(5 * y + 1) * np.cos(4 * x) + 0.2 * np.sin(3 * z + 2 * y) * x**2
    away = ((vertices - [0.7, 0.5, 0.5]) ** 2).sum(axis=1)
    vertices = vertices * (1 + bumps + lump * np.exp(-8 * away))[:, None] * [1, 1.3, 0.8]
    return vertices + noise * np.random.default_rng(3).standard_normal(vertices.shape), triangles
