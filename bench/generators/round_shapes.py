"""Eighteen shapes with round parts, two extrusions, and nineteen of other sizes, with known truth, as triangle meshes.

A mesh of a signed distance is made by dual contouring: one vertex a cell of a grid that the surface crosses, where the
tangent planes at the crossings meet best; so edges are sharp and faces are no regular pattern.
"""

from dataclasses import dataclass, field, replace

import numpy as np

Z = np.array([0.0, 0, 1])
X = np.array([1.0, 0, 0])
ORIGIN = (0, 0, 0)


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


# Distances: functions of points


def block(centre, half):
    def distance(p):
        q = np.abs(p - np.asarray(centre)) - np.asarray(half)
        return length(np.maximum(q, 0)) + np.minimum(q.max(1), 0)

    return distance


def polar(p, centre, axis):
    axis = np.asarray(axis, float) / np.linalg.norm(axis)
    v = p - np.asarray(centre, float)
    z = v @ axis
    return length(v - z[:, None] * axis), z


def rod(centre, axis, radius, half):
    def distance(p):
        rho, z = polar(p, centre, axis)
        q = np.stack([rho - radius, np.abs(z) - half], 1)
        return np.minimum(q.max(1), 0) + length(np.maximum(q, 0))

    return distance


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


def stadium(half, radius, high):
    """A plate with round ends."""

    def distance(p):
        off = length((p - np.clip(p[:, 0], -half, half)[:, None] * X)[:, :2]) - radius
        return np.maximum(off, np.abs(p[:, 2]) - high)

    return distance


# Parts


def tube(radius, axis, centre=ORIGIN):
    return Round("cylinder", lambda p: polar(p, centre, axis)[0] - radius, radius, tuple(axis))


def ball(radius, centre=ORIGIN):
    return Round("sphere", lambda p: length(p - np.asarray(centre)) - radius, radius)


def around(kind, side, axis=Z):
    """A part that has an axis and no radius."""
    return Round(kind, side, None, tuple(axis))


# Shapes. half: of the grid, along x and y, and along z


def rods(half, *each):
    """Rods that are joined: centre, axis, radius, half length."""
    return Shape(any_of(*[rod(*one) for one in each]), half, [tube(r, axis, c) for c, axis, r, _ in each])


def standing(post, part, half, *plinths):
    """A post on and below blocks: the height of the middle, half sizes."""
    return Shape(any_of(post, *[block((0, 0, z), size) for z, *size in plinths]), half, [part])


def spun(heights, radii, half, kind="revolution"):
    whole, side = turned(heights, radii, smooth=kind != "cone")
    return Shape(whole, half, [around(kind, side)])


def domed(centre, size, radius, half):
    return Shape(any_of(block(centre, size), lambda p: length(p) - radius), half, [ball(radius)])


def torus(large, small, half):
    def ring(p):
        return np.hypot(np.hypot(p[:, 0], p[:, 1]) - large, p[:, 2]) - small

    return Shape(ring, half, [around("revolution", ring)])


def elbow(large, small, along_z, along_x, legs, half):
    """A pipe with a bend: its radius and the bend's, the middles of its legs and their half lengths."""

    def bend(p):
        return np.hypot(np.hypot(p[:, 0], p[:, 2]) - large, p[:, 1]) - small

    straight = any_of(rod((large, 0, along_z), Z, small, legs[0]), rod((along_x, 0, large), X, small, legs[1]))

    def whole(p):
        return np.where((p[:, 0] >= 0) & (p[:, 2] >= 0), bend(p), straight(p))

    parts = [tube(small, Z, (large, 0, 0)), tube(small, X, (0, 0, large)), around("revolution", bend, (0, 1, 0))]
    return Shape(whole, half, parts)


def vaulted(size, radius, floor, half):
    """A block with a vault along x."""

    def hole(p):
        arch = np.where(p[:, 2] > 0, np.hypot(p[:, 1], p[:, 2]) - radius, np.abs(p[:, 1]) - radius)
        return np.maximum(arch, floor - p[:, 2])

    return Shape(without(block((0, 0, 0.1), size), hole), half, [tube(radius, X)])


def rounded(core, radius, half):
    """A box with rounded edges. Its parts: its twelve edges, as one surface, and its eight corners."""
    core, sharp = np.asarray(core), block(ORIGIN, core)

    def on(p, axes):
        far = length(np.maximum(np.abs(p) - core, 0)) - radius
        return np.where((np.abs(p) > core + 0.02).sum(1) == axes, far, 9.0)

    parts = [Round("cylinder", lambda p: on(p, 2), radius), Round("sphere", lambda p: on(p, 3), radius)]
    return Shape(lambda p: sharp(p) - radius, half, parts)


def drilled(plate, half, holes, ends=()):
    """A plate with holes along z: centres and radii. ends: the same for its round ends."""
    return Shape(
        without(plate, *[rod(c, Z, r, 2) for c, r in holes]), half, [tube(r, Z, c) for c, r in (*ends, *holes)]
    )


def capsule(radius, high, half):
    def distance(p):
        return length(p - np.clip(p[:, 2], -high, high)[:, None] * Z) - radius

    return Shape(distance, half, [tube(radius, Z), ball(radius, (0, 0, high)), ball(radius, (0, 0, -high))])


def silo(middle, radius, high, roof, half):
    """A rod with a cone on it."""
    top, side = turned(*roof, smooth=False)
    return Shape(any_of(rod((0, 0, middle), Z, radius, high), top), half, [tube(radius, Z), around("cone", side)])


def oval_can(wide, high, half):
    """A can as wide along x as this, times its depth."""

    def side(p):
        x, y = p[:, 0] / wide, p[:, 1]
        far = np.maximum(np.hypot(x, y), 1e-9)
        return far * (far - 1) / np.hypot(x / wide, y)

    return Shape(lambda p: np.maximum(side(p), np.abs(p[:, 2]) - high), half, [around("extrusion", side)])


def shapes():
    post, side = turned((-2.5, -2, -1.2, -0.4, 0.6, 1.6, 2.2, 2.5), (0.55, 0.42, 0.85, 0.75, 0.4, 0.33, 0.5, 0.55))
    holes = [((-1.1, 0.2, 0), 0.55), ((0.5, -0.4, 0), 0.35), ((1.3, 0.5, 0), 0.45)]
    left, right = (-1, 0, 0), (1, 0, 0)
    return {
        "column": standing(
            rod(ORIGIN, Z, 0.8, 3.05), tube(0.8, Z), (1.35, 3.65), (-3.25, 1.2, 1.2, 0.25), (3.25, 1.1, 1.1, 0.25)
        ),
        "capped": rods((1.9, 1.9), (ORIGIN, (0.3, 0.2, 1), 1, 1.5)),
        "cone": spun((-1.5, 1.5), (1.3, 0.5), (1.5, 1.6), "cone"),
        "dome": domed((0, 0, -1), (1.5, 1.5, 1), 1.3, (1.65, 2.15)),
        "torus": torus(1.5, 0.6, (2.2, 0.8)),
        "elbow": elbow(2, 0.7, -1.5, -1.5, (1.5, 1.5), (3.2, 3.2)),
        "baluster": standing(
            post, around("revolution", side), (0.95, 3.15), (-2.75, 0.8, 0.8, 0.3), (2.75, 0.7, 0.7, 0.3)
        ),
        "vase": spun((-2, -1, 0, 1, 1.6, 2), (0.6, 1.1, 1.25, 0.8, 0.55, 0.8), (1.4, 2.2)),
        "fillet": rounded((1.2, 0.7, 0.5), 0.3, (1.7, 1.1)),
        "vault": vaulted((2.6, 1.9, 2.1), 1.4, -2.0, (2.8, 2.4)),
        "plate": drilled(block(ORIGIN, (2, 1.3, 0.4)), (2.2, 0.7), holes),
        "tee": rods((2.7, 2.7), (ORIGIN, X, 0.8, 2.5), ((0, 0, 1.2), Z, 0.6, 1.4)),
        "capsule": capsule(0.8, 1, (1.0, 2.0)),
        "silo": silo(-0.5, 1.0, 1.5, ((0.999, 2.2), (1.0, 0.1)), (1.2, 2.4)),
        "shaft": rods((1.2, 2.7), ((0, 0, -1.5), Z, 0.6, 1.0), (ORIGIN, Z, 1.0, 0.6), ((0, 0, 1.5), Z, 0.45, 1.0)),
        "barrel": spun((-1.6, -0.8, 0, 0.8, 1.6), (0.8, 1.05, 1.13, 1.05, 0.8), (1.3, 1.8)),
        "link": drilled(stadium(1, 0.8, 0.35), (2.0, 0.6), [(left, 0.4), (right, 0.4)], [(left, 0.8), (right, 0.8)]),
        "knob": Shape(
            any_of(
                lambda p: length(p - np.array([0, 0, 0.9])) - 0.9,
                rod((0, 0, -0.4), Z, 0.45, 0.8),
                block((0, 0, -1.3), (1, 1, 0.2)),
            ),
            (1.2, 2.0),
            [ball(0.9, (0, 0, 0.9)), tube(0.45, Z)],
        ),
    }


def extruded():
    """Return two extrusions of a free profile: an oval can and a moulding with a waved top."""
    base = block((0, 0, -0.3), (2.2, 1.5, 0.9))

    def wave(p):
        return (p[:, 2] - 0.35 * np.cos(2.2 * p[:, 0])) / np.hypot(1, 0.77 * np.sin(2.2 * p[:, 0]))

    moulding = Shape(lambda p: np.maximum(wave(p), base(p)), (2.4, 1.4), [around("extrusion", wave, (0, 1, 0))])
    return {"oval": oval_can(2, 1.2, (2.2, 1.4)), "moulding": moulding}


def dented(p):
    """A can with two dents, of 3 % and 6 % of its radius."""
    rho, z = polar(p, ORIGIN, Z)
    angle = np.arctan2(p[:, 1], p[:, 0])
    dents = 0.06 * np.exp(-(((angle - 1) / 0.35) ** 2) - ((z - 0.3) / 0.4) ** 2)
    dents += 0.03 * np.exp(-(((angle + 1.6) / 0.25) ** 2) - ((z + 0.6) / 0.3) ** 2)
    return np.maximum(rho - 1 + dents, np.abs(z) - 1.5)


def more_shapes():
    """Shapes of other sizes than in `shapes`: no number was chosen on them."""
    post, side = turned((-2, -1.4, -0.6, 0.3, 1.2, 2), (0.5, 0.35, 0.7, 0.45, 0.3, 0.5))
    holes = [((-1.0, 0.4, 0), 0.4), ((0.4, -0.3, 0), 0.6), ((1.4, 0.5, 0), 0.25)]
    left, right = (-1.2, 0, 0), (1.2, 0, 0)
    return {
        "long rod": rods((1.7, 2.1), (ORIGIN, (0.2, -0.4, 1), 0.6, 1.8)),
        "dented can": Shape(dented, (1.2, 1.7), [tube(1, Z)]),
        "post": standing(
            rod(ORIGIN, Z, 0.6, 2.05), tube(0.6, Z), (1.05, 2.6), (-2.2, 0.9, 0.9, 0.2), (2.2, 0.8, 0.8, 0.2)
        ),
        "stump": spun((-1, 1), (1.4, 0.25), (1.6, 1.2), "cone"),
        "tip": spun((-1.2, 1.2), (0.9, 0.001), (1.1, 1.4), "cone"),
        "bowl": domed((0, 0, -0.8), (1.4, 1.1, 0.8), 0.9, (1.6, 1.8)),
        "tyre": torus(1.7, 0.45, (2.3, 0.65)),
        "pipe": elbow(1.3, 0.45, -1, -0.8, (1, 0.8), (2.3, 2.3)),
        "leg": standing(post, around("revolution", side), (0.9, 2.6), (-2.2, 0.7, 0.6, 0.25)),
        "jar": spun((-1.8, -0.9, 0.2, 1.2, 1.8), (0.5, 0.95, 0.7, 0.9, 1.1), (1.3, 2.0)),
        "soap": rounded((0.9, 1.1, 0.4), 0.2, (1.5, 1.5)),
        "bridge": vaulted((2.0, 1.5, 1.6), 1.1, -1.5, (2.2, 2.0)),
        "bracket": drilled(block(ORIGIN, (1.9, 1.2, 0.3)), (2.1, 0.6), holes),
        "cross": rods((2.2, 2.0), (ORIGIN, X, 0.6, 2.0), ((0.2, 0, 0), Z, 0.5, 1.8)),
        "pill": capsule(0.6, 1.3, (0.8, 2.1)),
        "bin": silo(-0.2, 0.8, 1.4, ((1.199, 2.0), (0.8, 0.2)), (1.0, 2.2)),
        "axle": rods((1.1, 2.3), ((0, 0, -1.2), Z, 0.4, 0.9), (ORIGIN, Z, 0.9, 0.4), ((0, 0, 1.2), Z, 0.6, 0.9)),
        "slab": drilled(stadium(1.2, 0.6, 0.25), (2.0, 0.5), [(left, 0.3), (right, 0.35)], [(left, 0.6), (right, 0.6)]),
        "tin": oval_can(1.5, 0.9, (1.7, 1.1)),
    }


def turned_shape(name, seed, noise, steps=52):
    """One of `more_shapes`, turned by chance, with noise: its truth, vertices and triangles."""
    shape = more_shapes()[name]
    vertices, faces = made(shape, steps)
    rotation, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    if np.linalg.det(rotation) < 0:
        rotation = -rotation
    parts = [replace(p, axis=p.axis and tuple(rotation @ np.asarray(p.axis, float))) for p in shape.parts]
    return replace(shape, parts=parts), with_noise(vertices @ rotation.T, noise, seed + 1), faces


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
