"""Makes grid meshes of a solid of triangles: its signed distances, marching cubes, dual contouring, usual defects."""

import numpy as np

from bench.generators.real_scans import marching_cubes

BAND = 6.0  # cells; distances are known up to here


def distances(corners, origin, cell, shape):
    """Signed distances in cells at the nodes of a grid, and the nearest triangle of nodes within the band (else -1)."""
    field = np.full(shape, BAND, np.float32)
    nearest = np.full(shape, -1, np.int32)
    flips = np.zeros(shape, bool)
    for number, triangle in enumerate((corners - origin) / cell):
        low = np.clip(np.floor(triangle.min(0) - BAND).astype(int), 0, shape)
        high = np.clip(np.ceil(triangle.max(0) + BAND).astype(int) + 1, 0, shape)
        normal = np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
        normal /= np.linalg.norm(normal)
        axes = [np.arange(a, b, dtype=np.float32) for a, b in zip(low, high, strict=True)]
        height = sum(
            np.expand_dims(normal[k] * (axes[k] - triangle[0, k]), [j for j in range(3) if j != k]) for k in range(3)
        )
        at = np.argwhere(np.abs(height) < BAND) + low
        far = _from_triangle(at.astype(float), triangle, normal)
        index = tuple(at[far < field[tuple(at.T)]].T)
        field[index], nearest[index] = far[far < field[tuple(at.T)]], number
        _flip(flips, triangle, normal)
    inside = np.logical_xor.accumulate(flips, axis=2)
    return np.where(inside, -field, field), nearest


def _from_triangle(points, triangle, normal):
    off = (points - triangle[0]) @ normal
    within = np.ones(len(points), bool)
    beside = np.full(len(points), np.inf)
    for k in range(3):
        begin, edge = triangle[k], triangle[(k + 1) % 3] - triangle[k]
        along = np.clip((points - begin) @ edge / (edge @ edge), 0, 1)
        beside = np.minimum(beside, np.linalg.norm(points - begin - along[:, None] * edge, axis=1))
        within &= (points - begin) @ np.cross(normal, edge) >= 0
    return np.where(within, np.abs(off), beside)


def _flip(flips, triangle, normal):
    """Turns the first node above the triangle in each column that meets it."""
    if abs(normal[2]) < 1e-12:
        return
    low = np.clip(np.ceil(triangle[:, :2].min(0)).astype(int), 0, flips.shape[:2])
    high = np.clip(np.floor(triangle[:, :2].max(0)).astype(int) + 1, 0, flips.shape[:2])
    at = np.stack(np.meshgrid(*map(np.arange, low, high), indexing="ij"), -1).reshape(-1, 2)
    within = np.ones(len(at), bool)
    for k in range(3):
        begin, edge = triangle[k, :2], (triangle[(k + 1) % 3] - triangle[k])[:2]
        side = edge[0] * (at[:, 1] - begin[1]) - edge[1] * (at[:, 0] - begin[0])
        within &= side * np.sign(normal[2]) > 0
    at = at[within]
    height = np.ceil(triangle[0, 2] - ((at - triangle[0, :2]) @ normal[:2]) / normal[2]).astype(int)
    flips[at[:, 0], at[:, 1], np.clip(height, 0, flips.shape[2] - 1)] ^= True


def dual_contouring(field):
    """The zero level of a field by a vertex in each cell, nearest to the tangent planes where its edges cross it."""
    inside, shape = field < 0, np.array(field.shape)
    slope = np.stack(np.gradient(field), -1)
    cells, quads, places, normals = [], [], [], []
    for axis in range(3):
        step = np.eye(3, dtype=int)[axis]
        first, second = inside.take(range(shape[axis] - 1), axis), inside.take(range(1, shape[axis]), axis)
        at = np.argwhere(first != second)
        a, b = field[tuple(at.T)], field[tuple((at + step).T)]
        share = (a / (a - b))[:, None]
        normal = slope[tuple(at.T)] * (1 - share) + slope[tuple((at + step).T)] * share
        u, v = np.eye(3, dtype=int)[(axis + 1) % 3], np.eye(3, dtype=int)[(axis + 2) % 3]
        around = np.stack([at - u - v, at - v, at, at - u], 1)
        around[~inside[tuple(at.T)]] = around[~inside[tuple(at.T)]][:, ::-1]
        quads.append(np.ravel_multi_index(np.moveaxis(around, 2, 0), shape))
        places.append(np.repeat(at + share * step, 4, axis=0))
        normals.append(np.repeat(normal / np.linalg.norm(normal, axis=1, keepdims=True), 4, axis=0))
    cells, quads = np.unique(np.concatenate(quads), return_inverse=True)
    quads, places, normals = quads.reshape(-1, 4), np.concatenate(places), np.concatenate(normals)
    of, count = quads.ravel(), np.bincount(quads.ravel())
    middle = np.stack([np.bincount(of, places[:, k]) / count for k in range(3)], 1)
    product = normals[:, :, None] * normals[:, None, :]
    square = np.stack([np.bincount(of, product.reshape(-1, 9)[:, k]) for k in range(9)], 1).reshape(-1, 3, 3)
    off = ((places - middle[of]) * normals).sum(1)
    right = np.stack([np.bincount(of, normals[:, k] * off) for k in range(3)], 1)
    move = np.einsum("nij,nj->ni", np.linalg.pinv(square, rcond=0.1, hermitian=True), right)
    corner = np.stack(np.unravel_index(cells, shape), -1)
    points = np.clip(middle + move, corner, corner + 1)
    return points, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]).astype(np.int32)


def smoothed(points, faces, rounds):
    """Moves each vertex to the mean of its neighbours, `rounds` times."""
    edges = np.unique(np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1), axis=0)
    a, b = np.concatenate([edges, edges[:, ::-1]]).T
    count = np.bincount(a, minlength=len(points))[:, None]
    for _ in range(rounds):
        points = np.stack([np.bincount(a, points[b, k], len(points)) for k in range(3)], 1) / count
    return points, faces


def with_defects(points, faces, field, seed):
    """Adds usual defects: a wall inside, three cells below the surface, crumbs outside it, doubled faces."""
    random, low, high = np.random.default_rng(seed), points.min(0), points.max(0)
    inner, within = marching_cubes(field + 3)
    parts = [(points, faces), (inner, within[:, ::-1])]
    ball = 1.5 * np.array([(1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)])
    sides = np.array([(k, (k + 1) % 4, 4) for k in range(4)] + [((k + 1) % 4, k, 5) for k in range(4)])
    for _ in range(12):
        place, side = random.uniform(low, high), random.integers(3)
        place[side] = random.choice([low[side] - 5, high[side] + 5])
        parts.append((ball + place, sides))
    start = np.cumsum([0, *(len(p) for p, _ in parts)])
    faces = np.concatenate([f + s for (_, f), s in zip(parts, start[:-1], strict=True)])
    doubled = faces[random.choice(len(faces), len(faces) // 50, replace=False)]
    return np.concatenate([p for p, _ in parts]), np.concatenate([faces, doubled]).astype(np.int32)
