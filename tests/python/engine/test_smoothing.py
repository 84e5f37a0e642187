"""Borders evened out: the moved and the kept faces, and the decrease of length."""

import numpy as np
import pytest

import shapes
from isimp import recipe as rcp
from isimp.engine import engine
from isimp.session import Session
from isimp.task import Stopped
from isimp_engine.replay.smoothing import reachable, shortened, smoothed
from session_scans import scan_of

SIDE = 30


def grid():
    """(pairs, place): squares of a grid, which share edges with their neighbours."""
    number = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
    across, along = (
        np.stack([a.ravel(), b.ravel()], axis=1)
        for a, b in ((number[:, :-1], number[:, 1:]), (number[:-1], number[1:]))
    )
    return np.concatenate([across, along]), np.divmod(np.arange(SIDE * SIDE), SIDE)


def length(label, pairs):
    return int(np.count_nonzero(label[pairs[:, 0]] != label[pairs[:, 1]]))


def test_a_jagged_border_becomes_shorter_and_a_straight_one_stays():
    pairs, (row, column) = grid()
    everywhere, free = np.ones(SIDE * SIDE, bool), np.zeros(2, bool)
    straight = (column >= 15).astype(np.int32)
    assert np.array_equal(smoothed(straight, pairs, everywhere, free, 10), straight)
    jagged = (column >= 15 + 3 * (row % 4 < 2)).astype(np.int32)
    made = smoothed(jagged, pairs, everywhere, free, 10)
    assert length(made, pairs) - SIDE <= 0.5 * (length(jagged, pairs) - SIDE)


def test_only_faces_inside_change_and_neither_locked_regions_nor_faces_in_none():
    pairs, (row, column) = grid()
    jagged = (column >= 15 + 3 * (row % 4 < 2)).astype(np.int32)
    inside = row < 10
    made = smoothed(jagged, pairs, inside, np.zeros(2, bool), 10)
    assert (made[~inside] == jagged[~inside]).all()
    assert (made[inside] != jagged[inside]).any()
    for fixed in ([True, False], [False, True]):
        assert np.array_equal(smoothed(jagged, pairs, inside, np.array(fixed), 10), jagged)
    none = np.where(jagged == 1, -1, 0).astype(np.int32)
    assert np.array_equal(smoothed(none, pairs, inside, np.zeros(1, bool), 10), none)


def test_smoothing_polls_every_round():
    pairs, (_, column) = grid()
    label, everywhere, asked = (column >= 15).astype(np.int32), np.ones(SIDE * SIDE, bool), []
    smoothed(label, pairs, everywhere, np.zeros(2, bool), 7, lambda: asked.append(1))
    assert len(asked) == 14, "of spreading the neighbourhood, and of spreading the regions"

    def stop():
        raise Stopped

    with pytest.raises(Stopped):
        smoothed(label, pairs, everywhere, np.zeros(2, bool), 7, stop)


def triangles():
    """(pairs, length of their edges, middle of each) of a grid of squares that are two triangles each."""
    row, column = np.divmod(np.arange(SIDE * SIDE), SIDE)
    corner = row * (SIDE + 1) + column
    lower = np.stack([corner, corner + 1, corner + SIDE + 2], axis=1)
    upper = np.stack([corner, corner + SIDE + 2, corner + SIDE + 1], axis=1)
    place = np.stack(np.divmod(np.arange((SIDE + 1) ** 2), SIDE + 1)[::-1], axis=1).astype(float)
    faces = np.concatenate([lower, upper])
    pairs, ends = engine.guides.shared_edges(faces)
    return pairs, np.linalg.norm(place[ends[:, 0]] - place[ends[:, 1]], axis=1), place[faces].mean(axis=1)


def test_no_tooth_is_left_and_borders_get_shorter():
    """A slanted border as a brush leaves it, by the middles of triangles, and some noise."""
    pairs, edge, middle = triangles()
    noise = np.random.default_rng(1).normal(0, 1.5, len(middle))
    label = (middle[:, 0] + 0.4 * middle[:, 1] + noise > 21).astype(np.int32)
    everywhere, free = np.ones(len(label), bool), np.zeros(2, bool)
    even = smoothed(label, pairs, everywhere, free, 10)
    made = shortened(even, pairs, edge, everywhere, free)

    def teeth(label):
        other = label[pairs[:, 0]] != label[pairs[:, 1]]
        return int(np.count_nonzero(np.bincount(pairs[other].ravel(), minlength=len(label)) > 1))

    def long(label):
        return edge[label[pairs[:, 0]] != label[pairs[:, 1]]].sum()

    assert teeth(even) > 0
    assert teeth(made) == 0
    assert long(made) < long(even) < 0.5 * long(label)
    assert np.array_equal(shortened(made, pairs, edge, everywhere, free), made)
    inside = middle[:, 1] < 10
    assert (shortened(even, pairs, edge, inside, free)[~inside] == even[~inside]).all()
    assert np.array_equal(shortened(even, pairs, edge, everywhere, ~free), even)
    none = np.where(even == 1, -1, 0).astype(np.int32)
    assert np.array_equal(shortened(none, pairs, edge, everywhere, np.zeros(1, bool)), none)


def test_what_no_way_leads_to_is_not_reached():
    pairs = np.array([[0, 1], [1, 2], [2, 3], [3, 4]])
    home = np.array([True, False, False, False, False])
    wanted = np.array([False, True, False, True, True])
    assert reachable(wanted, home, pairs).tolist() == [False, True, False, False, False]


@pytest.fixture
def jagged():
    """(session, scan, recipe, faces): a cube in its six sides, and a comb painted from one side into the next."""
    vertices, triangles = shapes.cube(10)
    scan = scan_of(vertices, triangles)
    session, recipe = Session(), rcp.Recipe().then(rcp.Partition(proxies=6))
    label = session.replay(scan, recipe).face_region
    ends = label[engine.guides.shared_edges(triangles)[0]]
    pairs = engine.guides.shared_edges(triangles)[0]
    meet = pairs[(ends[:, 0] == 0) & (ends[:, 1] == 1) | (ends[:, 0] == 1) & (ends[:, 1] == 0)]
    beside = sorted({int(face) for face in meet.ravel() if label[face] == 1})[::2]
    onto = int(meet[0][label[meet[0]] == 0][0])
    recipe = recipe.then(rcp.PaintFaces(faces=tuple(beside), onto=onto))
    return session, scan, recipe, np.flatnonzero((label == 0) | (label == 1))


def test_the_step_smooths_a_comb_and_describes_itself(jagged):
    session, scan, recipe, faces = jagged
    before = session.replay(scan, recipe)
    step = rcp.SmoothFaces(faces=tuple(faces.tolist()))
    after = session.replay(scan, recipe.then(step))
    pairs = scan.edges[0]
    assert length(after.face_region, pairs) < length(before.face_region, pairs)
    assert after.numbers["regions"] == before.numbers["regions"] == 6
    again = Session().replay(scan, recipe.then(step))
    assert np.array_equal(after.face_region, again.face_region)
    assert step.describe() == f"Smooth the borders in {len(faces)} faces"


def test_a_locked_region_keeps_its_border_where_the_hand_begins_in_another(jagged):
    session, scan, recipe, faces = jagged
    before = session.replay(scan, recipe).face_region
    faces = faces[np.argsort(before[faces] == 0, kind="stable")]
    locked = recipe.then(rcp.LockRegions(faces=(int(np.flatnonzero(before == 0)[0]),)))
    after = session.replay(scan, locked.then(rcp.SmoothFaces(faces=tuple(faces.tolist())))).face_region
    assert np.array_equal(before == 0, after == 0)


def test_a_locked_region_that_the_hand_begins_in_is_smoothed_and_stays_locked(jagged):
    session, scan, recipe, faces = jagged
    before = session.replay(scan, recipe).face_region
    first = int(np.flatnonzero(before == 0)[0])
    locked = recipe.then(rcp.LockRegions(faces=(first,)))
    rest = faces[faces != first].tolist()
    smooth, free = (each.then(rcp.SmoothFaces(faces=(first, *rest))) for each in (locked, recipe))
    after = session.replay(scan, smooth)
    assert np.array_equal(after.face_region, session.replay(scan, free).face_region)
    assert (after.face_region != before).any()
    assert np.flatnonzero(after.partition.region_locked).tolist() == [after.face_region[first]]


def test_a_region_smaller_than_the_brush_does_not_vanish(jagged):
    session, scan, recipe, faces = jagged
    small = recipe.then(rcp.PaintFaces(faces=(int(faces[5]),)))
    assert session.replay(scan, small).numbers["regions"] == 7
    after = session.replay(scan, small.then(rcp.SmoothFaces(faces=tuple(faces.tolist()))))
    assert after.numbers["regions"] == 7


def test_a_hand_may_erase_from_a_locked_region_which_stays_locked(jagged):
    """Erased across the middle, so that a part of it is cut off and joins the regions around it."""
    session, scan, recipe, _ = jagged
    before = session.replay(scan, recipe)
    side = np.flatnonzero(before.face_region == before.face_region[600])
    middle = scan.vertices[scan.triangles].mean(axis=1)
    axis = int(np.argmax(np.ptp(middle[side], axis=0)))
    strip = side[np.abs(middle[side, axis] - 0.35) < 0.06]
    locked = recipe.then(rcp.LockRegions(faces=(600,)))
    outcome = session.replay(scan, locked.then(rcp.EraseFaces(faces=tuple(strip.tolist()))))
    label, partition = outcome.face_region, outcome.partition
    kept = np.flatnonzero(partition.region_locked)
    assert len(kept) == 1
    assert set(np.flatnonzero(label == kept[0])) < set(side.tolist()) - set(strip.tolist())
