"""The drawing over a scan, as arrays."""

import numpy as np
import pytest

from isimp import sketch
from isimp.recipe import AddProxy, LockRegions, Mesh, Partition, Recipe
from isimp.session import Scan, Session
from isimp.task import Stopped, Watch

SIDES = Recipe((Partition(proxies=6),))


@pytest.fixture(scope="module")
def cube():
    """A cube of side 2, each side four squares cut in two; faces are the squares."""
    line, index, triangles = (-1.0, 0.0, 1.0), {}, []
    for axis in range(3):
        for side in (-1, 1):
            for i in range(2):
                for j in range(2):
                    corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)][::side]
                    quad = [
                        index.setdefault(tuple(np.roll((side, line[a], line[b]), axis)), len(index)) for a, b in corners
                    ]
                    triangles += [quad[:3], [quad[0], quad[2], quad[3]]]
    return Scan(np.array(list(index)), np.array(triangles, np.int32), np.repeat(np.arange(24, dtype=np.int32), 2), 24)


def drawn(cube, recipe=SIDES, meshing=None, label=None):
    session = Session()
    region = session.replay(cube, recipe).face_region if label is None else label
    return sketch.draw(session, cube, region, recipe, meshing, Watch())


def test_far_from_zero_all_is_drawn_relative_to_a_place_near_it(cube):
    """At 2**24 the cube's corners are odd and even numbers, of which float32 has the even ones alone."""
    far = np.array([2.0**24 + 1, 0, -(2.0**24) + 1])
    moved = Scan(cube.vertices + far, cube.triangles, cube.triangle_face, cube.face_count)
    recipe, meshing = SIDES.then(LockRegions(faces=(0,))), Mesh()
    near, made = drawn(cube, recipe, meshing), drawn(moved, recipe, meshing)
    assert tuple(near.origin) == (0, 0, 0)
    for name in ("borders", "outline", "corners", "surface", "locked"):
        assert getattr(made, name).dtype == np.float32
        placed = getattr(made, name).astype(float) + made.origin - far
        assert len(placed)
        assert set(map(tuple, placed.round(6))) == set(map(tuple, getattr(near, name).astype(float).round(6)))
    assert drawn(moved).origin == made.origin


def test_what_is_known_is_drawn_at_once(cube):
    session, recipe = Session(), SIDES.then(LockRegions(faces=(0,)))
    assert sketch.at_once(session, cube, recipe) is None, "it would take time"
    region = session.replay(cube, recipe).face_region
    made = sketch.at_once(session, cube, recipe.then(Mesh()))
    wanted = sketch.draw(session, cube, region, recipe, None, Watch())
    assert len(made.borders) > 0 < len(made.locked)
    assert segments(made.borders) == segments(wanted.borders)
    assert np.array_equal(made.locked, wanted.locked)
    side = sketch.borders_of(cube, session.known(cube, recipe).border, region, int(region[0]))
    assert len(segments(side)) == 8  # four edges of two pieces


def segments(points):
    """The set of lines, each as its sorted ends."""
    return {tuple(sorted(map(tuple, line))) for line in points.reshape(-1, 2, 3).round(6).tolist()}


def test_borders_are_where_regions_meet(cube):
    made = drawn(cube)
    lines = segments(made.borders)
    assert len(lines) == len(made.borders) // 2 == 24  # twelve edges of two pieces
    for begin, end in lines:
        assert sum(abs(a) == 1 and a == b for a, b in zip(begin, end, strict=True)) == 2
    assert (len(made.outline), len(made.corners), len(made.surface), made.reason) == (0, 0, 0, "")


def test_borders_of_a_region_to_none_are_drawn_and_no_others(cube):
    label = np.zeros(24, np.int32)
    assert len(drawn(cube, label=label).borders) == 0
    label[5] = -1
    assert len(segments(drawn(cube, label=label).borders)) == 4


def test_the_outline_is_that_of_the_polygons(cube):
    made = drawn(cube, meshing=Mesh())
    lines = segments(made.outline)
    assert len(lines) == len(made.outline) // 2 == 12
    assert {tuple(np.abs(corner).round(6)) for corner in made.corners} == {(1.0, 1.0, 1.0)}
    assert len(made.corners) == 8
    assert len(made.surface) == 3 * 12
    area = np.linalg.norm(
        np.cross(made.surface[1::3] - made.surface[::3], made.surface[2::3] - made.surface[::3]), axis=1
    )
    assert area.sum() / 2 == pytest.approx(24)
    assert made.heat.shape == (36, 4)
    assert np.ptp(made.heat, axis=0).max() == 0  # all are flat
    assert len(made.problems) == 0


def test_polygons_that_cannot_be_made_are_no_reason_to_draw_nothing(cube):
    broken = Recipe((*SIDES.steps, AddProxy(face=999)))
    made = drawn(cube, broken, Mesh(), label=np.arange(24, dtype=np.int32) // 4)
    assert len(segments(made.borders)) == 24
    assert "there is no face 999" in made.reason


def test_drawing_can_be_stopped(cube):
    watch = Watch()
    watch.cancel()
    with pytest.raises(Stopped):
        sketch.draw(Session(), cube, np.zeros(24, np.int32), SIDES, None, watch)


def test_the_edges_of_some_polygons():
    loops, start = np.array([0, 1, 2, 2, 1, 3, 4]), np.array([0, 3])
    assert sketch.edges_of([1], loops, start).tolist() == [[2, 1], [1, 3], [3, 4], [4, 2]]
    assert len(sketch.edges_of([], loops, start)) == 0


def test_heat_runs_from_flat_to_bent():
    share = sketch.heat(np.array([0.0, 0.025, 0.05, 9.0]), diagonal=10.0)
    assert share.tolist() == [0.0, 0.5, 1.0, 1.0]
    colors = sketch.heat_colors(share)
    assert colors[0, 1] > colors[0, 0]
    assert colors[2, 0] > colors[2, 1]
    assert sketch.heat(np.ones(2), 0.0).tolist() == [0.0, 0.0]


def test_short_lines_are_fainter_but_always_visible():
    assert sketch.strength(0) == sketch.strength(4) == 0.15
    assert sketch.strength(54) == sketch.strength(500) == 1
    assert 0.15 < sketch.strength(20) < sketch.strength(40) < 1


def test_lines_and_corners_come_by_length():
    vertices = np.array([[0, 0, 0], [4, 0, 0], [4, 1, 0], [0, 1, 0]], float)
    loops, start = np.array([0, 1, 2, 0, 2, 3]), np.array([0, 3])
    ends = sketch.outline(vertices, loops, start).reshape(-1, 2, 3)
    length = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)
    assert length == pytest.approx([17**0.5, 4, 4, 1, 1])
    places, reach = sketch.corners(vertices, loops, start)
    assert reach.tolist() == sorted(reach.tolist(), reverse=True)
    assert sorted(map(tuple, places.tolist())) == sorted(map(tuple, vertices.tolist()))
