"""Several images: UDIM tiles in and out, and materials that are kept apart."""

import numpy as np
import pytest
from PIL import Image

import isimp_engine as engine
import meshfiles
import shapes
from commands import called
from test_texture import SIX, inside, painted_cube, result, sample

TILES = {1001: (250, 10, 20), 1002: (30, 240, 50), 1011: (60, 70, 230)}


def write_udim_plane(folder, n=6):
    """A strip of three squares, each in a tile of its own colour."""
    vertices, triangles = shapes.plane(n)
    lines, uvs, faces = ["mtllib strip.mtl"], [], ["usemtl strip"]
    for k, (tile, colour) in enumerate(TILES.items()):
        lines += [f"v {x + k} {y} {z}" for x, y, z in vertices]
        u, v = (tile - 1001) % 10, (tile - 1001) // 10
        uvs += [f"vt {0.02 + 0.96 * x + u} {0.02 + 0.96 * y + v}" for x, y, _ in vertices]
        faces += ["f " + " ".join(f"{i}/{i}" for i in t) for t in triangles + 1 + k * len(vertices)]
        Image.new("RGB", (16, 16), colour).save(folder / f"strip.{tile}.png")
        Image.new("L", (16, 16), colour[0]).save(folder / f"rough.{tile}.png")
    (folder / "strip.obj").write_text("\n".join([*lines, *uvs, *faces]) + "\n")
    (folder / "strip.mtl").write_text("newmtl strip\nmap_Kd strip.<UDIM>.png\nmap_Pr rough.<UDIM>.png\n")
    return folder / "strip.obj"


def squares(soup):
    return np.floor(soup.vertices[soup.triangles][:, :, 0].mean(axis=1)).astype(int)


def test_udim_images_of_obj_files_are_read(tmp_path):
    soup = engine.read_textured(write_udim_plane(tmp_path))
    assert len(soup.images) == 3
    assert {file.name for file in soup.files} >= {"strip.1011.png", "rough.1002.png"}
    assert soup.uv.min() >= 0
    assert soup.uv.max() <= 1
    _, _, poly, made = result(soup, squares(soup), size=64)
    for q, region in enumerate(poly.polygon_region):
        colour = list(TILES.values())[region]
        assert (inside(poly, made, q)[:, :3] == colour).all()
        assert (inside(poly, replace_image(made, made.layers["roughness"]), q) == colour[0]).all()


def replace_image(made, image):
    from dataclasses import replace

    return replace(made, image=image)


def test_a_missing_tile_is_named(tmp_path):
    path = write_udim_plane(tmp_path)
    (tmp_path / "strip.1002.png").rename(tmp_path / "strip.0999.png")  # which is no tile
    with pytest.raises(engine.InvalidInput, match="UDIM tile 1002, but its image has only 1001, 1011"):
        engine.read_textured(path)
    for file in tmp_path.glob("strip.1*.png"):
        file.unlink()
    with pytest.raises(engine.FileError, match=r"strip.mtl, line 2: no file has the name .*strip.<UDIM>.png"):
        engine.read_textured(path)


def test_tiles_are_taken_from_python():
    vertices, triangles = shapes.plane(2)
    uv = vertices[:, :2] + [1, 0]
    soup = engine.TexturedSoup(vertices, triangles, uv, images=[{1002: np.full((4, 4, 3), 9, np.uint8)}])
    assert len(soup.images) == 1
    assert soup.uv.max() <= 1
    with pytest.raises(engine.InvalidInput, match="UDIM tile 1001"):
        engine.TexturedSoup(vertices, triangles, vertices[:, :2], images=[{1002: np.zeros((4, 4, 3), np.uint8)}])


def coloured_cube(**options):
    vertices, triangles, side = painted_cube()
    colors = np.repeat(np.array(SIX, np.uint8)[side][:, None], 3, axis=1)
    soup = engine.TexturedSoup(vertices, triangles, colors=colors)
    return soup, result(soup, side, **options)


def shown_colours(soup):
    """The colour in the middle of each triangle, in its own image."""
    found = np.empty((len(soup.triangles), 3), int)
    for m, image in enumerate(soup.images):
        of = soup.material == m
        found[of] = sample(image, soup.uv[of].mean(axis=1))[:, :3]
    return found


def sides(soup):
    corners = soup.vertices[soup.triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    axis = np.abs(normal).argmax(axis=1)
    return 2 * axis + (np.take_along_axis(normal, axis[:, None], 1)[:, 0] > 0)


@pytest.mark.parametrize("name", ["out.obj", "out.glb", "out.gltf"])
def test_results_of_several_tiles_are_read_back(tmp_path, name):
    soup, (_, _, poly, made) = coloured_cube(size=64, tiles=2, occlusion=True)
    assert made.image.shape == (2, 64, 64, 4)
    assert made.normal.shape == (2, 64, 64, 3)
    assert made.layers["occlusion"].shape == (2, 64, 64)
    assert sorted(np.unique(made.tile)) == [0, 1]
    assert made.uv.min() >= 0
    assert made.uv.max() <= 1
    assert made.report["tiles"] == 2
    files = engine.write_textured(tmp_path / name, poly, made)
    if name == "out.obj":
        wanted = {"out.obj", "out.mtl"}
        wanted |= {f"out{layer}.{1001 + t}.png" for layer in ("", "_normal", "_occlusion") for t in range(2)}
        assert {file.name for file in files} == wanted
        assert "map_Kd out.<UDIM>.png" in (tmp_path / "out.mtl").read_text()
    back = engine.read_textured(tmp_path / name)
    before = dict(zip(sides(soup).tolist(), soup.colors[:, 0, :3].tolist(), strict=True))
    assert len(back.images) == 2
    for side, colour in zip(sides(back), shown_colours(back), strict=True):
        assert np.abs(colour - before[side]).max() <= 1


def test_tiles_are_denser_and_have_no_untextured_texel():
    _, (_, _, _, one) = coloured_cube(size=64)
    _, (_, _, poly, four) = coloured_cube(size=64, tiles=4)
    assert four.report["texels_per_unit"] > 1.5 * one.report["texels_per_unit"]
    assert four.report["unknown"] == 0
    ends = np.append(poly.loop_start, len(poly.loops))
    for q, region in enumerate(poly.polygon_region):
        middle = four.uv[ends[q] : ends[q + 1]].mean(axis=0)[None]
        assert (sample(four.image[four.tile[q]], middle)[0, :3] == SIX[region]).all()


def test_the_command_does_not_overwrite_tiles_of_the_scan(tmp_path):
    path = write_udim_plane(tmp_path)
    before = (tmp_path / "strip.1001.png").read_bytes()
    (tmp_path / "other.mtl").write_text((tmp_path / "strip.mtl").read_text())
    (tmp_path / "other.obj").write_text(path.read_text().replace("strip.mtl", "other.mtl"))
    ran = called("simplify", tmp_path / "other.obj", path, "--proxies", "3", "--texture", "32", "--tiles", "2")
    assert ran.returncode == 2
    assert "belongs to the scan and would be overwritten" in ran.stderr
    assert (tmp_path / "strip.1001.png").read_bytes() == before


def transformed_glb(folder, **transform):
    """A plane with one texture, whose UVs an extension moves."""
    vertices, triangles = shapes.plane(1)
    soup = engine.TexturedSoup(vertices, triangles, vertices[:, :2], images=[np.zeros((8, 8, 3), np.uint8)])
    _, _, poly, made = result(soup, np.zeros(2, int), size=16)
    path = folder / "plane.glb"
    engine.write_textured(path, poly, made)
    before = engine.read_textured(path)
    document, body = meshfiles.of_glb(path.read_bytes())
    base = document["materials"][0]["pbrMetallicRoughness"]
    base["baseColorTexture"]["extensions"] = {"KHR_texture_transform": transform}
    document["extensionsUsed"] = ["KHR_texture_transform"]
    path.write_bytes(meshfiles.glb(document, body))
    return before.uv, engine.read_textured(path).uv


def test_texture_transforms_of_gltf_are_obeyed(tmp_path):
    before, after = transformed_glb(tmp_path, offset=[0.25, 0.5], scale=[2, 3])
    assert np.allclose(after[..., 0], 0.25 + 2 * before[..., 0], atol=1e-6)
    assert np.allclose(1 - after[..., 1], 0.5 + 3 * (1 - before[..., 1]), atol=1e-6)
    # A turn in the convention of Blender's importer: u and v upward are turned counter-clockwise.
    turn, sx, sy, ox, oy = 0.7, 2.0, 0.5, 0.1, 0.3
    before, after = transformed_glb(tmp_path, offset=[ox, oy], scale=[sx, sy], rotation=turn)
    c, s = np.cos(turn), np.sin(turn)
    x, y = sx * before[..., 0], sy * before[..., 1]
    assert np.allclose(after[..., 0], c * x - s * y + ox + sy * s, atol=1e-6)
    assert np.allclose(after[..., 1], s * x + c * y + 1 - oy - sy * c, atol=1e-6)
