"""An option means the same wherever a person gives it: in the command, a batch, Python, a recipe."""

import argparse
import json
import os
import re
from pathlib import Path

import numpy as np
import pytest

import isimp_engine as engine
import meshfiles
import shapes
from commands import called, check_line
from isimp_engine import batch
from isimp_engine.cli.command import parser
from isimp_engine.settings import OptionError
from isimp_engine.texturing.glb import contents

ROOT = Path(__file__).resolve().parents[3]
WORDS = re.compile(r"isimp (simplify|batch|tiles|report|colliders|info)((?: [^`|\n]*)?)")


@pytest.fixture
def box(tmp_path):
    meshfiles.ply_binary(tmp_path / "box.ply", *shapes.cube(6))
    return tmp_path / "box.ply"


def glb(path, change=lambda document: None, colors=None):
    """The cube as glTF with a material whose colour is a factor. change: of its JSON. colors: (4,) of all vertices."""
    vertices, triangles = shapes.cube(2)
    made = contents("cube", vertices, [triangles], np.tile([0.0, 0, 1], (len(vertices), 1)))
    (primitive,) = made.document["meshes"][0]["primitives"]
    primitive["extensions"], primitive["material"] = {}, 0
    made.document["materials"] = [{"pbrMetallicRoughness": {"baseColorFactor": [0.5, 1, 0, 1]}}]
    if colors is not None:
        wanted = np.tile(colors, (len(vertices), 1))
        primitive["attributes"]["COLOR_0"] = made.writer.array(wanted, "VEC4")
    change(made.document)
    path.write_bytes(made.glb(path))
    return path


@pytest.mark.parametrize("page", [*sorted((ROOT / "docs").glob("*.md")), ROOT / "README.md"], ids=lambda p: p.name)
def test_each_flag_that_a_page_names_is_one_of_its_command(page):
    commands = next(a for a in parser()._actions if isinstance(a, argparse._SubParsersAction)).choices
    flags = {name: {f for a in c._actions for f in a.option_strings} for name, c in commands.items()}
    for name, rest in WORDS.findall(page.read_text(encoding="utf-8")):
        assert set(re.findall(r"(?<![\w-])--[a-z][a-z-]+", rest)) <= flags[name], (name, rest)


def test_a_batch_takes_a_preset(tmp_path, box):
    glb(tmp_path / "look.glb")
    outcome = batch.run([box, tmp_path / "look.glb"], tmp_path / "out", options={"preset": "cad"}, format="glb")
    assert [row["why"] for row in outcome.rows] == [None, None]
    one = tmp_path / "one" / "look.glb"
    one.parent.mkdir()
    assert called("simplify", tmp_path / "look.glb", one, "--preset", "cad").returncode == 0
    assert (tmp_path / "out" / "look.glb").read_bytes() == one.read_bytes()
    assert engine.read_textured(one).has_texture


def test_options_come_before_those_of_a_preset(box):
    assert engine.simplify(box, preset="generated").report["options"]["meshing"]["planar"]
    made = engine.simplify(box, preset="generated", planar=False).report["options"]
    assert not made["meshing"]["planar"]


@pytest.mark.parametrize("flags", [("--convex",), ("--planar", "--planar-reach", "0.01")])
def test_options_of_meshing_have_flags(tmp_path, box, flags):
    assert called("simplify", box, tmp_path / "a.obj", *flags).returncode == 0


@pytest.mark.parametrize("unit", ["m", "mm", "cm", "um", "in", "ft"])
def test_the_unit_of_a_3mf_file_is_kept(tmp_path, box, unit):
    first, second = tmp_path / "a.3mf", tmp_path / "b.3mf"
    assert called("simplify", box, first, "--unit", unit).returncode == 0
    assert called("simplify", first, second).returncode == 0
    assert first.read_bytes() == second.read_bytes()
    assert called("simplify", first, tmp_path / "c.city.json").returncode == 0
    city = json.loads((tmp_path / "c.city.json").read_text())
    size = np.ptp(np.array(city["vertices"]) * city["transform"]["scale"], axis=0)
    assert size == pytest.approx(engine.lengths.UNITS[unit], rel=1e-6)


def test_colours_of_gltf_are_images_times_factors_and_of_vertices_times_factors(tmp_path):
    stored = engine.read_textured(glb(tmp_path / "a.glb", colors=[0.5, 0.25, 1, 1])).colors
    assert np.unique(stored.reshape(-1, 4), axis=0).tolist() == [[137, 137, 0, 255]]  # .25, .25 and 0 in sRGB

    def beside(document):  # a second primitive without colours of vertices
        (first,) = document["meshes"][0]["primitives"]
        second = first | {"attributes": {k: v for k, v in first["attributes"].items() if k != "COLOR_0"}}
        document["meshes"][0]["primitives"].append(second)

    colors = engine.read_textured(glb(tmp_path / "b.glb", beside, [1, 1, 1, 1])).colors
    assert np.unique(colors.reshape(-1, 4), axis=0).tolist() == [[188, 255, 0, 255]]


def test_images_do_not_matter_where_no_texture_is_kept(tmp_path):
    def image(document):
        document["images"] = [{"uri": "lost.png"}]
        document["textures"] = [{"source": 0}]
        document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {"index": 0}

    path = glb(tmp_path / "a.glb", image)
    assert called("simplify", path, tmp_path / "a.obj").returncode == 0
    assert called("info", path).returncode == 0
    check_line(called("simplify", path, tmp_path / "b.obj", "--texture"), 3, "lost.png")


def test_gltf_stands_at_its_centre(tmp_path):
    def centre(document):
        document["extensions"] = {"CESIUM_RTC": {"center": [4500000.0, 100.0, 200.0]}}
        document["extensionsRequired"] = ["CESIUM_RTC"]

    path = glb(tmp_path / "a.glb", centre)
    for vertices in (engine.read(path)[0], engine.read_textured(path).vertices):
        assert vertices.min(axis=0).round().tolist() == [4500000, 200, -100]


def test_a_mesh_without_area_has_no_round_parts(tmp_path):
    meshfiles.obj(tmp_path / "a.obj", np.zeros((3, 3)), [[0, 1, 2]])
    done = called("simplify", tmp_path / "a.obj", tmp_path / "b.obj", "--curved")
    assert "Traceback" not in done.stderr


@pytest.mark.skipif(os.name == "nt", reason="names are Unicode there")
@pytest.mark.parametrize("name", [b"\xff.obj", b"\xff.xml"])
def test_names_may_be_any_bytes(tmp_path, box, name):
    made = tmp_path / os.fsdecode(name)
    assert called("colliders", box, made).returncode == 0
    assert "\N{REPLACEMENT CHARACTER}" in made.read_text(encoding="utf-8")
    if made.suffix == ".obj":
        assert called("report", made, tmp_path / "report").returncode == 0


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"crs": -5}, "crs must be the number of an EPSG reference system, got -5"),
        ({"angle": "30"}, "angle must be in [0, 180], got '30'"),
        ({"keep_opening": [(1, 2)]}, "keep_opening must be a list of places (x, y, z), got [(1, 2)]"),
        ({"borders": np.full(432, np.nan)}, "borders: face 0 has no number"),
    ],
)
def test_wrong_values_are_named(box, options, text):
    with pytest.raises(OptionError, match=re.escape(text)):
        engine.simplify(box, **options)


def test_a_report_has_no_texture(tmp_path, box):
    check_line(called("report", box, tmp_path / "r", "--texture", 64), 2, "--texture: a report has no texture")


class Runs:
    """Makes a folder where it is unpickled."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return os.mkdir, (str(self.path),)


def test_a_file_of_weights_runs_nothing(tmp_path, box):
    np.save(tmp_path / "w.npy", np.array([Runs(tmp_path / "made")], dtype=object))
    done = called("simplify", box, tmp_path / "a.obj", "--weights", tmp_path / "w.npy")
    check_line(done, 2, "w.npy: is not a .npy file of numbers")
    assert not (tmp_path / "made").exists()
