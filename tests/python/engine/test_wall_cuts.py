"""A wall with windows is one region, and polygons have no holes: the cuts between them follow the wall."""

import numpy as np
import pytest

import isimp_engine as engine
import shapes

TURN = np.radians(23.0)
ALONG = np.array([np.cos(TURN), np.sin(TURN), 0.0])


def wall(columns, rows, door=0, noise=0.05):
    """An upright wall of cells of size 1, in which windows of 4 by 5 cells are holes, the door a notch."""
    wide, high = 8 * columns + 4, 9 * rows + 4
    cells = np.ones((wide, high), bool)
    for i, j in np.ndindex(columns, rows):
        cells[4 + 8 * i : 8 + 8 * i, 4 + 9 * j : 9 + 9 * j] = False
    cells[wide // 2 - 2 : wide // 2 + 2, :door] = False
    corner = np.argwhere(cells)
    square = np.stack([corner, corner + [1, 0], corner + [1, 1], corner + [0, 1]], 1)
    used, index = np.unique(square.reshape(-1, 2), axis=0, return_inverse=True)
    index = index.reshape(-1, 4)
    triangles = np.concatenate([index[:, [0, 1, 2]], index[:, [0, 2, 3]]]).astype(np.int32)
    vertices = used[:, :1] * ALONG + used[:, 1:] * [0.0, 0.0, 1.0]
    return vertices + noise * np.random.default_rng(3).standard_normal(vertices.shape), triangles


def made(arrays):
    """Polygons of a mesh as one region, with a separate sheet of 25: else the mesh counts as a plate of holes."""
    vertices, triangles = shapes.plane(20)
    square = (vertices[triangles].mean(axis=1)[:, :2] * 5).astype(np.int32)
    label = np.concatenate([np.zeros(len(arrays[1]), np.int32), 1 + square @ [1, 5]])
    mesh = engine.Mesh(*shapes.joined(arrays, (10 * vertices - [100, 0, 0], triangles)))
    return engine.polygonize(mesh, engine.partition_from(mesh, label.astype(np.int32)))


def cuts(poly):
    """The edges of two polygons of the first region."""
    found, inside = set(), []
    for q, corners in enumerate(np.split(poly.loops, poly.loop_start[1:])):
        if poly.polygon_region[q] != 0:
            continue
        for a, b in zip(corners, np.roll(corners, -1), strict=True):
            if (b, a) in found:
                inside.append(poly.vertices[b] - poly.vertices[a])
            found.add((a, b))
    return np.array(inside)


def slanted(lines):
    """Share of the length that is neither along the wall nor upright, within 4 degrees."""
    length = np.linalg.norm(lines, axis=1)
    sine = np.minimum(np.abs(lines @ ALONG), np.abs(lines[:, 2])) / length
    return length[sine > np.sin(np.radians(4))].sum() / length.sum()


@pytest.mark.parametrize(
    ("columns", "rows", "door", "polygons"),
    [(1, 1, 0, 2), (3, 1, 0, 2), (3, 2, 0, 2), (4, 2, 0, 2), (5, 2, 0, 3), (6, 3, 0, 4), (4, 2, 12, 3)],
)
def test_cuts_follow_the_wall(columns, rows, door, polygons):
    poly = made(wall(columns, rows, door))
    assert (poly.polygon_region == 0).sum() <= polygons
    assert slanted(cuts(poly)) < 0.02
    assert poly.report["crossing"] == poly.report["flipped"] == 0


def test_a_round_plate_is_cut_as_before():
    """It has no main directions."""
    vertices, triangles = shapes.plane(40)
    vertices = 2 * vertices - [1, 1, 0]
    middle = vertices[triangles].mean(axis=1)
    distance = np.linalg.norm(middle, axis=1)
    hole = np.linalg.norm(np.abs(middle) - [0.4, 0.4, 0], axis=1) < 0.15
    used, triangles = np.unique(triangles[(distance < 0.95) & ~hole], return_inverse=True)
    poly = made((vertices[used], triangles.reshape(-1, 3).astype(np.int32)))
    assert poly.report["split_for_holes"] == 1
    assert poly.report["crossing"] == poly.report["flipped"] == 0
