"""Recipes of the add-on, applied to files by the command and by batches."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import isimp_engine as engine
import meshfiles
from bench.generators import houses
from isimp_engine import batch, recipes
from isimp_engine.cli import main
from isimp_engine.settings import settings_of

steps = pytest.importorskip("isimp.recipe.steps")
rcp = pytest.importorskip("isimp.recipe")

MESH = {"step": "mesh"}


def recipe(*given):
    return recipes.parsed(json.loads(rcp.Recipe(given).to_json()))


def options(*given):
    return recipes.options_of(recipe(*given))


def read(*values):
    return recipes.parsed({"isimp_recipe": 1, "steps": list(values)})


def test_what_the_add_on_writes_is_read():
    wanted = rcp.Partition(proxies=30, noise=0.01, angle=40.0, smooth=0.25), rcp.Improve(), rcp.AddWorst(times=3)
    given = (*wanted, rcp.DeleteLeast(times=2, enabled=False), rcp.Mesh(flatten=7))
    found = options(*given)
    assert (found["proxies"], found["smooth"], found["noise"], found["angle"]) == (30, 0.25, 0.01, 40)
    assert not {"detail", "tolerance", "bound"} & found.keys()
    assert found["flatten"] == 7
    steps = [step for _, step in recipe(*given).active()]
    assert [(step.kind, getattr(step, "times", None)) for step in steps[1:3]] == [("improve", None), ("add_worst", 3)]
    assert "noise" not in options(rcp.Partition()), "below 0: estimated"
    assert options(rcp.Partition(proxies=5), rcp.AddWorst(), rcp.Partition(proxies=6))["proxies"] == 6


def test_every_preset_of_the_add_on_can_be_used():
    presets = pytest.importorskip("isimp.recipe.presets").PRESETS
    assert len(presets) > 3
    for preset in presets:
        settings_of({}, recipe(*preset.recipe.steps))


def test_recipes_of_earlier_versions_keep_their_meaning():
    found = recipes.options_of(read({"step": "partition", "proxies": 9, "seed": 1, "leave_out": 0.001}, MESH))
    assert (found["smooth"], found["metric"], found["stitch"], found["keep_openings"]) == (0.0, "normals", 0.0, True)


def test_a_setting_that_people_leave_out_has_the_default_of_the_engine():
    found = settings_of({}, read({"step": "partition", "proxies": 9}, MESH))
    assert found.partition.as_dict() == engine.PartitionOptions(proxies=9).as_dict()
    assert found.meshing.as_dict() == engine.MeshingOptions().as_dict()
    assert found.clean.as_dict() == engine.CleanOptions().as_dict()
    assert rcp.step_from_dict({"step": "partition"}).adaptivity == 0, "in the add-on too"
    assert rcp.Partition().adaptivity == 0.25, "the panel's default"


def test_a_texture_step_keeps_the_texture():
    assert "texture" not in options(rcp.Partition(), rcp.Mesh())
    assert options(rcp.Partition(), rcp.Mesh(), rcp.Texture())["texture"] == 0
    assert options(rcp.Partition(), rcp.Mesh(), rcp.Texture(size=64))["texture"] == 64
    assert "texture" not in options(rcp.Partition(), rcp.Mesh(), rcp.Texture(enabled=False))
    assert "texture" not in options(rcp.Partition(), rcp.Mesh(), rcp.Texture(), rcp.Partition()), "polygons go with it"


def test_every_step_is_done():
    """A step that is added to the add-on must be applied in the engine's package."""
    kinds = set(steps.KINDS.values())
    assert kinds == set(engine.replay.EDITS) | {"partition", "mesh", "texture"}


def test_regularise_is_read_with_its_settings():
    def regular(**settings):
        return recipes.regularise_options(recipe(rcp.Partition(), rcp.Regularise(**settings)))

    found = regular(angle=5.0, length=0.2, direction=(0.0, 2.0, 0.0))
    assert (found.angle, found.length, found.up) == (5.0, 0.2, "z")
    assert regular().as_dict() == engine.RegulariseOptions().as_dict()
    assert regular(up="y").up == "y"
    assert regular(up="none").up == "none"
    assert regular(enabled=False) is None


def test_the_command_and_batches_regularise_as_a_recipe_says(tmp_path):
    house = houses.make(0.002, 3)
    path, scan, out, report = (tmp_path / name for name in ("r.json", "house.obj", "out.obj", "report.json"))
    meshfiles.obj(scan, house.vertices, house.triangles)
    path.write_text(
        rcp.Recipe((rcp.Partition(proxies=110), rcp.Regularise(angle=6.0), rcp.Mesh(planar=True))).to_json()
    )
    assert main(["simplify", str(scan), str(out), "--recipe", str(path), "--report", str(report), "--quiet"]) == 0
    found = json.loads(report.read_text())
    assert found["options"]["regularise"]["angle"] == 6.0
    assert found["partition"]["directions"] < 20
    assert found["output"]["planar"] is True

    mesh = engine.clean(*engine.read(scan))
    part = engine.partition(mesh, engine.PartitionOptions(proxies=110, adaptivity=0.25))
    part = engine.regularise(mesh, part, engine.RegulariseOptions(angle=6.0))
    poly = engine.polygonize(mesh, part, engine.MeshingOptions(planar=True, join_junctions=rcp.Mesh().join_junctions))
    np.testing.assert_array_equal(engine.reading.read_polygons(out)[1], poly.loops)

    outcome = batch.run(scan, tmp_path / "models", recipe=path, format="obj")
    assert outcome.rows[0]["polygons"] == len(poly.loop_start)
    assert (tmp_path / "models" / "house.obj").read_bytes() == out.read_bytes()
    flag = ["--regularise", "4", "--report", str(report), "--quiet"]
    assert main(["simplify", str(scan), str(out), "--recipe", str(path), *flag]) == 0
    assert json.loads(report.read_text())["options"]["regularise"]["angle"] == 4.0, "the flag comes first"


def test_a_recipe_saved_with_a_byte_order_mark_is_read(tmp_path):
    own = recipe(rcp.Partition(proxies=7), rcp.Mesh())
    (tmp_path / "r.json").write_text(own.to_json(), encoding="utf-8-sig")
    assert recipes.recipe_of(tmp_path / "r.json") == own


@pytest.mark.parametrize(
    ("steps", "words"),
    [
        ([], "no partition step"),
        ([3], "step 1: not a step: 3"),
        ([{"step": "improve"}], "step 1: there are no regions yet"),
        ([{"step": "partition", "faces": [1]}], "step 1: there are no regions yet"),
        ([{"step": "partition", "sharp": True}], "step 1: 'sharp' needs marks of an object"),
        ([{"step": "partition", "weights": "w"}], "step 1: 'weights' needs marks of an object"),
        ([{"step": "partition"}, {"step": "texture"}], "step 2: there are no polygons yet"),
    ],
)
def test_a_recipe_that_no_file_can_follow_has_a_reason(steps, words):
    with pytest.raises(recipes.RecipeError, match=words):
        read(*steps)


def test_the_command_does_the_steps(scan, tmp_path):
    given = (rcp.Partition(proxies=10), rcp.AddWorst(times=2), rcp.Improve(), rcp.Mesh(flatten=5, join_junctions=0.0))
    path, out, report = tmp_path / "r.json", tmp_path / "out.ply", tmp_path / "report.json"
    path.write_text(rcp.Recipe(given).to_json())
    command = [sys.executable, "-m", "isimp_engine", "simplify", scan, out, "--recipe", path, "--report", report]
    environment = {"PYTHONPATH": str(Path(engine.__file__).parents[1])}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=60)
    assert (done.returncode, done.stderr) == (0, "")

    mesh = engine.clean(*engine.read(scan))
    part = engine.partition(mesh, engine.PartitionOptions(proxies=10, adaptivity=0.25))
    part = engine.improve(mesh, engine.add_worst(mesh, part, 2))
    poly = engine.polygonize(mesh, part, engine.MeshingOptions(flatten=5, join_junctions=0.0))
    assert len(np.unique(part.face_region)) == 12
    for written, expected in zip(
        engine.reading.read_polygons(out), (poly.vertices, poly.loops, poly.loop_start), strict=True
    ):
        np.testing.assert_array_equal(written, expected)
    said = json.loads(report.read_text())
    assert said["regions"] == 12
    assert said["options"]["recipe"] == json.loads(path.read_text())

    outcome = batch.run(scan, tmp_path / "models", recipe=path, format="ply")
    assert outcome.rows[0]["regions"] == 12
    assert (tmp_path / "models" / "scan.ply").read_bytes() == out.read_bytes()


def test_options_that_are_given_come_before_the_recipe(scan, tmp_path):
    values = json.loads(rcp.Recipe((rcp.Partition(detail=0.5, seed=4), rcp.Mesh())).to_json())
    outcome = batch.run(scan, tmp_path / "out", recipe=values, options={"proxies": 9}, reports=True)
    assert outcome.rows[0]["regions"] == 9
    said = json.loads((tmp_path / "out" / "scan.report.json").read_text())["options"]
    assert (said["proxies"], said["detail"], said["seed"]) == (9, None, 4)
    assert batch.run(scan, tmp_path / "out", recipe=values, reports=True).before == 0, "other options are other work"


def test_a_recipe_in_a_file_that_is_wrong_names_the_file(scan, tmp_path):
    path = tmp_path / "r.json"
    for text, words in [
        ("{", "is not JSON"),
        ("[" * 100_000, "its brackets are nested too deeply"),
        ('{"isimp_recipe": 1}', "'steps' must be a list"),
    ]:
        path.write_text(text)
        with pytest.raises(recipes.RecipeError, match=words) as error:
            recipes.read(path)
        assert str(error.value).startswith(f"{path}: ")
    path.write_bytes(b"\xff\xfe")
    with pytest.raises(batch.BatchError, match="is not JSON"):
        batch.run(scan, tmp_path / "out", recipe=path)
