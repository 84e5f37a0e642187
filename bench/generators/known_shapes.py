"""Shapes whose true number of planes is known, and scanned forms of them: 132 meshes, the same on every run."""

import numpy as np

from bench.generators.collapse import decimated

SEED = 7


class Shape:
    """Vertices (V, 3) float64, faces (F, 3) int64, and the number of planes the surface is made of."""

    def __init__(self, vertices, faces, planes):
        self.vertices, self.faces, self.planes = np.asarray(vertices, float), np.asarray(faces), planes

    def moved(self, vertices):
        return Shape(vertices, self.faces, self.planes)

    @property
    def longest_side(self):
        used = self.vertices[np.unique(self.faces)]
        return np.max(np.nanmax(used, axis=0) - np.nanmin(used, axis=0))


def welded(points, faces, planes):
    """Equal places become one vertex."""
    _, first, index = np.unique(np.round(points, 7) + 0.0, axis=0, return_index=True, return_inverse=True)
    return Shape(np.asarray(points, float)[first], index.reshape(-1)[faces], planes)


def grids(quads, planes):
    """Each quad (corners a b c d, n steps along ab, m along bc) as a grid of triangles."""
    points, faces, base = [], [], 0
    for corners, n, m in quads:
        a, b, c, d = (np.asarray(p, float) for p in corners)
        s, t = (k.reshape(-1, 1) for k in np.meshgrid(np.arange(n + 1) / n, np.arange(m + 1) / m, indexing="ij"))
        points.append(a * (1 - s) * (1 - t) + b * s * (1 - t) + c * s * t + d * (1 - s) * t)
        i, j = (k.reshape(-1) for k in np.meshgrid(np.arange(n), np.arange(m), indexing="ij"))
        at = base + i * (m + 1) + j
        faces += [np.stack([at, at + m + 1, at + m + 2], 1), np.stack([at, at + m + 2, at + 1], 1)]
        base += len(points[-1])
    return welded(np.concatenate(points), np.concatenate(faces), planes)


def polygons(loops, planes, halvings):
    """Each loop as a fan of triangles around its first corner, every triangle split in four `halvings` times."""
    points = np.concatenate(loops)
    starts = np.cumsum([0] + [len(loop) for loop in loops[:-1]])
    faces = [(s, s + k, s + k + 1) for s, loop in zip(starts, loops, strict=True) for k in range(1, len(loop) - 1)]
    shape = welded(points, np.array(faces), planes)
    for _ in range(halvings):
        shape = upsampled(shape)
    return shape


def split_in_four(vertices, triangles):
    """The same surface with every face split at the middles of its edges."""
    ends = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges, middle = np.unique(ends, axis=0, return_inverse=True)
    (a, b, c), (x, y, z) = triangles.T, (len(vertices) + middle.reshape(-1, 3)).T
    four = [[a, x, z], [x, b, y], [z, y, c], [x, y, z]]
    faces = np.concatenate([np.stack(face, axis=1) for face in four])
    return np.concatenate([vertices, vertices[edges].mean(axis=1)]), faces


def upsampled(shape):
    return Shape(*split_in_four(shape.vertices, shape.faces), shape.planes)


def box(low, high, steps):
    """The six sides of a box, outward; `steps` along x, y and z."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    i, j, k = steps
    return [
        ([(x0, y0, z0), (x0, y1, z0), (x1, y1, z0), (x1, y0, z0)], j, i),
        ([(x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)], i, j),
        ([(x0, y0, z0), (x1, y0, z0), (x1, y0, z1), (x0, y0, z1)], i, k),
        ([(x1, y0, z0), (x1, y1, z0), (x1, y1, z1), (x1, y0, z1)], j, k),
        ([(x1, y1, z0), (x0, y1, z0), (x0, y1, z1), (x1, y1, z1)], i, k),
        ([(x0, y1, z0), (x0, y0, z0), (x0, y0, z1), (x0, y1, z1)], j, k),
    ]


def cube(n=20):
    return grids(box((0, 0, 0), (1, 1, 1), (n, n, n)), 6)


def two_cubes(offset):
    far = tuple(c + 1 for c in offset)
    return grids(box((0, 0, 0), (1, 1, 1), (10, 10, 10)) + box(offset, far, (10, 10, 10)), 12)


def fin_cube():
    """A cube with a sheet standing on the middle of its top: the sheet's foot is a non-manifold edge."""
    fin = ([(0, 0.5, 1), (1, 0.5, 1), (1, 0.5, 2), (0, 0.5, 2)], 10, 10)
    return grids(box((0, 0, 0), (1, 1, 1), (10, 10, 10)) + [fin], 7)


def house():
    """An L-shaped house with saddle roofs: floor, six walls, four slopes."""
    plan = [(0, 0), (10, 0), (10, 4), (4, 4), (4, 10), (0, 10)]
    loops = [[(x, y, 0) for x, y in plan[:1] + plan[:0:-1]]]
    ridge = {1: (10, 2, 5), 4: (2, 10, 5)}  # the gables, by the first corner of their wall
    for k, a in enumerate(plan):
        b = plan[(k + 1) % 6]
        loops.append([(*a, 0), (*b, 0), (*b, 3)] + ([ridge[k]] if k in ridge else []) + [(*a, 3)])
    inner, (east, north) = (2, 2, 5), (ridge[1], ridge[4])
    loops += [
        [(0, 0, 3), (10, 0, 3), east, inner],
        [(0, 10, 3), (0, 0, 3), inner, north],
        [(10, 4, 3), (4, 4, 3), inner, east],
        [(4, 4, 3), (4, 10, 3), north, inner],
    ]
    return polygons(loops, 11, 4)


def frame(z):
    """A square of side 4 with a hole of side 2."""
    outer, inner = [(0, 0), (4, 0), (4, 4), (0, 4)], [(1, 1), (3, 1), (3, 3), (1, 3)]
    rings = [(outer[k], outer[k - 3], inner[k - 3], inner[k]) for k in range(4)]
    return [[(*p, z) for p in ring] for ring in rings], outer, inner


def washer():
    top, outer, inner = frame(1)
    bottom = [[(x, y, 0) for x, y, _ in loop[::-1]] for loop in top]
    sides = []
    for loop in (outer, inner[::-1]):
        for a, b in zip(loop, loop[1:] + loop[:1], strict=True):
            sides.append([(*a, 0), (*b, 0), (*b, 1), (*a, 1)])
    return polygons(top + bottom + sides, 10, 4)


def stairs(steps=10, n=5):
    """An open flight: a tread and a riser a step."""
    quads, w = [], float(steps)
    for k in range(steps):
        quads.append(([(k, 0, k), (k, 0, k + 1), (k, w, k + 1), (k, w, k)], n, 4 * n))
        quads.append(([(k, 0, k + 1), (k + 1, 0, k + 1), (k + 1, w, k + 1), (k, w, k + 1)], n, 4 * n))
    return grids(quads, 2 * steps)


def plate(thickness=0.01):
    return grids(box((0, 0, 0), (1, 1, thickness), (20, 20, 1)), 6)


def wedge(thickness=0.02, n=20):
    """A slab that runs out to nothing along one edge."""
    a, b, c, d = (0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)
    e, f = (0, 0, thickness), (0, 1, thickness)
    shape = grids([([a, d, c, b], n, n), ([e, b, c, f], n, n), ([a, e, f, d], 1, n)], 5)
    points, faces = [shape.vertices], [shape.faces]
    for y, turn in ((0.0, 1), (1.0, -1)):  # the ends: strips of triangles between the two slopes
        x = np.arange(n) / n
        low = np.stack([np.arange(n + 1) / n, np.full(n + 1, y), np.zeros(n + 1)], 1)
        high = np.stack([x, np.full(n, y), thickness * (1 - x)], 1)
        k = np.arange(n)
        strip = np.concatenate([np.stack([k, k + 1, n + 1 + k], 1), np.stack([k + 1, n + 2 + k, n + 1 + k], 1)[:-1]])
        faces.append(strip[:, ::turn] + sum(len(p) for p in points))
        points += [low, high]
    return welded(np.concatenate(points), np.concatenate(faces), 5)


def rotation(rng):
    """A turn by chance, as a matrix."""
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return q * np.sign(np.linalg.det(q))


def rotated(shape):
    return shape.moved(shape.vertices @ rotation(np.random.default_rng(3)).T)


def jittered_in_planes(shape, rng, share=0.3, n=20):
    """A unit cube whose vertices are moved, but only along the sides they lie on."""
    inside = (shape.vertices > 1e-6) & (shape.vertices < 1 - 1e-6)
    return shape.moved(shape.vertices + inside * rng.uniform(-share / n, share / n, shape.vertices.shape))


def noisy(shape, percent, rng):
    return shape.moved(shape.vertices + rng.normal(size=shape.vertices.shape) * shape.longest_side * percent / 100)


def smoothed(shape, steps):
    f, vertices = shape.faces, shape.vertices
    ends = np.concatenate([f[:, [0, 1]], f[:, [1, 2]], f[:, [2, 0]]])
    ends = np.unique(np.concatenate([ends, ends[:, ::-1]]), axis=0)
    degree = np.bincount(ends[:, 0], minlength=len(vertices))[:, None]
    for _ in range(steps):
        total = np.zeros_like(vertices)
        np.add.at(total, ends[:, 0], vertices[ends[:, 1]])
        vertices = vertices + 0.5 * (total / np.maximum(degree, 1) - vertices)
    return shape.moved(vertices)


def with_repeated_faces(shape, rng, count=100):
    twice = rng.choice(len(shape.faces), count, replace=False)
    return Shape(shape.vertices, np.concatenate([shape.faces, shape.faces[twice]]), shape.planes)


def with_lost_vertices(shape, rng, count=2):
    vertices = shape.vertices.copy()
    inside = np.flatnonzero(((vertices > 1e-6) & (vertices < 1 - 1e-6)).sum(axis=1) == 2)
    vertices[rng.choice(inside, count, replace=False)] = np.nan
    return shape.moved(vertices)


def with_repeated_corners(shape, rng, count=100):
    bad = shape.faces[rng.choice(len(shape.faces), count, replace=False)].copy()
    bad[:, 2] = bad[:, 0]
    return Shape(shape.vertices, np.concatenate([shape.faces, bad]), shape.planes)


def with_flat_faces(shape, rng, count=100):
    """A face without area between two neighbours: its third corner is the middle of their edge."""
    vertices, faces, taken = list(shape.vertices), [tuple(f) for f in shape.faces], set()
    owner = {(f[k], f[(k + 1) % 3]): i for i, f in enumerate(faces) for k in range(3)}
    for i in rng.permutation(len(faces)):
        a, b, _ = faces[i]
        j = owner.get((b, a))
        if i in taken or j in taken:
            continue
        d = next(v for v in faces[j] if v not in (a, b))
        m = len(vertices)
        vertices.append((vertices[a] + vertices[b]) / 2)
        faces[j] = (b, m, d)
        faces += [(m, a, d), (a, m, b)]
        taken |= {i, j}
        if m - len(shape.vertices) + 1 == count:
            break
    return Shape(np.array(vertices), np.array(faces), shape.planes)


def base_shapes():
    """The 22 shapes: name -> (class, shape)."""
    rng = np.random.default_rng(SEED)
    clean = {
        "cube12": cube(1),
        "cube20": cube(),
        "cube20_rotated": rotated(cube()),
        "cube20_jitter_planar": jittered_in_planes(cube(), rng),
        "cube20_dupfaces": with_repeated_faces(cube(), rng),
        "cube20_nan": with_lost_vertices(cube(), rng),
        "cube20_repeatidx": with_repeated_corners(cube(), rng),
        "cube20_zeroarea": with_flat_faces(cube(), rng),
        "lhouse": house(),
        "nm_edge_two_cubes": two_cubes((1, 1, 0)),
        "nm_fin_cube": fin_cube(),
        "plane_open": grids([([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], 20, 20)], 1),
        "plane_with_hole": polygons(frame(0)[0], 1, 4),
        "stairs_open10": stairs(),
        "thin_plate": plate(),
        "thin_wedge": wedge(),
        "two_cubes": two_cubes((3, 0, 0)),
        "washer": washer(),
    }
    shapes = {name: ("clean", shape) for name, shape in clean.items()}
    shapes["cube20_noise0.2pct"] = "noise .2/.3/1", noisy(cube(), 0.2, rng)
    shapes["cube20_noise1pct"] = "noise .2/.3/1", noisy(cube(), 1, rng)
    shapes["lhouse_noise0.3pct"] = "noise .2/.3/1", noisy(house(), 0.3, rng)
    shapes["cube20_smooth5"] = "smooth", smoothed(cube(), 5)
    return shapes


VARIED = [
    "cube20",
    "cube20_rotated",
    "lhouse",
    "washer",
    "two_cubes",
    "stairs_open10",
    "thin_plate",
    "thin_wedge",
    "plane_open",
    "plane_with_hole",
    "cube20_jitter_planar",
]


def variants(name, shape, rng):
    """The variants of each of the eleven varied shapes: (class, name, shape)."""
    for percent in (0.1, 0.3, 1, 2):
        kind = "noise .1/.3" if percent < 1 else "noise 1/2"
        yield kind, f"{name}~noise{percent}", noisy(shape, percent, rng)
    fine = upsampled(shape)
    yield "upsampled", f"{name}~up4", fine
    yield "upsampled", f"{name}~up4_noise0.3", noisy(fine, 0.3, rng)
    yield "noise+smooth", f"{name}~noise1_smooth3", smoothed(noisy(shape, 1, rng), 3)
    yield "smooth", f"{name}~smooth2", smoothed(shape, 2)
    coarse = Shape(*decimated(noisy(shape, 0.02, rng).vertices, shape.faces, 0.35), shape.planes)
    yield "decimated", f"{name}~dec35", coarse
    yield "decimated", f"{name}~dec35_noise0.3", noisy(coarse, 0.3, rng)


def all_meshes():
    """The 22 shapes and 110 variants: (class, name, shape)."""
    shapes = base_shapes()
    for name, (kind, shape) in shapes.items():
        yield kind, name, shape
    for k, name in enumerate(VARIED):
        yield from variants(name, shapes[name][1], np.random.default_rng([SEED, k]))
