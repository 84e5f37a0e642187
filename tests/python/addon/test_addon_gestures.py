"""The meaning of mouse events for the tools, without a window."""

import numpy as np
import pytest

from isimp import gestures, view
from isimp import recipe as rcp
from isimp.engine import engine
from isimp.gestures import Cut, Hit, Pointing, Sizing, Stroke, Wish, painted_over, rings_in
from isimp.pick import Surface
from isimp.session import Session, StepFailed, joined_faces
from session_scans import scan_of

A, A2, B, NONE = Hit(1, 0), Hit(2, 0), Hit(9, 1), Hit(20, -1)
NEAR, FAR = (2.0, 1.0), (60.0, 0.0)


@pytest.mark.parametrize(
    ("held", "moves", "wanted"),
    [
        ({}, [], Wish("add", (1,))),
        ({}, [(A2, NEAR)], Wish("add", (1,))),
        ({"verb": "delete"}, [], Wish("delete", (1,))),
        ({"verb": "choose"}, [(B, FAR)], Wish("choose", (1,))),
        ({"verb": "merge"}, [], None),
        ({"verb": "merge"}, [(B, FAR)], Wish("merge", (9,), into=1)),
        ({}, [(A2, FAR), (B, FAR)], Wish("merge", (9,), into=1)),
        ({}, [(B, FAR), (A2, NEAR)], None),  # dragged back: dropped
        ({}, [(B, FAR), (None, FAR)], None),
        ({}, [(NONE, FAR)], None),
        ({"verb": "delete"}, [(B, FAR)], Wish("delete", (1,))),
    ],
)
def test_pointing(held, moves, wanted):
    tool = Pointing()
    tool.press(A, **held)
    for hit, at in moves:
        tool.move(hit, at)
    assert tool.merging == (wanted is not None and wanted.verb == "merge")
    assert tool.release() == wanted
    assert tool.release() is None


def test_a_drag_is_longer_than_a_shake_of_the_hand():
    limit = gestures._DRAG
    assert not gestures.is_far((5, 5), (5 + limit, 5))
    assert gestures.is_far((5, 5), (5, 6 + limit))


def test_pointing_past_the_scan_and_dropping():
    tool = Pointing()
    tool.press(None)
    tool.move(B, FAR)
    assert tool.release() is None
    tool.press(NONE)
    assert tool.release() == Wish("add", (20,))  # a part that was left out is restored
    tool.press(A)
    tool.move(B, FAR)
    tool.cancel()
    assert (tool.release(), tool.merging) == (None, False)


@pytest.fixture(scope="module")
def grid():
    """A square of side 2 about the origin, 20 x 20 cells of two triangles, each cell a face of the user's."""
    line = np.linspace(-1, 1, 21)
    x, y = np.meshgrid(line, line, indexing="ij")
    vertices = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3)
    at = np.arange(441).reshape(21, 21)
    a, b, c, d = at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]
    triangles = np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)
    return Surface(vertices, triangles), np.repeat(np.arange(400), 2), engine.guides.shared_edges(triangles)[0]


DOWN = (0, 0, -1)


def cell(x, y):
    return int((x + 1) * 10) * 20 + int((y + 1) * 10)


def hit(x, y, region=0):
    return Hit(cell(x, y), region, (x, y, 0.0))


def test_a_stroke_covers_all_between_its_places(grid):
    stroke = Stroke(*grid, radius=0.12)
    stroke.press(hit(-0.85, 0.05), DOWN)
    stroke.move(hit(0.85, 0.05), DOWN)
    wish = stroke.release()
    assert (wish.verb, wish.into, wish.faces[0]) == ("paint", cell(-0.85, 0.05), cell(-0.85, 0.05))
    assert {cell(x, 0.05) for x in np.linspace(-0.85, 0.85, 18)} <= set(wish.faces)
    assert all(abs(face % 20 - 10) <= 2 for face in wish.faces)
    assert len(set(wish.faces)) == len(wish.faces)
    assert stroke.release() is None


def test_what_does_not_hang_together_with_the_first_place_is_not_painted(grid):
    stroke = Stroke(*grid, radius=0.12)
    stroke.press(hit(-0.85, 0.05), DOWN, "new")
    stroke.move(None, DOWN)  # past the scan, and back elsewhere
    stroke.move(hit(0.85, 0.05), DOWN)
    wish = stroke.release()
    assert (wish.verb, wish.into) == ("new", None)
    assert all(face // 20 < 5 for face in wish.faces)


def test_a_brush_smaller_than_a_face_paints_the_face(grid):
    stroke = Stroke(*grid, radius=1e-6)
    stroke.press(hit(0.55, 0.35), DOWN, "erase")
    assert stroke.release() == Wish("erase", (cell(0.55, 0.35),))


def test_a_stroke_cancelled_or_off_the_scan_paints_nothing(grid):
    stroke = Stroke(*grid, radius=0.2)
    stroke.press(None, DOWN)
    assert stroke.release() is None
    stroke.press(hit(0, 0), DOWN)
    stroke.cancel()
    assert (stroke.release(), stroke.covered) == (None, set())


def test_an_open_scan_is_painted_from_its_back_as_from_its_front(grid):
    painted = []
    for sight in (DOWN, (0, 0, 1)):
        stroke = Stroke(*grid, radius=0.2)
        stroke.press(hit(0.05, 0.05), sight)
        painted.append(stroke.release())
    assert painted[0] == painted[1]
    assert len(painted[0].faces) > 5


@pytest.mark.parametrize(("sight", "face", "upper"), [(DOWN, 210, True), ((0, 0, 1), 610, False)])
def test_a_stroke_does_not_reach_the_far_side(grid, sight, face, upper):
    line = np.linspace(-1, 1, 21)
    top = np.array([(x, y, 0.01) for x in line for y in line])
    cells = [(21 * i + j, 21 * i + j + 21, 21 * i + j + 22, 21 * i + j + 1) for i in range(20) for j in range(20)]
    triangles = np.array([t for a, b, c, d in cells for t in ((a, b, c), (a, c, d))])
    sheets = Surface(np.vstack([top, top - [0, 0, 0.02]]), np.vstack([triangles, triangles[:, ::-1] + len(top)]))
    stroke = Stroke(sheets, np.repeat(np.arange(800), 2), grid[2], radius=0.2)
    stroke.press(Hit(face, 0, (0.05, 0.05, 0.01 if upper else -0.01)), sight)
    assert len(stroke.covered) > 5
    assert all((triangle < 800) == upper for triangle in stroke.covered)


def test_a_cut_is_of_the_region_it_meets_most():
    cut = Cut()
    assert (cut.target, cut.release()) == (None, None)
    cut.press(None)
    for place in (hit(-0.5, 0, region=1), hit(0, 0, region=3), hit(0.1, 0, region=3), hit(0.2, 0, region=-1)):
        cut.move(place, FAR)
    assert cut.target == hit(0, 0, region=3)
    assert cut.release() == Wish("cut", (cell(0, 0),))


@pytest.mark.parametrize(("begin", "moves", "wanted"), [(A, [(B, NEAR)], "split"), (A, [(B, FAR), (A, NEAR)], "cut")])
def test_a_cut_without_a_line_splits_where_it_was_pressed(begin, moves, wanted):
    cut = Cut()
    cut.press(B, FAR)  # the earlier line is forgotten
    cut.move(B, NEAR)
    cut.press(begin, (0.0, 0.0))
    for place, at in moves:
        cut.move(place, at)
    assert cut.release() == Wish(wanted, (begin.face,))


@pytest.mark.parametrize("begin", [None, NONE])
def test_nothing_is_split_off_the_regions(begin):
    cut = Cut()
    cut.press(begin)
    assert cut.release() is None


@pytest.mark.parametrize(
    ("held", "moves", "wanted"),
    [
        ({}, [], ("grow", 1)),
        ({"ctrl": True}, [], ("shrink", 1)),
        ({}, [(3.0, 3.0)], ("grow", 1)),  # a hand that trembles
        ({}, [(60.0, 5.0)], ("grow", 12)),
        ({"ctrl": True}, [(60.0, 0.0)], ("grow", 12)),
        ({}, [(-41.0, 0.0)], ("shrink", 8)),
        ({}, [(60.0, 0.0), (2.0, 0.0)], None),  # dragged back: no change
        ({}, [(0.0, 60.0)], None),
        ({}, [(60.0, 0.0), (-10.0, 0.0)], ("shrink", 2)),
    ],
)
def test_sizing_follows_the_distance_of_the_mouse(held, moves, wanted):
    tool = Sizing(ring=5.0)
    tool.press(A, (100.0, 50.0), **held)
    for x, y in moves:
        tool.move((100.0 + x, 50.0 + y))
    assert tool.wish == (None if wanted is None else Wish(wanted[0], (A.face,), rings=wanted[1]))


def test_sizing_off_the_regions_does_nothing():
    for begin in (None, NONE):
        tool = Sizing(ring=5.0)
        tool.press(begin)
        assert tool.wish is None
        tool.move(FAR)
        assert tool.wish is None


def test_rings_are_at_least_one_and_not_endless():
    assert [rings_in(8.0, ring) for ring in (2.0, 3.0, 100.0, 1e-9, 0.0)] == [4, 3, 1, 160, 160]
    assert rings_in(1e9, 1.0) == 1000


def test_a_stroke_over_a_flat_face_keeps_to_the_edges_of_the_mended_mesh():
    """The engine turns an edge of face 1, which has no area: then 1 and 2 are adjacent, but 1 and 3 are not."""
    vertices = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [1, 1, 0], [0.5, -1, 0], [1.5, -1, 0]], float)
    triangles = np.array([[0, 2, 3], [0, 1, 2], [0, 4, 1], [1, 5, 2]], np.int32)
    scan, session = scan_of(vertices, triangles), Session()
    stroke = np.array([1, 2, 3])
    assert view.connected(stroke, scan.edges[0], 2).tolist() == [1, 2, 3]
    regions = rcp.Recipe((rcp.Partition(proxies=1, close_openings=False),))
    with pytest.raises(StepFailed, match="do not hang together"):
        session.replay(scan, regions.then(rcp.PaintFaces(faces=stroke.tolist())))
    joined = joined_faces(session.prepare(scan), stroke, 2)
    assert joined.tolist() == [1, 2]
    painted = session.replay(scan, regions.then(rcp.PaintFaces(faces=joined.tolist())))
    assert painted.face_region[1] == painted.face_region[2] != painted.face_region[3]


def test_faces_are_joined_over_long_ways_and_in_any_order():
    rng = np.random.default_rng(3)
    order = rng.permutation(5000)  # two long ways whose faces lie anywhere
    pairs = np.stack([order[:-1], order[1:]], axis=1)
    pairs = np.delete(pairs, 2999, axis=0)
    found = view.connected(np.arange(5000), pairs[rng.permutation(len(pairs))], int(order[17]))
    assert found.tolist() == sorted(order[:3000].tolist())
    few = np.sort(order[10:20])
    assert view.connected(few, pairs, int(order[12])).tolist() == few.tolist()
    assert view.connected(few, pairs[:0], int(order[12])).tolist() == [order[12]]


@pytest.mark.parametrize("seed", range(20))
def test_joined_faces_equal_a_plain_search(seed):
    rng = np.random.default_rng(seed)
    pairs = rng.integers(0, 60, (50, 2))
    chosen = np.sort(rng.choice(60, 45, replace=False))
    start = int(chosen[7])
    reached, inside = {start}, set(chosen.tolist())
    while True:
        more = {int(b) for pair in pairs for a, b in (pair, pair[::-1]) if a in reached and b in inside} - reached
        if not more:
            break
        reached |= more
    assert view.connected(chosen, pairs, start).tolist() == sorted(reached)


@pytest.mark.parametrize(
    ("faces", "locked", "wanted"),
    [
        (range(20), (), [0]),
        (range(20, 61), (), [20, 40]),  # most of a stroke, or a tenth of a region
        ([*range(20), 40], (), [0]),  # region 2 was only touched
        ([90, *range(20)], (), [0]),  # face 90 is in no region
        (range(61), (0, 1), [40]),
        ([*range(20), 80], (), [0]),  # region 3 is one face
        ([80], (), []),
    ],
)
def test_a_stroke_covers_regions_and_touches_others(faces, locked, wanted):
    label = np.repeat([0, 1, 2, 3, -1], [20, 20, 40, 1, 19])
    assert painted_over(list(faces), label, np.array(locked, int)) == wanted
