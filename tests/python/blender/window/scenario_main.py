"""The main job with the real buttons: Partition, Add, Delete, Mesh, undo and redo, in Object and in Edit Mode."""

import bpy
import numpy as np

import isimp


def make_scan(subdivisions=5):
    """A sphere with flat spots, of 20 * 4 ^ (subdivisions - 1) triangles."""
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=subdivisions, radius=2)
    scan = bpy.context.object
    scan.name = "Scan"
    for vertex in scan.data.vertices:
        vertex.co = [max(-1.5, min(1.5, value)) for value in vertex.co]
    bpy.ops.object.shade_flat()
    bpy.ops.ed.undo_push(message="scan")


def show_steps():
    """Puts the steps in the sidebar, where the mouse can leave them; before the add-on is switched on."""
    from isimp.blender.panel import common, steps

    for name in ("bl_space_type", "bl_region_type", "bl_category"):
        setattr(steps.ISIMP_PT_steps, name, getattr(common.Panel, name))
    steps.ISIMP_PT_steps.bl_options = set()


def show_edits():
    """Opens the panel Regions from the beginning; before the add-on is switched on."""
    from isimp.blender.panel import edit

    edit.ISIMP_PT_regions.bl_options = set()


def scan():
    return bpy.data.objects["Scan"]


def regions():
    """The number of regions of the scan."""
    obj = scan()
    if obj.mode == "EDIT":
        obj.update_from_editmode()
        import bmesh

        edit = bmesh.from_edit_mesh(obj.data)
        layer = edit.faces.layers.int.get("isimp_region")
        return len({face[layer] for face in edit.faces}) if layer else 0
    layer = obj.data.attributes.get("isimp_region")
    if layer is None:
        return 0
    label = np.empty(len(obj.data.polygons), np.int32)
    layer.data.foreach_get("value", label)
    return len(np.unique(label))


def same(what, seen, wanted):
    print(f"{what}: {seen}", flush=True)
    assert seen == wanted, f"{what}: {seen}, not {wanted}"


def run(hand):
    show_edits()
    isimp.register()
    make_scan()
    yield 0.5
    yield from hand.open_tab()
    yield from hand.shot("1-start")

    bpy.context.window_manager.isimp.partition.count_by = "proxies"
    yield from hand.type_into("partition.proxies", "14")
    same("typed", bpy.context.window_manager.isimp.partition.proxies, 14)
    yield from hand.find("bpy.ops.isimp.partition")
    place = hand.at
    yield from hand.press("isimp.partition")
    same("regions", regions(), 14)
    yield from hand.move(*place)
    same("the button stays under the mouse", hand.under_mouse(), "bpy.ops.isimp.partition")
    same("shading", hand.area.spaces.active.shading.color_type, "VERTEX")
    yield from hand.shot("2-partition")

    yield from hand.into_view()
    yield from hand.key("TAB")
    yield from hand.key("THREE")
    yield 0.3
    same("mode", scan().mode, "EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    yield from hand.into_view()
    yield from hand.click(*hand.at)
    same("selected", scan().data.total_face_sel, 1)
    yield from hand.press("isimp.add_proxy")
    same("regions after Add", regions(), 15)
    yield from hand.shot("3-add")
    yield from hand.press("isimp.delete_proxy")
    same("regions after Delete", regions(), 14)
    for wanted in (15, 14):
        yield from hand.undo()
        same("after undo", regions(), wanted)
    for wanted in (15, 14):
        yield from hand.redo()
        same("after redo", regions(), wanted)
    yield from hand.undo()

    yield from hand.into_view()
    yield from hand.key("TAB")
    yield 0.3
    same("mode", scan().mode, "OBJECT")
    same("regions in Object Mode", regions(), 15)
    yield from hand.press("isimp.mesh")
    same("and so does this one", hand.under_mouse(), "bpy.ops.isimp.mesh")
    with bpy.context.temp_override(window=hand.window, area=hand.area, region=hand.region("WINDOW")):
        same("no tool on the result", bpy.ops.isimp.point("INVOKE_DEFAULT"), {"CANCELLED"})
        same("nor the other", bpy.ops.isimp.paint("INVOKE_DEFAULT"), {"CANCELLED"})
    result = bpy.context.object
    same("result", result.name, "Scan.simplified")
    same("scan hidden", scan().hide_get(), True)
    assert 15 <= len(result.data.polygons) <= 25, len(result.data.polygons)
    assert not result.data.validate()
    same("shading", hand.area.spaces.active.shading.color_type, "MATERIAL")
    yield from hand.shot("4-mesh")

    yield from hand.undo()
    same("after undo", (bpy.context.object.name, scan().hide_get(), regions()), ("Scan", False, 15))
    same("shading", hand.area.spaces.active.shading.color_type, "VERTEX")
    yield from hand.redo()
    same("after redo", (bpy.context.object.name, scan().hide_get()), ("Scan.simplified", True))
    yield from hand.press("isimp.swap")
    same("swapped", (bpy.context.object.name, scan().hide_get()), ("Scan", False))
    yield from hand.shot("5-swap")
