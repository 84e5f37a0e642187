"""Colours of regions: neighbours differ, and each colour stays with its region."""

import numpy as np
import pytest

from isimp import view
from isimp.array_pool import ArrayPool

# Linear RGB as seen by people who lack one kind of cone (Machado, Oliveira, Fernandes 2009, severity 1).
DICHROMACY = {
    "full": np.eye(3),
    "protan": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deutan": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritan": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}
TO_LMS = [
    [0.4122214708, 0.5363325363, 0.0514459929],
    [0.2119034982, 0.6806995451, 0.1073969566],
    [0.0883024619, 0.2817188376, 0.6299787005],
]
TO_OKLAB = [
    [0.2104542553, 0.7936177850, -0.0040720468],
    [1.9779984951, -2.4285922050, 0.4505937099],
    [0.0259040371, 0.7827717662, -0.8086757660],
]


@pytest.mark.parametrize("vision", DICHROMACY)
def test_base_colours_differ_for_all_kinds_of_vision(vision):
    seen = np.clip(view.PALETTE[: view.BASE_COLORS, :3] @ np.array(DICHROMACY[vision]).T, 0, 1)
    lab = np.cbrt(seen @ np.array(TO_LMS).T) @ np.array(TO_OKLAB).T
    distance = np.linalg.norm(lab[:, None] - lab[None], axis=2) + np.eye(len(lab))
    assert distance.min() > 0.09  # .02 is just visible for adjacent colours


def grid_pairs(n):
    cell = np.arange(n * n).reshape(n, n)
    right = np.stack([cell[:, :-1].ravel(), cell[:, 1:].ravel()], axis=1)
    down = np.stack([cell[:-1].ravel(), cell[1:].ravel()], axis=1)
    return np.concatenate([right, down])


def complete_pairs(n):
    return np.stack(np.triu_indices(n, 1), axis=1)


@pytest.mark.parametrize(
    ("count", "pairs"), [(400, grid_pairs(20)), (24, complete_pairs(24)), (1, np.empty((0, 2), int))]
)
def test_neighbours_never_share_a_colour(count, pairs):
    color = view.assign_colors(count, pairs)
    assert ((color >= 0) & (color < len(view.PALETTE))).all()
    assert (color[pairs[:, 0]] != color[pairs[:, 1]]).all()


def test_dark_shades_are_kept_for_where_they_are_needed():
    assert view.assign_colors(400, grid_pairs(20)).max() < view.BASE_COLORS
    assert view.assign_colors(13, complete_pairs(13)).max() >= view.BASE_COLORS


def test_a_wheel_needs_few_colours_though_its_hub_has_many_neighbours():
    rim = np.arange(1, 41)
    pairs = np.concatenate([np.stack([np.zeros(40, int), rim], axis=1), np.stack([rim, np.roll(rim, 1)], axis=1)])
    color = view.assign_colors(41, np.sort(pairs, axis=1))
    assert color.max() < view.BASE_COLORS
    assert (color[pairs[:, 0]] != color[pairs[:, 1]]).all()


def test_a_new_region_takes_a_free_colour_and_changes_no_other():
    pairs = grid_pairs(6)
    color = view.assign_colors(36, pairs)
    more = np.concatenate([pairs, [[0, 36], [1, 36], [6, 36]]])
    after = view.assign_colors(37, more, np.append(color, -1))
    assert (after[:36] == color).all()
    assert after[36] not in color[[0, 1, 6]]


def test_a_region_that_meets_one_of_its_colour_gives_way_to_the_older():
    after = view.assign_colors(3, np.array([[0, 1], [1, 2]]), np.array([5, 5, 2]))
    assert after[0] == 5
    assert after[1] not in (5, 2)
    assert after[2] == 2


def test_kept_colours_are_replaced_if_they_leave_no_room():
    size = len(view.PALETTE)
    hub = np.stack([np.arange(size), np.full(size, size)], axis=1)  # the new region touches one of every colour
    after = view.assign_colors(size + 1, hub, np.append(np.arange(size), -1))
    assert (after[:size] != after[size]).all()


def test_region_pairs_and_borders_leave_out_faces_without_region():
    label = np.array([0, 0, 1, -1], np.int32)
    faces = np.array([[0, 1], [1, 2], [2, 1], [2, 3]])
    assert view.region_pairs(label, faces).tolist() == [[0, 1]]
    assert view.border_pairs(label, faces).tolist() == [1, 2, 3]


def test_faces_without_region_are_grey():
    row = view.face_colors(np.array([1, -1], np.int32), np.array([3, 4], np.int32))
    assert view.COLORS[row[0]].tolist() == view.PALETTE[4].tolist()
    assert view.COLORS[row[1]].tolist() == pytest.approx(view.NO_REGION)


@pytest.mark.parametrize("corners", [3, np.array([4, 3])])
@pytest.mark.parametrize("table", [view.COLORS, view.PACKED])
def test_corners_have_the_colour_of_their_face_in_memory_that_is_used_again(table, corners):
    pool = ArrayPool()
    made = view.corner_colors(table, np.array([5, 24], np.uint8), corners, pool)
    assert np.array_equal(made, np.repeat(table[[5, 24]], corners, axis=0))
    pool.give(made)
    again = view.corner_colors(table, np.array([24, 7], np.uint8), corners, pool)
    assert again is made
    assert np.array_equal(made, np.repeat(table[[24, 7]], corners, axis=0))
    other = view.corner_colors(table, np.array([5, 24], np.uint8), corners, pool)
    assert not np.shares_memory(other, made)  # which was not returned
    pool.give(other)
    assert len(view.corner_colors(table, np.array([5], np.uint8), 3, pool)) == 3  # not reused
