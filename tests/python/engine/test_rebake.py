"""A texture after an edit: unchanged charts keep their places, and the others are baked again."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

import isimp_engine as engine
import shapes


@pytest.fixture(scope="module")
def scan():
    """A noisy sphere with an image, its mesh, and its regions before and after a click."""
    vertices, triangles = shapes.cube(14)
    vertices = vertices - vertices.mean(axis=0)
    vertices /= np.linalg.norm(vertices, axis=1)[:, None]
    vertices = vertices + np.random.default_rng(3).normal(0, 0.005, vertices.shape)
    uv = (vertices[triangles][:, :, :2] + 1) / 2
    image = np.random.default_rng(1).integers(0, 255, (96, 96, 3), dtype=np.uint8)
    rough = np.random.default_rng(2).integers(0, 255, (32, 32), dtype=np.uint8)
    layers = {"roughness": engine.TextureLayer([rough])}
    soup = engine.TexturedSoup(vertices, triangles, uv, images=[image], layers=layers)
    mesh = engine.clean(vertices, triangles)
    before = engine.partition(mesh, engine.PartitionOptions(proxies=60))
    return soup, mesh, before, engine.add_proxy(mesh, before, 100)


def baked(scan, part, previous=None, **options):
    soup, mesh, *_ = scan
    poly = engine.polygonize(mesh, part)
    return poly, engine.texture(mesh, part, poly, soup, engine.TextureOptions(**options), previous=previous)


def layers_of(made):
    return {"color": made.image, "normal": made.normal} | made.layers


def corners(poly, made):
    """The place of each polygon's middle, in space and in the image."""
    ends = np.append(poly.loop_start, len(poly.loops))
    pieces = [slice(a, b) for a, b in itertools.pairwise(ends)]
    return np.array([np.hstack([poly.vertices[poly.loops[p]].mean(0), made.uv[p].mean(0)]) for p in pieces])


def test_untouched_charts_keep_their_place_and_their_pixels(scan):
    options = {"size": 256, "occlusion": True, "occlusion_rays": 9, "height": True}
    old_poly, old = baked(scan, scan[2], **options)
    poly, made = baked(scan, scan[3], old, **options)
    assert made.report["texels_per_unit"] == old.report["texels_per_unit"]
    assert 0 < made.report["kept_places"] < len(poly.loop_start)
    assert len(poly.loop_start) / 4 < made.report["kept_pixels"] < len(poly.loop_start)
    here, there = corners(poly, made), corners(old_poly, old)
    away = np.linalg.norm(here[:, None, :3] - there[None, :, :3], axis=2)
    moved = np.abs(here[:, 3:] - there[away.argmin(axis=1), 3:]).max(axis=1)
    stayed = (away.min(axis=1) < 1e-2) & (moved < 1e-12)
    assert stayed.sum() >= made.report["kept_pixels"]
    at = (here[stayed, 3:] * [256, -256] + [0, 256]).astype(int).T
    same = (made.image[at[1], at[0]] == old.image[at[1], at[0]]).all(axis=1)
    assert same.sum() >= made.report["kept_pixels"]


def test_it_equals_a_whole_bake_of_the_layout(scan):
    options = {"size": 256, "occlusion": True, "occlusion_rays": 9, "height": True}
    _, old = baked(scan, scan[2], **options)
    _, made = baked(scan, scan[3], old, **options)
    layout_only = replace(old, made_of=replace(old.made_of, digest=b""))  # no part of it can be reused
    _, whole = baked(scan, scan[3], layout_only, **options)
    assert whole.report["kept_pixels"] == 0
    assert whole.report["kept_places"] == made.report["kept_places"]
    assert np.array_equal(made.uv, whole.uv)
    for name, image in layers_of(whole).items():
        assert np.array_equal(layers_of(made)[name], image), name
    for name in ("texels", "searched", "unknown", "height_range"):
        assert made.report[name] == whole.report[name]


def test_the_same_polygons_again_are_not_baked(scan):
    poly, old = baked(scan, scan[2], size=128)
    _, made = baked(scan, scan[2], old, size=128)
    assert made.report["kept_pixels"] == len(poly.loop_start)
    assert made.report["kept_places"] == len(poly.loop_start)
    assert np.array_equal(made.image, old.image)


@pytest.mark.parametrize(
    ("options", "stays"),
    [
        ({"size": 256}, False),
        ({"unfold": 0}, False),
        ({"gutter": 9}, False),
        ({"band": 9}, True),
        ({"normals": False}, True),
    ],
)
def test_other_options_are_obeyed(scan, options, stays):
    _, old = baked(scan, scan[2], size=128)
    options = {"size": 128} | options
    _, made = baked(scan, scan[3], old, **options)
    assert (made.report["kept_places"] > 0) is stays
    assert made.report["kept_pixels"] == 0
    if not stays:
        _, fresh = baked(scan, scan[3], **options)
        assert np.array_equal(made.uv, fresh.uv)
        assert np.array_equal(made.image, fresh.image)


def test_another_image_on_the_same_scan_is_baked(scan):
    soup, mesh, part, _ = scan
    poly, old = baked(scan, part, size=128)
    other = engine.TexturedSoup(soup.vertices, soup.triangles, soup.uv, images=[255 - soup.images[0]])
    made = engine.texture(mesh, part, poly, other, engine.TextureOptions(size=128), previous=old)
    assert made.report["kept_pixels"] == 0
    assert np.array_equal(made.uv, old.uv)
    assert not np.array_equal(made.image, old.image)


def test_many_edits_in_a_row_keep_charts_apart(scan):
    """Free room is used again and again; the image must be that of a whole bake."""
    _, mesh, part, _ = scan
    poly, made = baked(scan, part, size=256)
    kept = []
    for face in (7, 400, 900, 1300, 1700, 2100):
        part = engine.add_proxy(mesh, part, face)
        part = engine.delete_proxy(mesh, part, (face * 7) % len(mesh.triangles))
        poly, made = baked(scan, part, made, size=256)
        kept.append(made.report["kept_places"])
        polygon = engine._core._bake_map(mesh, part, poly, made.made_of.atlas, engine.TextureOptions())[0]
        ends = np.append(poly.loop_start, len(poly.loops))
        for q, count in enumerate(np.bincount(polygon[polygon >= 0], minlength=len(poly.loop_start))):
            x, y = (made.uv[ends[q] : ends[q + 1]] * 256).T
            area = (np.roll(x, 1) * y - x * np.roll(y, 1)).sum() / 2
            assert abs(count - area) < 8 + 0.05 * area
    assert max(kept) > 0
