"""Scans with textures that are made here: figures, a planet, a house of two materials, a thin sign.

    python -m bench.generators.painted_scans FOLDER [NAME ...] [--faces N]

Each is an OBJ file with its MTL file and PNG images, dense, with the noise of a scanner, and with a texture that is
drawn from its places: `owl`, `planet`, `house`, `vase`. The same numbers give the same files.
"""

import argparse
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from PIL import Image


@dataclass
class Scan:
    """Triangles with a corner's own UVs, and an image for each material."""

    vertices: np.ndarray  #: (V, 3)
    triangles: np.ndarray  #: (F, 3)
    uv: np.ndarray  #: (F, 3, 2)
    material: np.ndarray  #: (F,)
    images: dict = field(default_factory=dict)  #: by the material's name (H, W, 3) uint8


def noise(points, cells, seed):
    """(n,) smooth noise from -1 to 1 with `cells` cells per unit length."""
    at = points * cells + 1000
    low = np.floor(at).astype(np.int64)
    t = at - low
    t = t * t * (3 - 2 * t)
    total = np.zeros(len(points))
    for corner in np.ndindex(2, 2, 2):
        share = np.prod(np.where(corner, t, 1 - t), axis=1)
        key = (low + corner).astype(np.uint64) * np.array([73856093, 19349663, 83492791], np.uint64)
        mixed = (key[:, 0] ^ key[:, 1] ^ key[:, 2] ^ np.uint64(seed * 2654435761)) * np.uint64(0x9E3779B97F4A7C15)
        total += share * (2 * ((mixed >> np.uint64(40)).astype(np.float64) / 2**24) - 1)
    return total


def clouds(points, cells, seed, octaves=5):
    """As above, with finer and finer parts."""
    return sum(noise(points, cells * 2**k, seed + k) / 2**k for k in range(octaves)) / 1.6


def mixed(low, high, share):
    """Colours between two: (n, 3)."""
    share = np.clip(share, 0, 1)[:, None]
    return np.asarray(low, float) * (1 - share) + np.asarray(high, float) * share


# The six sides of a cube: the outward direction, right and up. A side's square is unfolded to a part of the image.
SIDES = [
    ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    ((-1, 0, 0), (0, -1, 0), (0, 0, 1)),
    ((0, 1, 0), (-1, 0, 0), (0, 0, 1)),
    ((0, -1, 0), (1, 0, 0), (0, 0, 1)),
    ((0, 0, 1), (1, 0, 0), (0, 1, 0)),
    ((0, 0, -1), (1, 0, 0), (0, -1, 0)),
]
RIM = 4  # pixels around each side's part of the image


def directions(side, u, v):
    """Unit vectors for u and v from -1 to 1; equal steps are about equal angles."""
    out, right, up = (np.asarray(axis, float) for axis in SIDES[side])
    u, v = np.tan(u * np.pi / 4), np.tan(v * np.pi / 4)
    d = out + u[..., None] * right + v[..., None] * up
    return d / np.linalg.norm(d, axis=-1, keepdims=True)


def star(surface, colour, faces, pixels, rough):
    """A closed scan. surface: (n, 3) directions to points; colour: (n, 3) points to colours; rough: the noise."""
    n = max(4, round(np.sqrt(faces / 12)))
    steps = np.linspace(-1, 1, n + 1)
    points, triangles, uvs = [], [], []
    image = np.zeros((2 * pixels, 3 * pixels, 3), np.uint8)
    inner = pixels - 2 * RIM
    for side in range(6):
        u, v = np.meshgrid(steps, steps)
        points.append(surface(directions(side, u, v).reshape(-1, 3)))
        i, j = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(n)))
        a = side * (n + 1) ** 2 + j * (n + 1) + i
        quads = np.stack([a, a + 1, a + n + 2, a, a + n + 2, a + n + 1], axis=1).reshape(-1, 3)
        triangles.append(quads)
        column, row = side % 3, side // 3
        x = (column * pixels + RIM + (u + 1) / 2 * inner) / (3 * pixels)
        y = (row * pixels + RIM + (v + 1) / 2 * inner) / (2 * pixels)
        uvs.append(np.stack([x.ravel(), y.ravel()], axis=1)[quads - side * (n + 1) ** 2])
        at = (np.arange(pixels) + 0.5 - RIM) / inner * 2 - 1
        s, t = np.meshgrid(at, at)
        shown = colour(surface(directions(side, s, t).reshape(-1, 3))).reshape(pixels, pixels, 3)
        top = (1 - row) * pixels  # v points up, rows down
        image[top : top + pixels, column * pixels : (column + 1) * pixels] = np.clip(shown, 0, 255)[::-1]
    points, triangles = np.concatenate(points), np.concatenate(triangles)
    places, index = np.unique(np.round(points, 9), axis=0, return_inverse=True)
    triangles = index.ravel()[triangles]
    uv = np.concatenate(uvs)
    whole = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
    triangles, uv = triangles[whole], uv[whole]
    places = places + np.random.default_rng(5).normal(0, rough, places.shape)
    return Scan(places, triangles, uv, np.zeros(len(triangles), int), {"painted": image})


def ball(p, centre, radii):
    """About the distance from an ellipsoid."""
    q = (p - np.asarray(centre, float)) / radii
    k = np.linalg.norm(q, axis=1)
    return (k - 1) * min(np.atleast_1d(radii)) if np.ndim(radii) else (k - 1) * radii


def joined(distances, width):
    """The smooth union of solids."""
    total = distances[0]
    for d in distances[1:]:
        h = np.clip(0.5 + 0.5 * (d - total) / width, 0, 1)
        total = d * (1 - h) + total * h - width * h * (1 - h)
    return total


def owl_distance(p):
    parts = [ball(p, (0, 0, -0.1), np.array([0.62, 0.55, 0.78])), ball(p, (0, 0, 0.72), 0.5)]
    parts += [ball(p, (x, -0.02, 1.1), np.array([0.13, 0.1, 0.26])) for x in (-0.3, 0.3)]
    parts += [ball(p, (x, 0.12, -0.12), np.array([0.16, 0.36, 0.55])) for x in (-0.56, 0.56)]
    body = joined(parts, 0.12)
    small = [ball(p, (0, -0.5, 0.66), np.array([0.09, 0.14, 0.13]))]
    small += [ball(p, (x, -0.43, 0.8), 0.15) for x in (-0.2, 0.2)]
    # Feet and stand face the middle everywhere, and are joined smoothly: else rays stretch the faces beneath them.
    feet = [ball(p, (x, -0.33, -0.7), np.array([0.14, 0.14, 0.12])) for x in (-0.21, 0.21)]
    stand = np.maximum(np.hypot(p[:, 0], p[:, 1]) - 0.44, np.abs(p[:, 2] + 0.78) - 0.24)
    return joined([joined([body, *feet, stand], 0.14), *small], 0.05)


def owl_surface(d):
    """The places where rays from outside to the middle meet the owl."""
    p = 1.8 * d
    for _ in range(40):
        p = p - np.clip(0.8 * owl_distance(p), -0.05, 0.3)[:, None] * d
    return p


def owl_colour(p):
    x, y, z = p.T
    colour = mixed((120, 82, 52), (72, 46, 30), 0.5 + 0.7 * clouds(p, 5, 1))
    row = np.floor(z * 11)
    scale = np.hypot((x * 9 + 0.5 * (row % 2)) % 1 - 0.5, (z * 11) % 1 - 0.2)
    feathers = mixed((226, 206, 170), (150, 110, 74), (scale - 0.35) * 6)
    belly = (np.hypot(x / 0.42, (z + 0.12) / 0.62) < 1) & (y < -0.1)
    colour[belly] = feathers[belly] + 14 * clouds(p[belly], 18, 4)[:, None]
    wing = (np.abs(x) > 0.48) & (z < 0.42) & (z > -0.7)
    bars = mixed((94, 62, 42), (48, 30, 20), 2 * np.sin(26 * z + 5 * y + 1.5 * clouds(p, 3, 9)))
    colour[wing] = bars[wing]
    for side in (-0.2, 0.2):
        away = np.hypot(x - side, z - 0.8)
        front = (y < -0.3) & (z > 0.5)
        for radius, shade in ((0.24, (216, 190, 150)), (0.15, (236, 176, 40)), (0.075, (14, 12, 12))):
            colour[front & (away < radius)] = shade
        colour[front & (np.hypot(x - side + 0.03, z - 0.84) < 0.022)] = (250, 250, 250)
    beak = (np.hypot(x / 0.11, (z - 0.64) / 0.16) < 1) & (y < -0.42)
    feet = (y < -0.24) & (np.hypot((np.abs(x) - 0.21) / 0.15, (z + 0.72) / 0.14) < 1)
    colour[beak | feet] = mixed((238, 140, 30), (190, 96, 20), 0.5 + clouds(p, 9, 6))[beak | feet]
    wood = mixed((150, 104, 62), (98, 62, 36), 0.5 + 0.5 * np.sin(30 * np.hypot(x, y) + 4 * clouds(p, 3, 7)))
    colour[z < -0.83] = wood[z < -0.83]
    return colour


def owl(faces):
    return star(owl_surface, owl_colour, faces, 640, 0.0015)


def planet_surface(d):
    return d * (1 + 0.16 * clouds(d, 1.6, 11))[:, None]


def planet_colour(p):
    height = np.linalg.norm(p, axis=1) - 1
    land = mixed((52, 110, 48), (150, 120, 84), 6 * height + 0.3 * clouds(p, 12, 21))
    land = np.where((height > 0.075)[:, None], mixed((190, 190, 196), (250, 250, 252), 20 * (height - 0.075)), land)
    sea = mixed((22, 60, 130), (60, 150, 180), 1 + 14 * height + 0.2 * clouds(p, 20, 31))
    return np.where((height > 0)[:, None], land, sea) + 10 * clouds(p, 30, 41)[:, None]


def planet(faces):
    return star(planet_surface, planet_colour, faces, 512, 0.002)


def vase_surface(d):
    z = np.clip(d[:, 2], -1, 1)
    angle = np.arctan2(d[:, 1], d[:, 0])
    profile = 0.55 + 0.28 * np.cos(2.4 * z + 0.5) + 0.018 * np.cos(12 * angle) * (1 - z * z)
    return d * np.array([1, 1, 1.6]) * profile[:, None]


def vase_colour(p):
    angle, z = np.arctan2(p[:, 1], p[:, 0]), p[:, 2]
    colour = mixed((196, 112, 66), (168, 84, 46), 0.5 + clouds(p, 6, 51))
    key = (np.floor(angle * 24 / np.pi) + np.floor(z * 14)) % 2 > 0
    colour[(np.abs(z - 0.3) < 0.14) & key] = (34, 24, 22)
    colour[np.abs(np.abs(z - 0.3) - 0.17) < 0.02] = (34, 24, 22)
    waves = np.sin(angle * 8 + 3 * np.sin(z * 20)) > 0.4
    colour[(z < 0) & (z > -0.5) & waves] = (236, 214, 172)
    return colour


def vase(faces):
    return star(vase_surface, vase_colour, faces, 512, 0.0015)


def bricks(size, random):
    y, x = np.mgrid[0:size, 0:size] / size
    row = np.floor(y * 32)
    column = x * 12 + 0.5 * (row % 2)
    joint = ((y * 32) % 1 < 0.14) | (column % 1 < 0.07)
    shade = random.normal(0, 1, (32, 16))[row.astype(int) % 32, np.floor(column).astype(int) % 16]
    colour = np.array([164, 82, 60]) + 16 * shade[..., None] + random.normal(0, 5, (size, size, 1))
    colour[joint] = (196, 188, 176)
    for wx in (0.2, 0.62):
        pane = (np.abs(x - wx - 0.09) < 0.09) & (np.abs(y - 0.42) < 0.13)
        colour[pane] = (70, 92, 112)
        frame = pane & ((np.abs(x - wx - 0.09) < 0.006) | (np.abs(x - wx - 0.09) > 0.08) | (np.abs(y - 0.42) > 0.118))
        colour[frame] = (240, 238, 230)
    return np.clip(colour, 0, 255).astype(np.uint8)


def tiles(size, random):
    y, x = np.mgrid[0:size, 0:size] / size
    row = np.floor(y * 20)
    round_ = np.abs((x * 24 + 0.5 * (row % 2)) % 1 - 0.5)
    shade = 1 - 0.5 * ((y * 20) % 1) * (0.4 + round_)
    colour = np.array([150, 70, 58]) * shade[..., None] + random.normal(0, 6, (size, size, 1))
    return np.clip(colour, 0, 255).astype(np.uint8)


def house(faces):
    """Walls of bricks and a roof of tiles, with the noise of a survey."""
    random = np.random.default_rng(8)
    a, b, h, top = np.array([2.0, 0, 0]), np.array([0, 1.4, 0]), 1.2, 2.0
    up, zero = np.array([0, 0, h]), np.zeros(3)
    ridge = [np.array([0, 0.7, top]), np.array([2.0, 0.7, top])]
    walls = [(zero, a, up), (a, b, up), (a + b, -a, up), (b, -b, up)]
    roofs = [(up, a, ridge[0] - up), (up + a + b, -a, ridge[1] - up - a - b)]
    gables = [(up + b, zero + up, ridge[0]), (up + a, up + a + b, ridge[1])]
    n = max(4, round(np.sqrt(faces / 14)))
    pieces = []
    for m, patches in ((0, walls), (1, roofs)):
        for origin, right, upward in patches:
            s, t = (g.ravel() for g in np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1)))
            i, j = (g.ravel() for g in np.meshgrid(np.arange(n), np.arange(n)))
            q = j * (n + 1) + i
            quads = np.stack([q, q + 1, q + n + 2, q, q + n + 2, q + n + 1], axis=1).reshape(-1, 3)
            pieces.append((m, origin + s[:, None] * right + t[:, None] * upward, np.stack([s, t], axis=1), quads))
    s, t = (g.ravel() for g in np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1)))
    bottom = (np.array([0, 1.4, 0]), np.array([2.0, 0, 0]), np.array([0, -1.4, 0]))
    pieces.append((0, bottom[0] + s[:, None] * bottom[1] + t[:, None] * bottom[2], 0.02 * np.stack([s, t], 1), quads))
    for left, right, peak in gables:
        rows = [(i, j) for j in range(n + 1) for i in range(n + 1 - j)]
        number = {place: k for k, place in enumerate(rows)}
        at = np.array(rows) / n
        points = left + at[:, :1] * (right - left) + at[:, 1:] * (peak - left)
        cells = [(i, j) for j in range(n) for i in range(n - j)]
        found = [[number[i, j], number[i + 1, j], number[i, j + 1]] for i, j in cells]
        found += [
            [number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]] for i, j in cells if (i + 1, j + 1) in number
        ]
        shown = np.stack([at[:, 0] + at[:, 1] / 2, 0.62 + 0.36 * at[:, 1]], axis=1)
        pieces.append((0, points, shown, np.array(found)))
    points = np.concatenate([p for _, p, _, _ in pieces])
    uv = np.concatenate([t[q] for _, _, t, q in pieces])
    first = np.cumsum([0] + [len(p) for _, p, _, _ in pieces])
    triangles = np.concatenate([q + k for (_, _, _, q), k in zip(pieces, first, strict=False)])
    material = np.concatenate([np.full(len(q), m) for m, _, _, q in pieces])
    places, index = np.unique(np.round(points, 6), axis=0, return_inverse=True)
    places = places + random.normal(0, 0.003, places.shape)
    images = {"walls": bricks(1024, random), "roof": tiles(512, random)}
    return Scan(places, index.ravel()[triangles], uv, material, images)


MADE = {"owl": (owl, 200_000), "planet": (planet, 120_000), "vase": (vase, 60_000), "house": (house, 80_000)}


def write(folder, name, scan):
    """NAME.obj, NAME.mtl and an image for each material; returns the path of the first."""
    folder.mkdir(parents=True, exist_ok=True)
    uv, index = np.unique(scan.uv.reshape(-1, 2), axis=0, return_inverse=True)
    index = index.reshape(-1, 3)
    lines = [f"mtllib {name}.mtl"]
    lines += [f"v {x:.7g} {y:.7g} {z:.7g}" for x, y, z in scan.vertices.tolist()]
    lines += [f"vt {u:.7g} {v:.7g}" for u, v in uv.tolist()]
    for m, material in enumerate(scan.images):
        lines.append(f"usemtl {material}")
        of = scan.material == m
        rows = zip((scan.triangles[of] + 1).tolist(), (index[of] + 1).tolist(), strict=True)
        lines += [f"f {a}/{x} {b}/{y} {c}/{z}" for (a, b, c), (x, y, z) in rows]
    path = folder / f"{name}.obj"
    path.write_text("\n".join(lines) + "\n")
    materials = [f"newmtl {material}\nmap_Kd {name}_{material}.png" for material in scan.images]
    (folder / f"{name}.mtl").write_text("\n".join(materials) + "\n")
    for material, image in scan.images.items():
        Image.fromarray(image).save(folder / f"{name}_{material}.png")
    return path


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(MADE))
    parser.add_argument("--faces", type=int)
    asked = parser.parse_args()
    for name in asked.names or MADE:
        make, faces = MADE[name]
        scan = make(asked.faces or faces)
        print(f"{write(asked.folder, name, scan)}: {len(scan.triangles):,} faces")


if __name__ == "__main__":
    main()
