"""Undo and redo of every step, in object and in edit mode."""

import bpy
import pytest
import scans

from isimp.blender.scene import store
from isimp.recipe import AddProxy, DeleteProxy, Mesh, Partition


def scan():
    return bpy.data.objects["Scan"]


def seen():
    """The visible state of the scan: regions and the steps that led to them, or None."""
    obj = scan()
    if "isimp_region" not in obj.data.attributes:
        return None
    steps = [type(step) for step in store.load(obj).steps]
    return scans.regions(obj).tolist(), steps, store.numbers(obj).get("regions")


def test_steps_continue_from_the_state_after_undo():
    scans.dimple(scans.cube(cells=5))
    scans.mode("EDIT")
    scans.push("mode")
    bpy.ops.isimp.partition("EXEC_DEFAULT", True, proxies=8)
    bpy.ops.isimp.add_proxy("EXEC_DEFAULT", True, face=70)
    bpy.ops.ed.undo()
    bpy.ops.isimp.add_proxy("EXEC_DEFAULT", True, face=20)
    assert store.load(scan()).steps[1:] == (AddProxy(face=20),)
    bpy.ops.ed.undo()
    assert len(store.load(scan()).steps) == 1


def test_redo_into_edit_mode_still_knows_the_steps():
    """Undo past the start of edit mode takes back the mesh's properties, redo brings back only its layers."""
    scans.dimple(scans.cube(cells=5))
    scans.push("cube")
    bpy.ops.isimp.partition("EXEC_DEFAULT", True, proxies=8)
    scans.mode("EDIT")
    scans.push("mode")
    bpy.ops.isimp.add_proxy("EXEC_DEFAULT", True, face=70)
    bpy.ops.isimp.add_proxy("EXEC_DEFAULT", True, face=20)
    last = seen()
    for _ in range(4):
        bpy.ops.ed.undo()
    assert seen() is None
    for _ in range(4):
        bpy.ops.ed.redo()
    assert seen() == last
    bpy.ops.isimp.delete_proxy("EXEC_DEFAULT", True, face=0)
    scans.mode("OBJECT")
    assert [type(step) for step in store.load(scan()).steps] == [Partition, AddProxy, AddProxy, DeleteProxy]


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_mesh_is_undone_and_redone(mode):
    scans.cube(cells=4)
    scans.push("cube")
    bpy.ops.isimp.partition("EXEC_DEFAULT", True, proxies=6)
    scans.mode(mode)
    scans.push("mode")
    before = seen()
    bpy.ops.isimp.mesh("EXEC_DEFAULT", True)
    assert bpy.context.object.name == "Scan.simplified"
    after = seen()
    assert after[1] == [Partition, Mesh]
    bpy.ops.ed.undo()
    assert bpy.context.object == scan()
    assert scan().mode == mode
    assert not scan().hide_get()
    assert "Scan.simplified" not in bpy.context.scene.objects
    assert seen() == before
    bpy.ops.ed.redo()
    assert bpy.context.object.name == "Scan.simplified"
    assert scan().hide_get()
    assert seen() == after


def test_undo_shows_the_colours_again():
    scans.cube(cells=4)
    bpy.ops.isimp.partition("EXEC_DEFAULT", True, proxies=6)
    bpy.ops.isimp.mesh("EXEC_DEFAULT", True)
    areas = [area for window in bpy.context.window_manager.windows for area in window.screen.areas]
    views = [area.spaces.active.shading for area in areas if area.type == "VIEW_3D"]
    assert {view.color_type for view in views} == {"MATERIAL"}
    bpy.ops.ed.undo()
    assert {view.color_type for view in views} == {"VERTEX"}
    bpy.ops.ed.redo()
    assert {view.color_type for view in views} == {"MATERIAL"}
