"""Furniture of a room, and its walls, floor and ceiling."""

import numpy as np
import pytest

from isimp.furniture import furniture

SIDES = [(0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)]


def box(low, high, inwards=False):
    """Corners and pairs of triangles of the six sides: bottom, top, and four walls."""
    (a, b, c), (d, e, f) = low, high
    corners = np.array([(a, b, c), (a, e, c), (d, e, c), (d, b, c), (a, b, f), (a, e, f), (d, e, f), (d, b, f)], float)
    faces = [((p, q, r), (p, r, s)) for p, q, r, s in SIDES]
    return corners, np.array(faces).reshape(-1, 3)[:, :: -1 if inwards else 1]


def room(turn):
    """A room of 6 x 4 x 2.5 m with a table, a chest at a wall, a shelf's board and a picture on the wall."""
    parts = [
        box((0, 0, 0), (6, 4, 2.5), inwards=True),
        box((2, 1, 0.7), (3.5, 2, 0.75)),
        box((5.4, 0, 0), (6, 1, 0.8)),
        box((0, 1, 1.5), (0.3, 3, 1.53)),
        box((2, 3.97, 1), (3, 4, 2)),
    ]
    vertices = np.concatenate([corners for corners, _ in parts]) @ turn.T
    triangles = np.concatenate([faces + 8 * number for number, (_, faces) in enumerate(parts)])
    return vertices, triangles, np.repeat(np.arange(6 * len(parts)), 2)


@pytest.mark.parametrize("turned", [False, True])
def test_all_but_walls_floor_ceiling_and_their_pieces_is_furniture(turned):
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0] if turned else np.eye(3)
    turn *= np.linalg.det(turn)
    vertices, triangles, label = room(turn)
    found = furniture(vertices, triangles, label, turn @ (0, 0, 1), 0.03)
    assert not found[:6].any(), "the room itself"
    assert found[6:12].all(), "the table"
    assert found[13], "the chest's top"
    assert not found[24:].all(), "the picture lies on the wall"
    larger = furniture(vertices, triangles, label, turn @ (0, 0, 1), 0.15)
    assert larger.sum() > found.sum(), "with a larger smallest wall, short walls count as furniture"


def test_triangles_without_region_and_no_triangles_are_fine():
    vertices, triangles, label = room(np.eye(3))
    label[:12] = -1
    assert not furniture(vertices, triangles, label, (0, 0, 1), 0.03)[:6].any()
    assert len(furniture(vertices, triangles[:0], label[:0], (0, 0, 1), 0.03)) == 0
