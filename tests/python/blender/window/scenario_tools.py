"""The Region tool, with a real mouse: clicks, a drag and L; undo and redo of each; the drawing."""

import zlib

import bpy
import numpy as np
from scenario_main import make_scan, regions, same, scan

import isimp


def tool(hand, name):
    """Chooses a tool; its settings are drawn once where the bar is hidden."""
    view, hidden = hand.area.spaces.active, not hand.area.spaces.active.show_region_tool_header
    view.show_region_tool_header = True
    with bpy.context.temp_override(window=hand.window, area=hand.area, region=hand.region("WINDOW")):
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
    with bpy.context.temp_override(window=hand.window, area=hand.area, region=hand.region("WINDOW")):
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
    from isimp.blender.scene import store

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
    import scans

    return scans.regions(scan())


def state():
    """A number for all regions: it changes if a face moves to another region."""
    return zlib.crc32(labels())


def last():
    return type(steps()[-1]).__name__


def sketched():
    """Waits until the drawing over the scan is there, the polygons too."""
    from isimp.blender.scene import runtime
    from isimp.blender.view import overlay

    yield 0.3
    for _ in range(400):
        seen = overlay.scan_shown(bpy.context)
        if seen is None or overlay._key(bpy.context, seen) in runtime.get().drawings:
            return
        yield 0.05
    raise AssertionError("no sketch was made")


def drawn():
    from isimp.blender.scene import runtime
    from isimp.blender.view import overlay

    key = overlay._key(bpy.context, scan())
    return runtime.get().drawings[key].sketch


def hovered(hand):
    from isimp.blender.scene import runtime

    yield from hand.move(*place(hand, 0.2, 0.2))
    for _ in range(100):
        yield from hand.move(*place(hand, 0.2, 0.21))
        if runtime.get().hover is not None:
            break
        yield 0.1
    for word in ("of the area", "of the error", "planar within"):
        assert word in runtime.get().hover.text, runtime.get().hover
    assert "Ctrl: delete" in runtime.get().status


def clicked(hand):
    from isimp.blender.scene import runtime
    from isimp.blender.view import overlay

    before, keep, kept = regions(), overlay._keep, []

    def noted(key, made):
        kept.append(key[3] is None)
        keep(key, made)

    overlay._keep = noted
    yield from hand.click(*place(hand, 0.4, 0.4))
    yield from hand.settle()
    same("click adds", (regions(), last()), (before + 1, "AddProxy"))
    yield from sketched()
    overlay._keep = keep
    same("polygons, as borders are there at once", kept, [False])
    yield from hand.shot("tools-3-add")
    made = runtime.get().surface
    yield from undone_and_redone(hand, "added", state)
    yield from hovered(hand)
    same("what the mouse needs stays through undo", runtime.get().surface is made, True)
    yield from hand.click(*place(hand, 0.4, 0.4), ctrl=True)
    yield from hand.settle()
    same("ctrl-click deletes", (regions(), last()), (before, "DeleteProxy"))
    yield from undone_and_redone(hand, "deleted", state)


def colors(obj):
    values = np.empty(4 * len(obj.data.loops), np.float32)
    obj.data.attributes["isimp_color"].data.foreach_get("color", values)
    return values


def at_once(hand):
    """A click shows the region by a redraw before Blender hears of it, and all of it by one more."""
    from isimp.blender.drawing import late
    from isimp.blender.scene import runtime
    from isimp.blender.view import overlay

    if not late.IS_QUIET:
        return
    yield from sketched()
    yield from hand.move(*place(hand, -0.4, 0.4))
    yield 1
    before, drawn, settle = state(), [], late.settle
    late.settle = lambda: None  # else the polygons may be quicker than this test
    add = bpy.types.SpaceView3D.draw_handler_add
    counting = add(lambda: drawn.append(state() != before), (), "WINDOW", "POST_PIXEL")
    yield from hand.click(*place(hand, -0.4, 0.4))
    yield from hand.settle()
    yield from sketched()
    yield 0.5
    same("redraws of the result", drawn.count(True) <= 2, True)
    patch = runtime.get().late.patch
    shown = scan().evaluated_get(bpy.context.evaluated_depsgraph_get())
    same("not told of it yet", (patch.count > 20, np.array_equal(colors(shown), colors(scan()))), (True, False))
    yield from hand.shot("tools-3-late")
    late.settle = settle
    overlay.tell_late()
    yield 1
    shown = scan().evaluated_get(bpy.context.evaluated_depsgraph_get())
    same("told of it", (runtime.get().late.patch, np.array_equal(colors(shown), colors(scan()))), (None, True))
    bpy.types.SpaceView3D.draw_handler_remove(counting, "WINDOW")
    yield from hand.undo()
    shown = scan().evaluated_get(bpy.context.evaluated_depsgraph_get())
    same("undone", (state(), np.array_equal(colors(shown), colors(scan()))), (before, True))


def dropped(hand):
    x, y = place(hand, 0.0, 0.0)
    before = state()
    for drop in ({"kind": "ESC"}, {"kind": "Z", "ctrl": True}):
        yield from hand.move(x, y)
        hand.event("LEFTMOUSE", "PRESS")
        yield 0.1
        yield from hand.move(*place(hand, 0.6, 0.85))
        yield from hand.key(**drop)
        hand.event("LEFTMOUSE", "RELEASE")
        yield 0.3
        same(f"{drop['kind']} drops a drag", state(), before)


def in_edit_mode(hand):
    yield from hand.into_view()
    yield from hand.key("TAB")
    yield 0.3
    before = regions()
    yield from tool(hand, "isimp.region_tool.edit_mesh")
    yield from hand.click(*place(hand, 0.4, 0.4))
    yield from hand.settle()
    same("click adds in Edit Mode", (scan().mode, regions()), ("EDIT", before + 1))
    yield from undone_and_redone(hand, "added in Edit Mode", state)
    yield from hand.undo()
    yield from drag(hand, (0.0, 0.0), (0.6, 0.85))
    same("a drag merges in Edit Mode", (regions(), last()), (before - 1, "MergeRegions"))
    yield from undone_and_redone(hand, "merged in Edit Mode", state)
    yield from hand.undo()
    yield from hand.shot("tools-4-edit")
    yield from hand.into_view()
    yield from hand.key("TAB")
    yield 0.3
    yield from tool(hand, "isimp.region_tool.object")


def away(hand):
    """No text concerns a scan that is not shown any more."""
    from isimp.blender.scene import runtime
    from isimp.blender.view import overlay

    context = bpy.context
    with context.temp_override(window=hand.window, area=hand.area, region=hand.region("WINDOW")):
        same("hovered", overlay.hover_shown(context) is runtime.get().hover is not None, True)
        context.view_layer.objects.active = None
        same("not looked at", overlay.hover_shown(context), None)
        context.view_layer.objects.active = scan()


def refused(hand, words, **held):
    """A click in the middle that can't be done shows the reason, in words for visible things."""
    from isimp import messages

    told, unchanged = [], messages.unchanged
    messages.unchanged = lambda why: told.append(why) or unchanged(why)
    yield from hand.click(*place(hand, 0.0, 0.0), **held)
    yield from hand.settle()
    messages.unchanged = unchanged
    same("refused", told, [words])


def locked():
    from isimp.blender.scene import store

    return store.numbers(scan()).get("locked", 0)


def run(hand):
    yield from begin(hand)
    yield from sketched()
    sketch = drawn()
    assert len(sketch.borders)
    assert len(sketch.outline)
    assert len(sketch.corners)
    from isimp.blender.view import overlay

    with bpy.context.temp_override(window=hand.window, area=hand.area, region=hand.region("UI")):
        same("the panel tells what is drawn", overlay.previewed(bpy.context, scan()), sketch.numbers)
    yield from hand.shot("tools-1-sketch")
    yield from tool(hand, "isimp.region_tool.object")
    yield from hovered(hand)
    yield from hand.shot("tools-2-hover")
    away(hand)
    yield from at_once(hand)
    yield from clicked(hand)
    yield from dropped(hand)
    yield from in_edit_mode(hand)

    before = regions()
    yield from drag(hand, (0.0, 0.0), (0.9, 0.85), shot="tools-5-merge")
    same("a drag merges", (regions(), last()), (before - 1, "MergeRegions"))
    yield from undone_and_redone(hand, "merged", state)
    yield from hand.undo()
    for wanted in (1, 0):
        yield from hand.move(*place(hand, 0.0, 0.0))
        yield from hand.key("L")
        yield from hand.settle()
        same("L", (last(), locked()), ("LockRegions" if wanted else "UnlockRegions", wanted))
        yield from sketched()
        same("hatched", len(drawn().locked) > 0, bool(wanted))
        yield from undone_and_redone(hand, "L", locked)
        if wanted:
            kept = state()
            yield from refused(hand, "This region is locked: press L over it, or Unlock", ctrl=True)
            same("what is locked is not deleted", (state(), regions()), (kept, before))
            yield from refused(hand, "This region is locked: press L over it, or Unlock")
            same("nor divided", (state(), regions()), (kept, before))
            yield from sketched()
            yield from hand.shot("tools-6-locked")

    from isimp.blender.scene import runtime

    yield from tool(hand, "builtin.select_box")
    yield 0.3
    same("another tool", (runtime.get().hover, runtime.get().status), (None, ""))
