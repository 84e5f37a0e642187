"""Makes twins of real scans: cartons, one on a table, open buildings, rooms, a hall in chunks, grids of drawn houses.

Each is made from numbers, the same on every run. Lengths are metres.
"""

import numpy as np

from bench.generators.scanned import blurred, box, prism, surface
from isimp_engine.guides import shared_edges
from tests.shared.polygon_judge import groups
from tests.shared.shapes import joined


def _used(points: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    used, faces = np.unique(faces, return_inverse=True)
    return points[used], faces.reshape(-1, 3).astype(np.int32)


def sheet(corner, right, up, columns: int, rows: int) -> tuple[np.ndarray, np.ndarray]:
    """A rectangle as a grid of triangles."""
    i, j = (k.ravel() for k in np.meshgrid(np.arange(columns + 1), np.arange(rows + 1), indexing="ij"))
    points = np.add(corner, np.outer(i / columns, right) + np.outer(j / rows, up))
    i, j = (k.ravel() for k in np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij"))
    at = i * (rows + 1) + j
    return points, np.concatenate(
        [np.stack([at, at + rows + 1, at + rows + 2], 1), np.stack([at, at + rows + 2, at + 1], 1)]
    )


def carton(
    seed: int = 1, size: tuple[float, ...] = (0.0645, 0.160, 0.2113), bulge: float = 0.0035, rounding: float = 0.003
) -> tuple[np.ndarray, np.ndarray]:
    """A carton of six sides that bulge by up to `bulge`, with rounded edges, as a turntable scanner sees it."""
    rng, half, step = np.random.default_rng(seed), np.array(size) / 2, 0.0035
    parts = []
    for axis in range(3):
        a, b = (axis + 1) % 3, (axis + 2) % 3
        for side in (-1, 1):
            corner, right, up = -half.copy(), np.zeros(3), np.zeros(3)
            corner[axis] = side * half[axis]
            right[a], up[b] = size[a], size[b]
            points, faces = sheet(corner, right, up, round(size[a] / step), round(size[b] / step))
            parts.append((points, faces if side > 0 else faces[:, ::-1]))
    points, faces = joined(*parts)
    _, first, index = np.unique((points / 1e-6).round(), axis=0, return_index=True, return_inverse=True)
    points, faces = points[first], index.ravel()[faces]
    inner = np.clip(points, rounding - half, half - rounding)
    off = points - inner
    length = np.linalg.norm(off, axis=1, keepdims=True)
    place = inner + rounding * off / np.maximum(length, 1e-12)
    share = place / half
    for axis in range(3):
        a, b = (axis + 1) % 3, (axis + 2) % 3
        swell = (1 - share[:, a] ** 2) * (1 - share[:, b] ** 2) * np.sign(share[:, axis]) * np.abs(share[:, axis])
        place[:, axis] += bulge * rng.uniform(0.6, 1.0) * (size[a] * size[b]) / (size[1] * size[2]) * swell
    return place + rng.normal(0, 5.5e-5, place.shape), faces.astype(np.int32)


def _scanned(field: np.ndarray, cell: float, noise: float, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """The surface of a field of signed distances in cells, with waves and noise of `noise` metres together."""
    points, faces = surface(field)
    waves = np.stack([blurred(rng.standard_normal(field.shape), 2.0) for _ in range(3)], -1)
    waves /= waves.std()
    near = np.clip(np.rint(points).astype(int), 0, np.array(field.shape) - 1)
    off = 0.8 * waves[tuple(near.T)] + 0.6 * rng.standard_normal(points.shape)
    return points * cell + noise / np.sqrt(3) * off, faces


def _grid(low: np.ndarray, high: np.ndarray, cell: float) -> np.ndarray:
    axes = [np.arange(a, b, cell) for a, b in zip(low, high, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), -1)


def open_building(seed: int = 1, cell: float = 0.2) -> tuple[np.ndarray, np.ndarray]:
    """Walls and a roof like results of multi-view stereo: a ragged lower rim, holes, and debris in them."""
    rng = np.random.default_rng(seed)
    low = np.array([-2.0, -2.0, -3.0])
    grid = _grid(low, np.array([16.0, 12.0, 12.0]), cell)
    parts = [box(grid, (0, 0, -9), (14, 10, 6)), prism(grid, (0, 0, 6), (14, 10, 0), 0, 4)]
    parts += [box(grid, (9, -1.2, -9), (13, 4, 4))]
    field = blurred(np.clip(np.minimum.reduce(parts), -3 * cell, 3 * cell), 0.8)
    points, faces = _scanned(field, cell, 0.04, rng)
    points = points + low
    round_it = np.arctan2(points[:, 1] - 5, points[:, 0] - 7)
    rim = sum(rng.normal(0, 0.12) * np.sin(k * round_it + rng.uniform(0, 6.3)) for k in range(3, 40, 3))
    gone = points[:, 2] < 0.4 + rim + rng.normal(0, 0.08, len(points))
    debris = []
    for _ in range(16):
        where = points[rng.integers(len(points))]
        if where[2] < 1.5:
            continue
        near = np.linalg.norm(points - where, axis=1)
        if gone[near < 1.2].any():
            continue
        gone |= near < rng.uniform(0.3, 0.45)
        toward = rng.normal(0, 1, (2, 3))
        toward /= np.linalg.norm(toward, axis=1)[:, None]
        debris.append(sheet(where - 0.35 * toward.sum(0), 0.7 * toward[0], 0.7 * toward[1], 3, 3))
    return joined(_used(points, faces[~gone[faces].any(1)]), *debris)


def room(seed: int = 1, cell: float = 0.06) -> tuple[np.ndarray, np.ndarray]:
    """A room with a dozen pieces of furniture from the inside; walls behind furniture were not seen."""
    rng = np.random.default_rng(seed)
    size = np.array([rng.uniform(4.5, 6), rng.uniform(3.5, 4.5), 2.6])
    grid = _grid(np.full(3, -0.4), size + 0.4, cell)
    field = box(grid, (0, 0, 0), tuple(size))
    shadows = []
    for _ in range(12):
        wide, deep, high = rng.uniform(0.4, 1.4), rng.uniform(0.25, 0.6), rng.uniform(0.3, 1.8)
        foot = rng.choice([0.0, 0.0, 0.15, 0.9])
        axis, side = rng.integers(2), rng.integers(2)
        along = rng.uniform(0.1, size[axis] - wide - 0.1)
        gap = rng.choice([-0.2, 0.12])
        a, b = np.zeros(3), np.zeros(3)
        a[axis], b[axis] = along, along + wide
        a[1 - axis] = gap if side == 0 else size[1 - axis] - gap - deep
        b[1 - axis] = a[1 - axis] + deep
        a[2], b[2] = (foot if foot > 0 else -0.5), min(foot + high, 2.3)
        field = np.maximum(field, -box(grid, tuple(a), tuple(b)))
        if gap > 0:  # the gap behind it, seen from nowhere
            s, t = a.copy(), b.copy()
            s[1 - axis], t[1 - axis] = (
                (-0.1, a[1 - axis] + 0.05) if side == 0 else (b[1 - axis] - 0.05, size[1 - axis] + 0.1)
            )
            shadows.append((s - cell, t - 0.1 * (t - s) * np.array([1, 1, 1])))
    field = blurred(np.clip(field, -3 * cell, 3 * cell), 0.8)
    points, faces = _scanned(field, cell, 0.012, rng)
    points = points - 0.4
    gone = np.zeros(len(points), bool)
    for s, t in shadows:
        gone |= ((points > s) & (points < t)).all(1)
    for _ in range(25):
        gone |= np.linalg.norm(points - points[rng.integers(len(points))], axis=1) < rng.uniform(0.06, 0.2)
    gone |= (points[:, 2] > 1.9 + 0.3 * np.sin(4 * points[:, 0])) & (points[:, 0] > 0.7 * size[0])
    return _used(points, faces[~gone[faces].any(1)][:, ::-1])


def on_table(seed: int = 1, cell: float = 0.012) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A phone's scan of a carton on a table, with a ragged rim, and which faces are far from the carton."""
    rng, half, turn = np.random.default_rng(seed), np.array([0.11, 0.07]), np.radians(25)
    grid = _grid(np.array([-0.6, -0.45, -0.1]), np.array([0.6, 0.45, 0.3]), cell)
    c, s = np.cos(turn), np.sin(turn)
    turned = np.stack([c * grid[..., 0] + s * grid[..., 1], c * grid[..., 1] - s * grid[..., 0], grid[..., 2]], -1)
    field = np.minimum(grid[..., 2], box(turned, (*-half, -0.1), (*half, 0.16)))
    points, faces = _scanned(blurred(np.clip(field / cell, -3, 3), 0.6), cell, 0.0015, rng)
    points = points + [-0.6, -0.45, -0.1]
    about = np.arctan2(points[:, 1], points[:, 0])
    rim = 0.36 + sum(rng.normal(0, 0.006) * np.sin(k * about + rng.uniform(0, 6.3)) for k in range(2, 40, 3))
    gone = np.hypot(points[:, 0], points[:, 1]) > rim + rng.normal(0, 0.006, len(points))
    points, faces = _used(points, faces[~gone[faces].any(1)])
    middle = points[faces].mean(1)
    return points, faces, np.hypot(middle[:, 0], middle[:, 1]) > np.linalg.norm(half) + 0.04


def chunks(
    seed: int = 1, size: tuple[float, ...] = (24.0, 16.0, 5.0), tile: float = 6.0
) -> tuple[np.ndarray, np.ndarray]:
    """A hall from the inside, scanned in chunks: their borders lie up to an edge apart, and no vertices match."""
    rng, parts = np.random.default_rng(seed), []
    for axis in range(3):
        a, b = (axis + 1) % 3, (axis + 2) % 3
        for side in (0, 1):
            for i in range(max(1, round(size[a] / tile))):
                for j in range(max(1, round(size[b] / tile))):
                    spans = size[a] / max(1, round(size[a] / tile)), size[b] / max(1, round(size[b] / tile))
                    cell = rng.uniform(0.2, 0.3)
                    corner, right, up = np.zeros(3), np.zeros(3), np.zeros(3)
                    corner[axis] = side * size[axis]
                    corner[a], corner[b] = i * spans[0], j * spans[1]
                    right[a], up[b] = spans
                    points, faces = sheet(corner, right, up, round(spans[0] / cell), round(spans[1] / cell))
                    points = points + rng.normal(0, 0.012, points.shape)
                    points[:, axis] += rng.uniform(-0.03, 0.03)  # a drift of the whole chunk
                    grown = 1 + rng.uniform(-0.02, 0.02)
                    middle = points.mean(0)
                    points = middle + (points - middle) * grown
                    inward = faces if side == 0 else faces[:, ::-1]
                    parts.append((points, inward if rng.random() > 0.1 else inward[:, ::-1]))
    return joined(*parts)


def house(seed: int):
    """Signed distance of a drawn house and its box: a body, and parts that depend on `seed`.

    The ridge of a wing ends well below the eave, so that a scan shows whether the wall above it is one.
    """
    rng = np.random.default_rng(seed)
    long, deep, eave, rise = rng.uniform(11, 14), rng.uniform(8, 9), rng.uniform(5, 6), rng.uniform(2.5, 3.5)
    solids = [((0, 0, 0), (long, deep, eave))]
    prisms = [((0, 0, eave), (long, deep, 0), 0, rise)]
    if rng.random() < 0.7:  # a wing
        solids.append(((1.5, -3.5, 0), (6, deep / 2, eave - 2)))
        prisms.append(((1.5, -3.5, eave - 2), (6, deep / 2, 0), 1, 1.3))
    bays = [((7.5, -1.2, 0), (9.5, 1, 2.6)), ((long - 1, 3, 0), (long + 1.2, 5.2, 3))]
    solids += bays[: rng.integers(0, 3)]
    for k in range(rng.integers(0, 4)):  # dormers with flat roofs, behind
        x = 1.2 + 3 * k
        solids.append(((x, deep - 3.2, eave), (x + 1.6, deep - 1.1, eave + 1.5)))
    for k in range(rng.integers(0, 3)):  # chimneys through the ridge
        x = 2.5 + 4.5 * k
        solids.append(((x, deep / 2 - 0.5, eave), (x + 1, deep / 2 + 0.5, eave + rise + 1)))

    def distance(p: np.ndarray) -> np.ndarray:
        parts = [box(p, low, high) for low, high in solids] + [prism(p, *each) for each in prisms]
        return np.minimum.reduce(parts)

    return distance, np.array([-1.0, -4.5, -1.0]), np.array([long + 2.2, deep + 1, eave + rise + 2])


def _slopes(distance, points: np.ndarray) -> np.ndarray:
    return np.stack([distance(points + e) - distance(points - e) for e in np.eye(3) * 1e-5], -1) / 2e-5


def _onto(distance, points: np.ndarray) -> np.ndarray:
    """Points moved to where the distance is 0."""
    for _ in range(6):
        slope = _slopes(distance, points)
        points = points - (distance(points) / np.maximum((slope**2).sum(1), 0.25))[:, None] * slope
    return points


def clean_house(seed: int, cells: int = 110) -> tuple[np.ndarray, np.ndarray]:
    """The surface of a house without noise, its vertices on it."""
    distance, low, high = house(seed)
    cell = float((high - low).max()) / cells
    points, faces = surface(distance(_grid(low, high, cell)) / cell)
    return _onto(distance, points * cell + low), faces.astype(np.int32)


def drawn_house(seed: int, noise: float = 0.001, cells: int = 110) -> tuple[np.ndarray, np.ndarray]:
    """A house with sharp edges and white noise, a share of the diagonal."""
    return noisy(seed, *clean_house(seed, cells), noise)


def noisy(seed: int, points: np.ndarray, faces: np.ndarray, noise: float) -> tuple[np.ndarray, np.ndarray]:
    """A mesh with white noise, a share of the diagonal."""
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    return points + np.random.default_rng(seed).normal(0, noise * diagonal, points.shape), faces


def house_planes(seed: int, cells: int = 110, least: float = 0.1) -> int:
    """The number of planar faces of a house; see planes_of."""
    return planes_of(seed, *clean_house(seed, cells), cells, least)


def planes_of(seed: int, points: np.ndarray, faces: np.ndarray, cells: int = 110, least: float = 0.1) -> int:
    """The number of planar faces of a house: connected, in one plane, wider than a cell, at least some square metres.

    They are counted on its surface without noise, as parts of a house meet or hide each other's faces. Narrower ones
    are no faces of the drawing: solids touch there, and the cells cut the edge between them.
    """
    distance, low, high = house(seed)
    cell = float((high - low).max()) / cells
    corner = points[faces]
    area = 0.5 * np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    middle = _onto(distance, corner.mean(1))
    normal = _slopes(distance, middle)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-9)
    pairs, _ = shared_edges(faces)
    a, b = pairs.T
    away = np.abs((normal[a] * (middle[b] - middle[a])).sum(1))
    coplanar = ((normal[a] * normal[b]).sum(1) > 0.9999) & (away < 1e-3)
    _, piece = groups(len(faces), pairs[coplanar])
    size = np.bincount(piece, weights=area)
    large = [k for k in np.flatnonzero(size >= least) if size[k] >= 1.2 * cell * _reach(corner[piece == k])]
    return len(large)


def _reach(corners: np.ndarray) -> float:
    """The diagonal of the box of some triangles."""
    return float(np.linalg.norm(np.ptp(corners.reshape(-1, 3), axis=0)))


def grid_house(seed: int, binary: bool = True, cells: int = 96, turn: float = 31.0) -> tuple[np.ndarray, np.ndarray]:
    """A house by marching cubes on a grid of occupancy (0 or 1) or of signed distances.

    turn: of the house against the grid, in degrees about the vertical and half of it about another axis.
    """
    distance, low, high = house(seed)
    middle, reach = (low + high) / 2, np.linalg.norm(high - low) / 2
    a, b = np.radians(turn), np.radians(turn / 2)
    about = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]]) @ np.array(
        [[1, 0, 0], [0, np.cos(b), -np.sin(b)], [0, np.sin(b), np.cos(b)]]
    )
    cell = 2 * reach / cells
    grid = _grid(np.full(3, -reach), np.full(3, reach), cell)
    field = distance(grid @ about.T + middle) / cell
    points, faces = marching_cubes(np.where(field < 0, -0.5, 0.5) if binary else field)
    return points * cell - reach, faces


CORNERS = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)])
SIDES = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))  # seen from outside


def _cases() -> list[list[tuple[tuple[int, int], ...]]]:
    """Triangles for each set of inner corners of a cube, each of three edges of the cube as pairs of corners.

    Around each side of the cube, lines connect edges that leave the inside with the edges that enter it next, so that
    inner corners across a diagonal stay separate. Common sides of two cubes agree.
    """
    cases = []
    for case in range(256):
        inside = [bool(case >> k & 1) for k in range(8)]
        after = {}
        for side in SIDES:
            for k in range(4):
                a, b = side[k], side[(k + 1) % 4]
                if inside[a] or not inside[b]:
                    continue
                j = (k + 1) % 4  # from the edge that enters the inside to the next one that leaves it
                while inside[side[(j + 1) % 4]]:
                    j = (j + 1) % 4
                c, d = side[j], side[(j + 1) % 4]
                after[min(c, d), max(c, d)] = (min(a, b), max(a, b))
        triangles = []
        while after:
            start = next(iter(after))
            loop, at = [start], after.pop(start)
            while at != start:
                loop.append(at)
                at = after.pop(at)
            triangles += [(loop[0], loop[k], loop[k + 1]) for k in range(1, len(loop) - 1)]
        cases.append(triangles)
    return cases


def marching_cubes(field: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The zero level of a field, in cells: two coordinates of each vertex are whole numbers."""
    inside, shape = field < 0, field.shape
    index = np.zeros([n - 1 for n in shape], int)
    for k, corner in enumerate(CORNERS):
        index |= inside[tuple(slice(c, c + n - 1) for c, n in zip(corner, shape, strict=True))].astype(int) << k
    ends = []
    for case, triangles in enumerate(_cases()):
        cubes = np.argwhere(index == case) if triangles else np.empty((0, 3), int)
        corner = [np.ravel_multi_index((cubes + c).T, shape) for c in CORNERS]
        ends += [[[corner[k] for k in edge] for edge in triangle] for triangle in triangles if len(cubes)]
    pairs = np.concatenate([np.moveaxis(np.array(e), 2, 0) for e in ends]).reshape(-1, 2)
    edges, faces = np.unique(np.sort(pairs, axis=1), axis=0, return_inverse=True)
    a, b = (field.ravel()[edges[:, k]] for k in (0, 1))
    low, high = (np.stack(np.unravel_index(edges[:, k], shape), -1).astype(float) for k in (0, 1))
    return low + (a / (a - b))[:, None] * (high - low), faces.reshape(-1, 3)[:, ::-1].astype(np.int32)
