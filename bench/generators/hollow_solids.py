"""Makes hollow solids of boxes, whose fewest convex parts are known, and their twins with noise.

A solid is a union of boxes, with points that must stay free: the middle of a door, the space under a table. Lengths
are in metres.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tests.shared.shapes import voxels

Box = tuple[tuple[float, float, float], tuple[float, float, float]]


@dataclass(frozen=True)
class Solid:
    """Boxes that touch and do not overlap, and points outside all of them."""

    boxes: list[Box]
    free: list[tuple[float, float, float]]

    @property
    def volume(self):
        return float(sum(np.prod(np.subtract(high, low)) for low, high in self.boxes))

    def contains(self, points):
        inside = np.zeros(len(points), bool)
        for low, high in self.boxes:
            inside |= ((points > low) & (points < high)).all(axis=1)
        return inside


def room():
    """Five by four metres, with a door and a window."""
    w, d, h, t = 5.0, 4.0, 2.6, 0.24
    boxes = [((-t, -t, -t), (w + t, d + t, 0)), ((-t, -t, h), (w + t, d + t, h + t))]
    boxes += [((-t, -t, 0), (0, d + t, h)), ((0, d, 0), (w, d + t, h))]
    boxes += [((w, -t, 0), (w + t, 1.2, h)), ((w, 2.8, 0), (w + t, d + t, h))]
    boxes += [((w, 1.2, 0), (w + t, 2.8, 0.9)), ((w, 1.2, 2.1), (w + t, 2.8, h))]
    boxes += [((0, -t, 0), (1.0, 0, h)), ((1.9, -t, 0), (w, 0, h)), ((1.0, -t, 2.0), (1.9, 0, h))]
    return Solid(boxes, [(1.45, -t / 2, 1.0), (w + t / 2, 2.0, 1.5), (2.5, 2.0, 1.2)])


def table():
    """A top on four legs."""
    w, d, h, leg = 1.4, 0.8, 0.74, 0.06
    boxes = [((0, 0, h - 0.03), (w, d, h))]
    boxes += [((x, y, 0), (x + leg, y + leg, h - 0.03)) for x in (0.05, w - 0.11) for y in (0.05, d - 0.11)]
    return Solid(boxes, [(w / 2, d / 2, 0.3), (w / 2, 0.02, 0.3)])


def cabinet():
    """Open in front: two sides, a back, five boards and one upright board."""
    w, d, h, t = 1.2, 0.4, 2.0, 0.018
    boxes = [((0, 0, 0), (t, d, h)), ((w - t, 0, 0), (w, d, h)), ((t, d - t, 0), (w - t, d, h))]
    boxes += [((t, 0, z), (w - t, d - t, z + t)) for z in (0, 0.5, 1.0, 1.5, h - t)]
    boxes.append(((w / 2, 0, t), (w / 2 + t, d - t, 0.5)))
    return Solid(boxes, [(0.3, 0.2, 0.25), (0.9, 0.2, 0.25), (0.6, 0.2, 0.75), (0.6, 0.2, 1.25), (0.6, 0.2, 1.8)])


def stairs():
    """Ten steps, solid to the floor."""
    boxes = [((0.28 * i, 0, 0), (0.28 * (i + 1), 1.0, 0.17 * (i + 1))) for i in range(10)]
    return Solid(boxes, [(0.05, 0.5, 0.3), (1.0, 0.5, 0.9)])


def flight():
    """Twelve steps between two stringers that are solid walls."""
    n, run, rise, wide = 12, 0.28, 0.17, 1.0
    boxes = [((i * run, 0, (i + 1) * rise - 0.05), ((i + 1) * run, wide, (i + 1) * rise)) for i in range(n)]
    boxes += [((0, y, 0), (n * run, y + 0.1, n * rise + 0.2)) for y in (-0.1, wide)]
    return Solid(boxes, [(1.5, 0.5, 0.3), (0.5, 0.5, 1.5)])


def chair():
    """A seat, four legs, two posts and two rails."""
    s, h, leg = 0.45, 0.45, 0.04
    boxes = [((0, 0, h), (s, s, h + 0.03))]
    boxes += [((x, y, 0), (x + leg, y + leg, h)) for x in (0, s - leg) for y in (0, s - leg)]
    boxes += [((x, s - leg, h + 0.03), (x + leg, s, 1.0)) for x in (0, s - leg)]
    boxes += [((leg, s - leg, z), (s - leg, s, z + 0.1)) for z in (0.65, 0.85)]
    return Solid(boxes, [(s / 2, s / 2, 0.2), (s / 2, s - leg / 2, 0.6), (s / 2, s - leg / 2, 0.8)])


def floor_plan():
    """Three rooms in a row without a ceiling, with two doors."""
    h = 2.5
    boxes = [((0, 0, -0.2), (9, 4, 0)), ((0, 0, 0), (9, 0.2, h)), ((0, 3.8, 0), (9, 4, h))]
    boxes += [((0, 0.2, 0), (0.2, 3.8, h)), ((8.8, 0.2, 0), (9, 3.8, h))]
    for x in (3, 6):
        boxes += [((x, 0.2, 0), (x + 0.15, 1.5, h)), ((x, 2.4, 0), (x + 0.15, 3.8, h))]
        boxes += [((x, 1.5, 2.0), (x + 0.15, 2.4, h))]
    return Solid(boxes, [(3.05, 2, 1), (6.05, 2, 1), (1.5, 2, 1), (4.5, 2, 1), (7.5, 2, 1)])


def crate():
    """Open above."""
    w, d, h, t = 0.6, 0.4, 0.3, 0.02
    boxes = [((0, 0, 0), (w, d, t)), ((0, 0, t), (t, d, h)), ((w - t, 0, t), (w, d, h))]
    boxes += [((t, 0, t), (w - t, t, h)), ((t, d - t, t), (w - t, d, h))]
    return Solid(boxes, [(w / 2, d / 2, h / 2)])


def frame():
    """A ring of four bars."""
    boxes = [((0, 0, 0), (3, 0.5, 0.5)), ((0, 2.5, 0), (3, 3, 0.5))]
    boxes += [((x, 0.5, 0), (x + 0.5, 2.5, 0.5)) for x in (0, 2.5)]
    return Solid(boxes, [(1.5, 1.5, 0.25)])


def void():
    """A closed box with a void."""
    t = 0.1
    boxes = [((0, 0, z), (1, 1, z + t)) for z in (0, 1 - t)]
    boxes += [((x, 0, t), (x + t, 1, 1 - t)) for x in (0, 1 - t)]
    boxes += [((t, y, t), (1 - t, y + t, 1 - t)) for y in (0, 1 - t)]
    return Solid(boxes, [(0.5, 0.5, 0.5), (0.2, 0.2, 0.2)])


SOLIDS = {make.__name__: make for make in (room, table, cabinet, stairs, flight, chair, floor_plan, crate, frame, void)}


def surface(solid: Solid, edge: float = np.inf):
    """The border of a solid as vertices and triangles, cut by a grid whose cells are no longer than `edge`."""
    axes = []
    for k in range(3):
        ends = np.unique(np.round([place[k] for box in solid.boxes for place in box], 9))
        parts = [np.linspace(a, b, int(np.ceil((b - a) / edge)) + 1)[:-1] for a, b in pairwise(ends)]
        axes.append(np.concatenate([*parts, ends[-1:]]) if np.isfinite(edge) else ends)
    middles = np.stack(np.meshgrid(*[(a[1:] + a[:-1]) / 2 for a in axes], indexing="ij"), axis=-1)
    places, faces = voxels(solid.contains(middles.reshape(-1, 3)).reshape(middles.shape[:3]))
    places = places.round().astype(int) - 1
    return np.stack([axes[k][places[:, k]].astype(float) for k in range(3)], axis=1), faces


def twin(solid: Solid, noise: float = 0.001, seed: int = 1):
    """A scan of a solid: noise along normals, of a share of the diagonal, on triangles of a 50th of it or less."""
    size = float(np.linalg.norm(np.ptp([place for box in solid.boxes for place in box], axis=0)))
    thinnest = min(min(np.subtract(high, low)) for low, high in solid.boxes)
    vertices, faces = surface(solid, max(min(1.2 * thinnest, 0.02 * size), 0.012 * size))
    across = np.cross(*(vertices[faces[:, k]] - vertices[faces[:, 0]] for k in (1, 2)))
    normal = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(normal, faces[:, k], across)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return vertices + normal * np.random.default_rng(seed).normal(0, noise * size, (len(vertices), 1)), faces
