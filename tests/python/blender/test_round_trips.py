"""A textured result, exported by Blender to the formats of engines and imported again."""

import warnings

import bpy
import numpy as np
import pytest
import scans
from mathutils import Matrix

from isimp.blender.texturing import materials
from test_texture import simplify, textured_cube


def with_textures():
    """The setting that writes images, by its name in this Blender."""
    named = "export_textures" in bpy.ops.wm.usd_export.get_rna_type().properties
    return {"export_textures": True} if named else {"export_textures_mode": "NEW"}


#: for each format: the exporter, the importer, and whether n-gons are kept
FORMATS = {
    "fbx": (
        lambda path: bpy.ops.export_scene.fbx(filepath=path, use_selection=True, path_mode="COPY", embed_textures=True),
        lambda path: bpy.ops.import_scene.fbx(filepath=path),
        True,
    ),
    "usdc": (
        lambda path: bpy.ops.wm.usd_export(filepath=path, selected_objects_only=True, **with_textures()),
        lambda path: bpy.ops.wm.usd_import(filepath=path),
        True,
    ),
    "glb": (
        lambda path: bpy.ops.export_scene.gltf(filepath=path, use_selection=True),
        lambda path: bpy.ops.import_scene.gltf(filepath=path),
        False,
    ),
}
OPERATORS = {"fbx": ("export_scene", "fbx"), "usdc": ("wm", "usd_export"), "glb": ("export_scene", "gltf")}


def need(kind):
    """Skips a test of a format that this Blender does not write and read."""
    group, name = OPERATORS[kind]
    if name not in dir(getattr(bpy.ops, group)):
        pytest.skip(f"this Blender has no exporter of {kind}")
    if kind == "glb" and bpy.app.version < (3, 5, 0) and "bool" not in vars(np):
        pytest.skip("this Blender's importer of glTF does not work with its numpy")


def sent(kind, tmp_path, result):
    """A result, exported and imported again."""
    write, read, _ = FORMATS[kind]
    scans.activate(result)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # Blender's exporters have some
        assert write(str(tmp_path / f"out.{kind}")) == {"FINISHED"}
        there = set(bpy.data.objects)
        assert read(str(tmp_path / f"out.{kind}")) == {"FINISHED"}
    bpy.context.view_layer.update()
    (back,) = (obj for obj in set(bpy.data.objects) - there if obj.type == "MESH")
    return back


def corners(obj):
    """(L, 5) place in the world and UV of each corner, and (Q,) the corners of each polygon."""
    mesh = obj.data
    places = scans.world(obj)[[loop.vertex_index for loop in mesh.loops]]
    layer = next(layer for layer in mesh.uv_layers if layer.active_render)
    uv = np.array([item.uv[:] for item in layer.data])
    return np.c_[places, uv], [polygon.loop_total for polygon in mesh.polygons]


def image_at(material, place):
    """The image at an input of a material's Principled BSDF, through any nodes."""
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    sockets = [shader.inputs[place]]
    while sockets:
        socket = sockets.pop()
        for link in socket.links:
            if link.from_node.type == "TEX_IMAGE":
                return link.from_node.image
            sockets += list(link.from_node.inputs)
    return None


def pixels_of(image):
    width, height = image.size
    values = np.empty(4 * width * height, np.float32)
    image.pixels.foreach_get(values)
    return values.reshape(height, width, 4)[:, :, :3]


@pytest.mark.parametrize("kind", FORMATS)
def test_uvs_images_and_material_come_back(kind, tmp_path):
    need(kind)
    scan = textured_cube()
    scan.matrix_world = Matrix.Translation((1, 2, 3)) @ Matrix.Rotation(0.5, 4, "X")
    result = simplify()
    assert bpy.ops.isimp.texture(size=64) == {"FINISHED"}
    bpy.context.view_layer.update()
    (before, sides), (material,) = corners(result), result.data.materials
    images = {place: pixels_of(image_at(material, place)) for place in ("Base Color", "Normal")}
    assert np.abs(images["Base Color"] - images["Normal"]).max() > 0.5
    back = sent(kind, tmp_path, result)
    after, sides_after = corners(back)
    _, _, keeps_ngons = FORMATS[kind]
    assert sides_after == (sides if keeps_ngons else [3] * sum(side - 2 for side in sides))
    for one, other in ((after, before), (before, after)):
        assert np.abs(one[:, None] - other[None]).max(axis=2).min(axis=1).max() < 1e-5
    assert len(back.data.materials) == 1
    for place, wanted in images.items():
        image = image_at(back.data.materials[0], place)
        assert image is not None, place
        assert image != image_at(material, place)
        assert np.abs(pixels_of(image) - wanted).max() < 1 / 255 + 1e-6, place


def test_tiles_come_back_from_usd(tmp_path):
    need("usdc")
    if bpy.app.version < (4, 0, 0):
        pytest.skip("this Blender does not write and read tiles in USD")
    textured_cube()
    result = simplify()
    assert bpy.ops.isimp.texture(size=64, tiles=2) == {"FINISHED"}
    before, _ = corners(result)
    wanted = materials.pixels(image_at(result.data.materials[0], "Base Color"))
    back = sent("usdc", tmp_path, result)
    assert np.abs(corners(back)[0][:, 3:] - before[:, 3:]).max() < 1e-6
    image = image_at(back.data.materials[0], "Base Color")
    assert image.source == "TILED"
    found = materials.pixels(image)
    assert sorted(found) == sorted(wanted) == [1001, 1002]
    assert all(np.array_equal(found[number], wanted[number]) for number in wanted)
