"""Keep Texture: the scan's images on the result."""

import types

import bpy
import numpy as np
import pytest
import scans
from drawing import Recorder

from isimp.blender.panel import result as result_panel
from isimp.blender.scene import result as results
from isimp.blender.scene import store
from isimp.blender.texturing import materials, texture
from isimp.recipe import Mesh, Partition, Recipe, Texture

COLOURS = np.array([[200, 30, 30], [30, 160, 90]], np.uint8)


def image_of(name, colour, size=16):
    image = bpy.data.images.new(name, size, size)
    image.pixels.foreach_set(np.tile(np.append(colour / 255, 1), size * size).astype(np.float32))
    image.pack()
    return image


def textured_cube(quads=False):
    """A cube whose upper and lower halves of faces have two images."""
    scan = scans.cube(quads=quads)
    layer = scan.data.uv_layers.new(name="Scan UV")
    layer.data.foreach_set("uv", np.random.default_rng(0).random(2 * len(scan.data.loops)).astype(np.float32))
    for i, colour in enumerate(COLOURS):
        scan.data.materials.append(scans.material_of(f"m{i}", image_of(f"i{i}", colour)))
    flags = np.zeros(len(scan.data.polygons), np.int32)
    for polygon in scan.data.polygons:
        flags[polygon.index] = abs(polygon.normal.z) > 0.5
    scan.data.polygons.foreach_set("material_index", flags)
    return scan


def simplify(**settings):
    assert bpy.ops.isimp.partition(proxies=6) == {"FINISHED"}
    assert bpy.ops.isimp.mesh(**settings) == {"FINISHED"}
    return bpy.context.object


def steps_of(scan):
    return store.load(scan).steps


def shader(material):
    return next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")


def shown(result):
    """The image of the result's material."""
    (material,) = result.data.materials
    return shader(material).inputs["Base Color"].links[0].from_node.image


@pytest.mark.parametrize("quads", [False, True])
def test_each_polygon_shows_the_colour_of_its_side(quads):
    scan = textured_cube(quads)
    before = [material.name for material in scan.data.materials]
    result = simplify()
    assert bpy.ops.isimp.texture(size=128) == {"FINISHED"}
    image = shown(result)
    assert tuple(image.size) == (128, 128)
    assert image.packed_file is not None
    values = np.empty(4 * 128 * 128, np.float32)
    image.pixels.foreach_get(values)
    values = np.round(values.reshape(128, 128, 4) * 255)
    uv = result.data.uv_layers["Scan UV"].data
    for polygon in result.data.polygons:
        x, y = np.mean([uv[i].uv[:] for i in polygon.loop_indices], axis=0)
        wanted = COLOURS[int(abs(polygon.normal.z) > 0.5)]
        assert np.abs(values[int(y * 128), int(x * 128), :3] - wanted).max() <= 1
    assert [material.name for material in scan.data.materials] == before
    (material,) = result.data.materials
    normal = shader(material).inputs["Normal"].links[0].from_node
    assert normal.inputs["Color"].links[0].from_node.image.colorspace_settings.name == "Non-Color"


def test_mesh_keeps_the_texture_by_default_and_again():
    textured_cube()
    result = simplify()
    assert shown(result).packed_file is not None
    shader(result.data.materials[0]).inputs["Roughness"].default_value = 0.25
    assert bpy.ops.isimp.mesh(chord_tolerance=0.1) == {"FINISHED"}
    assert len(result.data.uv_layers) == 1
    (material,) = result.data.materials
    assert shader(material).inputs["Roughness"].default_value == 0.25
    assert sum(bool(image.get("isimp_texture")) for image in bpy.data.images) == 2


def test_a_copy_of_the_result_keeps_its_images():
    scan = textured_cube()
    result = simplify()
    before = shown(result), list(result.data.materials)
    bpy.ops.object.duplicate()
    copy = bpy.context.object
    scans.activate(scan)
    assert bpy.ops.isimp.partition(proxies=9) == {"FINISHED"}
    assert bpy.ops.isimp.mesh() == {"FINISHED"}
    assert bpy.context.object == result
    assert (shown(copy), list(copy.data.materials)) == before
    assert shown(result) != shown(copy)
    assert result.data.materials[0] != copy.data.materials[0]
    assert shown(copy).packed_file is not None


def test_the_texture_is_shown_until_the_scan_is():
    textured_cube()
    simplify()
    screens = [window.screen for window in bpy.context.window_manager.windows]
    views = [a.spaces.active.shading for s in screens for a in s.areas if a.type == "VIEW_3D"]
    assert {view.color_type for view in views} == {"TEXTURE"}
    bpy.ops.isimp.swap()
    assert {view.color_type for view in views} == {"VERTEX"}
    bpy.ops.isimp.swap()
    assert {view.color_type for view in views} == {"TEXTURE"}
    simplify(keep_texture=False)
    assert {view.color_type for view in views} == {"TEXTURE"}, "the result has its texture still"
    bpy.context.object.data.materials.clear()
    bpy.ops.isimp.swap()
    bpy.ops.isimp.swap()
    assert {view.color_type for view in views} == {"MATERIAL"}, "what was there before"
    for view in views:
        view.color_type = "SINGLE"
    bpy.ops.isimp.swap()
    bpy.ops.isimp.swap()
    assert {view.color_type for view in views} == {"SINGLE"}


def test_mesh_in_edit_mode_of_the_scan_keeps_the_texture():
    """There the layers of the mesh are empty."""
    textured_cube()
    image = shown(simplify())
    wanted = image.pixels[:]
    bpy.ops.isimp.swap()
    scans.mode("EDIT")
    meshes = len(bpy.data.meshes)
    assert bpy.ops.isimp.mesh() == {"FINISHED"}
    assert shown(bpy.context.object).pixels[:] == wanted
    assert len(bpy.data.meshes) == meshes


def test_the_recipe_has_the_texture():
    scan = textured_cube()
    simplify()
    assert [step.kind for step in steps_of(scan)] == ["partition", "mesh", "texture"]
    assert bpy.ops.isimp.texture(size=64) == {"FINISHED"}
    assert steps_of(scan)[-1].size == 64
    assert bpy.ops.isimp.mesh(chord_tolerance=0.1) == {"FINISHED"}
    assert tuple(shown(bpy.context.object).size) == (64, 64), "Mesh keeps the size"
    assert bpy.ops.isimp.step_delete(step=2) == {"FINISHED"}
    assert [step.kind for step in steps_of(scan)] == ["partition", "mesh"]


def test_the_buttons_of_the_panel_change_one_setting_each():
    scan = textured_cube()
    result = simplify()
    assert texture.image_width(result) == shown(result).size[0]

    def press(label):
        layout = Recorder([])
        result_panel.ISIMP_MT_texture.draw(types.SimpleNamespace(layout=layout), bpy.context)
        assert bpy.ops.isimp.texture(**layout.buttons[label].values) == {"FINISHED"}
        return steps_of(scan)[-1]

    assert bpy.ops.isimp.texture(size=64, occlusion=True) == {"FINISHED"}
    step = press("128 px")
    assert (step.size, step.occlusion, step.materials, texture.image_width(result)) == (128, True, False, 128)
    assert press("64 px").size == 64
    step = press("Keep Materials Apart")
    assert (step.size, step.occlusion, step.materials, len(result.data.materials)) == (64, True, True, 2)
    step = press("Ambient Occlusion")
    assert (step.size, step.occlusion, step.materials) == (64, False, True)
    assert press("Keep Materials Apart").materials is False
    assert press("Like the Scan").size == 0


def test_a_recipe_with_a_texture_makes_it(tmp_path):
    scan = textured_cube()
    recipe = Recipe((Partition(proxies=6, count_by="proxies"), Mesh(), Texture(size=32)))
    (tmp_path / "r.json").write_text(recipe.to_json())
    assert bpy.ops.isimp.recipe_import(filepath=str(tmp_path / "r.json")) == {"FINISHED"}
    assert tuple(shown(bpy.context.object).size) == (32, 32)
    assert bpy.context.object != scan


def test_mesh_reports_why_there_is_no_texture():
    scan = textured_cube()
    scan.modifiers.new("wide", "CAST")
    result = simplify()
    assert len(result.data.polygons) > 0
    assert len(result.data.materials) == 0


def test_undo_takes_it_away_in_one_step():
    textured_cube()
    simplify(keep_texture=False)
    scans.push("before")
    assert bpy.ops.isimp.texture(size=64) == {"FINISHED"}
    scans.push("texture")
    bpy.ops.ed.undo()
    result = next(obj for obj in bpy.data.objects if obj.name.endswith(".simplified"))
    assert len(result.data.materials) == 0


def test_what_it_cannot_read_is_said():
    scan = scans.cube()
    simplify()
    scan.data.uv_layers.new(name="UV")
    with pytest.raises(RuntimeError, match="no image texture"):
        bpy.ops.isimp.texture()
    material = scans.material_of("procedural", None)
    nodes = material.node_tree.nodes
    noise = nodes.new("ShaderNodeTexNoise")
    material.node_tree.links.new(noise.outputs["Color"], shader(material).inputs["Base Color"])
    scan.data.materials.append(material)
    with pytest.raises(RuntimeError, match=r"'procedural' comes from no image on a UV map\. Bake it"):
        bpy.ops.isimp.texture()


def test_an_edited_result_is_left_alone():
    textured_cube()
    result = simplify(keep_texture=False)
    result.data.flip_normals()
    with pytest.raises(RuntimeError, match="has changed since Mesh"):
        bpy.ops.isimp.texture()
    assert len(result.data.materials) == 0


def test_polygons_that_blender_removes_leave_a_result_without_a_texture(monkeypatch, capfd):
    textured_cube()
    bpy.ops.isimp.partition(proxies=6)
    monkeypatch.setattr(texture, "corner_order", lambda result, outcome: None)
    assert bpy.ops.isimp.mesh() == {"FINISHED"}
    told = capfd.readouterr().out
    assert "The result has no texture: Blender removed polygons" in told
    assert not results.is_edited(bpy.context.object)
    assert texture.image_width(bpy.context.object) == 0


@pytest.mark.parametrize(("is_float", "space"), [(False, "Non-Color"), (True, "sRGB")])
def test_colours_of_linear_images_are_stored_in_srgb(is_float, space):
    scan = textured_cube()
    for slot in scan.material_slots:
        image = bpy.data.images.new("Linear", 16, 16, float_buffer=is_float)
        image.colorspace_settings.name = space
        image.pixels.foreach_set(np.full(4 * 16 * 16, 0.2, np.float32))
        image.pack()
        shader(slot.material).inputs["Base Color"].links[0].from_node.image = image
    made = materials.pixels(shown(simplify()))
    assert made[8, 8, :3].tolist() == [124] * 3, "0.2 is 0.485 in sRGB"


def half_cube(turn):
    """A cube whose map for renders shows the lower, red half of its image, and whose map B the upper, green one."""
    scan = scans.cube()
    for name, low in (("A", 0), ("B", 0.5)):
        uv = np.random.default_rng(0).random((len(scan.data.loops), 2)) * (1, 0.4) + (0, low + 0.05)
        scan.data.uv_layers.new(name=name).data.foreach_set("uv", uv.astype(np.float32).ravel())
    image = bpy.data.images.new("Halves", 16, 16)
    colours = np.append(np.repeat(COLOURS, 128, axis=0) / 255, np.ones((256, 1)), axis=1)
    image.pixels.foreach_set(colours.astype(np.float32).ravel())
    image.pack()
    scan.data.materials.append(scans.material_of("Halves", image))
    tree = scan.data.materials[0].node_tree
    turn(tree, next(node for node in tree.nodes if node.type == "TEX_IMAGE").inputs["Vector"])
    return scan


def by_name(tree, socket):
    node = tree.nodes.new("ShaderNodeUVMap")
    node.uv_map = "B"
    tree.links.new(node.outputs["UV"], socket)


def by_mapping(tree, socket, kind="POINT", lift=0.5):
    node, source = tree.nodes.new("ShaderNodeMapping"), tree.nodes.new("ShaderNodeTexCoord")
    node.vector_type = kind
    node.inputs["Location"].default_value[1] = lift
    tree.links.new(source.outputs["UV"], node.inputs["Vector"])
    tree.links.new(node.outputs["Vector"], socket)


def by_inverse_mapping(tree, socket):
    by_mapping(tree, socket, "TEXTURE", -0.5)


@pytest.mark.parametrize("turn", [by_name, by_mapping, by_inverse_mapping])
def test_images_lie_where_their_nodes_place_them(turn):
    half_cube(turn)
    image = materials.pixels(shown(simplify()))
    assert np.abs(image[:, :, :3] - COLOURS[1].astype(int)).max() <= 2


def test_an_image_that_other_nodes_place_is_refused():
    def turn(tree, socket):
        tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"], socket)

    half_cube(turn)
    simplify()
    with pytest.raises(RuntimeError, match="'Halves' comes from no image on a UV map"):
        bpy.ops.isimp.texture()
