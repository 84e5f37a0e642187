"""Scans of buildings as photogrammetry makes them: rounded corners, wavy noise, holes, and ground."""

from functools import cache

import numpy as np

CELLS = 96  # along the longest side


def box(p: np.ndarray, low: tuple, high: tuple) -> np.ndarray:
    """Signed distance of points from a box, negative inside."""
    low, high = np.array(low, float), np.array(high, float)
    x, y, z = (np.abs(p[..., k] - (low[k] + high[k]) / 2) - (high[k] - low[k]) / 2 for k in range(3))
    away = np.sqrt(np.maximum(x, 0) ** 2 + np.maximum(y, 0) ** 2 + np.maximum(z, 0) ** 2)
    return away + np.minimum(np.maximum(np.maximum(x, y), z), 0)


def prism(p: np.ndarray, low: tuple, high: tuple, along: int, rise: float) -> np.ndarray:
    """A gable roof over a rectangle at the height low[2]: its ridge runs along an axis."""
    across = 1 - along
    middle, half = (low[across] + high[across]) / 2, (high[across] - low[across]) / 2
    slope = np.hypot(rise, half)
    roof = ((p[..., 2] - low[2]) * half + (np.abs(p[..., across] - middle) - half) * rise) / slope
    ends = np.maximum(low[along] - p[..., along], p[..., along] - high[along])
    return np.maximum.reduce([roof, ends, low[2] - p[..., 2]])


def _rod(p: np.ndarray, x: float, y: float, radius: float, low: float, high: float) -> np.ndarray:
    return np.maximum(np.hypot(p[..., 0] - x, p[..., 1] - y) - radius, np.maximum(low - p[..., 2], p[..., 2] - high))


def _bay(p: np.ndarray, x: float, y: float, radius: float, low: float, high: float) -> np.ndarray:
    """An octagonal bay window."""
    a, b = np.abs(p[..., 0] - x), np.abs(p[..., 1] - y)
    return np.maximum.reduce([a - radius, b - radius, (a + b) / np.sqrt(2) - radius, low - p[..., 2], p[..., 2] - high])


def _solid(p: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Signed distance of a house with a wing, dormers, chimneys, bays, pipes and windows, in metres."""
    long, deep, eave, rise = rng.uniform(12, 16), rng.uniform(8, 10), rng.uniform(5.5, 7), rng.uniform(2.5, 4)
    body = box(p, (0, 0, -1), (long, deep, eave))
    over = 0.4
    parts = [body, prism(p, (-over, -over, eave - 0.2), (long + over, deep + over, 0), 0, rise)]
    wing = rng.uniform(4, 6)
    at = rng.uniform(1, long - wing - 1)
    low_eave = eave - rng.uniform(0.5, 2)
    parts += [
        box(p, (at, -4, -1), (at + wing, deep / 2, low_eave)),
        prism(p, (at - over, -4 - over, low_eave - 0.2), (at + wing + over, deep / 2, 0), 1, rise * 0.7),
    ]
    for x in np.linspace(2, long - 3, 3):  # dormers at the back
        y = deep - 0.25 * deep
        foot, head = eave + 0.2, eave + 0.2 + 0.45 * rise
        parts.append(box(p, (x, deep / 2, foot), (x + 1.6, y + 1.2, head)))
        parts.append(prism(p, (x - 0.2, deep / 2, head - 0.1), (x + 1.8, y + 1.4, 0), 1, 0.8))
    for x in (0.2 * long, 0.75 * long):
        parts.append(box(p, (x, deep * 0.4, eave), (x + 0.9, deep * 0.4 + 0.7, eave + rise + 1)))
    parts.append(_bay(p, long, deep * 0.5, 1.4, 0.6, eave - 0.8))
    parts.append(_bay(p, long * 0.8, deep, 1.2, 0.4, 3))
    for x, y in ((-0.15, 0.3), (long + 0.1, deep - 0.3)):
        parts.append(_rod(p, x, y, 0.18, -1, eave))
    parts.append(box(p, (0.6, deep, 3.0), (4.4, deep + 1.2, 3.25)))  # a balcony
    solid = np.minimum.reduce(parts)
    for z in (1.0, 3.8):
        for x in np.arange(1.0, long - 1.6, 2.4):
            for y in (0.0, deep):
                solid = np.maximum(solid, -box(p, (x, y - 0.3, z), (x + 1.1, y + 0.3, z + 1.5)))
        for y in np.arange(1.2, deep - 1.6, 2.2):
            solid = np.maximum(solid, -box(p, (-0.3, y, z), (0.3, y + 1.0, z + 1.5)))
    ground = p[..., 2] - 0.25 * np.sin(0.35 * p[..., 0]) * np.cos(0.3 * p[..., 1])
    return np.minimum(solid, ground)


def blurred(a: np.ndarray, sigma: float) -> np.ndarray:
    reach = int(np.ceil(3 * sigma))
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2)
    kernel /= kernel.sum()
    for axis in range(a.ndim):
        wide = np.pad(a, [(reach, reach) if k == axis else (0, 0) for k in range(a.ndim)], mode="edge")
        a = sum(k * wide.take(np.arange(i, i + a.shape[axis]), axis) for i, k in enumerate(kernel))
    return a


def surface(field: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The zero level of a field by surface nets: a vertex in each cell, a square about each edge of the grid."""
    inside = field < 0
    total, count = np.zeros((*(n - 1 for n in field.shape), 3)), np.zeros(tuple(n - 1 for n in field.shape))
    grid = np.stack(np.meshgrid(*(np.arange(n, dtype=float) for n in field.shape), indexing="ij"), -1)
    squares = []
    for axis in range(3):
        lower = tuple(slice(None, -1) if k == axis else slice(None) for k in range(3))
        upper = tuple(slice(1, None) if k == axis else slice(None) for k in range(3))
        crossed = inside[lower] != inside[upper]
        share = np.where(crossed, field[lower] / np.where(crossed, field[lower] - field[upper], 1), 0)
        place = grid[lower].copy()
        place[..., axis] += share
        a, b = [k for k in range(3) if k != axis]
        for i in (0, 1):
            for j in (0, 1):
                of = [slice(None)] * 3
                of[a] = slice(i, i + field.shape[a] - 1)
                of[b] = slice(j, j + field.shape[b] - 1)
                total += np.where(crossed[tuple(of)][..., None], place[tuple(of)], 0)
                count += crossed[tuple(of)]
        at = np.argwhere(crossed)
        at = at[(at[:, a] > 0) & (at[:, b] > 0) & (at[:, a] < field.shape[a] - 1) & (at[:, b] < field.shape[b] - 1)]
        cells = []
        for i, j in ((1, 1), (0, 1), (0, 0), (1, 0)):
            cell = at.copy()
            cell[:, a] -= i
            cell[:, b] -= j
            cells.append(np.ravel_multi_index(cell.T, count.shape))
        square = np.stack(cells, -1)
        flip = inside[tuple(at.T)] ^ (axis == 1)
        square[~flip] = square[~flip, ::-1]
        squares.append(square)
    quads = np.concatenate(squares)
    used, quads = np.unique(quads, return_inverse=True)
    quads = quads.reshape(-1, 4)
    points = (total / np.maximum(count, 1)[..., None]).reshape(-1, 3)[used]
    return points, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


# Seed, noise and rounding of the scans that are measured.
SCANS = ((1, 0.001, 0.8), (2, 0.002, 0.8), (3, 0.003, 1.0), (4, 0.004, 1.2), (5, 0.0015, 0.6), (6, 0.0025, 1.0))


@cache
def make(seed: int, noise: float = 0.002, rounding: float = 0.8, holes: int = 6) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and triangles of a house on its ground.

    noise: standard deviation of the wavy and the uncorrelated part together, as a share of the diagonal; rounding: of
    corners, in cells of some 25 cm; holes: of one to two metres. The same arguments give the same scan.
    """
    rng = np.random.default_rng(seed)
    low, high = np.array([-3.0, -7.0, -0.8]), np.array([20.0, 14.0, 14.0])
    cell = float((high - low).max()) / CELLS
    axes = [np.arange(a, b, cell) for a, b in zip(low, high, strict=True)]
    turn = np.radians(rng.uniform(0, 90))
    c, s = np.cos(turn), np.sin(turn)
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), -1)
    middle = (low + high) / 2
    about = grid - middle
    # the house is turned against the grid, as a scan's grid has no relation to walls
    turned = np.stack([c * about[..., 0] - s * about[..., 1], s * about[..., 0] + c * about[..., 1], about[..., 2]], -1)
    field = blurred(np.clip(_solid(turned + middle, rng), -3 * cell, 3 * cell), rounding)
    points, faces = surface(field)
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    waves = np.stack([blurred(rng.standard_normal(field.shape), 2.0) for _ in range(3)], -1)
    waves /= waves.std()
    near = np.clip(np.rint(points).astype(int), 0, np.array(field.shape) - 1)
    off = 0.8 * waves[tuple(near.T)] + 0.6 * rng.standard_normal(points.shape)
    points = points + noise * diagonal / np.sqrt(3) * off
    gone = np.zeros(len(points), bool)
    for _ in range(holes):
        where = points[rng.integers(len(points))]
        gone |= np.linalg.norm(points - where, axis=1) < rng.uniform(2, 4)
    faces = faces[~gone[faces].any(1)]
    used, faces = np.unique(faces, return_inverse=True)
    return points[used] * cell, faces.reshape(-1, 3)
