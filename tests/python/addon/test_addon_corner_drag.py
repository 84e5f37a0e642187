"""A corner of three regions, moved by a drag, without a window."""

import numpy as np
import pytest

import session_scans
from isimp import corner_drag

SIGHT = np.array([0.0, 0.0, -1.0])


def above(at, start, end):
    """Whether places are on the left of the line between two points."""
    return (end[0] - start[0]) * (at[:, 1] - start[1]) - (end[1] - start[1]) * (at[:, 0] - start[0]) > 0


@pytest.fixture(scope="module")
def around():
    """A square of 20 x 20 cells of side .1: region 5 on the left, 1 above and 3 below on the right."""
    scan = session_scans.square()
    centers = scan.vertices[scan.triangles].mean(axis=1)
    label = np.where(centers[:, 0] < 0, 5, np.where(centers[:, 1] > 0, 1, 3))
    pairs, edges = scan.edges
    border = label[pairs[:, 0]] != label[pairs[:, 1]]
    corner = int(np.argmin(np.linalg.norm(scan.vertices, axis=1)))
    vertices = scan.vertices.astype(np.float64)
    return corner_drag.Around(centers, label, vertices, edges[border], label[pairs[border]], corner)


@pytest.mark.parametrize("drag", [(0.33, 0.21), (-0.42, 0.11), (0.12, -0.44), (-0.31, -0.32)])
def test_borders_run_straight_to_the_new_corner(around, drag):
    found = corner_drag.swept(around, np.array([*drag, 7.0]), SIGHT)
    label = around.label.copy()
    for region, taken in found.items():
        assert (label[taken] != region).all()
        label[taken] = region
    at, to = around.centers[:, :2], np.array(drag)
    ends = 1.0 if 3 * np.hypot(*drag) > 1 else 0.1 * np.ceil(30 * np.hypot(*drag))
    on_left = np.where(at[:, 1] > to[1], above(at, to, (0, ends)), above(at, (0, -ends), to))
    on_left[np.abs(at[:, 1]) > ends] = at[np.abs(at[:, 1]) > ends, 0] < 0
    wanted = np.where(on_left, 5, np.where(above(at, to, (ends, 0)) | ((at[:, 0] > ends) & (at[:, 1] > 0)), 1, 3))
    assert np.count_nonzero(label != around.label) > 20
    assert np.count_nonzero(label != wanted) <= 4  # on a line, or between two of them at the corner


def test_a_border_that_runs_into_a_ring_ends_there():
    """The common border of two regions, as a lollipop: two edges from the corner, then a triangle."""
    vertices = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 1, 0], [3, -1, 0], [-1, 1, 0], [-1, -1, 0]], float)
    border = np.array([[0, 1], [2, 3], [3, 4], [4, 2], [1, 2], [0, 5], [0, 6]])
    beside = np.array([[1, 2]] * 5 + [[1, 3], [2, 3]])
    centers = np.array([[0.5, 0.2, 0], [0.5, -0.2, 0], [-0.5, 0, 0]])
    label = np.array([1, 2, 3])
    found = corner_drag.swept(corner_drag.Around(centers, label, vertices, border, beside, 0), 2 * vertices[3], SIGHT)
    assert all((label[taken] != region).all() for region, taken in found.items())


def test_a_drag_along_the_sight_moves_nothing(around):
    assert corner_drag.swept(around, np.array([0.0, 0.0, 1.0]), SIGHT) == {}
