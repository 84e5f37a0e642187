"""The thesis's experiments in bench/, on small meshes: they run, and their findings follow from the figures."""

import csv

import numpy as np
import pytest

import meshfiles
import shapes
from bench.studies import thesis, thesis_findings

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
        assert mine[-2:] == ["end repair", "end flood"] or sorted(mine)[-2:] == ["end flood", "end repair"]
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


def test_every_finding_has_a_verdict_and_its_figures(folder):
    rows = rows_of(folder, "findings")
    assert len(rows) >= 14
    assert {row["holds"] for row in rows} <= {"True", "False"}
    assert all(any(c.isdigit() for c in row["here"]) for row in rows)


def hand_made():
    """One scan on which all findings of the thesis hold."""
    speed = [
        {"scan": scan, "faces": faces, "proxies": count, "method": way, "backend": "cpu", "speed_up": gain}
        for scan, faces, more in (("small", 1000, 1.0), ("large", 9000, 2.0))
        for count in (10, 100)
        for way, gain in (("queued", 0.5 * more), ("naive", 20 / count), ("naive, brute force", 10 / count))
    ]
    ends = {("lloyd", "end"): 1.0, ("queued", "end flood"): 1.1, ("queued", "end repair"): 1.05}
    ends |= {("naive", "end flood"): 1.3, ("naive", "end repair"): 1.2}
    rounds = [{"scan": "a", "method": way, "round": name, "error": error} for (way, name), error in ends.items()]
    for way, last in (("lloyd", 1.0), ("queued", 0.9), ("naive", 0.8)):
        rounds += [{"scan": "a", "method": way, "round": k, "error": last + (k < 5)} for k in range(1, 21)]
    fractions = [{"scan": "a", "method": "default", "fraction": 1.0, "error": 0.8}]
    for k in range(1, 6):
        times = {"decimating": 0.3, "partitioning": 0.4**k}
        common = {"scan": "a", "fraction": 1 / 2**k} | times
        fractions += [
            common | {"method": "hybrid", "error": 1.0},
            common | {"method": "hybrid, relaxed", "error": 0.85},
        ]
    return {"speed": speed, "rounds": rounds, "fractions": fractions}


def verdicts(**tables):
    return {row["thesis"].split(" (connected")[0]: row["holds"] for row in thesis_findings.findings(**tables)}


def test_findings_hold_or_fail_by_the_figures():
    tables = hand_made()
    assert [what for what, holds in verdicts(**tables).items() if not holds] == ["the decimator dominates"]
    for row in tables["fractions"]:
        row["decimating"] = 5.0
    for row in tables["rounds"]:
        if row["round"] == "end repair":
            row["error"] = 1.4
    for row in tables["speed"]:
        row["speed_up"] = 3.0
    after = verdicts(**tables)
    assert [what for what, holds in after.items() if not holds] == [
        "the naive one gains less with more regions",
        "the queued one gains more on larger meshes",
        "the queued one is slower on small meshes",
        "(not in the thesis) a parallel repair loses less",
        "decimating first is twice as fast",
    ]
