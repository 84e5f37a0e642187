"""The experiments of the thesis in bench/ run on small meshes."""

import csv

import numpy as np
import pytest

import meshfiles
import shapes
from bench.studies import thesis

WAYS = ("lloyd", "queued", "naive", "naive, brute force", "default")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The output of one command for two small sheets."""
    data, out = tmp_path_factory.mktemp("data"), tmp_path_factory.mktemp("out")
    for name, size in (("small.ply", 24), ("large.ply", 48)):
        vertices, triangles = shapes.bumpy(size)
        noise = np.random.default_rng(1).normal(0, 0.002, vertices.shape)
        meshfiles.ply_binary(data / name, vertices + noise, triangles)
    scans = ["--scans", "small.ply,large.ply", "--counts", "8,16,24"]
    thesis.main(["--data", str(data), "--out", str(out), "--csv-only", *scans])
    return out


def rows_of(folder, name):
    with (folder / f"{name}.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_speed_has_every_method_on_every_scan_at_every_count(folder):
    rows = [row for row in rows_of(folder, "speed") if row["backend"] == "cpu"]
    assert {(r["scan"], int(r["proxies"]), r["method"]) for r in rows} == {
        (scan, count, way) for scan in ("small.ply", "large.ply") for count in (8, 16, 24) for way in WAYS
    }
    assert all(float(r["seconds"]) >= 0 and float(r["error"]) > 0 for r in rows)
    assert all(float(r["speed_up"]) == 1 for r in rows if r["method"] == "lloyd")


def test_rounds_end_connected_both_ways(folder):
    rows = [row for row in rows_of(folder, "rounds") if row["scan"] == "small.ply"]
    for way in ("queued", "naive"):
        mine = [row["round"] for row in rows if row["method"] == way]
        assert mine[-2:] == ["end repair", "end flood"]
        assert "1" in mine
    lloyd = [float(row["error"]) for row in rows if row["method"] == "lloyd"]
    assert lloyd[-1] == 1
    assert lloyd[0] > 1


def test_fractions_have_the_hybrid_with_and_without_relaxing(folder):
    rows = [row for row in rows_of(folder, "fractions") if row["scan"] == "large.ply"]
    assert [row["method"] for row in rows] == ["lloyd", "default", *["hybrid", "hybrid, relaxed"] * 5]
    assert [float(row["fraction"]) for row in rows[2::2]] == [1 / 2, 1 / 4, 1 / 8, 1 / 16, 1 / 32]
    for plain, relaxed in zip(rows[2::2], rows[3::2], strict=True):
        assert float(relaxed["error"]) < float(plain["error"])
