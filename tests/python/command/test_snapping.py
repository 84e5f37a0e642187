"""`--snap-sizes` and `--scale`: multiples of a step, and one known length, on parts with the noise of a scanner."""

import csv
import json

import numpy as np
import pytest

import isimp_engine as engine
import meshfiles
from bench.generators import round_shapes
from commands import called, check_line, ran
from isimp_engine import pipeline, reports
from isimp_engine import recipe as rcp
from isimp_engine.lengths import length_of
from isimp_engine.sizes import Measured
from isimp_engine.snapping import snap_sizes
from test_report import divided

NOISE = 0.001  # share of the diagonal


def bracket(seed=1, thick=12.4):
    """An L of 40 x 15, 6 and `thick` thick, whose upper end is at 30 degrees, turned by any angle."""
    top = 30 + thick * np.tan(np.radians(30))
    outline = [(0, 0), (thick, 0), (40, 0), (40, 6), (thick, 6), (thick, top), (0, 30), (0, 6)]
    corners = np.array([(x, y, z) for y in (0, 15) for x, z in outline], float)
    caps = [(0, 1, 4, 7), (1, 2, 3, 4), (7, 4, 5, 6)]
    faces = caps + [tuple(k + 8 for k in cap[::-1]) for cap in caps]
    faces += [(k, k + 8, (k + 1) % 8 + 8, (k + 1) % 8) for k in range(8)]
    triangles = np.array([(face[0], face[k], face[k + 1]) for face in faces for k in (1, 2)], np.int32)
    for _ in range(4):
        corners, triangles = divided(corners, triangles)
    random = np.random.default_rng(seed)
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    scanned = corners + random.normal(size=corners.shape) * NOISE * np.linalg.norm(np.ptp(corners, axis=0))
    return scanned @ turn.T + [100, 2000, -30], triangles


def lengths(rows):
    """Distances by their true values, to the tenth."""
    return {round(row.get("measured", row["value"]), 1): row for row in rows if row["kind"] == "distance"}


@pytest.mark.parametrize("seed", range(3))
def test_sizes_become_multiples_within_their_uncertainty_and_others_stay(seed):
    made = engine.simplify(bracket(seed), snap_sizes=1.0)
    rows = lengths(made.report["sizes"])
    for true in (6, 15, 40):
        assert rows[true]["snapped"] == "yes"
        assert rows[true]["value"] == pytest.approx(true, abs=1e-9)
        assert abs(rows[true]["measured"] - true) <= rows[true]["uncertainty"]
    for true in (12.4, 27.6):
        assert rows[true]["snapped"] == "no multiple is near"
        assert rows[true]["value"] == pytest.approx(true, abs=0.03)
    angles = {round(row["value"], 9) for row in made.report["sizes"] if row["kind"] == "angle"}
    assert 90 in angles
    assert angles & {60, 120}
    assert not any(angle % 5 for angle in angles)
    places = np.asarray(made.polygons.vertices)
    wide = [np.ptp(places @ np.asarray(made.partition.region_normal[row["of"]])) for row in (rows[15], rows[40])]
    assert wide == pytest.approx([15, 40], abs=1e-6)
    assert made.report["output"]["planarity_max"] < 1e-6
    part, triangles = made.partition, np.asarray(made.mesh.triangles)
    for region, (normal, offset) in enumerate(zip(part.region_normal, part.region_offset, strict=True)):
        middle = np.asarray(made.mesh.vertices)[triangles[part.face_region == region]].mean(axis=(0, 1))
        assert abs(normal @ middle - offset) < 0.03, "sloped planes turn about their middle"


def test_sizes_that_are_not_sure_enough_stay_with_the_reason():
    rows = engine.simplify(bracket(), snap_sizes=0.01).report["sizes"]
    reasons = {row["snapped"] for row in rows if row["kind"] == "distance"}
    assert reasons == {"its uncertainty is too large for the step"}


def test_round_parts_take_diameters_and_places():
    vertices, triangles = round_shapes.made(round_shapes.shapes()["plate"])
    scan = 10 * round_shapes.with_noise(vertices, 0.0005, 5), triangles
    made = engine.simplify(scan, curved=True, snap_sizes="1mm", unit="mm")
    rows = {row["name"]: row for row in made.report["sizes"]}
    parts = {part.number: part for part in made.partition.curved}
    snapped = [row for row in rows.values() if row["kind"] == "diameter" and row["snapped"] == "yes"]
    assert {round(row["value"]) for row in snapped} >= {7, 9}
    for row in snapped:
        assert 2 * parts[row["of"]].radius == row["value"] == round(row["value"])
    places = sorted(row["value"] for row in rows.values() if row["kind"] == "axis" and row["snapped"] == "yes")
    assert places == pytest.approx([7, 8, 9, 9, 11, 15, 15, 17, 18, 25, 31, 33], abs=1e-9)


def test_the_command_lists_what_moved(tmp_path):
    scan, out, report = tmp_path / "bracket.ply", tmp_path / "out.obj", tmp_path / "report.json"
    vertices, triangles = bracket()
    meshfiles.ply_binary(scan, vertices, triangles.tolist())
    done = ran("simplify", scan, out, "--snap-sizes", "1mm", "--unit", "mm", "--report", report)
    assert " (+-" in done.stdout
    assert "stays, no multiple is near" in done.stdout
    rows = json.loads(report.read_text())["sizes"]
    assert json.loads(report.read_text())["options"]["snap_sizes"] == 1
    ran("report", scan, tmp_path / "out", "--snap-sizes", "1")
    table = list(csv.DictReader((tmp_path / "out" / "sizes.csv").read_text().splitlines()))
    assert [row["value"] for row in table] == [repr(row["value"]) for row in rows]
    assert {row["snapped"] for row in table} == {row["snapped"] for row in rows}
    check_line(called("simplify", scan, out, "--snap-sizes", "1mm"), 2, "give --unit")
    check_line(called("simplify", scan, out, "--snap-sizes", "one", "--unit", "mm"), 2, "must be a length as 1mm")
    check_line(called("simplify", scan, out, "--snap-sizes", "1", "--bound", "1"), 2, "exclude each other")


def test_a_recipe_snaps_sizes_as_the_option_does():
    recipe = rcp.Recipe((rcp.Partition(), rcp.Regularise(snap_sizes=1.0))).then(rcp.Mesh())
    made = engine.simplify(bracket(), recipe=json.loads(recipe.to_json()))
    assert lengths(made.report["sizes"])[40]["value"] == pytest.approx(40, abs=1e-9)
    assert made.report["output"]["planarity_max"] < 1e-6


@pytest.mark.parametrize(
    ("text", "unit", "length"),
    [
        ("1mm", "mm", 1),
        (".5mm", "m", 0.0005),
        ("1/16in", "mm", 1.5875),
        ("2 cm", "mm", 20),
        (3, None, 3),
        ("0.25", "m", 0.25),
        (5e-05, None, 0.00005),
        ("1e-5", None, 0.00001),
        ("1E+2 mm", "m", 0.1),
        ("1e1/2e1in", "mm", 12.7),
        ("2.", "m", 2),
    ],
)
def test_lengths_are_read_as_people_write_them(text, unit, length):
    assert length_of(text, unit) == pytest.approx(length, rel=1e-12)


@pytest.mark.parametrize("text", ["", "mm", "-1mm", "0", "1/0in", "1 km", "nan", "inf", "1e999", "1e", "e3", "."])
def test_what_is_no_length_is_refused(text):
    with pytest.raises(ValueError, match="must be a length"):
        length_of(text, "mm")


def test_planes_are_held_where_a_caller_wants_them():
    mesh = engine.clean(*bracket())
    part = engine.regularise(mesh, engine.partition(mesh))
    again = snap_sizes(mesh, part, 1.0)
    assert np.array_equal(again.face_region, part.face_region)
    assert not np.array_equal(again.region_offset, part.region_offset)
    assert {row["snapped"] for row in reports.size_rows(mesh, again, 1.0)} >= {"yes", "no multiple is near"}


def test_of_two_planes_the_surer_one_moves_less():
    mesh = engine.clean(*bracket())
    part = snap_sizes(mesh, engine.regularise(mesh, engine.partition(mesh)), 1.0)
    planes, row = Measured(mesh, part).planes, lengths(reports.size_rows(mesh, part, 1.0))[6]
    pulls = [(planes.offset[r] - planes.normal[r] @ planes.mean[r]) / planes.shift(r) for r in (row["of"], row["to"])]
    assert pulls[0] == pytest.approx(pulls[1], rel=1e-6), "their normals are opposite"


def test_one_known_length_scales_the_model_and_its_report(tmp_path):
    vertices, triangles = bracket()
    name = lengths(engine.simplify((vertices, triangles)).report["sizes"])[40]["name"]
    for given in (name, "-".join(reversed(name.split("-")))):
        made = engine.simplify((vertices / 25.4, triangles), scale=f"{given}=4cm", unit="mm", snap_sizes="1mm")
        rows = lengths(made.report["sizes"])
        assert made.report["scale"]["factor"] == pytest.approx(25.4, rel=1e-3)
        assert [rows[true]["value"] for true in (6, 15, 40)] == pytest.approx([6, 15, 40], abs=1e-9)
        assert rows[12.4]["value"] == pytest.approx(12.4, abs=0.03)
    size = np.linalg.norm(np.ptp(np.asarray(made.polygons.vertices), axis=0))
    assert size == pytest.approx(np.linalg.norm(np.ptp(vertices, axis=0)), rel=0.02)
    scan, out = tmp_path / "bracket.ply", tmp_path / "out.obj"
    meshfiles.ply_binary(scan, vertices / 25.4, triangles.tolist())
    done = called("simplify", scan, out, "--scale", f"{name}=40")
    assert f"size {name} was 1.57" in done.stdout
    check_line(called("simplify", scan, out, "--scale", "98-99=40"), 2, "there is no length '98-99'", name)
    check_line(called("simplify", scan, out, "--scale", "40"), 2, "as 3-7=40mm")
    check_line(called("simplify", scan, out, "--scale", f"{name}=40", "--lods", "10,5"), 2, "exclude each other")


def test_a_scale_changes_lengths_of_options_too():
    vertices, triangles = bracket()
    with_tolerance = {"tolerance": 0.02, "leave_out": 0.001}
    before = engine.simplify((vertices / 25.4, triangles), **with_tolerance)
    name = lengths([row | {"measured": 25.4 * row["value"]} for row in before.report["sizes"]])[40]["name"]
    made = engine.simplify((vertices / 25.4, triangles), scale=f"{name}=40", **with_tolerance)
    assert made.report["options"]["tolerance"] == pytest.approx(25.4 * 0.02, rel=1e-3)
    assert made.partition.region_count == before.partition.region_count


def test_a_scale_of_a_mesh_is_refused_before_the_work(monkeypatch):
    mesh = engine.clean(*bracket())
    monkeypatch.setattr(pipeline, "Replay", None)
    with pytest.raises(engine.InvalidInput, match="a Mesh keeps its scale"):
        engine.simplify(mesh, scale="3-7=40")


@pytest.mark.parametrize("given", ["{a}", "{", "{a}=40", "{0}=40", "}=40"])
def test_a_wrong_scale_is_shown_as_it_was_given(given):
    with pytest.raises(engine.InvalidInput) as error:
        engine.simplify(bracket(), scale=given)
    assert f"'{given.partition('=')[0]}'" in str(error.value)
    assert str(error.value).startswith("scale")


def test_info_knows_the_result_of_a_scaled_scan(tmp_path):
    vertices, triangles = bracket()
    name = lengths(engine.simplify((vertices, triangles)).report["sizes"])[40]["name"]
    scan, report = tmp_path / "bracket.ply", tmp_path / "report.json"
    meshfiles.ply_binary(scan, vertices / 25.4, triangles.tolist())
    options = "--scale", f"{name}=40", "--bound", "0.02"
    expected = json.loads(called("info", scan, "--json", *options).stdout)["result"]
    called("simplify", scan, tmp_path / "out.obj", "--report", report, *options)
    made = json.loads(report.read_text())
    assert (expected["regions"], expected["polygons"]) == (made["regions"], made["output"]["polygons"])
    assert expected["partition"]["tolerance"] == made["partition"]["tolerance"]


@pytest.mark.parametrize(
    ("planes", "parts", "message"),
    [
        ([(99, (1, 0, 0), 0)], [], r"region must be in \[0, 8\), got 99"),
        ([(0, (2, 0, 0), 0)], [], "the plane of region 0 is none"),
        ([(0, (1, 0, 0), np.nan)], [], "the plane of region 0 is none"),
        ([], [(0, (0, 0, 0), (0, 0, 1), 1)], r"the round part must be in \[0, 0\), got 0"),
    ],
)
def test_planes_that_can_not_be_held_are_refused(planes, parts, message):
    mesh = engine.clean(*bracket())
    with pytest.raises(engine.InvalidInput, match=message):
        engine._core._hold_planes(mesh, engine.partition(mesh), planes, parts)
