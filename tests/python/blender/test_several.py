"""Several selected scans are done one after the other; hidden ones become visible."""

import bmesh
import bpy
import pytest
import scans

from isimp.blender.scene import store, targets


def three():
    made = [scans.cube(name) for name in "ABC"]
    for number, scan in enumerate(made):
        scan.location.x = 3 * number
        scan.select_set(True)
    bpy.context.view_layer.update()
    return made


def test_partition_and_mesh_do_all_selected_scans(capfd):
    made = three()
    assert bpy.ops.isimp.partition(proxies=6) == {"FINISHED"}
    assert [len(set(scans.regions(scan).tolist())) for scan in made] == [6, 6, 6]
    assert {obj.name for obj in bpy.context.selected_objects} == {"A", "B", "C"}
    assert bpy.ops.isimp.mesh() == {"FINISHED"}
    assert {obj.name for obj in bpy.context.selected_objects} == {f"{name}.simplified" for name in "ABC"}
    assert [scan.hide_get() for scan in made] == [True] * 3
    assert "3 scans done" in capfd.readouterr().out
    assert bpy.ops.isimp.mesh(chord_tolerance=0.2) == {"FINISHED"}, "selected results stand for their scans"
    assert len(bpy.data.objects) == 6


def test_mesh_finds_missing_regions_and_names_scans_that_have_changed(capfd):
    made = three()
    scans.activate(made[2])
    bpy.ops.isimp.partition(proxies=6)
    edit = bmesh.new()
    edit.from_mesh(made[2].data)
    edit.faces.ensure_lookup_table()
    edit.faces.remove(edit.faces[0])
    edit.to_mesh(made[2].data)
    edit.free()
    scans.activate(made[0])
    for scan in made:
        scan.select_set(True)
    bpy.ops.isimp.mesh()
    told = capfd.readouterr().out
    assert "2 scans done" in told
    assert "Not done, as they have no regions yet: 'C'" in told
    assert store.load(made[1]).ends_in_mesh()


def test_a_partition_of_selected_faces_is_of_the_active_scan_alone():
    made = three()
    bpy.ops.isimp.partition(proxies=6)
    for scan in made:
        scans.select_faces(scan, 0, 1, 2, 3)
    bpy.ops.isimp.partition(proxies=2, part=True)
    assert sorted(len(set(scans.regions(scan).tolist())) for scan in made) == [6, 6, 8]


def test_other_selected_objects_are_left_alone():
    scan, lamp = scans.cube(), bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    bpy.context.scene.collection.objects.link(lamp)
    lamp.select_set(True)
    assert bpy.ops.isimp.partition(proxies=6) == {"FINISHED"}
    assert set(scans.regions(scan).tolist()) == set(range(6))


def test_a_scan_in_a_hidden_collection_is_said_to_be_out_of_sight(capfd):
    scan = scans.cube()
    home = bpy.data.collections.new("Home")
    bpy.context.scene.collection.children.link(home)
    home.objects.link(scan)
    bpy.context.scene.collection.objects.unlink(scan)
    scans.activate(scan)
    bpy.ops.isimp.partition(proxies=6)
    assert "can't be seen" not in capfd.readouterr().out
    home.hide_viewport = True
    bpy.context.view_layer.objects.active = scan
    if bpy.context.view_layer.objects.active != scan:
        pytest.skip("this Blender lets no hidden object be active")
    bpy.ops.isimp.partition(proxies=7)
    assert "'Scan' can't be seen: its collection is hidden" in capfd.readouterr().out


def test_linked_duplicates_are_named():
    scan = scans.cube()
    twin = bpy.data.objects.new("Twin", scan.data)
    bpy.context.scene.collection.objects.link(twin)
    assert targets.notes(scan) == ["'Twin' has the same mesh, and so the same regions"]
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("Third", scan.data))
    assert targets.notes(scan) == ["2 other objects have the same mesh, and so the same regions"]


def test_a_hidden_scan_comes_to_sight():
    scan = scans.cube()
    scan.hide_set(True)
    bpy.context.view_layer.objects.active = scan
    bpy.ops.isimp.partition(proxies=6)
    assert scan.visible_get()
