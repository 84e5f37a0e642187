"""Meshes with round parts, made as tests want them; bench/generators/round_shapes.py has more."""

import numpy as np


def turned(profile, steps=96):
    """A closed solid of revolution around z; profile: (radius, height) from the bottom to the top."""
    profile = np.asarray(profile, float)
    angle = np.arange(steps) * 2 * np.pi / steps
    rho, z = profile.T
    vertices = np.stack(
        [np.outer(rho, np.cos(angle)), np.outer(rho, np.sin(angle)), np.repeat(z[:, None], steps, 1)], -1
    ).reshape(-1, 3)
    i, k = (a.ravel() for a in np.meshgrid(np.arange(len(rho) - 1), np.arange(steps), indexing="ij"))
    a, b = i * steps + k, i * steps + (k + 1) % steps
    c, d = b + steps, a + steps
    last, n = (len(rho) - 1) * steps, len(vertices)
    ends = np.arange(steps)
    after = (ends + 1) % steps
    low, high = np.full(steps, n), np.full(steps, n + 1)
    triangles = np.concatenate(
        [np.stack(t, 1) for t in ((a, b, c), (a, c, d), (low, after, ends), (high, last + ends, last + after))]
    )
    return np.concatenate([vertices, [[0, 0, z[0]], [0, 0, z[-1]]]]), triangles.astype(np.int32)


def star(n=48, radius=1.0, reach=1.8):
    """A sphere with two pipes along each axis, of another radius for each, as a cube's sides with n x n squares."""
    u, v = (x.ravel() for x in np.meshgrid(*[np.linspace(-1, 1, n + 1)] * 2, indexing="ij"))
    ring = np.maximum(np.abs(u), np.abs(v))[:, None]  # a pipe ends at 0.5 and begins at 0.75
    cube = np.stack([u, v, ring[:, 0]], axis=1)
    cube /= np.maximum(np.linalg.norm(cube, axis=1), 1e-9)[:, None]
    k = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    a, b, c, d = (x.ravel() for x in (k[:-1, :-1], k[1:, :-1], k[1:, 1:], k[:-1, 1:]))
    square = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    sides = []
    for turn, pipe in enumerate((0.45, 0.38, 0.31)):
        foot = np.sqrt(radius**2 - pipe**2)
        circle = np.stack([u, v], axis=1) * (pipe / np.maximum(np.hypot(u, v), 1e-9))[:, None]
        share = np.clip(4 * ring - 3, 0, 1)
        ball = (1 - share) * np.c_[circle, np.full(len(u), foot)] + share * radius * cube
        ball *= radius / np.linalg.norm(ball, axis=1)[:, None]
        tube = np.c_[circle * np.minimum(2 * ring, 1), foot + (reach - foot) * np.clip(3 - 4 * ring, 0, 1)]
        side = np.where(ring >= 0.75, ball, tube)
        sides += [np.roll(side * [sign, 1, sign], turn, axis=1) for sign in (1, -1)]
    vertices, number = np.unique(np.round(np.concatenate(sides), 9), axis=0, return_inverse=True)
    return vertices, number.reshape(6, -1)[:, square].reshape(-1, 3).astype(np.int32)


def can(upper=1.0):
    lids = np.arange(1, 8) / 8
    side = np.linspace(0, 1, 41)
    return turned(
        [(r, -1.5) for r in lids]
        + [(1 + (upper - 1) * t, -1.5 + 3 * t) for t in side]
        + [(upper * r, 1.5) for r in lids[::-1]]
    )


def vase():
    lids = np.arange(1, 6) / 6
    z = np.linspace(-2, 2, 60)
    side = 0.9 + 0.35 * np.sin(1.3 * z + 0.4)
    return turned(
        [(r * side[0], -2) for r in lids] + list(zip(side, z, strict=True)) + [(r * side[-1], 2) for r in lids[::-1]]
    )


def tilted(radius, low, high, degrees, towards, at):
    """A closed cylinder whose axis leans by this angle."""
    lids, side = np.arange(1, 5) / 5, np.linspace(low, high, 17)
    vertices, triangles = turned(
        [(radius * r, low) for r in lids] + [(radius, z) for z in side] + [(radius * r, high) for r in lids[::-1]], 48
    )
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    axis = np.array([s * np.cos(towards), s * np.sin(towards), c])
    x = np.array([c, 0, -axis[0]]) / np.hypot(c, axis[0])
    return vertices @ np.array([x, np.cross(axis, x), axis]) + at, triangles


def finer(vertices, triangles, times=2):
    """A mesh whose triangles are split in four, some times."""
    for _ in range(times):
        edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        ends, middle = np.unique(edges, axis=0, return_inverse=True)
        a, b, c = triangles.T
        x, y, z = middle.reshape(-1, 3).T + len(vertices)
        vertices = np.concatenate([vertices, vertices[ends].mean(axis=1)])
        parts = ((a, x, z), (x, b, y), (z, y, c), (x, y, z))
        triangles = np.concatenate([np.stack(part, 1) for part in parts]).astype(np.int32)
    return vertices, triangles
