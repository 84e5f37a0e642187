"""Recipes replayed on arrays, with the real engine and without Blender."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import shapes
from isimp import recipe as rcp
from isimp import view
from isimp.recipe import AddProxy, DeleteProxy, Mesh, Partition, Recipe
from isimp.session import Scan, Session, StepFailed, engine
from isimp.task import Stopped, Watch
from session_scans import scan_of

SIDES = Recipe((Partition(proxies=6),))


def bumpy_sphere(rows=16, columns=24):
    """A sphere with flat spots, as quads and two fans of triangles; faces are cut along one diagonal."""
    polar, turn = np.meshgrid(
        np.linspace(0, np.pi, rows + 1)[1:-1], np.linspace(0, 2 * np.pi, columns, endpoint=False), indexing="ij"
    )
    radius = 1 + 0.15 * np.cos(3 * polar) * np.cos(2 * turn)
    ring = np.stack([np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn), np.cos(polar)], axis=-1)
    vertices = np.concatenate([(ring * radius[..., None]).reshape(-1, 3), [[0, 0, 1], [0, 0, -1]]])
    at = np.arange((rows - 1) * columns).reshape(rows - 1, columns)
    beside = np.roll(at, -1, axis=1)
    a, b, c, d = at[:-1].ravel(), at[1:].ravel(), beside[1:].ravel(), beside[:-1].ravel()
    quads = np.stack([a, b, c, a, c, d], axis=1).reshape(-1, 3)
    north, south = len(vertices) - 2, len(vertices) - 1
    caps = [(north, i, j) for i, j in zip(at[0], beside[0], strict=True)]
    caps += [(south, j, i) for i, j in zip(at[-1], beside[-1], strict=True)]
    triangles = np.concatenate([quads, caps]).astype(np.int32)
    face = np.concatenate([np.repeat(np.arange(len(a)), 2), len(a) + np.arange(len(caps))]).astype(np.int32)
    return Scan(vertices, triangles, face, int(face[-1]) + 1)


def each_triangle(scan):
    return scan_of(scan.vertices, scan.triangles)


@pytest.fixture(scope="module")
def quads():
    return bumpy_sphere()


@pytest.fixture(scope="module")
def scan(quads):
    return each_triangle(quads)


def test_partition_labels_every_face_and_has_numbers(scan):
    outcome = Session().replay(scan, SIDES)
    assert np.unique(outcome.face_region).tolist() == list(range(6))
    assert (outcome.face_region.dtype, outcome.numbers["regions"]) == (np.int32, 6)
    assert (outcome.numbers["triangles"], outcome.numbers["components"]) == (len(scan.triangles), 1)
    assert outcome.numbers["closed"]
    assert outcome.numbers["error"] == pytest.approx(outcome.partition.error)


def test_faces_with_many_corners_keep_every_region(quads):
    outcome = Session().replay(quads, Recipe((Partition(proxies=60),)))
    assert len(outcome.face_region) == quads.face_count
    assert np.unique(outcome.face_region).tolist() == list(range(60))


def test_a_face_belongs_to_the_region_with_most_of_its_area():
    """Two faces of a triangle each, and one of two: 8 of area in region 1, 6.3 in region 2."""
    vertices = np.array([[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0], [5, 0, 3], [9, 0, 3]], float)
    triangles = np.array([[0, 1, 2], [0, 2, 3], [1, 4, 2], [4, 5, 2]], np.int32)
    prepared = Session().prepare(Scan(vertices, triangles, np.array([0, 1, 1, 2], np.int32), 3))

    def regions(*labels, seeds):
        part = SimpleNamespace(face_region=labels, region_count=3, region_seed=seeds)
        return prepared.faces.regions(part).tolist()

    assert regions(0, 1, 2, 2, seeds=[0, 1, 3]) == [0, 1, 2]
    assert regions(0, 1, 2, 0, seeds=[0, 1, 2]) == [0, 2, 0]  # region 2 would have no face, so it gets its seed's
    assert regions(0, 1, -1, 2, seeds=[0, 1, 3]) == [0, 1, 2]


def test_add_and_delete_work_at_the_users_faces(quads):
    session = Session()
    first = session.replay(quads, SIDES)
    added = session.replay(quads, SIDES.then(AddProxy(face=200)))
    assert (added.face_region[200], added.numbers["regions"]) == (6, 7)
    deleted = session.replay(quads, SIDES.then(AddProxy(face=200)).then(DeleteProxy(face=200)))
    assert (deleted.numbers["regions"], first.numbers["regions"]) == (6, 6)


def test_colours_stay_with_their_region_and_part_neighbours(scan):
    session = Session()
    recipe = Recipe((Partition(proxies=20),))
    before = session.replay(scan, recipe)
    for step in (AddProxy(face=11), AddProxy(face=200), DeleteProxy(face=400), AddProxy(face=300)):
        recipe = recipe.then(step)
        after = session.replay(scan, recipe)
        pairs, _ = engine.guides.shared_edges(scan.triangles)
        color = after.region_color[after.face_region][pairs]
        assert np.array_equal(after.border, view.border_pairs(after.face_region, pairs))
        assert (color[:, 0] != color[:, 1])[after.border].all()
        shared = before.region_color if isinstance(step, AddProxy) else None
        if shared is not None:
            assert (after.region_color[: len(shared)] == shared).mean() > 0.9
        before = after


def test_what_was_computed_before_is_kept(scan, monkeypatch):
    session, calls = Session(), []
    for of, name in ((engine.repairs, "clean"), (engine.guided, "partition"), (engine.replay, "edited")):
        real = getattr(of, name)
        monkeypatch.setattr(of, name, lambda *a, real=real, name=name, **k: (calls.append(name), real(*a, **k))[1])
    recipe = SIDES.then(AddProxy(face=3))
    first = session.replay(scan, recipe)
    assert calls == ["clean", "partition", "edited"]
    again = Scan(scan.vertices.copy(), scan.triangles.copy(), scan.triangle_face.copy(), scan.face_count)
    assert session.replay(again, recipe) is first
    session.replay(scan, SIDES.then(AddProxy(face=4)))
    assert calls == ["clean", "partition", "edited", "edited"]


def test_edit_and_edit_back_is_equal_to_the_bit(scan):
    session, recipe = Session(), SIDES.then(AddProxy(face=3)).then(Mesh())
    first = session.replay(scan, recipe)
    session.replay(scan, Recipe((Partition(proxies=9), *recipe.steps[1:])))
    for again in (session.replay(scan, recipe), Session().replay(scan, recipe)):
        assert (again.face_region == first.face_region).all()
        assert (again.region_color == first.region_color).all()
        assert np.array_equal(again.polygons.vertices, first.polygons.vertices)
        assert np.array_equal(again.polygons.loops, first.polygons.loops)


PLAIN = Partition(proxies=12, adaptivity=0.0)  # the stroke then is in one piece, and cuts nothing off
STROKE = tuple(range(100, 110))
EDITS = [
    rcp.MergeRegions(face=3),  # with the adjacent one
    rcp.SplitRegion(face=3),
    rcp.CutRegion(face=3, line=((-3, 0.1, 0), (3, 0.1, 0)), direction=(0, 0, 1)),
    rcp.CutRegion(face=3, line=((-3, 0.1, 0.1), (3, 0.1, 0.1), (4, -3, 0.1)), direction=(0, 0.1, 1)),
    rcp.PaintFaces(faces=STROKE),
    rcp.PaintFaces(faces=STROKE, lock=True),
    rcp.EraseFaces(faces=STROKE),
    rcp.SmoothFaces(faces=STROKE),
    rcp.GrowRegion(face=3, rings=2),
    rcp.ShrinkRegion(face=3),
    rcp.LockRegions(faces=(3, 200)),
    rcp.LeaveOutRegions(faces=(3, 200)),
    rcp.AddWorst(times=3),
    rcp.DeleteLeast(times=2),
    rcp.MergeCheapest(times=2),
    rcp.Improve(),
    rcp.EvenBorders(),
]


@pytest.mark.parametrize("step", EDITS, ids=lambda step: step.kind)
def test_every_edit_can_be_replayed_taken_back_and_done_again_to_the_bit(quads, step):
    session, recipe = Session(), Recipe((Partition(proxies=12),))
    before = session.replay(quads, recipe)
    if isinstance(step, rcp.MergeRegions):
        repaired = session.prepare(quads, repair=before.repair)
        face = repaired.faces.triangle_at(step.face)
        beside = engine.regions.region_statistics(repaired.mesh, before.partition, face)["neighbours"][0]
        step = rcp.MergeRegions(face=step.face, other=int(np.flatnonzero(before.face_region == beside)[0]))
    first = session.replay(quads, recipe.then(step))
    assert len(np.unique(first.face_region)) == first.numbers["regions"]
    for again in (
        session.replay(quads, Recipe.from_json(recipe.then(step).to_json())),
        Session().replay(quads, recipe.then(step)),
        Session().replay(quads, Recipe((Partition(proxies=12), rcp.SplitRegion(face=9, enabled=False), step))),
    ):
        assert (again.face_region == first.face_region).all()
        assert (again.region_color == first.region_color).all()
    back = session.replay(quads, Recipe(recipe.then(step).steps[:1]))
    assert (back.face_region == before.face_region).all()
    assert (back.region_color == before.region_color).all()


def test_painted_faces_are_a_region_and_locked_ones_stay(quads):
    session, recipe = Session(), Recipe((PLAIN, rcp.PaintFaces(faces=STROKE, lock=True)))
    painted = session.replay(quads, recipe)
    region = painted.face_region[100]
    assert np.flatnonzero(painted.face_region == region).tolist() == list(STROKE)
    assert painted.numbers["locked"] == 1
    for step in (
        rcp.AddWorst(times=8),
        rcp.DeleteLeast(times=6),
        rcp.Improve(),
        rcp.EvenBorders(),
        rcp.GrowRegion(face=130),
    ):
        after = session.replay(quads, recipe.then(step))
        assert np.flatnonzero(after.face_region == after.face_region[100]).tolist() == list(STROKE)
    with pytest.raises(StepFailed, match="Step 3, Delete proxy at face 100: the region of face 100 is locked"):
        session.replay(quads, recipe.then(DeleteProxy(face=100)))
    free = recipe.then(rcp.UnlockRegions(faces=(100,))).then(DeleteProxy(face=100))
    assert session.replay(quads, free).numbers["locked"] == 0


def test_a_region_keeps_its_colour_through_edits(quads):
    session, recipe = Session(), Recipe((Partition(proxies=12),))
    before = session.replay(quads, recipe)
    for step in EDITS[4:9]:
        after = session.replay(quads, recipe.then(step))
        seeds = quads.triangle_face[np.asarray(before.partition.region_seed)]
        same = before.region_color[before.face_region[seeds]] == after.region_color[after.face_region[seeds]]
        assert same.sum() >= 10, step


def test_a_step_switched_off_does_nothing(scan):
    session = Session()
    off = Recipe((*SIDES.steps, AddProxy(face=3, enabled=False)))
    assert session.replay(scan, off) is session.replay(scan, SIDES)


@pytest.mark.parametrize(
    ("step", "message"),
    [
        (AddProxy(face=99999), "Step 2, Add proxy at face 99999: there is no face 99999: the mesh has"),
        (DeleteProxy(face=99999), "Step 2, Delete proxy at face 99999"),
        (rcp.PaintFaces(faces=(3, 99999)), "Step 2, Paint 2 faces into a new region: there is no face 99999"),
        (rcp.PaintFaces(faces=(3, 300)), "Step 2, Paint 2 faces into a new region: the faces to paint do not hang"),
        (rcp.MergeRegions(face=3, other=3), "Step 2, Merge .*: faces 3 and 3 are in one region"),
        (
            rcp.CutRegion(face=3, line=((9, 9, 9), (9, 8, 9))),
            "Step 2, Cut .*: the line does not cut the region of face 3",
        ),
        (rcp.DeleteLeast(times=99), "Step 2, Delete 99 of least error: only . of 99 can be done"),
    ],
)
def test_a_failed_step_has_its_index_and_reason_and_keeps_the_previous_outcome(scan, step, message):
    session = Session()
    good = session.replay(scan, SIDES)
    with pytest.raises(StepFailed, match=message) as caught:
        session.replay(scan, SIDES.then(step).then(Mesh()))
    assert caught.value.index == 1
    assert caught.value.outcome is good


def test_a_step_without_enough_memory_keeps_the_previous_outcome(scan, monkeypatch):
    def fails(*given):
        raise MemoryError("std::bad_alloc")

    session = Session()
    good = session.replay(scan, SIDES)
    monkeypatch.setattr("isimp.session.apply_mesh", fails)
    with pytest.raises(StepFailed, match="Step 2, Mesh: there is not enough memory") as caught:
        session.replay(scan, SIDES.then(Mesh()))
    assert (caught.value.index, caught.value.outcome) == (1, good)


@pytest.mark.parametrize("step", [AddProxy(face=1), DeleteProxy(face=1), Mesh()])
def test_steps_without_regions_need_a_partition(scan, step):
    with pytest.raises(StepFailed, match="a Partition step must come first"):
        Session().replay(scan, Recipe((step,)))


def test_no_steps_and_no_faces_are_said(scan):
    with pytest.raises(ValueError, match="no active step"):
        Session().replay(scan, Recipe())
    empty = Scan(scan.vertices, scan.triangles[:0], scan.triangle_face[:0], 0)
    with pytest.raises(ValueError, match="no faces"):
        Session().replay(empty, SIDES)


def test_a_face_that_was_dropped_is_named(scan):
    triangles = np.concatenate([scan.triangles, scan.triangles[:1]])
    twice = scan_of(scan.vertices, triangles)
    outcome = Session().replay(twice, SIDES)
    assert outcome.face_region[-1] == -1
    with pytest.raises(StepFailed, match="was left out by the repair of the mesh"):
        Session().replay(twice, SIDES.then(AddProxy(face=len(triangles) - 1)))
    with pytest.raises(StepFailed, match=f"there is no face {len(triangles)}"):
        Session().replay(twice, SIDES.then(rcp.PaintFaces(faces=(0, len(triangles)))))


def test_stop_is_heard_and_progress_only_rises(scan):
    watch = Watch()
    watch.cancel()
    with pytest.raises(Stopped):
        Session().replay(scan, SIDES, watch)
    watch = Watch()
    Session().replay(scan, SIDES.then(Mesh()), watch)
    assert watch.progress == pytest.approx(1.0)


def test_known_outcomes_need_no_work(scan):
    session, recipe = Session(), Recipe((Partition(proxies=30), AddProxy(face=11)))
    assert session.known(scan, recipe) is None
    outcome = session.replay(scan, recipe)
    assert session.known(scan, recipe) is outcome
    assert session.known(scan, recipe.then(AddProxy(face=200))) is None
    assert session.known(scan, Recipe()) is None


def test_changed_weights_do_not_use_the_cached_outcome(scan):
    session, recipe = Session(), Recipe((Partition(proxies=30, weights="w"), Mesh()))
    flat = replace(scan, layers={"w": np.zeros(scan.face_count, np.float32)})
    hilly = replace(scan, layers={"w": np.linspace(0, 1, scan.face_count, dtype=np.float32)})
    first, second = session.replay(flat, recipe), session.replay(hilly, recipe)
    assert (first.face_region != second.face_region).any()
    assert session.replay(flat, recipe) is first
    with pytest.raises(StepFailed, match="there is no vertex group or numeric attribute 'w'"):
        session.replay(scan, recipe)


def seam_of(scan, wanted):
    """Edges of a scan with both ends where `wanted` holds, as (K, 2) vertices."""
    edges = scan.edges[1]
    on = wanted(scan.vertices)
    return edges[on[edges].all(axis=1)].astype(np.int32)


def halves(scan):
    """1 for each face above the middle, else 0."""
    height = scan.vertices[scan.triangles].mean(axis=1)[:, 2]
    return (np.bincount(scan.triangle_face, height) > 0).astype(np.int32)


GUIDES = {
    "materials": lambda scan: {".material": halves(scan)},
    "face_sets": lambda scan: {".face_set": halves(scan)},
    "borders": lambda scan: {"groups": halves(scan)},
    "seams": lambda scan: {".seam": scan.edges[1][np.ptp(halves(scan)[scan.triangle_face[scan.edges[0]]], axis=1) > 0]},
    "sharp": lambda scan: {
        ".sharp": scan.edges[1][np.ptp(halves(scan)[scan.triangle_face[scan.edges[0]]], axis=1) > 0]
    },
}


@pytest.mark.parametrize("option", GUIDES)
def test_no_step_makes_a_region_cross_a_marked_edge(quads, option):
    scan, side = replace(quads, layers=GUIDES[option](quads)), halves(quads)
    marked = {option: "groups" if option == "borders" else True}
    session, recipe = Session(), Recipe((Partition(proxies=12, **marked),))
    outcome = session.replay(scan, recipe)
    assert outcome.numbers["barriers"] > 20
    assert outcome.numbers["barriers_inside"] == 0
    for step in EDITS[1:]:
        outcome = session.replay(scan, recipe.then(step))
        for region in range(outcome.numbers["regions"]):
            assert len(set(side[outcome.face_region == region])) == 1, step
    free = session.replay(scan, Recipe((Partition(proxies=12),)))
    assert any(len(set(side[free.face_region == region])) == 2 for region in range(12)), "it would cross otherwise"
    polygons = session.replay(scan, recipe.then(Mesh())).polygons
    regions = np.asarray(polygons.polygon_region)
    assert set(regions) == set(range(session.replay(scan, recipe).numbers["regions"]))


def test_an_angle_keeps_sharp_edges():
    vertices, triangles = np.array([[x, y, abs(x - 1)] for x in range(3) for y in range(4)], float), []
    for x in range(2):
        for y in range(3):
            a = 4 * x + y
            triangles += [(a, a + 4, a + 5), (a, a + 5, a + 1)]
    roof = scan_of(vertices, triangles)
    one = Session().replay(roof, Recipe((Partition(proxies=1, leave_out=0.0),)))
    assert one.numbers["regions"] == 1
    two = Session().replay(roof, Recipe((Partition(proxies=1, angle=45.0, leave_out=0.0),)))
    assert (two.numbers["regions"], two.numbers["barriers"]) == (2, 3)


def test_a_seam_that_ends_inside_a_region_splits_it(scan):
    stroke = seam_of(scan, lambda v: (np.abs(v[:, 1]) < 1e-9) & (v[:, 0] > 0) & (np.abs(v[:, 2]) < 0.7))
    assert len(stroke) >= 3
    marked = replace(scan, layers={".seam": stroke})
    outcome = Session().replay(marked, Recipe((Partition(proxies=4, seams=True),)))
    assert (outcome.numbers["barriers"], outcome.numbers["barriers_inside"]) == (len(stroke), 0)
    assert Session().replay(marked, Recipe((Partition(proxies=4),))).numbers["regions"] == 4


def test_a_missing_attribute_is_named_and_missing_marks_are_none(scan):
    with pytest.raises(StepFailed, match="there is no face attribute 'groups' for the barriers"):
        Session().replay(scan, Recipe((Partition(proxies=6, borders="groups"),)))
    outcome = Session().replay(scan, Recipe((Partition(proxies=6, seams=True, materials=True),)))
    assert outcome.numbers["regions"] == 6


def test_a_part_is_split_alone_and_the_rest_keeps_its_regions_and_colours(scan):
    session, recipe = Session(), Recipe((Partition(proxies=12),))
    before = session.replay(scan, recipe)
    faces = tuple(np.flatnonzero(before.face_region == before.face_region[50]).tolist())
    part = rcp.Partition(proxies=4, faces=faces)
    after = session.replay(scan, Recipe.from_json(recipe.then(part).to_json()))
    inside = np.isin(np.arange(scan.face_count), faces)
    assert len(set(after.face_region[inside])) == 4
    assert not set(after.face_region[inside]) & set(after.face_region[~inside])
    assert after.numbers["regions"] == 15
    np.testing.assert_array_equal(
        before.region_color[before.face_region[~inside]], after.region_color[after.face_region[~inside]]
    )
    alone = session.replay(scan, Recipe((part,)))
    assert set(np.flatnonzero(alone.face_region >= 0)) == set(faces)


def test_a_later_partition_keeps_locked_regions(quads):
    session, recipe = Session(), Recipe((PLAIN, rcp.PaintFaces(faces=STROKE, lock=True)))
    painted = session.replay(quads, recipe)
    color = painted.region_color[painted.face_region[100]]
    for settings in ({"proxies": 20}, {"proxies": 9}, {"detail": 0.02}, {"bound": 0.1}):
        after = session.replay(quads, recipe.then(rcp.AddWorst(times=2)).then(Partition(**settings)))
        assert np.flatnonzero(after.face_region == after.face_region[100]).tolist() == list(STROKE)
        assert after.numbers["locked"] == 1
        assert after.region_color[after.face_region[100]] == color
        assert after.numbers["regions"] == settings.get("proxies", after.numbers["regions"])
    twice = recipe.then(Partition(proxies=20)).then(Partition(proxies=9))
    assert (
        session.replay(quads, twice).face_region == session.replay(quads, recipe.then(Partition(proxies=9))).face_region
    ).all()


def test_a_bound_violated_by_polygons_makes_another_partition(quads, monkeypatch):
    monkeypatch.setattr(engine.within, "SLACK", 0.8)  # nearer than the regions' own planes have to be
    session, recipe = Session(), Recipe((Partition(bound=0.1),))
    loose, meshed = session.replay(quads, recipe), session.replay(quads, recipe.then(Mesh()))
    numbers = meshed.numbers
    assert numbers["scan_distance"] <= numbers["scan_distance_allowed"] == pytest.approx(0.08)
    assert numbers["regions_before"] == loose.numbers["regions"] < numbers["regions"]
    assert numbers["regions"] == meshed.partition.region_count == len(meshed.region_color)
    assert set(meshed.polygons.polygon_region) <= set(meshed.face_region)
    locked = recipe.then(rcp.LockRegions(faces=(0,)))  # by hand: all stay, and the report has the distance of the scan
    kept, by_hand = session.replay(quads, locked.then(Mesh())), session.replay(quads, locked)
    np.testing.assert_array_equal(kept.face_region, by_hand.face_region)
    assert kept.numbers["scan_distance"] > kept.numbers["scan_distance_allowed"]


def test_the_search_for_polygons_within_a_bound_shows_how_far_it_is_and_can_be_stopped(quads, monkeypatch):
    monkeypatch.setattr(engine.within, "SLACK", 0.8)
    session, recipe, watch, seen = Session(), Recipe((Partition(bound=0.1),)), Watch(), []
    session.replay(quads, recipe)
    real = engine.within.polygonize

    def polygonize(*args, **given):
        seen.append((watch.progress, watch.stage))
        if len(seen) == 3:
            watch.cancel()
        return real(*args, **given)

    monkeypatch.setattr(engine.within, "polygonize", polygonize)
    with pytest.raises(Stopped):
        session.replay(quads, recipe.then(Mesh()), watch)
    assert [stage for _, stage in seen] == ["meshing"] * 3
    shares = [share for share, _ in seen]
    assert 0 == shares[0] < shares[1] < shares[2] < 1  # the scan and its regions were there


def test_weights_and_borders_of_faces_are_those_of_the_command():
    vertices, triangles = shapes.room(16)
    low = vertices[triangles].mean(axis=1)[:, 2] < np.median(vertices[:, 2])
    scan = replace(scan_of(vertices, triangles), layers={"w": low.astype(np.float32), "b": low.astype(np.int32)})
    plain = Partition(proxies=30)
    for own, marks in (({"weights": "w"}, {"weights": 16.0**low}), ({"borders": "b"}, {"borders": low})):
        outcome = Session().replay(scan, Recipe((replace(plain, **own),)))
        assert outcome.repair.lengths.handles > 0
        made = engine.simplify((scan.vertices, triangles), recipe=json.loads(Recipe((plain,)).to_json()), **marks)
        np.testing.assert_array_equal(made.partition.face_region, outcome.partition.face_region)
