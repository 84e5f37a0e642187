"""The estimate of the number of polygons before they are made."""

import json

import numpy as np
import pytest

import isimp_engine as engine
import meshfiles
import shapes
from commands import called
from isimp import messages, stored
from isimp import recipe as rcp
from isimp.session import Session
from session_scans import scan_of

REASONS = ("unconnected", "pinches", "holes", "handles", "closed", "repair")


def foreseen(mesh, **options):
    part = engine.partition(mesh, engine.PartitionOptions(**options))
    return engine.regions.expected_polygons(mesh, part), engine.polygonize(mesh, part).report


@pytest.mark.parametrize("proxies", [30, 60, 120])
def test_a_room_with_tunnels_gets_about_the_expected_number_and_handles_are_named(proxies):
    expected, made = foreseen(engine.clean(*shapes.room(16)), proxies=proxies)
    assert expected["polygons"] == pytest.approx(made["polygons"], rel=0.3)
    assert expected["polygons"] > expected["regions"]
    assert expected["split_for_holes"] + expected["split_for_handles"] > 0
    assert expected["polygons"] == expected["regions"] + sum(expected[f"split_for_{name}"] for name in REASONS)


def test_the_report_has_it_and_info_can_leave_the_meshing_out(tmp_path):
    vertices, triangles = shapes.bumpy(40)
    meshfiles.ply_binary(tmp_path / "scan.ply", vertices, triangles.tolist())
    done = called("simplify", tmp_path / "scan.ply", tmp_path / "o.ply", "--report=-", "--proxies=50")
    report = json.loads(done.stdout)
    assert report["expected"]["polygons"] == pytest.approx(report["output"]["polygons"], rel=0.15)
    done = called("info", tmp_path / "scan.ply", "--json", "--estimate", "--proxies=50")
    result = json.loads(done.stdout)["result"]
    assert (result["polygons"], result["estimated"]) == (report["expected"]["polygons"], True)
    assert result["expected"] == report["expected"]
    said = called("info", tmp_path / "scan.ply", "--estimate", "--proxies=50").stdout
    assert f"would become about {report['expected']['polygons']} polygons of 50 regions" in said
    exact = json.loads(called("info", tmp_path / "scan.ply", "--json", "--proxies=50").stdout)["result"]
    assert (exact["polygons"], exact["estimated"]) == (report["output"]["polygons"], False)


def test_the_panel_shows_the_estimate_until_the_polygons_exist():
    session, scan = Session(), scan_of(*shapes.room(16))
    steps = rcp.Recipe((rcp.Partition(proxies=30, close_openings=False),))
    numbers = session.replay(scan, steps).numbers
    said = messages.expected(numbers)
    assert said.startswith(f"Mesh will make about {numbers['expected']['polygons']} polygons, ")
    assert "more than regions: " in said
    kept = stored.numbers_from(json.dumps({name: value for name, value in numbers.items() if name != "scan"}))
    assert messages.expected(kept) == said
    assert messages.expected(session.replay(scan, steps.then(rcp.Mesh())).numbers) == ""
    assert messages.expected({}) == messages.expected({"expected": {"polygons": 3}}) == ""


def test_the_preview_takes_the_place_of_the_estimate():
    numbers = {"regions": 200, "expected": {"polygons": 206, "regions": 200, "holes": 6}}
    preview = {"polygons": 201, "regions": 200, "split": {"split_for_holes": 1}}
    assert messages.expected(numbers).startswith("Mesh will make about 206 polygons, 6 more than regions")
    assert messages.expected(numbers, {}) == messages.expected(numbers)
    assert messages.expected(numbers, preview) == "Mesh will make 201 polygons, 1 more than regions: 1 with holes"
    assert messages.expected(numbers | {"polygons": 201}, preview) == ""


def test_it_does_not_depend_on_the_order_of_faces():
    vertices, triangles = shapes.bumpy(40)
    mesh = engine.clean(vertices, triangles)
    part = engine.partition(mesh, engine.PartitionOptions(proxies=40))
    order = np.random.default_rng(2).permutation(len(triangles))
    other = engine.clean(vertices, triangles[order])
    same = engine.partition_from(other, part.face_region[order])
    assert engine.regions.expected_polygons(other, same)["polygons"] == pytest.approx(
        engine.regions.expected_polygons(mesh, part)["polygons"], rel=0.1
    )
