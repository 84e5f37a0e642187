"""Height maps of a shape whose heights are known, and the output of the command for them."""

import json

import numpy as np
import pytest
from PIL import Image

import isimp_engine as engine
import shapes
from test_cli import isimp
from test_texture import picture, ramp

PEAK = 0.125


def hill(n=16):
    """A square with a pyramid on it: its corners stay in the plane z = 0."""
    vertices, triangles = shapes.plane(n)
    away = np.abs(vertices[:, :2] - 0.5).max(axis=1)
    vertices[:, 2] = np.maximum(0, PEAK * (1 - away / 0.25))
    return vertices, triangles


def write_hill(folder):
    vertices, triangles = hill()
    lines = ["mtllib t.mtl", "usemtl m", *(f"v {x} {y} {z}" for x, y, z in vertices)]
    lines += [f"vt {u} {v}" for u, v, _ in vertices]
    lines += ["f " + " ".join(f"{v + 1}/{v + 1}" for v in t) for t in triangles]
    (folder / "hill.obj").write_text("\n".join(lines) + "\n")
    (folder / "t.mtl").write_text("newmtl m\nmap_Kd t.png\n")
    picture(folder, "t.png", ramp())
    return folder / "hill.obj"


def made_of(vertices, triangles, **options):
    soup = engine.TexturedSoup(vertices, triangles, vertices[:, :2], images=[ramp()])
    mesh = engine.clean(vertices, triangles)
    part = engine.partition_from(mesh, np.zeros(len(triangles), np.int32))
    poly = engine.polygonize(mesh, part)
    made = engine.texture(mesh, part, poly, soup, engine.TextureOptions(size=128, height=True, **options))
    return poly, made


@pytest.mark.parametrize("up", [1, -1])
def test_heights_equal_the_scan(up):
    vertices, triangles = hill()
    poly, made = made_of(vertices * [1, 1, up], triangles)
    grey, span = made.layers["height"], made.factors["height"]
    assert grey.shape == (128, 128)
    assert grey.dtype == np.uint16
    assert made.report["height_range"] == span
    corners = poly.vertices[poly.loops]
    plane = corners[:, 2].mean()  # a polygon lies in the middle of its region, not at its rim
    assert 0.005 < up * plane < 0.02
    assert np.ptp(corners[:, 2]) < 1e-9
    assert span == pytest.approx(2 * (PEAK - up * plane), rel=0.02)
    # The place of each point of the plane in the image, from the corners of the one polygon.
    to_uv, *_ = np.linalg.lstsq(np.c_[corners[:, :2], np.ones(len(corners))], made.uv, rcond=None)
    x, y = np.meshgrid(np.linspace(0.02, 0.98, 40), np.linspace(0.02, 0.98, 40))
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    uv = np.c_[points, np.ones(len(points))] @ to_uv
    found = grey[((1 - uv[:, 1]) * 128).astype(int), (uv[:, 0] * 128).astype(int)]
    height = (found / 65535 - 0.5) * span + plane
    wanted = up * np.maximum(0, PEAK * (1 - np.abs(points - 0.5).max(axis=1) / 0.25))
    # Half a pixel of 128 / the slope of the hill's sides
    assert np.abs(height - wanted).max() < 0.02
    assert np.abs(height - wanted).mean() < 0.003


def test_the_same_bits_for_any_number_of_threads():
    one, three = (made_of(*hill(), threads=n)[1] for n in (1, 3))
    assert (one.layers["height"] == three.layers["height"]).all()


def test_all_heights_of_a_plane_are_in_the_middle():
    _, made = made_of(*shapes.plane(4))
    assert (made.layers["height"] == 32768).all()
    assert made.factors["height"] == 0


@pytest.mark.parametrize("ending", ["obj", "glb"])
def test_the_command_writes_sixteen_bits_next_to_the_output(tmp_path, ending):
    scan, out, report = write_hill(tmp_path), tmp_path / f"out.{ending}", tmp_path / "r.json"
    args = ["simplify", scan, out, "--proxies", "5", "--texture", "128", "--height", "--report", report]
    done = isimp(*args)
    assert done.returncode == 0, done.stderr
    with Image.open(tmp_path / "out_height.png") as image:
        assert image.size == (128, 128)
        assert image.mode.startswith("I")
    told = json.loads(report.read_text())["texture"]
    assert told["layers"] == ["height"]
    assert told["height_range"] >= 0
    if ending == "obj":
        lines = (tmp_path / "out.mtl").read_text().splitlines()
        assert "disp out_height.png" in lines
        assert any(line.startswith("# height above the polygon") for line in lines)


def test_the_command_refuses_heights_without_a_texture(tmp_path):
    done = isimp("simplify", write_hill(tmp_path), tmp_path / "out.obj", "--proxies", "5", "--height")
    assert done.returncode == 2
    assert "--height needs --texture" in done.stderr


def test_a_scans_own_image_is_not_overwritten(tmp_path):
    scan = write_hill(tmp_path)
    (tmp_path / "t.png").rename(tmp_path / "out_height.png")
    (tmp_path / "t.mtl").write_text("newmtl m\nmap_Kd out_height.png\n")
    before = (tmp_path / "out_height.png").read_bytes()
    done = isimp("simplify", scan, tmp_path / "out.glb", "--proxies", "5", "--texture", "64", "--height")
    assert done.returncode == 2
    assert "belongs to the scan" in done.stderr
    assert (tmp_path / "out_height.png").read_bytes() == before
    assert isimp("simplify", scan, tmp_path / "out.glb", "--proxies", "5", "--texture", "64").returncode == 0


def test_a_recipe_may_request_heights(tmp_path):
    scan = write_hill(tmp_path)
    steps = [{"step": "partition", "proxies": 5}, {"step": "mesh"}, {"step": "texture", "size": 64, "height": True}]
    (tmp_path / "r.json").write_text(json.dumps({"isimp_recipe": 1, "steps": steps}))
    done = isimp("simplify", scan, tmp_path / "out.obj", "--recipe", tmp_path / "r.json")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out_height.png").is_file()
    steps[2]["height"] = 1
    (tmp_path / "r.json").write_text(json.dumps({"isimp_recipe": 1, "steps": steps}))
    done = isimp("simplify", scan, tmp_path / "out2.obj", "--recipe", tmp_path / "r.json")
    assert "height of texture must be true or false" in done.stderr
