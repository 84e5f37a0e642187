"""Helpers for tests of batches: scans, the command, and readers of an output folder."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import isimp_engine as engine
import meshfiles
import shapes

HERE = str(Path(__file__).parent)
ENVIRONMENT = {
    **os.environ,
    "PYTHONPATH": os.pathsep.join([str(Path(engine.__file__).parents[1]), HERE]),
    "COLUMNS": "100",
}
ODD = "odd_work:run"


def isimp(*arguments, **keywords):
    command = [sys.executable, "-m", "isimp_engine", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, env=ENVIRONMENT, timeout=120, **keywords)


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
