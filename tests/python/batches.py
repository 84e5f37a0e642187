"""Helpers for tests of batches: scans, and readers of an output folder."""

import json
import time

import meshfiles
import shapes

ODD = "odd_work:run"


def scan(path, n=3):
    path.parent.mkdir(parents=True, exist_ok=True)
    vertices, triangles = shapes.cube(n)
    meshfiles.ply_binary(path, vertices, triangles.tolist())
    return path


def rows_by_name(out):
    lines = (out / "results.jsonl").read_text().splitlines()
    rows = {row["name"]: row for row in map(json.loads, lines)}
    assert len(rows) == len(lines), "one line a scan"
    return rows


def whys(outcome):
    return {row["name"]: row["why"] for row in outcome.failed}


def wait_for(condition, seconds=30.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)
