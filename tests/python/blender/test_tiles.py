"""UDIM tiles and several materials of a result in Blender, and textures after an edit."""

import bpy
import numpy as np
import pytest
import scans

from isimp.blender.scene import store
from isimp.blender.texturing import materials
from test_texture import COLOURS, image_of, shader, shown, simplify, textured_cube


def tiled_image(folder, name, colours):
    """A packed image of tiles of one colour each."""
    for number, colour in colours.items():
        single = image_of(f"{name}.{number}", np.asarray(colour))
        single.filepath_raw, single.file_format = str(folder / f"{name}.{number}.png"), "PNG"
        single.save()
        bpy.data.images.remove(single)
    image = bpy.data.images.load(str(folder / f"{name}.{min(colours)}.png"))
    image.source = "TILED"
    for number in sorted(colours.keys() - {tile.number for tile in image.tiles}):
        image.tiles.new(number)
    return image


def udim_cube(folder, pack=False):
    """A cube whose level sides lie in tile 1012, the others in 1001."""
    scan = scans.cube()
    layer = scan.data.uv_layers.new(name="Scan UV")
    uv = np.full((len(scan.data.loops), 2), 0.5, np.float32)
    uv += np.random.default_rng(0).uniform(-0.4, 0.4, uv.shape)
    level = np.zeros(len(scan.data.loops), bool)
    for polygon in scan.data.polygons:
        level[polygon.loop_start : polygon.loop_start + polygon.loop_total] = abs(polygon.normal.z) > 0.5
    uv[level] += [1, 1]
    layer.data.foreach_set("uv", uv.ravel())
    image = tiled_image(folder, "skin", {1001: COLOURS[0], 1012: COLOURS[1]})
    if pack:
        image.pack()
    scan.data.materials.append(scans.material_of("skin", image))
    return scan


def colours_of(result, tiles, uv):
    """The colour in the middle of each side of the cube, by whether the side is level."""
    found = {}
    for polygon in result.data.polygons:
        x, y = np.mean([uv[i].uv[:] for i in polygon.loop_indices], axis=0)
        number = 1001 + int(x) + 10 * int(y)
        pixels = tiles[number]
        at = pixels[int((1 - y % 1) * len(pixels)), int(x % 1 * len(pixels)), :3]
        found.setdefault(bool(abs(polygon.normal.z) > 0.5), []).append(at.astype(int).tolist())
    assert all(np.ptp(colours, axis=0).max() <= 1 for colours in found.values())
    return {level: colours[0] for level, colours in found.items()}


@pytest.mark.parametrize("pack", [False, True])
def test_tiles_of_a_scan_are_read(tmp_path, pack):
    udim_cube(tmp_path, pack)
    if pack:
        for file in tmp_path.glob("*.png"):
            file.unlink()
    result = simplify()
    assert bpy.ops.isimp.texture(size=64) == {"FINISHED"}
    image = shown(result)
    assert image.source != "TILED"
    colours = colours_of(result, {1001: materials.pixels(image)}, result.data.uv_layers.active.data)
    assert colours == {False: COLOURS[0].tolist(), True: COLOURS[1].tolist()}


def test_a_missing_tile_is_named(tmp_path):
    udim_cube(tmp_path)
    assert bpy.ops.isimp.partition(proxies=6) == {"FINISHED"}
    (tmp_path / "skin.1012.png").unlink()
    assert bpy.ops.isimp.mesh(keep_texture=False) == {"FINISHED"}
    with pytest.raises(RuntimeError, match=r"The tile 1012 of the image 'skin.1001.png' can't be read"):
        bpy.ops.isimp.texture(size=64)


def test_a_result_of_several_tiles_is_one_packed_image(tmp_path):
    scan = textured_cube()
    result = simplify()
    assert bpy.ops.isimp.texture(size=64, tiles=2) == {"FINISHED"}
    assert store.load(scan).texture().tiles == 2
    image = shown(result)
    assert image.source == "TILED"
    assert [tile.number for tile in image.tiles] == [1001, 1002]
    assert len(image.packed_files) == 2
    read = materials.pixels(image)
    assert {number: tile.shape for number, tile in read.items()} == {1001: (64, 64, 4), 1002: (64, 64, 4)}
    uv = result.data.uv_layers["Scan UV"].data
    colours = colours_of(result, read, uv)
    assert np.abs(np.array([colours[False], colours[True]]) - COLOURS).max() <= 1
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "tiles.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "tiles.blend"))
    image = next(image for image in bpy.data.images if " color" in image.name)
    assert {number: np.array_equal(tile, read[number]) for number, tile in materials.pixels(image).items()} == {
        1001: True,
        1002: True,
    }


def test_again_with_one_tile_it_is_a_plain_image():
    textured_cube()
    result = simplify()
    assert bpy.ops.isimp.texture(size=64, tiles=2, occlusion=True) == {"FINISHED"}
    assert bpy.ops.isimp.texture(size=64) == {"FINISHED"}
    assert shown(result).source != "TILED"
    assert sum(bool(image.get("isimp_texture")) for image in bpy.data.images) == 2
    uv = np.array([corner.uv[:] for corner in result.data.uv_layers["Scan UV"].data])
    assert uv.max() <= 1


def test_materials_are_kept_apart_and_joined_again():
    scan = textured_cube()
    result = simplify()
    assert bpy.ops.isimp.texture(size=32, materials=True) == {"FINISHED"}
    assert store.load(scan).texture().materials
    assert len(result.data.materials) == 2
    for polygon in result.data.polygons:
        material = result.data.materials[polygon.material_index]
        wanted = int(abs(polygon.normal.z) > 0.5)
        assert material.name.endswith(f"m{wanted}")
        image = shader(material).inputs["Base Color"].links[0].from_node.image
        assert np.abs(materials.pixels(image)[16, 16, :3] - COLOURS[wanted].astype(int)).max() <= 1
    shader(result.data.materials[0]).inputs["Roughness"].default_value = 0.3
    assert bpy.ops.isimp.texture(size=64, materials=True) == {"FINISHED"}
    assert len(result.data.materials) == 2
    assert shader(result.data.materials[0]).inputs["Roughness"].default_value == pytest.approx(0.3)
    assert sum(bool(image.get("isimp_texture")) for image in bpy.data.images) == 4
    assert bpy.ops.isimp.texture(size=64) == {"FINISHED"}
    assert len(result.data.materials) == 1
    assert sum(bool(image.get("isimp_texture")) for image in bpy.data.images) == 2
    assert [material.name for material in scan.data.materials] == ["m0", "m1"]


def sphere_with_a_picture():
    """A sphere of many faces with an image of noise."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=32)
    scan = bpy.context.object
    image = bpy.data.images.new("noise", 64, 64)
    image.pixels.foreach_set(np.random.default_rng(0).random(4 * 64 * 64).astype(np.float32))
    image.pack()
    scan.data.materials.append(scans.material_of("noise", image))
    scans.activate(scan)
    return scan


def test_after_an_edit_the_texture_is_made_again_with_its_settings():
    scan = sphere_with_a_picture()
    assert bpy.ops.isimp.partition(proxies=60) == {"FINISHED"}
    assert bpy.ops.isimp.mesh() == {"FINISHED"}
    assert bpy.ops.isimp.texture(size=512) == {"FINISHED"}
    result = bpy.context.object
    result["mine"] = 5
    shader(result.data.materials[0]).inputs["Roughness"].default_value = 0.3
    before = materials.pixels(shown(result))
    scans.activate(scan)
    assert bpy.ops.isimp.add_proxy(face=500) == {"FINISHED"}
    assert bpy.ops.isimp.mesh() == {"FINISHED"}
    assert bpy.context.object == result
    after = materials.pixels(shown(result))
    assert after.shape == before.shape, "the size that was chosen stays"
    assert not np.array_equal(after, before)
    assert result["mine"] == 5
    assert shader(result.data.materials[0]).inputs["Roughness"].default_value == pytest.approx(0.3)
