"""Regions and steps through save, load, duplicate, append, and two scans in one scene."""

import bpy
import scans

from isimp.blender.scene import store
from isimp.recipe import AddProxy, Partition


def prepared(name="Scan", proxies=8):
    scan = scans.dimple(scans.cube(name=name))
    bpy.ops.isimp.partition(proxies=proxies)
    bpy.ops.isimp.add_proxy(face=20)
    return scan


def state(scan):
    return scans.regions(scan).tolist(), scans.colors(scan).tolist(), store.load(scan), store.numbers(scan)


def test_save_and_load_keep_everything(tmp_path):
    before = state(prepared())
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "kept.blend"))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "kept.blend"))
    scan = bpy.data.objects["Scan"]
    assert state(scan) == before
    scans.activate(scan)
    bpy.ops.isimp.delete_proxy(face=20)
    assert len(store.load(scan).steps) == 3


def test_what_a_saved_file_shows_is_given_back_after_loading(tmp_path):
    scans.cube()
    bpy.ops.isimp.partition(proxies=6)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "shown.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "shown.blend"), load_ui=True)
    scans.activate(bpy.data.objects["Scan"])
    bpy.ops.isimp.mesh()
    areas = [area for window in bpy.context.window_manager.windows for area in window.screen.areas]
    assert {area.spaces.active.shading.color_type for area in areas if area.type == "VIEW_3D"} == {"MATERIAL"}


def test_a_duplicate_has_steps_of_its_own():
    scan = prepared()
    before = state(scan)
    bpy.ops.isimp.mesh()
    bpy.ops.isimp.swap()
    bpy.ops.object.duplicate()
    twin = bpy.context.object
    assert twin != scan
    assert state(twin)[:2] == before[:2]
    bpy.ops.isimp.add_proxy(face=33)
    bpy.ops.isimp.mesh()
    assert bpy.context.object.name == f"{twin.name}.simplified"
    assert "Scan.simplified" in bpy.data.objects
    assert [type(step) for step in store.load(scan).steps][:2] == [Partition, AddProxy]
    assert scans.regions(scan).tolist() == before[0]


def test_append_to_another_file_brings_the_steps(tmp_path):
    before = state(prepared())
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "library.blend"))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    with bpy.data.libraries.load(str(tmp_path / "library.blend")) as (source, target):
        target.objects = source.objects
    scan = target.objects[0]
    bpy.context.scene.collection.objects.link(scan)
    scans.activate(scan)
    assert state(scan) == before
    assert bpy.ops.isimp.mesh() == {"FINISHED"}


def test_objects_that_share_a_mesh_share_its_regions():
    scan = prepared()
    other = bpy.data.objects.new("Other", scan.data)
    bpy.context.scene.collection.objects.link(other)
    scans.activate(other)
    assert store.load(other) == store.load(scan)
    bpy.ops.isimp.delete_proxy(face=20)
    assert len(store.load(scan).steps) == 3
    bpy.ops.isimp.mesh()
    assert bpy.context.object.name == "Other.simplified"
