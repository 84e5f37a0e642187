"""Changes of the result by hand are kept, and the result has the place of its scan."""

import bpy
import pytest
import scans
from mathutils import Matrix

from isimp.blender.scene import result as results
from isimp.blender.scene import targets


def simplified():
    scan = scans.cube()
    scan.vertex_groups.new(name="Group")
    assert bpy.ops.isimp.partition(proxies=6) == {"FINISHED"}
    assert bpy.ops.isimp.mesh() == {"FINISHED"}
    return scan, bpy.context.object


def bevel(result):
    scans.activate(result)
    scans.mode("EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.bevel(offset=0.1)
    scans.mode("OBJECT")


def move_vertex(result):
    result.data.vertices[0].co.x += 0.5


def mark_seam(result):
    result.data.edges[0].use_seam = True


def assign_material(result):
    result.data.materials.append(bpy.data.materials.new("Mine"))
    result.data.materials.append(bpy.data.materials.new("Other"))
    result.data.polygons[0].material_index = 1


def unwrap(result):
    result.data.uv_layers.new(name="Mine")


def replace_material(result):
    result.data.materials.append(bpy.data.materials.new("Mine"))


def weigh(result):
    result.vertex_groups["Group"].add([0], 0.7, "REPLACE")


def crease(result):
    if "crease" in bpy.types.MeshEdge.bl_rna.properties:
        result.data.edges[0].crease = 0.5
    else:  # Blender 4.0 and later
        result.data.attributes.new("crease_edge", "FLOAT", "EDGE").data[0].value = 0.5


def measure(result):
    result.data.attributes.new("Mine", "FLOAT_VECTOR", "POINT").data[0].vector = (1, 2, 3)


def write_note(result):
    note = b"north" if bpy.app.version > (4, 0) else "north"
    result.data.attributes.new("Note", "STRING", "FACE").data[0].value = note


def shade_smooth(result):
    result.data.polygons[0].use_smooth = True


EDITS = [bevel, move_vertex, mark_seam, assign_material, unwrap]
EDITS += [replace_material, weigh, crease, measure, write_note, shade_smooth]


@pytest.mark.parametrize("edit", EDITS)
def test_mesh_again_keeps_a_result_that_was_edited_by_hand(edit, capfd):
    scan, first = simplified()
    edit(first)
    before = results.digest(first)
    assert bpy.ops.isimp.mesh() == {"FINISHED"}
    told = "'Scan.simplified' was edited by hand and is kept, hidden. The new polygons are 'Scan.simplified.001'"
    assert told in capfd.readouterr().out
    second = bpy.context.object
    assert (first.name, second.name) == ("Scan.simplified", "Scan.simplified.001")
    assert results.digest(first) == before
    assert (first.hide_get(), second.hide_get(), len(second.data.polygons)) == (True, False, 6)
    assert targets.result_of(bpy.context.scene, scan) == second
    assert targets.scan_of(first) == scan
    assert bpy.ops.isimp.mesh() == {"FINISHED"}
    assert bpy.context.object == second, "one that nobody has edited is refreshed"


def rename(result):
    result.name = "Figure_LOD0"


def link_copy(result):
    bpy.ops.object.duplicate(linked=True)


def mark(result):
    result.asset_mark()


@pytest.mark.parametrize(("do", "why"), [(rename, "renamed"), (link_copy, "copied"), (mark, "marked as an asset")])
def test_a_result_that_its_user_has_put_to_use_is_kept(do, why, capfd):
    scan, first = simplified()
    do(first)
    scans.activate(scan)
    before = results.digest(first)
    bpy.ops.isimp.partition(proxies=8)
    assert bpy.ops.isimp.mesh() == {"FINISHED"}
    second = bpy.context.object
    assert second != first
    assert results.digest(first) == before
    assert (
        f"'{first.name}' was {why} and is kept, hidden. The new polygons are '{second.name}'" in capfd.readouterr().out
    )
    assert bpy.ops.isimp.mesh() == {"FINISHED"}
    assert bpy.context.object == second


@pytest.mark.parametrize("away", [0.0, 3.0])
def test_a_copy_of_a_result_is_kept_and_the_result_is_refreshed(away, capfd):
    scan, first = simplified()
    bpy.ops.object.duplicate()
    copy = bpy.context.object
    copy.location.x += away
    before = results.digest(copy)
    assert results.why_kept_here(bpy.context, scan) == "copied", "changed settings leave it alone"
    bpy.ops.isimp.partition(proxies=8)
    assert bpy.ops.isimp.mesh() == {"FINISHED"}
    assert bpy.context.object == first
    assert results.digest(copy) == before != results.digest(first)
    assert copy.hide_get() == (away == 0), "one at the same place would hide the new polygons"
    assert f"'{copy.name}' was copied and is kept" in capfd.readouterr().out
    scans.activate(scan)
    bpy.ops.isimp.mesh()
    assert "is kept" not in capfd.readouterr().out, "it is said once"


def test_what_is_hidden_is_not_rendered_either():
    scan, result = simplified()
    assert (scan.hide_render, result.hide_render) == (True, False)
    bpy.ops.isimp.swap()
    assert (scan.hide_render, result.hide_render) == (False, True)
    result.hide_render, result.isimp.unrendered = True, ""  # a user's own choice
    bpy.ops.isimp.swap()
    assert (scan.hide_render, result.hide_render) == (True, True)
    bpy.ops.isimp.partition(proxies=7)
    assert scan.hide_render is False


def test_edits_in_edit_mode_count_before_it_is_left():
    _, first = simplified()
    scans.mode("EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.transform.resize(value=(2, 1, 1))
    assert bpy.ops.isimp.mesh() == {"FINISHED"}
    assert bpy.context.object != first
    assert scans.coordinates(first.data)[:, 0].max() == pytest.approx(2)


def test_a_result_in_edit_mode_next_to_an_active_scan_is_shown_and_filled():
    """Blender keeps the mode of an object while another one is active."""
    scan, made = simplified()
    for call in (
        lambda: bpy.ops.isimp.show_problems(kind="DIVIDED"),
        lambda: bpy.ops.isimp.partition(proxies=7) and bpy.ops.isimp.mesh(),
    ):
        scans.activate(made)
        scans.mode("EDIT")
        bpy.context.view_layer.objects.active = scan
        assert (made.mode, bpy.context.mode) == ("EDIT", "OBJECT")
        assert call() == {"FINISHED"}
        assert made.mode == "OBJECT"
    assert len(made.data.polygons) == 7


def test_a_result_of_an_earlier_version_is_kept_as_its_edits_are_unknown():
    _, first = simplified()
    first.isimp.made = ""
    bpy.ops.isimp.mesh()
    assert bpy.context.object != first


def test_a_result_survives_saving_without_being_taken_for_edited(tmp_path):
    simplified()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "file.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "file.blend"))
    assert not results.is_edited(bpy.data.objects["Scan.simplified"])


def transforms(obj):
    names = ("location", "rotation_euler", "rotation_quaternion", "scale", "delta_location", "delta_scale")
    return {name: tuple(getattr(obj, name)) for name in names} | {"mode": obj.rotation_mode}


def test_a_mirrored_scan_gives_its_numbers_to_the_result():
    scan = scans.cube()
    scan.scale, scan.rotation_euler, scan.location = (-1, 1, 1), (0.1, 0.2, 0.3), (1, 2, 3)
    scan.delta_location = (0, 0, 5)
    bpy.context.view_layer.update()
    bpy.ops.isimp.partition(proxies=6)
    bpy.ops.isimp.mesh()
    assert transforms(bpy.context.object) == transforms(scan)


def test_the_result_has_the_scans_parent():
    scan = scans.cube()
    parent = scans.hang(scan, scale=(1, 3, 1), location=(4, 5, 6))
    scan.rotation_euler = (0.5, 0.2, 0.1)
    scan.matrix_parent_inverse = Matrix.Translation((1, 1, 1))
    bpy.context.view_layer.update()
    bpy.ops.isimp.partition(proxies=6)
    bpy.ops.isimp.mesh()
    result = bpy.context.object
    bpy.context.view_layer.update()
    assert result.parent == parent
    assert result.matrix_world == scan.matrix_world
    parent.location = (40, 50, 60)
    bpy.context.view_layer.update()
    assert result.matrix_world == scan.matrix_world


def test_a_constrained_scan_has_its_result_where_it_is_seen():
    scan, goal = scans.cube(), bpy.data.objects.new("Goal", None)
    bpy.context.scene.collection.objects.link(goal)
    goal.location = (7, 8, 9)
    scan.constraints.new("COPY_LOCATION").target = goal
    bpy.context.view_layer.update()
    bpy.ops.isimp.partition(proxies=6)
    bpy.ops.isimp.mesh()
    assert tuple(bpy.context.object.matrix_world.translation) == (7, 8, 9)


def test_a_result_that_was_moved_aside_stays_there():
    scan, result = simplified()
    result.location.x += 5
    bpy.context.view_layer.update()
    bpy.ops.isimp.mesh(chord_tolerance=0.1)
    assert bpy.context.object == result
    assert tuple(result.location) == pytest.approx((5, 0, 0))
    scan.location.y = 3
    bpy.context.view_layer.update()
    bpy.ops.isimp.mesh()
    assert tuple(result.location) == pytest.approx((5, 3, 0))


def test_renders_keep_taking_the_users_colours():
    scan = scans.cube()
    colors = scan.data.color_attributes
    for name in ("first", "Col"):
        colors.new(name, "BYTE_COLOR", "CORNER")
    colors.active_color, colors.render_color_index = colors["first"], colors.find("Col")
    bpy.ops.isimp.partition(proxies=6)
    assert colors.active_color.name == "isimp_color"
    assert colors[colors.render_color_index].name == "Col"
    bpy.ops.isimp.mesh()
    assert (colors.active_color.name, colors[colors.render_color_index].name) == ("first", "Col")


def test_render_colours_taken_by_an_earlier_version_are_given_back():
    scan = scans.cube()
    colors = scan.data.color_attributes
    colors.active_color = colors.new("Col", "BYTE_COLOR", "CORNER")
    bpy.ops.isimp.partition(proxies=6)
    colors.render_color_index = colors.find("isimp_color")
    bpy.ops.isimp.mesh()
    assert colors[colors.render_color_index].name == "Col"


def test_polygons_have_the_materials_of_their_regions():
    scan = scans.cube()
    for name in ("Red", "Blue"):
        scan.data.materials.append(bpy.data.materials.new(name))
    for polygon in scan.data.polygons:
        polygon.material_index = int(polygon.center.z > 0.99)
    bpy.ops.isimp.partition(proxies=6)
    for _ in range(2):  # made, and refreshed
        bpy.ops.isimp.mesh()
        result = bpy.context.object
        assert [material.name for material in result.data.materials] == ["Red", "Blue"]
        top = [polygon.material_index for polygon in result.data.polygons if polygon.normal.z > 0.9]
        rest = [polygon.material_index for polygon in result.data.polygons if polygon.normal.z < 0.9]
        assert (top, rest) == ([1], [0] * 5)
    assert len(bpy.data.objects) == 2


@pytest.mark.parametrize("takes_name", [False, True])
def test_a_copy_of_a_scan_leaves_the_result_to_the_renamed_original(takes_name):
    scan, first = simplified()
    scan.hide_set(False)
    scans.activate(scan)
    bpy.ops.object.duplicate()
    copy = bpy.context.object
    scan.name = "Turned"
    if takes_name:
        copy.name = "Scan"
    bpy.ops.isimp.partition(proxies=8)
    bpy.ops.isimp.mesh()
    second = bpy.context.object
    assert [targets.scan_of(made) for made in (first, second)] == [scan, copy]
    assert [len(made.data.polygons) for made in (first, second)] == [6, 8]


@pytest.mark.parametrize("scan_hangs", [False, True])
def test_a_parent_that_the_user_gave_to_a_result_stays(scan_hangs):
    scan, result = simplified()
    parent = scans.hang(result, location=(5, 0, 0))
    if scan_hangs:
        scans.hang(scan, location=(0, 9, 0))
    bpy.context.view_layer.update()
    for _ in range(2):
        bpy.ops.isimp.mesh(chord_tolerance=0.1)
        bpy.context.view_layer.update()
        assert (bpy.context.object, result.parent) == (result, parent)
        assert tuple(result.matrix_world.translation) == (5, 0, 0)
