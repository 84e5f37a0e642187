"""The display of a batch: results.html, pictures, progress."""

import os
import re
import shutil
import struct
import subprocess
import sys
import zlib

import numpy as np
import pytest

import shapes
from batches import scan
from commands import ENVIRONMENT
from isimp_engine import batch
from isimp_engine.batch import page, picture
from isimp_engine.batch.run import State

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="a batch needs fork")


def test_problems_come_first_on_the_page(scans, tmp_path):
    scan(scans / "z_crash.ply").write_text("ply\n")
    batch.run(scans, tmp_path / "out", options={"proxies": 6})
    text = (tmp_path / "out" / "results.html").read_text()
    assert text.index("z_crash.ply") < text.index('<a href="a.obj">a.ply</a>') < text.index("sub/c.obj")
    assert text.count('<img src="data:image/png;base64,') == 3
    assert "3 of 4 scans ok, 1 failed; 324 faces became 18 polygons" in text
    assert len(list((tmp_path / "out" / ".isimp-batch" / "pictures").iterdir())) == 3
    batch.run(scans, tmp_path / "out", options={"proxies": 7}, pictures=False)
    assert "<img" not in (tmp_path / "out" / "results.html").read_text()
    assert not list((tmp_path / "out" / ".isimp-batch" / "pictures").iterdir()), "pictures of former results go"


def test_defects_come_before_sound_results():
    good = {"name": "a", "status": "ok", "manifold": True, "bent": 0, "warnings": []}
    bent, bad = good | {"name": "b", "bent": 3, "manifold": False}, {"name": "c", "status": "failed"}
    assert [row["name"] for row in page.in_order([good, bent, bad])] == ["c", "b", "a"]
    assert page.defects(bent) == ["3 bent", "not manifold"]


def pixels(data):
    """The picture in a PNG that `picture.png` wrote."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    width, height = struct.unpack(">2I", data[16:24])
    body = data[41 : 41 + struct.unpack(">I", data[33:37])[0]]
    rows = np.frombuffer(zlib.decompress(body), np.uint8).reshape(height, 1 + 3 * width)
    return np.cumsum(rows[:, 1:].reshape(height, width, 3), axis=1, dtype=np.uint8)


def test_pictures_show_scan_and_model():
    vertices, triangles = shapes.cube(1)
    loops, starts = triangles.ravel(), np.arange(0, 36, 3, dtype=np.int32)
    image = pixels(picture.beside((vertices, triangles), (vertices, loops, starts, np.arange(12) // 2)))
    side = picture.SIDE
    assert image.shape == (side, 2 * side + 4, 3)
    left, right = image[:, :side], image[:, side + 4 :]
    assert len(np.unique(left.reshape(-1, 3), axis=0)) == 4, "three sides and the background, without holes"
    assert ((left == 255).all(axis=2) == (right == 255).all(axis=2)).mean() > 0.99
    assert (left[:, :, 0] == left[:, :, 1]).all()
    assert (right[side // 2, side // 2, 0] != right[side // 2, side // 2, 2]).any()
    assert (left[0] == 255).all()


def test_pictures_of_bad_meshes():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [np.nan, 0, 0], [np.inf, 1, 1]])
    triangles = np.array([[0, 1, 2], [0, 1, 3], [0, 1, 4], [0, 0, 1]], np.int32)
    camera = picture._camera(vertices, triangles)
    assert (picture.draw(vertices, triangles, np.ones((1, 3)), camera) < 255).any()
    nothing = picture._camera(vertices, triangles[:0])
    assert (picture.draw(vertices, triangles[:0], np.ones((1, 3)), nothing) == 255).all()


def test_progress_has_rate_and_time_left():
    from isimp_engine.cli.batch import duration, progress

    state = State(scans=1200, before=100, done=20, failed=2, running=["b/x.ply", "c.ply"], seconds=60, share=0.1)
    assert progress(state) == "120 of 1,200, 2 failed, 20.0 a minute, 9 min left: b/x.ply, c.ply"
    assert progress(State(scans=3, before=0)) == "0 of 3"
    assert [duration(s) for s in (5.2, 89, 91, 7500)] == ["5 s", "89 s", "2 min", "2 h 05 min"]


@pytest.mark.skipif(shutil.which("script") is None, reason="needs a terminal by script(1)")
def test_progress_is_for_terminals(scans, tmp_path):
    line = f"{sys.executable} -m isimp_engine batch {scans} {tmp_path / 'out'} --proxies 6"
    done = subprocess.run(
        ["script", "-qec", line, "/dev/null"], capture_output=True, text=True, env=ENVIRONMENT, timeout=60
    )
    assert done.returncode == 0
    assert re.search(r"\x1b\[K\d of 3[^\r\n]*: \w+\.ply", done.stdout)
    assert "\x1b[K" in done.stdout
