"""Operators that finish a result, clean regions up, or merge coplanar faces."""

from types import SimpleNamespace

import bpy
import numpy as np
import pytest
import scans

from isimp import recipe as rcp
from isimp.blender.controls import settings
from isimp.blender.operators import finish
from isimp.blender.scene import runtime, store, targets
from isimp.blender.texturing import texture
from isimp.blender.work.modal import Work
from isimp.engine import engine
from isimp.task import Stopped, Watch
from test_texture import textured_cube

OPS = bpy.ops.isimp


def parted(proxies=6):
    scan = scans.cube(cells=6)
    OPS.partition(proxies=proxies)
    return scan


def test_make_editable_ends_in_edit_mode_with_faces_to_select():
    scan = parted()
    OPS.paint_faces(painted="-1:0")
    assert store.numbers(scan)["regions"] == 7
    assert OPS.make_editable() == {"FINISHED"}
    assert bpy.context.mode == "EDIT_MESH"
    assert tuple(bpy.context.scene.tool_settings.mesh_select_mode) == (False, False, True)
    assert store.numbers(scan)["regions"] == 6, "the sliver is merged"
    scans.mode("OBJECT")
    assert len(bpy.context.object.data.polygons) == 6
    assert isinstance(store.load(scan).steps[-1], rcp.Mesh)


def test_levels_of_detail_are_kept_under_names_of_their_own():
    scan = parted(60)
    for level, count in enumerate((60, 20, 6)):
        scans.activate(scan)
        scan.hide_set(False)
        group = settings.group(bpy.context, rcp.Partition)
        if level:
            assert (group.count_by, group.proxies) == ("proxies", count)
        OPS.partition(proxies=group.proxies if level else 60)
        OPS.mesh()
        assert OPS.keep_lod() == {"FINISHED"}
        assert bpy.context.object == scan
    kept = [bpy.data.objects[f"Scan_LOD{level}"] for level in range(3)]
    sizes = [len(obj.data.polygons) for obj in kept]
    assert sizes == sorted(sizes, reverse=True)
    assert len(set(sizes)) == 3
    OPS.mesh()
    assert [len(obj.data.polygons) for obj in kept] == sizes, "Mesh leaves them alone"


def test_all_levels_of_detail_are_made_at_once():
    scan = parted(60)
    assert OPS.make_lods(counts=(60, 6, 20)) == {"FINISHED"}
    levels = [bpy.data.objects[f"Scan_LOD{number}"] for number in range(3)]
    sizes = [len(level.data.polygons) for level in levels]
    assert sizes == sorted(sizes, reverse=True)
    assert sizes[2] == 6
    assert [level.hide_get() for level in levels] == [False, True, True]
    assert bpy.context.object == levels[0] == targets.result_of(bpy.context.scene, scan)
    (part,) = levels[0].children
    assert (part.name, part.hide_get()) == ("UCX_Scan_LOD0_00", True)
    assert OPS.make_lods(counts=(30, 6, 0), colliders=False) == {"FINISHED"}
    assert sorted(obj.name for obj in bpy.data.objects if "LOD" in obj.name) == ["Scan_LOD0", "Scan_LOD1"]
    with pytest.raises(RuntimeError, match="at least one number"):
        OPS.make_lods(counts=(0, 0, 0))
    bpy.data.objects.new("Scan_LOD2", None)
    with pytest.raises(RuntimeError, match="Scan_LOD2 has the name of a level: rename it"):
        OPS.make_lods(counts=(30, 20, 6))


def levels_of(scan):
    return {obj.name: len(obj.data.polygons) for _, obj in targets.levels(scan)}


def test_the_levels_of_the_last_press_stay_until_new_ones_are_made(monkeypatch):
    scan = parted(60)
    OPS.make_lods(counts=(60, 20, 6))
    before, shown = levels_of(scan), targets.result_of(bpy.context.scene, scan)
    with monkeypatch.context() as patch:
        patch.setattr(runtime.get().session, "replay", fails_after(0))
        with pytest.raises(RuntimeError, match="Stop here"):
            OPS.make_lods(counts=(40, 10, 4))
    assert levels_of(scan) == before
    assert (bpy.context.object, shown.visible_get()) == (shown, True)
    assert [part.name for part in shown.children] == ["UCX_Scan_LOD0_00"]
    with monkeypatch.context() as patch:
        patch.setattr(runtime.get().session, "replay", fails_after(1))
        with pytest.raises(RuntimeError, match="Stop here"):
            OPS.make_lods(counts=(40, 10, 7))
    assert levels_of(scan) == before | {"Scan_LOD2": 7}, "the level that was made replaces the former one"
    assert targets.result_of(bpy.context.scene, scan) == shown
    OPS.make_lods(counts=(40, 10, 0))
    assert list(levels_of(scan)) == ["Scan_LOD0", "Scan_LOD1"]
    assert [mesh.name for mesh in bpy.data.meshes if "LOD" in mesh.name and "UCX" not in mesh.name] == [
        "Scan_LOD0",
        "Scan_LOD1",
    ]


def fails_after(count):
    """A `replay` that works `count` times, then fails."""
    replay, left = runtime.get().session.replay, [None] * count

    def replayed(*args):
        if not left:
            raise ValueError("Stop here")
        left.pop()
        return replay(*args)

    return replayed


def test_objects_of_the_user_stay_when_levels_are_replaced():
    scan = parted(60)
    scan.location = 1, 2, 3
    OPS.make_lods(counts=(20, 6, 0))
    level = bpy.data.objects["Scan_LOD0"]
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    bpy.context.scene.collection.objects.link(lamp)
    lamp.parent, lamp.location = level, (0, 0, 5)
    own = scans.add("Scan_LOD7", [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    scans.activate(level)
    for _ in range(2):
        OPS.make_lods(counts=(30, 6, 0))
        assert (lamp.parent, tuple(lamp.matrix_world.translation)) == (None, (1, 2, 8))
        assert [place.name for place in bpy.data.collections if "colliders" in place.name] == ["Scan_LOD0 colliders"]
        assert [part.name for part in bpy.data.objects["Scan_LOD0"].children] == ["UCX_Scan_LOD0_00"]
    assert own.name == "Scan_LOD7"


def test_a_level_edited_by_hand_gets_another_name(capfd):
    scan = parted(60)
    OPS.make_lods(counts=(20, 6, 0), colliders=False)
    edited = bpy.data.objects["Scan_LOD0"]
    edited.data.vertices[0].co.x += 1
    OPS.make_lods(counts=(20, 6, 0), colliders=False)
    assert "'Scan_LOD0.old'" in capfd.readouterr().out
    assert (edited.name, edited.hide_get()) == ("Scan_LOD0.old", True)
    assert targets.result_of(bpy.context.scene, scan).name == "Scan_LOD0"


def test_levels_of_a_scan_with_a_long_name_are_found_and_replaced():
    scan = parted(60)
    scan.name = "ä" * 30
    OPS.make_lods(counts=(30, 20, 6))
    levels = [obj for _, obj in targets.levels(scan)]
    assert [obj.name for obj in levels] == [f"{'ä' * 22}_LOD{number}" for number in range(3)]
    (part,) = levels[0].children
    assert part.name == f"UCX_{levels[0].name}_00"
    OPS.make_lods(counts=(30, 6, 0))
    assert len(targets.levels(scan)) == 2
    OPS.keep_lod()
    assert [number for number, _ in targets.levels(scan)] == [1, 2]


def test_levels_end_at_one_that_fails():
    scans.activate(scans.cube("Small", 1))
    with pytest.raises(RuntimeError, match="At most 12 regions"):
        OPS.make_lods(counts=(40, 6, 0))
    assert "Small_LOD1" in bpy.data.objects
    assert "Small_LOD0" not in bpy.data.objects


def test_the_image_of_each_level_is_half_as_wide():
    scan = textured_cube()
    for image in bpy.data.images:
        image.scale(256, 256)
    OPS.make_lods(counts=(12, 6, 0))
    widths = [texture.image_width(bpy.data.objects[f"{scan.name}_LOD{level}"]) for level in range(2)]
    assert widths == [256, 128]


def test_slivers_are_merged_by_steps_of_the_recipe():
    scan = parted()
    OPS.paint_faces(painted="-1:0")
    OPS.paint_faces(painted="-1:200")
    assert OPS.merge_slivers() == {"FINISHED"}
    assert store.numbers(scan)["regions"] == 6
    assert [type(step) for step in store.load(scan).steps[-2:]] == [rcp.MergeRegions] * 2
    with pytest.raises(RuntimeError, match="No region is that small"):
        OPS.merge_slivers()


def test_locked_slivers_stay():
    scan = parted()
    OPS.paint_faces(painted="-1:0")
    OPS.lock(face=0)
    with pytest.raises(RuntimeError, match="No region is that small"):
        OPS.merge_slivers()
    assert store.numbers(scan)["regions"] == 7


@pytest.mark.parametrize(("names", "first"), [("unreal", "UCX_{}_00"), ("godot", "{}_00-convcol")])
def test_colliders_are_objects_that_follow_the_result(names, first):
    scan = parted()
    assert OPS.mesh(planar=True) == {"FINISHED"}
    result = targets.result_of(bpy.context.scene, scan)
    assert OPS.colliders(names=names) == {"FINISHED"}
    place = bpy.data.collections[f"{result.name} colliders"]
    (part,) = place.objects
    assert part.name == first.format(result.name)
    assert (part.parent, part.display_type, part.hide_render) == (result, "WIRE", True)
    assert (len(part.data.vertices), len(part.data.polygons)) == (8, 12)
    corners = [{tuple(round(x, 4) for x in v.co) for v in mesh.vertices} for mesh in (part.data, result.data)]
    assert corners[0] == corners[1]
    assert bpy.context.view_layer.objects.active == result
    assert OPS.colliders(names=names, enclose=True, parts=1) == {"FINISHED"}
    assert [part.name for part in result.children] == [first.format(result.name)], "a second press replaces them"
    assert [place.name for place in bpy.data.collections if "colliders" in place.name] == [f"{result.name} colliders"]
    result.children[0].name = "Kept"
    assert OPS.colliders(names=names) == {"FINISHED"}
    assert sorted(part.name for part in result.children) == sorted(["Kept", first.format(result.name)])


def test_colliders_can_be_stopped():
    scan = parted()
    OPS.mesh()
    result, watch = targets.result_of(bpy.context.scene, scan), Watch()
    assert len(finish.convex_parts(result)(watch)) == 1
    watch.cancel()
    with pytest.raises(Stopped):
        finish.convex_parts(result)(watch)


def test_levels_of_an_open_scan_have_no_colliders(capfd):
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=8, y_subdivisions=8)
    scan = bpy.context.object
    assert OPS.make_lods(counts=(4, 2, 0)) == {"FINISHED"}
    assert "Warning: No colliders: " in capfd.readouterr().out
    assert len(targets.levels(scan)) == 2
    assert not bpy.data.objects[f"{scan.name}_LOD0"].children


def test_a_number_of_colliders_with_a_thickness_is_told_to_do_nothing(capfd):
    parted()
    OPS.mesh()
    OPS.colliders(thickness=0.1, parts=2)
    assert "At Most does not apply with Wall Thickness" in capfd.readouterr().out
    OPS.colliders(parts=2)
    assert "At Most" not in capfd.readouterr().out


@pytest.mark.parametrize("height", [1, 10, -10])
def test_colliders_of_an_open_result_need_a_thickness(height):
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=8, y_subdivisions=8)
    scans.activate(bpy.context.object)
    bpy.context.object.scale.z = height
    bpy.context.view_layer.update()
    assert OPS.partition(proxies=1) == {"FINISHED"}
    assert OPS.mesh() == {"FINISHED"}
    before = len(bpy.data.objects), len(bpy.data.collections)
    with pytest.raises(RuntimeError, match="No colliders: "):
        OPS.colliders()
    assert (len(bpy.data.objects), len(bpy.data.collections)) == before
    assert OPS.colliders(thickness=0.2) == {"FINISHED"}
    (part,) = bpy.data.collections[-1].objects
    assert np.ptp([v.co.z for v in part.data.vertices]) == pytest.approx(0.2 / abs(height), rel=1e-3)


def test_merge_flat_keeps_materials_and_places():
    source = scans.cube(cells=5)
    for name in ("Stone", "Glass"):
        source.data.materials.append(bpy.data.materials.new(name))
    normals = np.array([polygon.normal for polygon in source.data.polygons])
    centers = np.array([polygon.center for polygon in source.data.polygons])
    glass = (normals[:, 2] > 0.9) & (centers[:, 0] > 0.2)
    source.data.polygons.foreach_set("material_index", glass.astype(np.int32))
    source.location, source.rotation_euler = (1, 2, 3), (0.1, 0.2, 0.3)
    bpy.context.view_layer.update()
    before = scans.geometry(source.data)
    assert OPS.merge_flat() == {"FINISHED"}
    made = bpy.context.object
    bpy.context.view_layer.update()
    assert made.name == "Scan.flat"
    assert len(made.data.polygons) == 7
    used = np.array([polygon.material_index for polygon in made.data.polygons])
    assert np.bincount(used).tolist() == [6, 1]
    assert [slot.material.name for slot in made.material_slots] == ["Stone", "Glass"]
    corners = {tuple(v) for v in scans.coordinates(source.data).tolist()}
    assert {tuple(v) for v in scans.coordinates(made.data).tolist()} <= corners
    assert np.array(made.matrix_world) == pytest.approx(np.array(source.matrix_world), abs=1e-6)
    assert scans.geometry(source.data) == before
    assert source.hide_get()


def world_corners(obj):
    """The corners of an object in the world, rounded and sorted."""
    place = np.array(obj.matrix_world)
    return np.unique(np.round(scans.coordinates(obj.data) @ place[:3, :3].T + place[:3, 3], 4), axis=0)


@pytest.mark.parametrize("how", ["delta", "mode", "bone", "constraint", "sheared"])
def test_merge_flat_puts_its_object_where_the_source_is(how):
    source = scans.cube(cells=2)
    if how == "delta":
        source.delta_location, source.delta_scale, source.delta_rotation_euler = (1, 2, 3), (2, 1, 1), (0, 0, 0.5)
    elif how == "mode":
        source.rotation_mode, source.rotation_quaternion = "QUATERNION", (0.8, 0.6, 0, 0)
    elif how == "constraint":
        source.constraints.new("LIMIT_LOCATION").use_min_x = True
        source.location.x = -3
    else:
        bpy.ops.object.armature_add(location=(1, 2, 3), rotation=(0.4, 0, 0))
        parent = bpy.context.object
        source.parent = parent
        if how == "bone":
            source.parent_type, source.parent_bone = "BONE", parent.data.bones[0].name
        else:
            parent.scale, source.rotation_euler = (-1, 2, 3), (0.3, 0.4, 0.5)
        scans.activate(source)
    bpy.context.view_layer.update()
    wanted = world_corners(source)
    assert OPS.merge_flat() == {"FINISHED"}
    bpy.context.view_layer.update()
    found = world_corners(bpy.context.object)
    assert len(found) == 8
    assert {tuple(each) for each in found} <= {tuple(each) for each in wanted}


def test_merge_flat_keeps_materials_where_blender_removes_an_invalid_polygon():
    source = scans.cube(cells=2)
    for name in ("Stone", "Glass"):
        source.data.materials.append(bpy.data.materials.new(name))
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [2, 1, 0]], float)
    loops, start = np.array([0, 1, 2, 3, 0, 1, 2, 3, 1, 4, 5, 2]), np.array([0, 4, 8])  # the second is the first
    poly = SimpleNamespace(vertices=square, loops=loops, loop_start=start)
    made = finish._new_flat(bpy.context, source, poly, np.array([0, 0, 1], np.int32))
    assert [polygon.material_index for polygon in made.data.polygons] == [0, 1]


def test_merge_flat_works_on_a_drawn_mesh_without_regions():
    bpy.ops.mesh.primitive_cube_add()
    bpy.ops.object.modifier_add(type="SUBSURF")
    assert OPS.merge_flat() == {"FINISHED"}
    assert len(bpy.context.object.data.polygons) == 6
    bpy.ops.object.empty_add()
    assert not OPS.merge_flat.poll()


def test_the_clipboard_without_a_recipe_is_said():
    scans.cube()
    bpy.context.window_manager.clipboard = "hello"
    with pytest.raises(RuntimeError, match="The clipboard holds no recipe"):
        OPS.recipe_paste()
    assert targets.result_of(bpy.context.scene, bpy.context.object) is None


def test_merge_flat_can_be_stopped_and_says_why_it_fails(monkeypatch):
    source, watch = scans.cube(cells=3), Watch()
    watch.cancel()
    with pytest.raises(Stopped):
        finish._flat(source, 0.01)(watch)
    monkeypatch.setattr(runtime.get(), "running", Work(bpy.context, source, rcp.Recipe()))
    assert not OPS.merge_flat.poll()
    monkeypatch.undo()

    def fails(*given, **more):
        raise ValueError("no face is usable")

    monkeypatch.setattr(engine, "merge_flat", fails)
    with pytest.raises(RuntimeError, match=r"^Error: [Nn]o face is usable\. Nothing was changed\."):
        OPS.merge_flat()
    assert (len(bpy.data.objects), bpy.context.object) == (1, source)
