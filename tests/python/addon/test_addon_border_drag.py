"""The border between two regions, moved by a drag, without a window."""

import numpy as np
import pytest

import session_scans
from isimp.border_drag import one_border, swept

SIGHT = np.array([0.0, 0.0, -1.0])


def divided(left, right, at):
    """A square of 20 x 20 cells of side .1, whose region 1 lies between two places, as `swept` takes it.

    at: the place of the border.
    """
    scan = session_scans.square()
    centers = scan.vertices[scan.triangles].mean(axis=1)
    label = ((centers[:, 0] > left) & (centers[:, 0] < right)).astype(int)
    pairs, edges = scan.edges
    edges = edges[label[pairs[:, 0]] != label[pairs[:, 1]]]
    first = edges[np.isclose(scan.vertices[edges, 0], at).all(axis=1)][0, 0]
    return centers, label, scan.vertices[one_border(edges, first)], pairs


@pytest.fixture(scope="module")
def square():
    """Regions 0 and 1 are left and right of the middle."""
    return divided(0, 1, 0)


@pytest.mark.parametrize(("drag", "columns"), [(0.3, 3), (0.1, 1), (-0.3, 3)])
def test_a_border_moves_with_a_drag(square, drag, columns):
    centers, label, border, pairs = square
    taker = label == (0 if drag > 0 else 1)
    found = swept(centers, taker, border, pairs, np.array([drag, 0.0, 5.0]), SIGHT)
    taken = centers[found[~taker[found]]]
    beside = np.sort(np.abs(taken[:, 0]))
    assert len(taken) == 40 * columns
    assert np.all(taken[:, 0] * drag > 0)
    assert beside[-1] < abs(drag)
    assert np.abs(centers[found[taker[found]]][:, 0]).max() < 0.3  # no more than a strip


@pytest.mark.parametrize(("drag", "side"), [(0.05, 0.0), (-0.05, 0.1)])
def test_a_border_moves_into_a_region_of_one_column(drag, side):
    """The growing region is on both sides of it."""
    centers, label, border, pairs = divided(0, 0.1, side)
    found = swept(centers, label == 0, border, pairs, np.array([drag, 0.0, 0.0]), SIGHT)
    assert np.count_nonzero(label[found]) == 20


def test_a_slanting_drag_moves_a_border_too(square):
    centers, label, border, pairs = square
    taker = label == 0
    found = swept(centers, taker, border, pairs, np.array([0.3, 0.1, 0.0]), SIGHT)
    assert 60 < np.count_nonzero(~taker[found]) <= 130


def test_a_border_does_not_move_without_a_drag_across_it(square):
    centers, label, border, pairs = square
    for drag in (np.zeros(3), np.array([0.0, 0.0, 1.0])):
        assert len(swept(centers, label == 1, border, pairs, drag, SIGHT)) == 0
    assert len(swept(centers, label == 1, border[:0], pairs, np.array([0.3, 0.0, 0.0]), SIGHT)) == 0
