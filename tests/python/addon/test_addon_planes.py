"""Planes in recipes: Regularise and planes set by hand, replayed with the real engine and without Blender."""

import json
from dataclasses import replace

import numpy as np
import pytest

from bench.generators import houses
from isimp import messages, regularity, sketch
from isimp import recipe as rcp
from isimp.session import Session, StepFailed, engine
from isimp.task import Watch
from session_scans import scan_of

BEGIN = rcp.Recipe((rcp.Partition(proxies=112),))


@pytest.fixture(scope="module")
def house():
    made = houses.make(0.001, 3, turn=0.0)
    return scan_of(made.vertices, made.triangles)


@pytest.fixture(scope="module")
def session():
    return Session()


def face_along(session, scan, recipe, axis, number=0):
    """A face of the largest region except `number` that faces along an axis."""
    outcome = session.replay(scan, recipe)
    normal, _, _, area = session.region_fits(scan, outcome)
    facing = np.flatnonzero(abs(normal[:, axis]) > 0.99)
    region = facing[np.argsort(-area[facing], kind="stable")][number]
    return int(np.flatnonzero(outcome.face_region == region)[0])


def plane_of(outcome, face):
    region = outcome.face_region[face]
    return outcome.partition.region_normal[region], outcome.partition.region_held[region]


def test_steps_are_saved_and_read_again():
    steps = (
        rcp.Regularise(),
        rcp.Regularise(angle=5.0, length=0.1, up="region", face=7),
        rcp.AlignPlanes(faces=(3, 4), to="coplanar", direction=(0.0, 1.0, 0.0), length=0.02),
    )
    recipe = rcp.Recipe((rcp.Partition(), *steps))
    assert rcp.Recipe.from_json(recipe.to_json()) == recipe
    assert [messages.line(step) for step in steps] == ["Regularise", "Regularise", "Make 2 regions coplanar"]
    short = {"isimp_recipe": 1, "steps": [{"step": "regularise"}, {"step": "align", "faces": [2], "to": "level"}]}
    assert rcp.Recipe.from_json(json.dumps(short)).steps == (rcp.Regularise(), rcp.AlignPlanes(faces=(2,), to="level"))


def test_regularise_replaces_an_earlier_one_but_for_planes_set_after_it():
    first, second, hand = rcp.Regularise(), rcp.Regularise(angle=3.0), rcp.AlignPlanes(faces=(1,))
    edit = rcp.AddProxy(face=4)
    assert BEGIN.then(first).then(edit).then(second).steps == (*BEGIN.steps, edit, second)
    assert BEGIN.then(first).then(hand).then(second).then(first).steps == (*BEGIN.steps, first, hand, first)
    regular = BEGIN.then(first)
    assert regular.then(rcp.Mesh()).regularised(second) == regular.then(rcp.Mesh())
    assert regular.then(edit).regularised(second).steps == (*BEGIN.steps, edit, second)


def test_regularise_reports_the_planes(house, session):
    before = session.replay(house, BEGIN)
    after = session.replay(house, BEGIN.then(rcp.Regularise()))
    assert np.array_equal(after.face_region, before.face_region)
    assert np.array_equal(after.region_color, before.region_color)
    found = {name: after.numbers[name] for name in ("held", "planes", "directions", "planes_add")}
    assert found["directions"] < 20
    assert found["planes"] < after.numbers["regions"]
    assert found["held"] > 90
    assert 0 <= found["planes_add"] < 0.01
    assert not found.keys() & before.numbers.keys()
    meshed = session.replay(house, BEGIN.then(rcp.Regularise()).then(rcp.Mesh(planar=True)))
    assert found.items() <= meshed.numbers.items()
    assert meshed.polygons.report["planar"]


def test_up_is_the_scenes_in_the_scans_space(session):
    made = houses.make(0.001, 3, turn=0.0)
    lying = scan_of(made.vertices[:, [0, 2, 1]] * (1, -1, 1), made.triangles)
    levels = {}
    for name, step in {
        "scene": rcp.Regularise(direction=(0.0, -1.0, 0.0)),
        "y": rcp.Regularise(up="y"),
        "none": rcp.Regularise(up="none"),
    }.items():
        outcome = session.replay(lying, BEGIN.then(step))
        levels[name] = outcome.partition.regularity["snapped_to"]["level"]
        held = np.asarray(outcome.partition.region_held) == 1
        along = np.abs(np.asarray(outcome.partition.region_normal)[held] @ (0, 1, 0))
        assert name == "none" or (along > 1 - 1e-12).sum() == levels[name] > 2
    assert (levels["scene"], levels["none"]) == (levels["y"], 0)
    floor = face_along(session, lying, BEGIN, 1)
    by_region = session.replay(lying, BEGIN.then(rcp.Regularise(up="region", face=floor)))
    assert by_region.partition.regularity["snapped_to"]["level"] == pytest.approx(levels["y"], abs=3)
    with pytest.raises(StepFailed, match="no region is chosen for the up direction"):
        session.replay(lying, BEGIN.then(rcp.Regularise(up="region")))
    with pytest.raises(StepFailed, match="level and upright need an up direction"):
        session.replay(lying, BEGIN.then(rcp.AlignPlanes(faces=(floor,), up="none")))


def test_planes_set_by_hand_survive_edits_elsewhere_and_regularise(house, session):
    wall, roof = face_along(session, house, BEGIN, 0), face_along(session, house, BEGIN, 2)
    hand = BEGIN.then(rcp.AlignPlanes(faces=(wall,), to="upright"))
    normal, held = plane_of(session.replay(house, hand), wall)
    assert held == 2
    assert abs(normal[2]) < 1e-12
    for step in (rcp.SplitRegion(face=roof), rcp.Regularise(), rcp.LockRegions(faces=(roof,)), rcp.Mesh()):
        hand = hand.then(step)
        same, held = plane_of(session.replay(house, hand), wall)
        assert held == 2
        assert np.array_equal(same, normal)
    assert session.replay(house, hand).numbers["held"] > 80
    freed = hand.then(rcp.AlignPlanes(faces=(wall,), to="free")).then(rcp.Regularise())
    assert plane_of(session.replay(house, freed), wall)[1] == 3


def test_planes_hang_on_faces_so_they_come_back_in_another_partition(house, session):
    wall = face_along(session, house, BEGIN, 0)
    hand = BEGIN.then(rcp.AlignPlanes(faces=(wall,), to="upright"))
    fewer = hand.changed(0, rcp.Partition(proxies=90))
    assert fewer.steps[1] == hand.steps[1]
    normal, held = plane_of(session.replay(house, fewer), wall)
    assert held == 2
    assert abs(normal[2]) < 1e-12


def test_a_plane_that_needs_too_much_fails_with_the_amount(house, session):
    wall = face_along(session, house, BEGIN, 0)
    far = BEGIN.then(rcp.AlignPlanes(faces=(wall,), to="upright", direction=(0.3, 0.0, 1.0), length=0.001))
    with pytest.raises(StepFailed, match=r"needs [\d.]+, allowed 0.001") as failed:
        session.replay(house, far)
    assert (failed.value.index, failed.value.outcome.numbers["regions"]) == (1, 112)
    told = messages.reason(failed.value.reason, lambda value: f"{1000 * value:.0f} mm")
    assert told.startswith("this region needs ")
    assert told.endswith(" mm, allowed 1 mm")
    assert far.replaced(1, replace(far.steps[1], enabled=False)).active() == BEGIN.active()


def test_a_leaning_plane_has_its_angle_and_the_effect_of_snapping(house, session):
    up = np.array([0.0, 0.0, 2.0])
    turn = np.radians(2.1)
    spread = np.diag([0.0, 1.0, 4.0])  # a wall that faces along x, 4 units high in the root mean square
    found = regularity.leaning(np.array([np.cos(turn), 0.0, np.sin(turn)]), _turned(spread, turn), up)
    assert not found.is_level
    assert found.degrees == pytest.approx(2.1)
    assert found.adds == pytest.approx(2 * np.sin(turn))
    roof = regularity.leaning(np.array([0.0, np.sin(turn), -np.cos(turn)]), np.eye(3), up)
    assert roof.is_level
    assert roof.degrees == pytest.approx(2.1)
    slope = np.array([np.cos(0.7), 0.0, np.sin(0.7)])
    assert regularity.leaning(slope, np.eye(3), up) is None
    outcome = session.replay(house, BEGIN)
    assert session.region_fits(house, outcome) is session.region_fits(house, outcome), "kept"


def _turned(spread, turn):
    """A spread turned about y."""
    turned = np.array([[np.cos(turn), 0, -np.sin(turn)], [0, 1, 0], [np.sin(turn), 0, np.cos(turn)]])
    return turned @ spread @ turned.T


def test_directions_have_hues_and_planes_shades():
    normal = np.array([(0, 0, 1), (0, 0, -1), (1, 0, 0), (0, 0, 1), (0, 1, 0)], float)
    offset, held = np.array([1.0, 0.0, 0.0, -1.0, 0.0]), np.array([True, True, True, True, False])
    colors = regularity.direction_colors(normal, offset, held, np.array([1.0, 5.0, 2.0, 1.0, 9.0]))
    assert colors.dtype == np.float32
    assert tuple(colors[4]) == tuple(np.array(regularity.FREE, np.float32))
    level, across = colors[[0, 1, 3], :3], colors[2, :3]
    hue = level / level.max(axis=1, keepdims=True)
    assert np.allclose(hue, hue[0], atol=1e-6)
    assert len(np.unique(level.round(4), axis=0)) == 3, "three planes of one direction"
    assert np.allclose(level[1] * 2, level[0] + level[2], atol=1e-6), "shades in the order of the planes"
    assert not np.allclose(across / across.max(), hue[0], atol=0.1)
    assert regularity.direction_colors(normal[:0], offset[:0], held[:0], offset[:0]).shape == (0, 4)


def test_the_preview_equals_mesh_and_has_colours_of_directions(house):
    session = Session()
    region = session.replay(house, BEGIN).face_region
    snapped = sketch.draw(session, house, region, BEGIN, rcp.Mesh(), Watch(), rcp.Regularise())
    made = session.replay(house, BEGIN.then(rcp.Regularise()).then(rcp.Mesh()))
    assert snapped.numbers == made.numbers
    assert snapped.directions.shape == (len(snapped.surface), 4)
    hues = np.unique(snapped.directions, axis=0)
    assert len(hues) > made.numbers["directions"] / 2
    plain = sketch.draw(session, house, region, BEGIN, rcp.Mesh(), Watch())
    assert np.array_equal(np.unique(plain.directions, axis=0)[0], np.array(regularity.FREE, np.float32))
    assert len(np.unique(plain.directions, axis=0)) == 1


@pytest.mark.parametrize("planar", [False, True])
def test_planes_that_polygons_do_not_keep_to_have_the_colour_of_free_ones(session, planar):
    made = houses.make(0.004, 3, turn=0.0)
    noisy, few = scan_of(made.vertices, made.triangles), rcp.Recipe((rcp.Partition(proxies=60),))
    region = session.replay(noisy, few).face_region
    drawn = sketch.draw(session, noisy, region, few, rcp.Mesh(planar=planar), Watch(), rcp.Regularise())
    outcome = session.replay(noisy, few.then(rcp.Regularise()).then(rcp.Mesh(planar=planar)))
    gone = np.asarray(outcome.polygons.planes_let_go)
    assert len(gone) == outcome.numbers["let_go"] > 0
    of = np.asarray(outcome.polygons.polygon_region)[session.triangulate(outcome.polygons)[1]]
    is_free = (drawn.directions[::3] == np.array(regularity.FREE, np.float32)).all(axis=1)
    held = np.asarray(outcome.partition.region_held) == 1
    assert held[gone].all()
    held[gone] = False
    assert np.array_equal(is_free, ~held[of])


def test_a_bound_does_not_cost_the_planes(house, session):
    recipe = rcp.Recipe((rcp.Partition(bound=0.025), rcp.Regularise(), rcp.Mesh()))
    outcome = session.replay(house, recipe)
    assert outcome.numbers["scan_distance"] > outcome.numbers["scan_distance_allowed"], "all steps are tried"
    assert outcome.numbers["held"] > 0
    assert outcome.numbers["regions"] == outcome.numbers["regions_before"]


def test_the_engine_knows_no_other_alignments():
    cube = engine.Mesh(np.eye(3), np.array([[0, 1, 2]], np.int32))
    part = engine.partition_from(cube, np.zeros(1, np.int32))
    with pytest.raises(engine.InvalidInput, match=f"to must be one of {', '.join(rcp.ALIGNMENTS)}, got 'x'"):
        engine.align_planes(cube, part, [0], "x")
