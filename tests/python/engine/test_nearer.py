"""A bound that brings the regions of a drawn model nearer to it."""

import json

import numpy as np
import pytest

import isimp_engine as engine
from bench.quality import real
from isimp_engine.cli import main
from isimp_engine.nearer import LEAST_TIMES, nearer_by_bound
from isimp_engine.within import Made, polygonize_within, scan_distances
from shapes import bent_pipe, cube, torus


def found_for(vertices, faces, **options):
    mesh, options = engine.Mesh(vertices, faces), engine.PartitionOptions(**options)
    part = engine.partition(mesh, options)
    return mesh, part, nearer_by_bound(mesh, part, Made(options))


@pytest.mark.parametrize("detail", [0.005, 0.0025])
def test_the_polygons_of_the_bound_are_nearer(detail):
    mesh, part, found = found_for(*bent_pipe(), detail=detail)
    assert found.times >= LEAST_TIMES
    options = engine.PartitionOptions(bound=found.bound)
    other = engine.partition(mesh, options)
    assert other.region_count == found.regions <= 1.03 * part.region_count
    off = []
    for each in (part, other):
        polygons = polygonize_within(mesh, each).polygons
        off.append(np.nanmean(scan_distances(mesh, each, polygons)))
    assert off[1] < off[0] / 1.5


def test_there_is_none_where_it_gains_nothing():
    assert found_for(*cube(12))[2] is None
    assert found_for(*torus(60, 30))[2] is None
    assert found_for(*bent_pipe(), proxies=30)[2] is None
    assert found_for(*bent_pipe(), curved=True)[2] is None


def test_there_is_none_for_a_scan():
    vertices, faces = bent_pipe()
    noisy = vertices + np.random.default_rng(1).normal(0, 0.002, vertices.shape)
    assert found_for(noisy, faces)[2] is None


def test_the_command_names_it(tmp_path, capsys):
    real.write_ply(tmp_path / "scan.ply", *bent_pipe())
    out, report = tmp_path / "out.obj", tmp_path / "report.json"
    assert main(["simplify", str(tmp_path / "scan.ply"), str(out), "--report", str(report)]) == 0
    told = json.loads(report.read_text())["nearer"]
    assert told["regions"] > 1
    line = f"--bound {told['bound']:.3g} has {told['regions']} regions"
    assert line in capsys.readouterr().out
    assert main(["info", "--estimate", str(tmp_path / "scan.ply")]) == 0
    assert line in capsys.readouterr().out
    assert main(["simplify", str(tmp_path / "scan.ply"), str(out), "--report", str(report), "--bound", "0.02"]) == 0
    assert json.loads(report.read_text())["nearer"] is None
