"""Ambient occlusion of shapes whose answer is known."""

import numpy as np
import pytest

import isimp_engine as engine
import meshfiles
import shapes
from test_texture import result, sample


def coloured(vertices, triangles):
    return engine.TexturedSoup(vertices, triangles, colors=np.full((len(vertices), 3), 200, np.uint8))


def with_wall(height, gap=1e-3):
    """A floor of side 1, and a wall along it at x = -gap, as long as the floor is."""
    floor, triangles = shapes.plane(8)
    wall = np.array([[-gap, 0, 0], [-gap, 1, 0], [-gap, 1, height], [-gap, 0, height]])
    more = np.array([[0, 1, 2], [0, 2, 3]], triangles.dtype) + len(floor)
    return coloured(np.r_[floor, wall], np.r_[triangles, more]), np.r_[np.zeros(len(triangles)), np.ones(2)]


def open_share(points, height, gap=1e-3):
    """The open share of the cosine-weighted hemisphere with a wall (view factor of a perpendicular rectangle)."""
    x, y = points[:, 0] + gap, points[:, 1]
    top = np.hypot(x, height)
    covered = sum((np.arctan(b / x) - x / top * np.arctan(b / top)) / (2 * np.pi) for b in (y, 1 - y))
    return 1 - covered


def on_floor(poly, made, points):
    """The occlusion at points of polygon 0, the floor."""
    ends = np.append(poly.loop_start, len(poly.loops))
    q = int(np.flatnonzero(poly.polygon_region == 0)[0])
    own = slice(ends[q], ends[q + 1])
    corners, uv = poly.vertices[poly.loops[own]][:, :2], made.uv[own]
    affine, *_ = np.linalg.lstsq(np.c_[corners, np.ones(len(corners))], uv, rcond=None)
    return sample(made.layers["occlusion"], np.c_[points, np.ones(len(points))] @ affine)


@pytest.mark.parametrize("height", [0.3, 3.0])
def test_a_wall_blocks_the_share_of_its_view_factor(height):
    soup, regions = with_wall(height)
    _, _, poly, made = result(soup, regions, size=256, occlusion=True, occlusion_rays=1152)
    points = 0.1 + 0.8 * np.random.default_rng(1).random((400, 2))
    error = on_floor(poly, made, points) / 255 - open_share(points, height)
    assert np.abs(error).max() < 0.03
    assert abs(error.mean()) < 0.004
    assert open_share(points, height).min() < 0.8  # some light is blocked


def test_next_to_a_high_wall_half_of_the_light_is_left():
    vertices, triangles = shapes.plane(4)
    floor = vertices * [0.2, 20, 1]
    wall = np.array([[-1e-3, -20, 0], [-1e-3, 40, 0], [-1e-3, 40, 60], [-1e-3, -20, 60]])
    more = np.array([[0, 1, 2], [0, 2, 3]], triangles.dtype) + len(floor)
    soup = coloured(np.r_[floor, wall], np.r_[triangles, more])
    _, _, poly, made = result(soup, np.r_[np.zeros(len(triangles)), np.ones(2)], size=1024, occlusion=True)
    points = np.c_[np.full(50, 0.1), np.linspace(6, 14, 50)]
    assert np.abs(on_floor(poly, made, points) / 255 - 0.5).max() < 0.03


def test_faces_beyond_the_distance_keep_nothing_off():
    soup, regions = with_wall(3.0)
    points = np.c_[np.linspace(0.1, 0.9, 50), np.full(50, 0.5)]
    _, _, poly, made = result(soup, regions, size=512, occlusion=True, occlusion_distance=0.4)
    shown = on_floor(poly, made, points)
    assert (shown[points[:, 0] > 0.42] == 255).all()
    assert (shown[points[:, 0] < 0.3] < 250).all()


def test_nothing_is_dark_on_a_convex_shape_far_from_zero():
    vertices, triangles = shapes.cube(3)
    soup = coloured(vertices + [2.0**19, -(2.0**21), 2.0**10], triangles)
    _, _, _, made = result(soup, np.arange(len(triangles)) // 18, size=128, occlusion=True)
    assert (made.layers["occlusion"] == 255).all()


def test_between_two_plates_it_is_black():
    floor, triangles = shapes.plane(8)
    lid = (floor - [0.5, 0.5, 0]) * [40, 40, 1] + [0.5, 0.5, 0.01]
    soup = coloured(np.r_[floor, lid], np.r_[triangles, triangles + len(floor)])
    _, _, poly, made = result(soup, np.repeat([0, 1], len(triangles)), size=1024, occlusion=True)
    points = np.c_[np.linspace(0.2, 0.8, 20), np.full(20, 0.5)]
    assert (on_floor(poly, made, points) == 0).all()


def test_it_is_written_and_read_again(tmp_path):
    soup, regions = with_wall(1.0)
    _, _, poly, made = result(soup, regions, size=64, occlusion=True)
    engine.write_textured(tmp_path / "out.glb", poly, made)
    back = engine.read_textured(tmp_path / "out.glb")
    assert list(back.layers) == ["roughness", "metallic", "occlusion", "normal"]
    assert np.array_equal(back.layers["occlusion"].images[0][:, :, 0], made.layers["occlusion"])
    material = meshfiles.of_glb((tmp_path / "out.glb").read_bytes())[0]["materials"][0]
    assert "occlusionTexture" in material
    assert "metallicRoughnessTexture" not in material["pbrMetallicRoughness"]
    trimesh = pytest.importorskip("trimesh")
    (mesh,) = trimesh.load(tmp_path / "out.glb").geometry.values()
    assert np.array_equal(np.asarray(mesh.visual.material.occlusionTexture)[:, :, 0], made.layers["occlusion"])
    engine.write_textured(tmp_path / "out.obj", poly, made)
    assert "map_Ka out_occlusion.png" in (tmp_path / "out.mtl").read_text()
