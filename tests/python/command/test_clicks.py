"""Clicks of recipes, as the add-on makes them, done by the command: on their scan and on other versions of it."""

import json
from dataclasses import replace

import numpy as np
import pytest

import isimp_engine as engine
import meshfiles
import shapes
from bench.generators import houses
from isimp import recipe as rcp
from isimp.session import Session, StepFailed, with_places
from isimp_engine.cli import main
from session_scans import scan_of

SCANS = {
    "bumpy": lambda: shapes.bumpy(24),
    "room": lambda: shapes.room(16),
    "torus": lambda: shapes.torus(40, 20),
    "house": lambda: (lambda house: (house.vertices, house.triangles))(houses.make(0.002, 3)),
}


def drawn(kind, random, scan, session, recipe):
    """A step of this kind at random faces that can be done after a recipe; None if there is none in ten tries."""
    cls = next(cls for cls, name in rcp.KINDS.items() if name == kind)
    names = set(cls.__dataclass_fields__)
    outcome = session.replay(scan, recipe)
    for _ in range(10):
        one, other = (int(face) for face in random.choice(np.flatnonzero(outcome.face_region >= 0), 2))
        settings = {"face": one, "other": other} if "other" in names else {"face": one} if "face" in names else {}
        if kind == "merge_regions":
            beside = scan.face_edges[0][outcome.border]
            settings = dict(zip(("face", "other"), map(int, random.choice(beside)), strict=True))
        if "faces" in names:
            region = outcome.face_region == outcome.face_region[one]
            settings = {"faces": (one, *np.flatnonzero(region)[: 1 if kind == "align" else 9].tolist())}
        if kind == "cut_region":
            middle = scan.vertices[scan.triangles[one]].mean(0).astype(float)
            settings["line"] = (tuple(middle - [9, 9, 9]), tuple(middle + [9, 9, 9.5]))
        if kind in ("regularise", "align"):
            settings.pop("face", None)
        try:
            session.replay(scan, recipe.then(cls(**settings)))
        except StepFailed:
            continue
        return cls(**settings)
    return None


def clicked(scan, kinds, seed=5):
    """A recipe with a step of each kind that can be done."""
    random, session = np.random.default_rng(seed), Session()
    recipe = rcp.Recipe((rcp.Partition(proxies=30, adaptivity=0.0),))
    for kind in kinds:
        step = drawn(kind, random, scan, session, recipe)
        if step is not None:
            recipe = recipe.then(step)
    return session, recipe.then(rcp.Mesh())


def exported(recipe, scan):
    return with_places(scan, recipe).to_json()


def simplified(folder, scan, recipe, *flags):
    """The polygons and the report of the command."""
    (folder / "recipe.json").write_text(recipe)
    out, report = folder / "o.ply", folder / "r.json"
    recipe = ["--recipe", str(folder / "recipe.json"), *flags]
    status = main(["simplify", str(scan), str(out), "--report", str(report), "--quiet", *recipe])
    return (engine.reading.read_polygons(out), json.loads(report.read_text())) if status == 0 else None


KINDS = [kind for kind in rcp.KINDS.values() if kind not in ("partition", "mesh", "texture")]


@pytest.mark.parametrize("name", SCANS)
def test_clicks_on_their_own_scan_make_the_add_ons_polygons(tmp_path, name):
    scan = scan_of(*SCANS[name]())
    session, recipe = clicked(scan, KINDS)
    done = {rcp.KINDS[type(step)] for step in recipe.steps}
    assert len(done & set(KINDS)) >= 17, sorted(set(KINDS) - done)
    wanted = session.replay(scan, recipe).polygons
    meshfiles.ply_binary(tmp_path / "scan.ply", scan.vertices, scan.triangles.tolist())
    for text in (exported(recipe, scan), recipe.to_json()):
        polygons, report = simplified(tmp_path, tmp_path / "scan.ply", text)
        for written, expected in zip(polygons, (wanted.vertices, wanted.loops, wanted.loop_start), strict=True):
            np.testing.assert_array_equal(written, expected)
        assert report["clicks"] == {"by": "place" if "places" in json.loads(text) else "number", "lost": []}


def test_locks_and_parts_are_kept_as_in_the_add_on(tmp_path):
    scan = scan_of(*shapes.bumpy(24))
    session, first = Session(), rcp.Recipe((rcp.Partition(proxies=20),))
    chosen = np.flatnonzero(session.replay(scan, first).face_region == 3)
    steps = (
        rcp.LockRegions(faces=(int(chosen[0]),)),
        rcp.Partition(proxies=40),
        rcp.Partition(proxies=5, faces=(7, 8, 9)),
    )
    recipe = first.then(steps[0]).then(steps[1]).then(replace(steps[2], faces=tuple(range(60, 200)))).then(rcp.Mesh())
    assert len(recipe.steps) == 5
    wanted = session.replay(scan, recipe).polygons
    meshfiles.ply_binary(tmp_path / "scan.ply", scan.vertices, scan.triangles.tolist())
    polygons, _ = simplified(tmp_path, tmp_path / "scan.ply", exported(recipe, scan))
    np.testing.assert_array_equal(polygons[0], wanted.vertices)
    np.testing.assert_array_equal(polygons[1], wanted.loops)


def test_clicks_act_at_their_places_of_another_version_of_the_scan(tmp_path):
    """The coarser version has a quarter of the faces, in another order."""
    fine, (vertices, triangles) = scan_of(*shapes.bumpy(40)), shapes.bumpy(20)
    order = np.random.default_rng(1).permutation(len(triangles))
    meshfiles.ply_binary(tmp_path / "coarse.ply", vertices, triangles[order].tolist())
    random = np.random.default_rng(2)
    surface = fine.source.surface
    coarse = engine.source.source_of(tmp_path / "coarse.ply").surface
    part = engine.simplify(tmp_path / "coarse.ply", proxies=30).labels
    right = 0
    for face in random.integers(0, fine.face_count, 100):
        recipe = rcp.Recipe((rcp.Partition(), rcp.AddProxy(face=int(face))))
        given = engine.recipes.parsed(json.loads(exported(recipe, fine)))
        moved, lost = engine.replay.placed(given, coarse)
        assert lost == []
        point = surface.middles(np.array([face]))[0][0]
        wanted = np.argmin(np.linalg.norm(coarse.middles(np.arange(coarse.count))[0] - point, axis=1))
        right += part[moved.steps[1].face] == part[wanted]
    assert right >= 95
    _, recipe = clicked(fine, ("add_proxy", "split_region", "paint", "merge_regions", "lock"))
    polygons, report = simplified(tmp_path, tmp_path / "coarse.ply", exported(recipe, fine))
    assert len(polygons[2]) > 25
    assert len(report["clicks"]["lost"]) <= 1


def test_a_stroke_covers_the_finer_faces_of_another_version():
    coarse, fine = scan_of(*shapes.bumpy(20)), shapes.bumpy(40)
    chosen = np.flatnonzero(np.linalg.norm(coarse.vertices[coarse.triangles].mean(1), axis=1) < 0.5)
    recipe = rcp.Recipe((rcp.Partition(), rcp.PaintFaces(faces=tuple(chosen.tolist()))))
    given = engine.recipes.parsed(json.loads(exported(recipe, coarse)))
    moved, _ = engine.replay.placed(given, engine.source.source_of(fine).surface)
    assert len(moved.steps[1].faces) > 2.5 * len(chosen)


def test_the_same_scan_in_other_coordinates_has_the_same_faces(tmp_path):
    """As a scan that Blender keeps near zero and upright, and its file does not."""
    scan = scan_of(*shapes.bumpy(24))
    recipe = rcp.Recipe((rcp.Partition(proxies=20), rcp.AddProxy(face=5), rcp.PaintFaces(faces=(900, 901)), rcp.Mesh()))
    given = rcp.Recipe.from_json(exported(recipe, scan))
    far = scan_of(scan.vertices[:, [0, 2, 1]] * np.array([1000, -1000, 1000]) + 5e4, scan.triangles)
    assert engine.replay.placed(given, far.source.surface) == (recipe, [])
    other = scan_of(far.vertices * np.array([1, 1, 3]), far.triangles)
    assert engine.replay.placed(given, other.source.surface)[1] == [1, 2]


def test_places_are_written_on_one_line():
    scan = scan_of(*shapes.bumpy(24))
    recipe = rcp.Recipe((rcp.Partition(proxies=20), rcp.PaintFaces(faces=tuple(range(99)))))
    surface = scan.source.surface
    recipe = replace(recipe, places=rcp.Places(*engine.replay.places_of(recipe, surface)))
    for indent in (None, 2):
        text = recipe.to_json(indent)
        assert json.loads(text) == json.loads(json.dumps(recipe.to_values()))
        again = rcp.Recipe.from_json(text)
        assert (again, again.places) == (recipe, recipe.places)


def test_a_click_without_a_face_is_named_and_left_out(tmp_path, capsys):
    scan = scan_of(*shapes.bumpy(24))
    clicks = rcp.AddProxy(face=5), rcp.AddProxy(face=900), rcp.AddProxy(face=5, enabled=False)
    recipe = rcp.Recipe((rcp.Partition(proxies=20), *clicks, rcp.Mesh()))
    values = json.loads(exported(recipe, scan))
    values["places"]["points"][0] = [9.0, 9.0, 9.0]
    meshfiles.ply_binary(tmp_path / "scan.ply", scan.vertices, scan.triangles.tolist())
    _, report = simplified(tmp_path, tmp_path / "scan.ply", json.dumps(values))
    assert report["regions"] == 21
    (lost,) = report["clicks"]["lost"]
    assert (lost["step"], lost["kind"]) == (2, "add_proxy")
    assert "no face of this scan is near" in lost["why"]
    assert simplified(tmp_path, tmp_path / "scan.ply", json.dumps(values), "--strict") is None
    assert "step 2: no face of this scan is near" in capsys.readouterr().err
    (tmp_path / "recipe.json").write_text(json.dumps(values))
    arguments = ["simplify", tmp_path / "scan.ply", tmp_path / "o.ply", "--recipe", tmp_path / "recipe.json"]
    assert main([str(argument) for argument in arguments]) == 0
    assert "warning: step 2 of the recipe, add_proxy, is left out" in capsys.readouterr().out
    with pytest.raises(engine.InvalidInput, match="step 2"):
        engine.simplify(tmp_path / "scan.ply", recipe=values, strict=True)


def test_a_click_that_can_not_be_done_is_named_and_left_out():
    """Face 1 has no area, so the repair drops it; the last step names a face that the scan lacks."""
    vertices, triangles = shapes.bumpy(12)
    triangles[1] = triangles[0][[0, 0, 1]]
    steps = [
        rcp.Partition(proxies=9),
        rcp.AddProxy(face=1),
        rcp.Partition(proxies=3, faces=(1,)),
        rcp.AddProxy(face=999),
    ]
    values = rcp.Recipe((*steps, rcp.AddProxy(face=40), rcp.AddProxy(face=1, enabled=False))).to_values()
    made = engine.simplify((vertices, triangles), recipe=values)
    assert made.partition.region_count == 10
    lost = made.report["clicks"]["lost"]
    assert [each["step"] for each in lost] == [2, 3, 4]
    assert "face 1 was left out by the repair" in lost[0]["why"]
    assert "there is no face 999" in lost[2]["why"]
    with pytest.raises(engine.InvalidInput, match="step 2: face 1 was left out"):
        engine.simplify((vertices, triangles), recipe=values, strict=True)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"points": [[0, 0]]}, "3 numbers"),
        ({"points": []}, "a point, a normal and a width for each"),
        ({"size": "big"}, "size must be a list of numbers"),
        ({"more": 1}, "places must have size, count, faces, points, normals, widths"),
        ({"size": -1}, "size must be at least 0"),
    ],
)
def test_places_that_are_wrong_are_refused(change, words):
    places = {"size": 1.0, "count": 9, "faces": [5], "points": [[0, 0, 0]], "normals": [[0, 0, 1]], "widths": [0.1]}
    values = {"isimp_recipe": 1, "steps": [{"step": "partition"}], "places": places | change}
    with pytest.raises(rcp.RecipeError, match=words):
        rcp.Recipe.from_values(values)
    with pytest.raises(engine.recipes.RecipeError):
        engine.recipes.parsed(values)
