"""Ways in besides the sidebar: menus, keys, the command; selection of similar regions; a clean way out."""

import types

import bpy
import numpy as np
import pytest
import scans
import ui_strings
from drawing import Recorder

from isimp import blender
from isimp.blender import command, menus


@pytest.mark.parametrize("keeps", [True, False])
@pytest.mark.parametrize("menu", [menus.ISIMP_MT_object, menus.ISIMP_MT_pie])
def test_menus_have_operators_with_the_settings_of_the_panel(menu, keeps):
    panel, layout = bpy.context.window_manager.isimp, Recorder([])
    panel.keep_texture = keeps
    menu.draw(types.SimpleNamespace(layout=layout), bpy.context)
    panel.keep_texture = True
    assert {"isimp.partition", "isimp.mesh", "isimp.swap"} <= set(layout.buttons)
    assert layout.buttons["isimp.mesh"].values["keep_texture"] == keeps


def test_the_object_menu_has_the_entry_once():
    for name in ("VIEW3D_MT_object", "VIEW3D_MT_edit_mesh"):
        drawers = getattr(bpy.types, name).draw._draw_funcs
        assert drawers.count(menus._draw_entry) == 1


def handlers():
    return {
        name: len(getattr(bpy.app.handlers, name)) for name in dir(bpy.app.handlers) if name.endswith(("_post", "_pre"))
    }


def registered():
    return sorted(name for name in dir(bpy.types) if "isimp" in name.lower())


def test_the_add_on_unregisters_without_a_trace_and_registers_again_20_times(addon):
    before = handlers(), registered()
    for _ in range(20):
        addon.unregister()
        assert registered() == []
        assert not hasattr(bpy.types.Mesh, "isimp")
        assert not hasattr(bpy.types.WindowManager, "isimp")
        assert menus._draw_entry not in bpy.types.VIEW3D_MT_object.draw._draw_funcs
        addon.register()
    assert (handlers(), registered()) == before
    scans.cube()
    assert bpy.ops.isimp.partition(proxies=6) == {"FINISHED"}


def test_the_command_equals_the_package_s_command(tmp_path, capfd):
    (tmp_path / "tri.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    assert command.run(["info", str(tmp_path / "tri.off")]) == 0
    assert "1 face" in capfd.readouterr().out
    assert command.run(["info", str(tmp_path / "none.off")]) == 3
    assert command.run(["simplify"]) == 2
    assert command.run(["--version"]) == 0


def faces_of(scan):
    scan.update_from_editmode()
    flags = np.empty(len(scan.data.polygons), bool)
    scan.data.polygons.foreach_get("select", flags)
    return flags


def test_regions_that_face_up_are_selected_as_the_scan_is_seen():
    scan = scans.cube()
    bpy.ops.isimp.partition(proxies=6)
    normals = np.array([polygon.normal for polygon in scan.data.polygons])
    bpy.ops.isimp.select_by(by="DIRECTION")
    assert (faces_of(scan) == (normals[:, 2] > 0.9)).all()
    scans.mode("OBJECT")
    scan.rotation_euler = (np.pi / 2, 0, 0)  # +y points up now
    bpy.context.view_layer.update()
    bpy.ops.isimp.select_by(by="DIRECTION")
    assert (faces_of(scan) == (normals[:, 1] > 0.9)).all()
    scans.mode("OBJECT")
    scan.rotation_euler, scan.scale = (0, 0, 0), (1, 1, -1)  # the underside is up now
    bpy.context.view_layer.update()
    bpy.ops.isimp.select_by(by="DIRECTION")
    assert (faces_of(scan) == (normals[:, 2] < -0.9)).all()


def test_small_and_bent_regions_are_selected():
    scan = scans.cube()
    bpy.ops.isimp.partition(proxies=6)
    bpy.ops.isimp.paint_faces(painted="-1:0,1")
    bpy.ops.isimp.select_by(by="SIZE", share=1.0)
    assert np.flatnonzero(faces_of(scan)).tolist() == [0, 1]
    bpy.ops.isimp.select_by(by="FLATNESS", extend=False)
    assert not faces_of(scan).any()
    top, side = (next(p.index for p in scan.data.polygons if p.normal[axis] > 0.9) for axis in (2, 1))
    scans.mode("OBJECT")
    bpy.ops.isimp.merge(face=top, other=side)
    bpy.ops.isimp.select_by(by="FLATNESS")
    label = scans.regions(scan)
    assert set(label[faces_of(scan)].tolist()) == {label[top]}


def test_an_edit_of_the_scan_is_noticed(capfd):
    scan = scans.dimple(scans.cube())
    bpy.ops.isimp.partition(proxies=8)
    bpy.ops.isimp.mesh()
    assert "was edited" not in capfd.readouterr().out
    scan.data.vertices[3].co.x += 0.3
    scan.data.update()
    bpy.ops.isimp.mesh()
    assert "The scan was edited since Partition" in capfd.readouterr().out
    bpy.ops.isimp.mesh()
    assert "was edited" not in capfd.readouterr().out, "once is enough"


@pytest.mark.skipif(not bpy.context.window, reason="needs a window, which the background has")
def test_the_workspace_is_made_once_and_opened():
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    names = set(bpy.data.workspaces.keys())
    assert bpy.ops.isimp.workspace() == {"FINISHED"}
    assert set(bpy.data.workspaces.keys()) - names == {"iSimp"}
    made = bpy.data.workspaces["iSimp"]
    areas = [area for screen in made.screens for area in screen.areas if area.type == "VIEW_3D"]
    space = max(areas, key=lambda area: area.width * area.height).spaces.active
    assert (space.show_region_ui, space.show_region_toolbar, space.shading.type) == (True, True, "SOLID")
    assert bpy.ops.isimp.workspace() == {"FINISHED"}
    assert set(bpy.data.workspaces.keys()) - names == {"iSimp"}
    assert set(names) <= set(bpy.data.workspaces.keys()), "those that were there stay"


def test_tooltips_end_without_a_full_stop():
    texts = {text for cls in blender._CLASSES for text in ui_strings.of_class(cls)}
    assert "Merge the regions of the selected faces into one. The regions must be neighbours" in texts
    assert sorted(text for text in texts if text.endswith(".") and not text.endswith("...")) == []
