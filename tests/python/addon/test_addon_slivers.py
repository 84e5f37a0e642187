"""Which small regions become part of which neighbour."""

import numpy as np

from isimp import slivers

#: five faces in a row, each a region of its own
LABEL = np.arange(5)
PAIRS = np.array([[0, 1], [1, 2], [2, 3], [3, 4]])
UP, SIDE = (0, 0, 1), (1, 0, 0)


def merges(area, directions, locked=(), share=0.5):
    area = np.array(area, float)
    return slivers.merges(LABEL, PAIRS, area, np.array(directions) * area[:, None], np.array(locked, int), share)


def test_a_sliver_merges_with_the_neighbour_with_the_most_similar_plane():
    assert merges([4, 0.1, 4, 4, 4], [UP, SIDE, SIDE, UP, UP]) == [(2, 1)]
    assert merges([4, 0.1, 4, 4, 4], [SIDE, SIDE, UP, UP, UP]) == [(0, 1)]


def test_nothing_is_merged_where_all_are_large_or_locked():
    assert merges([4, 4, 4, 4, 4], [UP] * 5) == []
    assert merges([4, 0.1, 4, 4, 4], [UP] * 5, locked=[1]) == []
    assert merges([4, 0.1, 4, 4, 4], [UP, UP, SIDE, UP, UP], locked=[0]) == [(2, 1)]


def test_chains_of_slivers_name_each_region_once_and_no_region_is_merged_with_itself():
    found = merges([4, 0.1, 0.2, 0.3, 4], [UP] * 5)
    assert [region for _, region in found] == [1, 2, 3], "the smallest first"
    home = list(range(5))
    for onto, region in found:
        assert home[onto] != home[region]
        home = [home[onto] if each == home[region] else each for each in home]
    assert len(set(home)) == 2


def test_faces_without_a_region_are_no_neighbours():
    label = np.array([0, -1, 1, 2, 3])
    found = slivers.merges(label, PAIRS, np.array([0.1, 4, 4, 4]), np.ones((4, 3)), np.empty(0, int), 0.5)
    assert found == []
