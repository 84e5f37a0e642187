"""Roughness, metallic, emission and normal maps of a scan's materials on the result."""

import json
import warnings

import bpy
import numpy as np
import pytest
import scans

from isimp.blender.scene import store
from isimp.blender.texturing import materials
from test_texture import COLOURS, image_of, shader, simplify, textured_cube


def data_image(name, value):
    image = image_of(name, np.broadcast_to(value, 3).astype(float))
    image.colorspace_settings.name = "Non-Color"
    return image


def plug(material, image, place, between=None, output=None):
    """An image at an input, through a node of another kind if given."""
    tree = material.node_tree
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    socket = node.outputs["Color"]
    if between is not None:
        middle = tree.nodes.new(between)
        tree.links.new(socket, middle.inputs["Color"])
        socket = middle.outputs[output]
    tree.links.new(socket, place)
    return node


def values_of(image):
    width, height = image.size
    values = np.empty(4 * width * height, np.float32)
    image.pixels.foreach_get(values)
    return np.round(values.reshape(height, width, 4) * 255)


def linked(place):
    return place.links[0].from_node.image


def shown(result, image):
    """The colour in the middle of each side of the cube, by whether the side is level."""
    values, uv, found = values_of(image), result.data.uv_layers.active.data, {}
    for polygon in result.data.polygons:
        x, y = np.mean([uv[i].uv[:] for i in polygon.loop_indices], axis=0)
        at = values[int(y * image.size[1]), int(x * image.size[0]), :3]
        found.setdefault(bool(abs(polygon.normal.z) > 0.5), []).append(at.tolist())
    assert all(np.ptp(colours, axis=0).max() <= 1 for colours in found.values())
    return {level: colours[0] for level, colours in found.items()}


def test_images_and_numbers_at_the_inputs_are_carried():
    scan = textured_cube()
    walls, caps = (shader(material) for material in scan.data.materials)
    plug(scan.data.materials[0], data_image("rough", 51), walls.inputs["Roughness"])
    caps.inputs["Roughness"].default_value = 0.8
    separate = "ShaderNodeSeparateColor"
    plug(scan.data.materials[0], data_image("metal", [0, 0, 102]), walls.inputs["Metallic"], separate, "Blue")
    for node in (walls, caps):
        node.inputs["Emission Strength"].default_value = 2.0
    materials.emission_of(walls).default_value = (0, 0, 0, 1)
    plug(scan.data.materials[1], image_of("glow", COLOURS[0]), materials.emission_of(caps))
    result = simplify()
    assert bpy.ops.isimp.texture(size=64) == {"FINISHED"}
    (material,) = result.data.materials
    made = shader(material)
    assert shown(result, linked(made.inputs["Roughness"])) == {False: [51] * 3, True: [204] * 3}
    assert shown(result, linked(made.inputs["Metallic"])) == {False: [102] * 3, True: [0] * 3}
    glow = linked(materials.emission_of(made))
    assert shown(result, glow)[False] == [0, 0, 0]
    assert np.abs(np.array(shown(result, glow)[True]) - COLOURS[0]).max() <= 1
    assert made.inputs["Emission Strength"].default_value == 2.0
    assert glow.colorspace_settings.name == "sRGB"
    assert linked(made.inputs["Roughness"]).colorspace_settings.name == "Non-Color"
    assert all(image.packed_file for image in bpy.data.images if image.get("isimp_texture"))


def test_what_is_one_number_stays_a_number():
    scan = textured_cube()
    for material in scan.data.materials:
        shader(material).inputs["Roughness"].default_value = 0.9
        shader(material).inputs["Metallic"].default_value = 0.25
    result = simplify()
    made = shader(result.data.materials[0])
    assert not made.inputs["Roughness"].is_linked
    assert made.inputs["Roughness"].default_value == pytest.approx(0.9, abs=1e-4)
    assert made.inputs["Metallic"].default_value == pytest.approx(0.25, abs=1e-4)
    assert not materials.emission_of(made).is_linked
    assert sum(bool(image.get("isimp_texture")) for image in bpy.data.images) == 2


def test_again_the_layers_take_the_place_of_the_last_ones():
    scan = textured_cube()
    plug(scan.data.materials[0], data_image("rough", 51), shader(scan.data.materials[0]).inputs["Roughness"])
    result = simplify()
    for size in (64, 96):
        assert bpy.ops.isimp.texture(size=size) == {"FINISHED"}
    assert tuple(linked(shader(result.data.materials[0]).inputs["Roughness"]).size) == (96, 96)
    assert sum(bool(image.get("isimp_texture")) for image in bpy.data.images) == 3


def test_the_scans_normal_map_is_in_that_of_the_result():
    scan = textured_cube()
    layer = scan.data.uv_layers.active
    for polygon in scan.data.polygons:
        axes = np.abs(np.array(polygon.normal)).argsort()[:2]
        for i in polygon.loop_indices:  # u along the first of the side's axes, and v along the second
            layer.data[i].uv = [scan.data.vertices[scan.data.loops[i].vertex_index].co[int(a)] / 2 + 0.5 for a in axes]
    material, place = scan.data.materials[1], shader(scan.data.materials[1]).inputs["Normal"]
    leaning = np.array([0.6, 0, 0.8]) * 127.5 + 127.5
    plug(material, data_image("bent", leaning), place, "ShaderNodeNormalMap", "Normal")
    result = simplify()
    turn = shader(result.data.materials[0]).inputs["Normal"].links[0].from_node
    image = linked(turn.inputs["Color"])
    values, uv = values_of(image), result.data.uv_layers.active.data
    for polygon in result.data.polygons:
        x, y = np.mean([uv[i].uv[:] for i in polygon.loop_indices], axis=0)
        local = values[int(y * image.size[1]), int(x * image.size[0]), :3] / 127.5 - 1
        lean = 0.6 if abs(polygon.normal.z) > 0.5 else 0.0
        assert np.hypot(*local[:2]) == pytest.approx(lean, abs=0.03)


def test_what_comes_from_no_image_is_left_out_and_said(capfd):
    scan = textured_cube()
    tree = scan.data.materials[0].node_tree
    noise = tree.nodes.new("ShaderNodeTexNoise")
    tree.links.new(noise.outputs["Color"], shader(scan.data.materials[0]).inputs["Roughness"])
    result = simplify()
    assert (
        "'Roughness' of the material 'm0' comes from no image on a UV map, and is left out." in capfd.readouterr().out
    )
    assert shader(result.data.materials[0]).inputs["Base Color"].is_linked
    assert bpy.ops.isimp.texture(size=64) == {"FINISHED"}
    assert "'Roughness' of the material 'm0'" in capfd.readouterr().out


def test_ambient_occlusion_is_made_and_kept_by_the_recipe(tmp_path):
    scan = textured_cube()
    result = simplify()
    assert bpy.ops.isimp.texture(size=64, occlusion=True, occlusion_distance=0.5) == {"FINISHED"}
    step = store.load(scan).texture()
    assert (step.size, step.occlusion, step.occlusion_distance) == (64, True, 0.5)
    assert bpy.ops.isimp.mesh(chord_tolerance=0.1) == {"FINISHED"}
    assert store.load(scan).texture() == step
    (image,) = (image for image in bpy.data.images if image.get("isimp_texture") == "occlusion")
    assert (values_of(image) == 255).all()  # a cube hides nothing from itself
    assert image.colorspace_settings.name == "Non-Color"
    scans.activate(result)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # Blender's exporters have some
        bpy.ops.export_scene.gltf(
            filepath=str(tmp_path / "out.gltf"), use_selection=True, export_format="GLTF_SEPARATE"
        )
    (material,) = json.loads((tmp_path / "out.gltf").read_text())["materials"]
    assert "occlusionTexture" in material
    material = result.data.materials[0]
    shader(material).inputs["Roughness"].default_value = 0.125
    assert bpy.ops.isimp.texture(size=64) == {"FINISHED"}
    assert not any(image.get("isimp_texture") == "occlusion" for image in bpy.data.images)
    assert result.data.materials[0] == material
    assert shader(material).inputs["Base Color"].is_linked
    assert shader(material).inputs["Roughness"].default_value == 0.125


def test_a_layer_that_the_scan_gets_later_is_plugged_in_where_nothing_of_the_users_is():
    scan = textured_cube()
    result = simplify()
    made, own = shader(result.data.materials[0]), image_of("own", COLOURS[0])
    plug(result.data.materials[0], own, made.inputs["Metallic"])
    for place in ("Roughness", "Metallic"):
        plug(scan.data.materials[0], data_image(place, 51), shader(scan.data.materials[0]).inputs[place])
    assert bpy.ops.isimp.texture(size=64) == {"FINISHED"}
    assert linked(made.inputs["Roughness"]).get("isimp_texture") == "roughness"
    assert linked(made.inputs["Metallic"]) == own
    assert not any(image.get("isimp_texture") == "metallic" for image in bpy.data.images)


def test_a_height_map_of_an_earlier_version_goes_with_its_nodes():
    textured_cube()
    result = simplify()
    assert bpy.ops.isimp.texture(size=64) == {"FINISHED"}
    material = result.data.materials[0]
    old = bpy.data.images.new("height", 64, 64, float_buffer=True)
    old["isimp_texture"] = "height"
    node, shift = (material.node_tree.nodes.new(f"ShaderNode{kind}") for kind in ("TexImage", "Displacement"))
    node.image = old
    material.node_tree.links.new(node.outputs["Color"], shift.inputs["Height"])
    assert bpy.ops.isimp.texture(size=64) == {"FINISHED"}
    assert not any(node.type == "DISPLACEMENT" for node in material.node_tree.nodes)
    assert "height" not in bpy.data.images


def test_a_layer_may_lie_on_another_map_than_the_colours():
    scan = textured_cube()
    scan.data.uv_layers.new(name="Zero", do_init=False).data.foreach_set("uv", np.zeros(2 * len(scan.data.loops)))
    values = np.full((256, 4), 0.8, np.float32)
    values[0] = 0.2
    image = bpy.data.images.new("Corner", 16, 16)
    image.colorspace_settings.name = "Non-Color"
    image.pixels.foreach_set(values.ravel())
    image.pack()
    for slot in scan.material_slots:
        node = plug(slot.material, image, shader(slot.material).inputs["Roughness"])
        node.interpolation = "Closest"
        names = slot.material.node_tree.nodes.new("ShaderNodeUVMap")
        names.uv_map = "Zero"
        slot.material.node_tree.links.new(names.outputs["UV"], node.inputs["Vector"])
    scan.data.uv_layers["Scan UV"].active_render = True
    (material,) = simplify().data.materials
    made = shader(material).inputs["Roughness"]
    value = values_of(linked(made)).mean() / 255 if made.is_linked else made.default_value
    assert value < 0.7, "the corner of the image is dark"
