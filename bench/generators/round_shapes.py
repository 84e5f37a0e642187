"""Eighteen shapes with round parts, and two extrusions, whose truth is known, as triangle meshes of signed distances.

A mesh is made by dual contouring: one vertex a cell of a grid that the surface crosses, where the tangent planes at the
crossings meet best; so edges are sharp and faces are no regular pattern.
"""

from dataclasses import dataclass, field

import numpy as np

Z = np.array([0.0, 0, 1])
X = np.array([1.0, 0, 0])


@dataclass(frozen=True)
class Round:
    """A curved part of the truth. `distance` is signed or not, of points to the whole surface."""

    kind: str
    distance: object
    radius: float | None = None
    axis: tuple | None = None


@dataclass(frozen=True)
class Shape:
    distance: object
    half: tuple
    parts: list = field(default_factory=list)


def length(v):
    return np.linalg.norm(v, axis=-1)


def block(p, centre, half):
    q = np.abs(p - np.asarray(centre)) - np.asarray(half)
    return length(np.maximum(q, 0)) + np.minimum(q.max(1), 0)


def polar(p, centre, axis):
    axis = np.asarray(axis, float) / np.linalg.norm(axis)
    v = p - np.asarray(centre, float)
    z = v @ axis
    return length(v - z[:, None] * axis), z


def rod(p, centre, axis, radius, half):
    rho, z = polar(p, centre, axis)
    q = np.stack([rho - radius, np.abs(z) - half], 1)
    return np.minimum(q.max(1), 0) + length(np.maximum(q, 0))


def tube(radius, axis, centre=(0, 0, 0)):
    return Round("cylinder", lambda p: polar(p, centre, axis)[0] - radius, radius, tuple(axis))


def ball(radius, centre=(0, 0, 0)):
    return Round("sphere", lambda p: length(p - np.asarray(centre)) - radius, radius)


def turned(heights, radii, smooth=True):
    """A solid of revolution around z, by its radius over the height."""
    heights, radii = np.asarray(heights, float), np.asarray(radii, float)
    slopes = np.gradient(radii, heights) if smooth else None  # slopes of cubic Hermite curves

    def radius(z):
        z = np.clip(z, heights[0], heights[-1])
        if slopes is None:
            return np.interp(z, heights, radii)
        k = np.clip(np.searchsorted(heights, z, side="right") - 1, 0, len(heights) - 2)
        h = heights[k + 1] - heights[k]
        t = (z - heights[k]) / h
        return (
            (2 * t**3 - 3 * t**2 + 1) * radii[k]
            + (t**3 - 2 * t**2 + t) * h * slopes[k]
            + (3 * t**2 - 2 * t**3) * radii[k + 1]
            + (t**3 - t**2) * h * slopes[k + 1]
        )

    def side(p):
        z = p[:, 2]
        steep = (radius(z + 1e-4) - radius(z - 1e-4)) / 2e-4
        return (np.hypot(p[:, 0], p[:, 1]) - radius(z)) / np.sqrt(1 + steep**2)

    low, high = heights[0], heights[-1]
    return lambda p: np.maximum(side(p), np.abs(p[:, 2] - (low + high) / 2) - (high - low) / 2), side


def any_of(*distances):
    return lambda p: np.minimum.reduce([d(p) for d in distances])


def without(distance, *holes):
    return lambda p: np.maximum(distance(p), -np.minimum.reduce([h(p) for h in holes]))


def ring(p, large, small):
    return np.hypot(np.hypot(p[:, 0], p[:, 1]) - large, p[:, 2]) - small


def elbow(large, small, along_z, along_x, half):
    """A pipe with a bend: its radius and the bend's, the middles of its legs and their half lengths."""

    def bend(p):
        return np.hypot(np.hypot(p[:, 0], p[:, 2]) - large, p[:, 1]) - small

    def whole(p):
        legs = np.minimum(
            rod(p, (large, 0, along_z), Z, small, half[0]), rod(p, (along_x, 0, large), X, small, half[1])
        )
        return np.where((p[:, 0] >= 0) & (p[:, 2] >= 0), bend(p), legs)

    parts = [tube(small, Z, (large, 0, 0)), tube(small, X, (0, 0, large)), Round("revolution", bend, None, (0, 1, 0))]
    return whole, parts


def revolution(side):
    return Round("revolution", side, None, tuple(Z))


def vault(radius, floor):
    """The hole below a vault along x."""

    def hole(p):
        arch = np.where(p[:, 2] > 0, np.hypot(p[:, 1], p[:, 2]) - radius, np.abs(p[:, 1]) - radius)
        return np.maximum(arch, floor - p[:, 2])

    return hole


def rounded(core, radius):
    """A box with rounded edges: its distance; its twelve edges, as one surface, and its eight corners."""
    core = np.asarray(core)

    def far(p):
        return length(np.maximum(np.abs(p) - core, 0)) - radius

    def on(p, axes):
        return np.where((np.abs(p) > core + 0.02).sum(1) == axes, far(p), 9.0)

    parts = [Round("cylinder", lambda p: on(p, 2), radius), Round("sphere", lambda p: on(p, 3), radius)]
    return lambda p: block(p, (0, 0, 0), core) - radius, parts


def stadium(p, half, radius, high):
    """A plate with round ends."""
    return np.maximum(length((p - np.clip(p[:, 0], -half, half)[:, None] * X)[:, :2]) - radius, np.abs(p[:, 2]) - high)


def oval(wide):
    """The side of a can as wide along x as this, times its depth."""

    def side(p):
        x, y = p[:, 0] / wide, p[:, 1]
        far = np.maximum(np.hypot(x, y), 1e-9)
        return far * (far - 1) / np.hypot(x / wide, y)

    return side


def shapes():
    cone, cone_side = turned((-1.5, 1.5), (1.3, 0.5), smooth=False)
    vase, vase_side = turned((-2, -1, 0, 1, 1.6, 2), (0.6, 1.1, 1.25, 0.8, 0.55, 0.8))
    post, post_side = turned((-2.5, -2, -1.2, -0.4, 0.6, 1.6, 2.2, 2.5), (0.55, 0.42, 0.85, 0.75, 0.4, 0.33, 0.5, 0.55))
    barrel, barrel_side = turned((-1.6, -0.8, 0, 0.8, 1.6), (0.8, 1.05, 1.13, 1.05, 0.8))
    roof, roof_side = turned((0.999, 2.2), (1.0, 0.1), smooth=False)
    pipe, bend = elbow(2, 0.7, -1.5, -1.5, (1.5, 1.5))
    box, fillets = rounded((1.2, 0.7, 0.5), 0.3)
    holes = [((-1.1, 0.2, 0), 0.55), ((0.5, -0.4, 0), 0.35), ((1.3, 0.5, 0), 0.45)]
    leaning = (0.3, 0.2, 1)
    return {
        "column": Shape(
            any_of(
                lambda p: rod(p, (0, 0, 0), Z, 0.8, 3.05),
                lambda p: block(p, (0, 0, -3.25), (1.2, 1.2, 0.25)),
                lambda p: block(p, (0, 0, 3.25), (1.1, 1.1, 0.25)),
            ),
            (1.35, 3.65),
            [tube(0.8, Z)],
        ),
        "capped": Shape(lambda p: rod(p, (0, 0, 0), leaning, 1, 1.5), (1.9, 1.9), [tube(1, leaning)]),
        "cone": Shape(cone, (1.5, 1.6), [Round("cone", cone_side, None, tuple(Z))]),
        "dome": Shape(
            any_of(lambda p: block(p, (0, 0, -1), (1.5, 1.5, 1)), lambda p: length(p) - 1.3), (1.65, 2.15), [ball(1.3)]
        ),
        "torus": Shape(lambda p: ring(p, 1.5, 0.6), (2.2, 0.8), [revolution(lambda p: ring(p, 1.5, 0.6))]),
        "elbow": Shape(pipe, (3.2, 3.2), bend),
        "baluster": Shape(
            any_of(
                post,
                lambda p: block(p, (0, 0, -2.75), (0.8, 0.8, 0.3)),
                lambda p: block(p, (0, 0, 2.75), (0.7, 0.7, 0.3)),
            ),
            (0.95, 3.15),
            [revolution(post_side)],
        ),
        "vase": Shape(vase, (1.4, 2.2), [revolution(vase_side)]),
        "fillet": Shape(box, (1.7, 1.1), fillets),
        "vault": Shape(
            without(lambda p: block(p, (0, 0, 0.1), (2.6, 1.9, 2.1)), vault(1.4, -2.0)), (2.8, 2.4), [tube(1.4, X)]
        ),
        "plate": Shape(
            without(
                lambda p: block(p, (0, 0, 0), (2, 1.3, 0.4)),
                *[lambda p, c=c, r=r: rod(p, c, Z, r, 2) for c, r in holes],
            ),
            (2.2, 0.7),
            [tube(r, Z, c) for c, r in holes],
        ),
        "tee": Shape(
            any_of(lambda p: rod(p, (0, 0, 0), X, 0.8, 2.5), lambda p: rod(p, (0, 0, 1.2), Z, 0.6, 1.4)),
            (2.7, 2.7),
            [tube(0.8, X), tube(0.6, Z)],
        ),
        "capsule": Shape(
            lambda p: length(p - np.clip(p[:, 2], -1, 1)[:, None] * Z) - 0.8,
            (1.0, 2.0),
            [tube(0.8, Z), ball(0.8, (0, 0, 1)), ball(0.8, (0, 0, -1))],
        ),
        "silo": Shape(
            any_of(lambda p: rod(p, (0, 0, -0.5), Z, 1.0, 1.5), roof),
            (1.2, 2.4),
            [tube(1.0, Z), Round("cone", roof_side, None, tuple(Z))],
        ),
        "shaft": Shape(
            any_of(
                lambda p: rod(p, (0, 0, -1.5), Z, 0.6, 1.0),
                lambda p: rod(p, (0, 0, 0), Z, 1.0, 0.6),
                lambda p: rod(p, (0, 0, 1.5), Z, 0.45, 1.0),
            ),
            (1.2, 2.7),
            [tube(0.6, Z), tube(1.0, Z), tube(0.45, Z)],
        ),
        "barrel": Shape(barrel, (1.3, 1.8), [revolution(barrel_side)]),
        "link": Shape(
            without(
                lambda p: stadium(p, 1, 0.8, 0.35),
                lambda p: rod(p, (-1, 0, 0), Z, 0.4, 2),
                lambda p: rod(p, (1, 0, 0), Z, 0.4, 2),
            ),
            (2.0, 0.6),
            [tube(r, Z, (x, 0, 0)) for x in (-1, 1) for r in (0.8, 0.4)],
        ),
        "knob": Shape(
            any_of(
                lambda p: length(p - np.array([0, 0, 0.9])) - 0.9,
                lambda p: rod(p, (0, 0, -0.4), Z, 0.45, 0.8),
                lambda p: block(p, (0, 0, -1.3), (1, 1, 0.2)),
            ),
            (1.2, 2.0),
            [ball(0.9, (0, 0, 0.9)), tube(0.45, Z)],
        ),
    }


def extruded():
    """Return two extrusions of a free profile: an oval can and a moulding with a waved top."""
    side = oval(2)

    def wave(p):
        return (p[:, 2] - 0.35 * np.cos(2.2 * p[:, 0])) / np.hypot(1, 0.77 * np.sin(2.2 * p[:, 0]))

    return {
        "oval": Shape(
            lambda p: np.maximum(side(p), np.abs(p[:, 2]) - 1.2), (2.2, 1.4), [Round("extrusion", side, None, tuple(Z))]
        ),
        "moulding": Shape(
            lambda p: np.maximum(wave(p), block(p, (0, 0, -0.3), (2.2, 1.5, 0.9))),
            (2.4, 1.4),
            [Round("extrusion", wave, None, (0, 1, 0))],
        ),
    }


def gradient(distance, p, step=1e-4):
    g = np.stack([distance(p + step * e) - distance(p - step * e) for e in np.eye(3)], 1)
    return g / np.maximum(length(g), 1e-12)[:, None]


def contour(distance, half_x, half_z, steps):
    """Triangles of the zero set, by dual contouring of a grid of cells of one size."""
    h = 2 * half_x / steps
    xs, zs = np.arange(-half_x, half_x + h, h) + 0.013 * h, np.arange(-half_z, half_z + h, h) + 0.017 * h
    grid = np.stack(np.meshgrid(xs, xs, zs, indexing="ij"), -1)
    value = distance(grid.reshape(-1, 3)).reshape(grid.shape[:3])
    cells = tuple(n - 1 for n in value.shape)
    places, normals, owners, quads = [], [], [], []
    for axis in range(3):
        low, high = [slice(None)] * 3, [slice(None)] * 3
        low[axis], high[axis] = slice(0, -1), slice(1, None)
        at = np.argwhere((value[tuple(low)] < 0) != (value[tuple(high)] < 0))
        at = at[((at > 0) & (at < np.array(value.shape) - 2)).all(1)]
        to = at + np.eye(3, dtype=int)[axis]
        a, b = grid[tuple(at.T)], grid[tuple(to.T)]
        fa, fb = value[tuple(at.T)], value[tuple(to.T)]
        p = a + (fa / (fa - fb))[:, None] * (b - a)
        n = gradient(distance, p)
        u, v = (axis + 1) % 3, (axis + 2) % 3
        corners = []
        for du, dv in ((0, 0), (1, 0), (1, 1), (0, 1)):
            cell = at.copy()
            cell[:, u] -= du
            cell[:, v] -= dv
            corners.append(np.ravel_multi_index(cell.T, cells))
            places.append(p)
            normals.append(n)
            owners.append(corners[-1])
        quad = np.stack(corners, 1)
        quads.append(np.where((fa < 0)[:, None], quad, quad[:, ::-1]))
    places, normals, owners = np.concatenate(places), np.concatenate(normals), np.concatenate(owners)
    cell, index = np.unique(owners, return_inverse=True)
    count = len(cell)
    middle = np.stack([np.bincount(index, places[:, k], count) for k in range(3)], 1)
    middle /= np.bincount(index, minlength=count)[:, None]
    square, right = np.zeros((count, 3, 3)), np.zeros((count, 3))
    np.add.at(square, index, normals[:, :, None] * normals[:, None])
    np.add.at(right, index, normals * ((places - middle[index]) * normals).sum(1)[:, None])
    size, vectors = np.linalg.eigh(square)
    inverse = np.where(size > 0.08 * size[:, 2:], 1 / np.maximum(size, 1e-9), 0)
    move = np.einsum("kij,kj,klj,kl->ki", vectors, inverse, vectors, right)
    points = middle + np.clip(move, -1.2 * h, 1.2 * h)
    quad = np.searchsorted(cell, np.concatenate(quads))
    first = length(points[quad[:, 0]] - points[quad[:, 2]]) < length(points[quad[:, 1]] - points[quad[:, 3]])
    one = np.where(first[:, None], quad[:, [0, 1, 2]], quad[:, [0, 1, 3]])
    other = np.where(first[:, None], quad[:, [0, 2, 3]], quad[:, [1, 2, 3]])
    return points, np.concatenate([one, other])


def made(shape, steps=64):
    """Vertices and triangles of a shape."""
    half_x, half_z = shape.half
    return contour(shape.distance, half_x, half_z, int(steps * 0.62) if half_z > 1.6 * half_x else steps)


def with_noise(vertices, share, seed):
    """Normal noise in all directions, `share` of the diagonal long on average."""
    if share == 0:
        return vertices
    size = np.linalg.norm(np.ptp(vertices, axis=0))
    return vertices + np.random.default_rng(seed).normal(size=vertices.shape) * share * size / np.sqrt(3)


def part_of_faces(shape, vertices, triangles):
    """(F,) the curved part that each face of the clean shape is on, -1 where on none."""
    corners = vertices[triangles]
    centre = corners.mean(1)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(length(normal), 1e-300)[:, None]
    best, part = np.full(len(triangles), np.inf), np.full(len(triangles), -1)
    near = 0.004 * np.linalg.norm(np.ptp(vertices, axis=0))
    for k, round_part in enumerate(shape.parts):
        d = np.abs(round_part.distance(centre))
        is_on = (d < near) & (np.abs((gradient(round_part.distance, centre) * normal).sum(1)) > 0.97) & (d < best)
        best[is_on], part[is_on] = d[is_on], k
    return part
