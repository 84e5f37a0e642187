"""Parallel planes at equal distances: stairs whose treads are not quite so."""

import copy
import json
import pathlib

import numpy as np
import pytest

import isimp_engine as engine
from isimp_engine.cli import main

DEPTH, WIDTH = 0.3, 1.2
HEIGHTS = np.array([0.168, 0.176, 0.17, 0.179, 0.167, 0.174])


def stair(heights: np.ndarray) -> tuple[engine.Mesh, engine.Partition]:
    """A stair of steps of these heights, each tread and riser a region, and one for each side, back and bottom."""
    top = np.cumsum(heights)
    outline = [(0.0, 0.0)]
    for k, z in enumerate(top):
        outline += [(DEPTH * k, z), (DEPTH * (k + 1), z)]
    outline.append((DEPTH * len(top), 0.0))
    xz = np.array(outline)
    n = len(xz)
    vertices = np.concatenate([np.stack([xz[:, 0], np.full(n, y), xz[:, 1]], 1) for y in (0.0, WIDTH)])
    triangles, label = [], []
    for k in range(n):  # the band between the two sides
        after = (k + 1) % n
        triangles += [(k, n + after, n + k), (k, after, n + after)]
        label += [k, k]
    front = side(n)
    triangles += [tuple(t) for t in front] + [tuple(n + i for i in t[::-1]) for t in front]
    label += [n] * len(front) + [n + 1] * len(front)
    mesh = engine.clean(vertices, np.array(triangles))
    return mesh, engine.partition_from(mesh, np.array(label, np.int32)[mesh.source_face])


def side(corners: int) -> list[tuple[int, int, int]]:
    """Triangles of a stair's side: all from its lower back corner, from which a rising stair hides nothing."""
    return [(corners - 1, k + 1, k) for k in range(corners - 2)]


def treads(part: engine.Partition) -> np.ndarray:
    up = part.region_normal[:, 2] > 0.99
    assert up.any()
    return np.sort(part.region_offset[up])


def test_the_stair_is_sound() -> None:
    mesh, part = stair(HEIGHTS)
    assert mesh.report["closed"]
    assert part.region_count == 2 * len(HEIGHTS) + 4


def test_treads_are_at_equal_heights_only_on_request() -> None:
    mesh, part = stair(HEIGHTS)
    plain = engine.regularise(mesh, part, engine.RegulariseOptions(length=0.01))
    assert plain.report["evenly_spaced"] == 0
    assert np.abs(np.diff(treads(plain), 2)).max() > 0.005
    even = engine.regularise(mesh, part, engine.RegulariseOptions(length=0.01, even_spacing=True))
    assert even.report["evenly_spaced"] >= len(HEIGHTS)
    assert np.abs(np.diff(treads(even), 2)).max() < 1e-12
    assert np.abs(treads(even) - np.cumsum(HEIGHTS)).max() < 0.01
    again = copy.deepcopy(even)
    assert again.regularity == even.regularity
    poly = engine.polygonize(mesh, even, engine.MeshingOptions(planar=True))
    heights = np.unique(np.round(poly.vertices[:, 2], 9))
    assert poly.report["whole"] == 1.0
    assert np.abs(np.diff(heights[1:], 2)).max() < 1e-8  # the lowest is the floor


@pytest.mark.parametrize("seed", range(3))
def test_steps_of_any_height_stay(seed: int) -> None:
    mesh, part = stair(np.random.default_rng(seed).uniform(0.08, 0.3, 6))
    even = engine.regularise(mesh, part, engine.RegulariseOptions(length=0.002, even_spacing=True))
    plain = engine.regularise(mesh, part, engine.RegulariseOptions(length=0.002))
    assert np.array_equal(treads(even), treads(plain))


def test_command(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    mesh, _ = stair(HEIGHTS)
    scan, report = tmp_path / "stair.off", tmp_path / "report.json"
    lines = ["OFF", f"{len(mesh.vertices)} {len(mesh.triangles)} 0"]
    lines += [" ".join(map(repr, row)) for row in mesh.vertices.tolist()]
    lines += [f"3 {a} {b} {c}" for a, b, c in mesh.triangles.tolist()]
    scan.write_text("\n".join(lines))
    arguments = ["simplify", str(scan), str(tmp_path / "out.obj"), "--proxies", "16", "--quiet", "--even-spacing"]
    assert main(arguments) == 2
    assert "--even-spacing needs --regularise" in capsys.readouterr().err
    assert main([*arguments, "--regularise", "--report", str(report)]) == 0
    assert json.loads(report.read_text())["options"]["regularise"]["even_spacing"] is True
