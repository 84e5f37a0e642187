"""Areas and pieces of triangle meshes."""

import numpy as np
import pytest

import shapes
from isimp_engine import surfaces


@pytest.mark.parametrize("kind", ["f4", "f8"])
def test_areas_are_half_the_cross_product(kind, monkeypatch):
    vertices, triangles = shapes.bumpy(20)
    vertices = (vertices + 3).astype(kind)
    a, b, c = (vertices[triangles[:, k]].astype(float) for k in range(3))
    wanted = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    np.testing.assert_array_equal(surfaces.areas(vertices, triangles), wanted)
    monkeypatch.setattr(surfaces, "_BLOCK", 7)
    np.testing.assert_array_equal(surfaces.areas(vertices, triangles), wanted)
    assert surfaces.areas(vertices, triangles[:0]).shape == (0,)


def test_pieces_have_their_least_element():
    path = np.stack([np.arange(40, 99), np.arange(41, 100)], axis=1)[::-1]
    pairs = np.concatenate([path, [[7, 3], [3, 9], [20, 0]]])
    found = surfaces.pieces(101, pairs)
    wanted = np.arange(101)
    wanted[40:100], wanted[[7, 9]], wanted[20] = 40, 3, 0
    np.testing.assert_array_equal(found, wanted)
    np.testing.assert_array_equal(surfaces.pieces(3, np.zeros((0, 2), int)), [0, 1, 2])
