"""Regions and corners that mirror as the scan does."""

import copy
import json
import pickle
import re

import numpy as np
import pytest

import isimp_engine as engine
import shapes
from isimp import messages
from isimp_engine import cli, recipes
from polygon_judge import judge


@pytest.fixture(scope="module")
def mesh():
    return engine.Mesh(*shapes.figure(48, noise=0.001))


@pytest.fixture(scope="module")
def part(mesh):
    return engine.partition(mesh, engine.PartitionOptions(proxies=100, symmetry="found"))


def test_the_report_has_the_plane(part):
    plane = part.symmetry
    assert np.allclose(plane["normal"], [1, 0, 0], atol=0.01)
    assert plane["offset"] == pytest.approx(0, abs=0.01)
    assert 0 < plane["mismatch_mean"] < plane["mismatch"] < 0.02
    assert 0.9 * part.region_count <= plane["regions"] <= part.region_count
    assert part.report["symmetry"] == plane


def test_without_symmetry_there_is_no_plane(mesh):
    plain = engine.partition(mesh, engine.PartitionOptions(proxies=100))
    assert plain.symmetry is None
    assert engine.polygonize(mesh, plain).report["mirrored_corners"] == 0


def test_corners_lie_at_the_images_of_others(mesh, part):
    polygons = engine.polygonize(mesh, part)
    normal, offset = np.array(part.symmetry["normal"]), part.symmetry["offset"]
    image = polygons.vertices - 2 * np.outer(polygons.vertices @ normal - offset, normal)
    distance = np.linalg.norm(image[:, None] - polygons.vertices, axis=2).min(axis=1)
    exact = int((distance < 1e-9).sum())
    assert polygons.report["mirrored_corners"] == exact
    assert exact >= 0.8 * len(polygons.vertices)


@pytest.mark.parametrize("proxies", [20, 100, 300])
def test_an_independent_judge_finds_no_defect(mesh, proxies):
    part = engine.partition(mesh, engine.PartitionOptions(proxies=proxies, symmetry="x"))
    polygons = engine.polygonize(mesh, part)
    verdict, _ = judge(polygons, mesh, part, outlined=True)  # corners within reach of their vertices too
    assert verdict.sound, vars(verdict)


def test_a_part_of_one_region_across_the_plane_keeps_its_polygon():
    vertices, triangles = shapes.figure()
    patch, faces = shapes.plane(8)
    x, y, _ = ((patch - [0.5, 0.5, 0]) * [0.8, 0.3, 0]).T
    patch = np.stack([x, y, 1.4 + 0.02 * np.sin(9 * y)], axis=1)
    mesh = engine.Mesh(*shapes.joined((vertices, triangles), (patch, faces)))
    part = engine.partition(mesh, engine.PartitionOptions(proxies=60, symmetry="x", leave_out=0))
    polygons = engine.polygonize(mesh, part)
    assert set(polygons.polygon_region) == set(range(part.region_count))


def test_the_number_needed_counts_the_pieces_that_the_plane_makes():
    rows = [(x, 2 * row) for row in range(12) for x in range(-4, 4)]
    turns = [(3 if row % 2 else -4, 2 * row + 1) for row in range(11)]
    halves = np.array([[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]]])
    corners = (np.array(rows + turns)[:, None, None] + halves).reshape(-1, 2)
    mesh = engine.Mesh(
        *shapes.welded(np.pad(corners, ((0, 0), (0, 1))).astype(float), np.arange(len(corners)).reshape(-1, 3))
    )
    part = engine.partition(mesh, engine.PartitionOptions(proxies=2, symmetry="x"))
    assert part.proxies_needed == part.region_count >= 6


def test_the_plane_is_kept_by_copies_and_edits(mesh, part):
    for same in (pickle.loads(pickle.dumps(part)), copy.deepcopy(part)):  # noqa: S301
        assert same.symmetry == part.symmetry
    edited = engine.delete_proxy(mesh, part, 50)
    assert edited.symmetry == part.symmetry | {"regions": None}
    again = engine.partition_from(mesh, part.face_region, before=part)
    assert again.symmetry == part.symmetry


def test_a_scan_that_does_not_mirror_is_refused(tmp_path, capsys):
    mesh = engine.Mesh(*shapes.figure(lump=1.2))
    found = engine.partition(mesh, engine.PartitionOptions(proxies=300, symmetry="found"))
    assert found.symmetry is None
    with pytest.raises(engine.InvalidInput, match="does not mirror across z: a tenth of it is more than") as refused:
        engine.partition(mesh, engine.PartitionOptions(proxies=300, symmetry="z"))
    told = messages.reason(str(refused.value), lambda length: f"{100 * length:.0f} cm")
    assert re.fullmatch(r"the scan does not mirror across Z: a tenth of it is \d+ cm off, allowed \d+ cm", told)
    with pytest.raises(engine.InvalidInput) as refused:
        engine.partition(mesh, engine.PartitionOptions(bound=0.1, symmetry="z"))
    assert messages.reason(str(refused.value)).startswith("symmetry can't be had with a bound: choose another way")
    scan = tmp_path / "scan.ply"
    engine.write(scan, engine.polygonize(mesh, found))
    assert cli.main(["simplify", str(scan), str(tmp_path / "out.ply"), "--symmetry", "z", "--proxies", "20"]) == 2
    assert "does not mirror across z" in capsys.readouterr().err


@pytest.mark.parametrize("flag", ["x", "found"])
def test_the_command_reports_it(tmp_path, capsys, flag):
    scan, report = tmp_path / "scan.obj", tmp_path / "report.json"
    vertices, triangles = shapes.figure()
    rows = [f"v {x} {y} {z}" for x, y, z in vertices] + [f"f {a} {b} {c}" for a, b, c in triangles + 1]
    scan.write_text("\n".join(rows) + "\n")
    given = ["simplify", str(scan), str(tmp_path / "out.ply"), "--proxies", "80", "--symmetry", flag]
    assert cli.main([*given, "--report", str(report)]) == 0
    told = json.loads(report.read_text())
    assert told["options"]["symmetry"] == flag
    assert abs(told["partition"]["symmetry"]["normal"][0]) > 0.99
    corners, all_ = told["output"]["mirrored_corners"], told["output"]["vertices"]
    assert f"mirrors across x: {told['partition']['symmetry']['regions']} of 80 regions" in capsys.readouterr().out
    assert corners >= 0.8 * all_


def test_the_command_reports_a_missing_plane(tmp_path, capsys):
    vertices, triangles = shapes.figure(lump=1.2)
    scan = tmp_path / "scan.obj"
    rows = [f"v {x} {y} {z}" for x, y, z in vertices] + [f"f {a} {b} {c}" for a, b, c in triangles + 1]
    scan.write_text("\n".join(rows) + "\n")
    assert cli.main(["simplify", str(scan), str(tmp_path / "out.ply"), "--proxies", "300", "--symmetry", "found"]) == 0
    assert "no mirror plane found" in capsys.readouterr().out


def test_a_recipe_may_request_it():
    steps = [{"step": "partition", "proxies": 80, "symmetry": "y"}]
    assert recipes.options_of(recipes.parsed({"isimp_recipe": 1, "steps": steps}))["symmetry"] == "y"
    with pytest.raises(recipes.RecipeError, match="symmetry"):
        recipes.parsed({"isimp_recipe": 1, "steps": [{"step": "partition", "symmetry": "w"}]})
