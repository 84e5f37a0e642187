"""Shared by the scenarios: made scans, the tools and their drags, and the state of the scan."""

import zlib

import bpy
import numpy as np
import scans

import isimp
from isimp.blender.panel import common, edit
from isimp.blender.panel import steps as step_panel
from isimp.blender.scene import runtime, store
from isimp.blender.view import overlay


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
    for name in ("bl_space_type", "bl_region_type", "bl_category"):
        setattr(step_panel.ISIMP_PT_steps, name, getattr(common.Panel, name))
    step_panel.ISIMP_PT_steps.bl_options = set()


def show_edits():
    """Opens the panel Regions from the beginning; before the add-on is switched on."""
    edit.ISIMP_PT_regions.bl_options = set()


def scan():
    return bpy.data.objects["Scan"]


def regions():
    """The number of regions of the scan."""
    try:
        return len(np.unique(labels()))
    except KeyError:
        return 0


def same(what, seen, wanted):
    print(f"{what}: {seen}", flush=True)
    assert seen == wanted, f"{what}: {seen}, not {wanted}"


def tool(hand, name):
    """Chooses a tool; its settings are drawn once where the bar is hidden."""
    view, hidden = hand.area.spaces.active, not hand.area.spaces.active.show_region_tool_header
    view.show_region_tool_header = True
    with hand.within():
        bpy.ops.wm.tool_set_by_id(name=name)
    yield 0.2
    if hidden:
        view.show_region_tool_header = False
        yield 0.1


def begin(hand, make=make_scan, proxies=14, bars=False):
    """A scan in its regions, viewed from the front; bars: with the sidebar and the others."""
    isimp.register()
    make()
    yield 0.5
    yield from hand.open_tab() if bars else hand.open_view()
    bpy.ops.isimp.partition("EXEC_DEFAULT", True, proxies=proxies)
    yield from view(hand)


def view(hand):
    """Turns the view to the front of the scan, so that it fills the view."""
    if bpy.app.version >= (4, 0, 0):  # where these buttons would lie over it
        hand.area.spaces.active.show_gizmo_navigate = False
        yield 0.5
    with hand.within():
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_selected()
    yield 0.8


def place(hand, x, z):
    """The place in the window of a place in the scan's front; x and z from -1 to 1 over the scan."""
    from bpy_extras import view3d_utils

    region, view = hand.region("WINDOW"), hand.area.spaces.active.region_3d
    at = view3d_utils.location_3d_to_region_2d(region, view, (1.5 * x, -1.5, 1.5 * z))
    return region.x + at[0], region.y + at[1]


def drag(hand, begin, end, shot=None, **held):
    """Drags from one place on the scan's front to another, with keys held."""
    yield from hand.move(*place(hand, *begin))
    hand.event("LEFTMOUSE", "PRESS", **held)
    yield 0.1
    for share in np.linspace(0, 1, 7):
        x, z = (1 - share) * np.array(begin) + share * np.array(end)
        yield from hand.move(*place(hand, x, z))
    if shot:
        yield from hand.shot(shot)
    hand.event("LEFTMOUSE", "RELEASE", **held)
    yield from hand.settle()


def steps():
    return store.load(scan()).steps


def undone_and_redone(hand, what, seen):
    """Ctrl-Z undoes an action in one go, and Ctrl-Shift-Z does it again. seen: the state to compare."""
    after, count = seen(), len(steps())
    yield from hand.undo()
    same(f"{what}, undone", (seen() != after, len(steps())), (True, count - 1))
    yield from hand.redo()
    same(f"{what}, redone", (seen(), len(steps())), (after, count))


def labels():
    """(faces,) the region of each face of the scan, in either mode."""
    return scans.regions(scan())


def state():
    """A number for all regions: it changes if a face moves to another region."""
    return zlib.crc32(labels())


def last():
    return type(steps()[-1]).__name__


def locked():
    return store.numbers(scan()).get("locked", 0)


def sketched():
    """Waits until the drawing over the scan is there, the polygons too."""
    yield 0.3
    for _ in range(400):
        seen = overlay.scan_shown(bpy.context)
        if seen is None or overlay._key(bpy.context, seen) in runtime.get().drawings:
            return
        yield 0.05
    raise AssertionError("no sketch was made")


def settings():
    return bpy.context.window_manager.isimp


def settled():
    live = runtime.get().live
    for _ in range(200):
        if not live.pending and live.work is None and live.shown is None:
            yield 0.2
            return
        yield 0.05
    raise AssertionError("the settings do not settle")


def shown():
    """The number of visible regions: of the preview over the scan while a setting is dragged, else of the scan."""
    drawn = runtime.get().live.shown_of(scan())
    return regions() if drawn is None else drawn.work.task.result.numbers["regions"]


def running():
    return runtime.get().running is not None
