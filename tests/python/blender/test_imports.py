"""Import of scans with the look of their files: UV maps, materials, images, colours, and the direction that is up."""

import shutil
from pathlib import Path

import bpy
import numpy as np
import pytest
import scans

from isimp.blender.panel import result as result_panel
from isimp.blender.scene import places
from isimp.blender.texturing import texture

OPS = bpy.ops.isimp
RED, GREEN = (200, 30, 30), (30, 160, 90)
SHARED = Path(__file__).resolve().parents[4] / "shared" / "data" / "textured"


def imported(path, **more):
    assert OPS.import_scan(filepath=str(path), **more) == {"FINISHED"}
    return bpy.context.object


def write_image(path, colour, size=16):
    image = bpy.data.images.new("made", size, size)
    image.pixels.foreach_set(np.tile(np.append(np.array(colour) / 255, 1), size * size).astype(np.float32))
    image.filepath_raw, image.file_format = str(path), "PNG"
    image.save()
    bpy.data.images.remove(image)


def write_cube(folder, library="cube.mtl"):
    """An OBJ of a cube with Y up: the sides are red, top and bottom are green, by two images in a folder below."""
    scan = scans.cube(cells=4)
    (folder / "images").mkdir()
    write_image(folder / "images" / "red.png", RED)
    write_image(folder / "images" / "green.png", GREEN)
    lines = [f"mtllib {library}", *(f"v {x} {z} {-y}" for x, y, z in scans.coordinates(scan.data).tolist())]
    lines += ["vt 0.25 0.25", "vt 0.75 0.25", "vt 0.25 0.75", "vn 0 0 1"]
    for name, wanted in (("red", False), ("green", True)):
        lines.append(f"usemtl {name}")
        for polygon in scan.data.polygons:
            if (abs(polygon.normal.z) > 0.5) == wanted:
                a, b, c = (v + 1 for v in polygon.vertices)
                lines.append(f"f {a}/1/1 {b}/2/1 {c}/3/1")
    (folder / "cube.obj").write_text("\n".join([*lines, "l 1 2"]) + "\n")
    mtl = "newmtl red\nKd .1 .2 .3\nmap_Kd images/red.png\nnewmtl green\nPr .3\nmap_Kd images\\green.png\n"
    (folder / "cube.mtl").write_text(mtl)
    bpy.data.objects.remove(scan)
    return folder / "cube.obj"


def shader(material):
    return next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")


def image_of(material):
    return shader(material).inputs["Base Color"].links[0].from_node.image


def warnings_of(capfd):
    return [line for line in capfd.readouterr().out.splitlines() if line.startswith("Warning: ")]


def test_an_obj_has_the_look_that_blenders_own_importer_gives_it(tmp_path):
    path = write_cube(tmp_path)
    ours = imported(path)
    bpy.ops.wm.obj_import(filepath=str(path))
    theirs = next(obj for obj in bpy.context.selected_objects if obj != ours)
    assert np.allclose(ours.matrix_world, theirs.matrix_world, atol=1e-6)
    assert np.array_equal(scans.coordinates(ours.data), scans.coordinates(theirs.data))
    assert [layer.name for layer in ours.data.uv_layers] == [layer.name for layer in theirs.data.uv_layers] == ["UVMap"]
    for polygon, other in zip(ours.data.polygons, theirs.data.polygons, strict=True):
        assert list(polygon.vertices) == list(other.vertices)
        materials = (ours.data.materials[polygon.material_index], theirs.data.materials[other.material_index])
        assert materials[0].name == materials[1].name.split(".")[0]
        assert image_of(materials[0]) == image_of(materials[1])
    uv = [np.array([corner.uv[:] for corner in mesh.uv_layers[0].data]) for mesh in (ours.data, theirs.data)]
    assert np.array_equal(*uv)
    red, green = (shader(ours.data.materials[name]) for name in ("red", "green"))
    assert tuple(red.inputs["Base Color"].default_value)[:3] == pytest.approx((0.1, 0.2, 0.3))
    assert green.inputs["Roughness"].default_value == pytest.approx(0.3)


def test_an_imported_texture_reaches_the_result(tmp_path):
    scan = imported(write_cube(tmp_path))
    assert texture.is_textured(scan)
    assert OPS.partition(proxies=6) == {"FINISHED"}
    assert result_panel.ISIMP_PT_texture.poll(bpy.context)
    assert OPS.mesh() == {"FINISHED"}
    result = bpy.context.object
    (material,) = result.data.materials
    image = image_of(material)
    values = np.empty(4 * image.size[0] * image.size[1], np.float32)
    image.pixels.foreach_get(values)
    values = np.round(values.reshape(image.size[1], image.size[0], 4) * 255)
    turn = np.array(result.matrix_world)[:3, :3]
    for polygon in result.data.polygons:
        corners = [result.data.uv_layers.active.data[i].uv[:] for i in polygon.loop_indices]
        x, y = np.mean(corners, axis=0) * image.size
        wanted = GREEN if abs((turn @ polygon.normal)[2]) > 0.5 else RED
        assert np.abs(values[int(y), int(x), :3] - wanted).max() <= 1


def test_what_is_missing_or_not_read_is_named(tmp_path, capfd):
    path = write_cube(tmp_path)
    (tmp_path / "images" / "red.png").unlink()
    with (tmp_path / "cube.mtl").open("a") as file:
        file.write("bump images/green.png\n")
    scan = imported(path)
    assert [material.name for material in scan.data.materials] == ["red", "green"]
    assert not shader(scan.data.materials["red"]).inputs["Base Color"].is_linked
    told = warnings_of(capfd)
    assert len(told) == 2
    assert told[0].endswith("Not read of cube.obj: normals, lines, bump maps")
    assert f"the image {tmp_path / 'images' / 'red.png'} does not exist" in told[1]
    (tmp_path / "cube.mtl").unlink()
    scan = imported(path)
    assert "cube.mtl does not exist" in warnings_of(capfd)[-1]
    assert len(scan.data.materials) == 2
    assert scan.data.uv_layers


def test_many_faults_are_one_message(tmp_path, capfd):
    path = write_cube(tmp_path)
    (tmp_path / "cube.mtl").write_text("newmtl red\n" + "Kd wrong\n" * 9 + "newmtl green\n")
    imported(path)
    assert warnings_of(capfd)[-1].endswith("6 problems more")


def test_faces_without_a_material_have_an_empty_slot(tmp_path):
    path = write_cube(tmp_path)
    path.write_text(path.read_text().replace("usemtl red\n", ""))
    scan = imported(path)
    assert [material and material.name for material in scan.data.materials] == [None, "green"]
    for polygon in scan.data.polygons:
        assert polygon.material_index == int(abs(polygon.normal.y) > 0.5)


PLY = (
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n{vertex}"
    "element face 1\nproperty list uchar int vertex_indices\n{face}end_header\n{rows}"
)
RGB = "property uchar red\nproperty uchar green\nproperty uchar blue\n"


def test_ply_keeps_colours_and_stands_as_it_is(tmp_path, capfd):
    rows = "0 0 0 255 0 0 9\n1 0 0 128 255 0 9\n0 1 0 0 0 255 9\n3 0 1 2\n"
    (tmp_path / "a.ply").write_text(PLY.format(vertex=RGB + "property float quality\n", face="", rows=rows))
    scan = imported(tmp_path / "a.ply")
    assert scan.rotation_euler[:] == (0, 0, 0)
    (layer,) = scan.data.color_attributes
    assert (layer.name, layer.domain, layer.data_type) == ("Col", "POINT", "FLOAT_COLOR")
    assert layer == scan.data.color_attributes.active_color
    colours = np.array([item.color[:] for item in layer.data])
    assert colours == pytest.approx(np.array([[1, 0, 0, 1], [0.21586, 1, 0, 1], [0, 0, 1, 1]]), abs=1e-4)
    assert warnings_of(capfd) == ["Warning: Not read of a.ply: quality"]


def test_colours_of_faces_are_kept_at_their_corners(tmp_path):
    rows = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2 255 0 255\n"
    (tmp_path / "a.ply").write_text(PLY.format(vertex="", face=RGB, rows=rows))
    (layer,) = imported(tmp_path / "a.ply").data.color_attributes
    assert layer.domain == "CORNER"
    assert [item.color[:] for item in layer.data] == [(1, 0, 1, 1)] * 3


def test_colours_of_obj_are_called_as_blender_calls_them(tmp_path):
    (tmp_path / "a.obj").write_text("v 0 0 0 1 0 0\nv 1 0 0 0 .5 0\nv 0 1 0 0 0 1\nf 1 2 3\n")
    ours = imported(tmp_path / "a.obj").data.color_attributes[0]
    bpy.ops.wm.obj_import(filepath=str(tmp_path / "a.obj"))
    theirs = bpy.context.selected_objects[0].data.color_attributes[0]
    assert (ours.name, ours.domain, ours.data_type) == (theirs.name, theirs.domain, theirs.data_type)
    values = [np.array([item.color[:] for item in layer.data]) for layer in (ours, theirs)]
    assert values[0] == pytest.approx(values[1], abs=0.005)


def test_up_is_chosen_by_format_or_by_hand(tmp_path):
    triangle = "v {0} 0 0\nv {1} 0 0\nv {0} 0 1\nf 1 2 3\n"
    (tmp_path / "near.obj").write_text(triangle.format(0, 1))
    (tmp_path / "far.obj").write_text(triangle.format(4_600_123.25, 4_600_124.25))
    (tmp_path / "beside.obj").write_text(triangle.format(40, 41))
    assert imported(tmp_path / "beside.obj").rotation_euler.x == pytest.approx(np.pi / 2), "no map coordinates"
    assert imported(tmp_path / "near.obj").rotation_euler.x == pytest.approx(np.pi / 2)
    assert imported(tmp_path / "near.obj", up="Z").rotation_euler.x == 0
    far = imported(tmp_path / "far.obj")
    assert far.rotation_euler.x == 0, "map coordinates have Z up"
    assert places.origin(far)[0] == 4_600_124
    turned = imported(tmp_path / "far.obj", up="Y")
    bpy.context.view_layer.update()
    assert turned.rotation_euler.x == pytest.approx(np.pi / 2)
    assert scans.world(turned) + places.origin(turned) == pytest.approx(
        np.array([[4_600_123.25, 0, 0], [4_600_124.25, 0, 0], [4_600_123.25, -1, 0]]), abs=1e-6
    )


def test_the_origin_of_a_turned_scan_is_turned_too(tmp_path):
    (tmp_path / "a.obj").write_text("v 1 5000000 9\nv 2 5000000 9\nv 1 5000001 9\nf 1 2 3\n")
    scan = imported(tmp_path / "a.obj", up="Y")
    bpy.context.view_layer.update()
    assert (scans.world(scan) + places.origin(scan))[2] == pytest.approx((1, -9, 5000001), abs=1e-5)


def test_a_damaged_face_moves_no_uv_and_no_material(tmp_path):
    """Blender removes invalid faces: layers written after that would be shifted."""
    path = write_cube(tmp_path)
    path.write_text(path.read_text().replace("usemtl red\n", "usemtl red\nf 1/2 1/2 2/1\n"))
    scan = imported(path)
    for polygon in scan.data.polygons:
        assert scan.data.materials[polygon.material_index].name == ("green" if abs(polygon.normal.y) > 0.5 else "red")
        assert [scan.data.uv_layers[0].data[i].uv[:] for i in polygon.loop_indices] == [
            (0.25, 0.25),
            (0.75, 0.25),
            (0.25, 0.75),
        ]


@pytest.mark.parametrize("name", ["bunny10k_textured", "dancing_girl", "frankfurt_tile"])
def test_textured_scans_have_the_materials_of_blenders_own_importer(name, tmp_path):
    if not SHARED.is_dir():
        pytest.skip("needs ../shared/data/textured")
    folder = shutil.copytree(SHARED / name, tmp_path / "copy")
    (path,) = folder.glob("*.obj")
    ours = imported(path)
    bpy.ops.wm.obj_import(filepath=str(path))
    theirs = [obj for obj in bpy.context.selected_objects if obj != ours]
    assert sum(len(obj.data.polygons) for obj in theirs) == len(ours.data.polygons)
    assert {image_of(m) for m in ours.data.materials} == {image_of(m) for obj in theirs for m in obj.data.materials}
    assert texture.is_textured(ours)


def test_faces_that_blender_removes_are_counted(tmp_path, capfd):
    (tmp_path / "twice.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3 1 2\nf 1 1 2\n")
    assert len(imported(tmp_path / "twice.obj").data.polygons) == 1
    assert "twice.obj: 2 faces removed, as Blender keeps no face with a vertex twice" in capfd.readouterr().out


def test_points_without_faces_are_refused(tmp_path):
    (tmp_path / "points.obj").write_text("v 0 0 0\nv 1 0 0\n")
    with pytest.raises(RuntimeError, match="has 2 points and no faces; make a mesh of them first"):
        imported(tmp_path / "points.obj")
    assert not bpy.data.objects
