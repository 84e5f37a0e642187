"""The tools in the toolbar, with a real mouse: click, ctrl-click, alt-click; undo and redo; what is drawn meanwhile."""

import bpy
import numpy as np
from scenario_main import make_scan, regions, same, scan

import isimp


def tool(hand, name):
    with bpy.context.temp_override(window=hand.window, area=hand.area, region=hand.region("WINDOW")):
        bpy.ops.wm.tool_set_by_id(name=name)
    yield 0.3


def view(hand):
    """Looks at the scan from the front, so that it fills the view."""
    with bpy.context.temp_override(window=hand.window, area=hand.area, region=hand.region("WINDOW")):
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_selected()
    yield 0.8


def place(hand, x, z):
    """Where a place in the scan's front is in the window; x and z from -1 to 1 over the scan."""
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
    from isimp.blender import store

    return store.load(scan()).steps


def sketched():
    """Waits until what is drawn over the scan is there."""
    from isimp.blender import runtime

    yield 0.3
    for _ in range(200):
        made = runtime.get().drawings
        if runtime.get().sketching is None and made:
            return
        yield 0.05
    raise AssertionError("no sketch was made")


def drawn():
    from isimp.blender import overlay, runtime

    key = overlay._key(bpy.context, scan())
    return runtime.get().drawings[key].sketch


def border():
    """How many edges of the scan lie between regions."""
    import scans

    label = scans.regions(scan())
    pairs = scans.face_pairs(scan().data)
    return int(np.count_nonzero(label[pairs[:, 0]] != label[pairs[:, 1]]))


def run(hand):
    isimp.register()
    make_scan()
    yield 0.5
    yield from hand.open_tab()
    bpy.ops.isimp.partition("EXEC_DEFAULT", True, proxies=14)
    yield from view(hand)
    yield from sketched()
    sketch = drawn()
    assert len(sketch.borders)
    assert len(sketch.outline)
    assert len(sketch.corners)
    yield from hand.shot("tools-1-sketch")
    yield from tool(hand, "isimp.region_tool.object")

    from isimp.blender import runtime

    yield from hand.move(*place(hand, 0.2, 0.2))
    for _ in range(100):
        yield from hand.move(*place(hand, 0.2, 0.21))
        if runtime.get().hover is not None:
            break
        yield 0.1
    for word in ("of the area", "of the error", "flat to"):
        assert word in runtime.get().hover.text, runtime.get().hover
    assert "Ctrl: delete" in runtime.get().status
    yield from hand.shot("tools-2-hover")

    yield from hand.click(*place(hand, 0.4, 0.4))
    yield from hand.settle()
    same("click adds", regions(), 15)
    yield from sketched()
    yield from hand.shot("tools-3-add")
    yield from hand.undo()
    same("undone", regions(), 14)
    yield from hand.redo()
    same("redone", regions(), 15)
    yield from hand.click(*place(hand, 0.4, 0.4), ctrl=True)
    yield from hand.settle()
    same("ctrl-click deletes", regions(), 14)
    yield from hand.click(*place(hand, -0.3, -0.3), alt=True)
    yield from hand.settle()
    selected = np.empty(len(scan().data.polygons), bool)
    scan().data.polygons.foreach_get("select", selected)
    assert 20 < selected.sum() < len(selected) / 2, selected.sum()

    x, y = place(hand, 0.0, 0.0)
    yield from hand.move(x, y)
    hand.event("LEFTMOUSE", "PRESS")
    yield 0.1
    yield from hand.move(x + 5, y)
    yield from hand.key("ESC")
    hand.event("LEFTMOUSE", "RELEASE")
    yield 0.3
    same("Esc drops", regions(), 14)

    yield from hand.into_view()
    yield from hand.key("TAB")
    yield 0.3
    yield from tool(hand, "isimp.region_tool.edit_mesh")
    yield from hand.click(*place(hand, 0.4, 0.4))
    yield from hand.settle()
    same("click adds in Edit Mode", (scan().mode, regions()), ("EDIT", 15))
    yield from hand.undo()
    same("undone in Edit Mode", regions(), 14)
    yield from hand.shot("tools-4-edit")
    yield from hand.into_view()
    yield from hand.key("TAB")
    yield 0.3
    yield from tool(hand, "isimp.region_tool.object")
    before = regions()
    yield from hand.move(*place(hand, 0.0, 0.0))
    hand.event("LEFTMOUSE", "PRESS")
    yield 0.1
    for x in (0.3, 0.6, 0.9):
        yield from hand.move(*place(hand, x, 0.85))
        yield 0.1
    yield from hand.shot("tools-5-merge")
    hand.event("LEFTMOUSE", "RELEASE")
    yield from hand.settle()
    same("a drag merges", regions(), before - 1)
    yield from hand.undo()
    same("undone", regions(), before)
    yield from hand.move(*place(hand, 0.0, 0.0))
    yield from hand.key("L")
    yield from hand.settle()
    same("locked", type(steps()[-1]).__name__, "LockRegions")
    yield from sketched()
    same("hatched", len(drawn().locked) > 0, True)
    yield from hand.shot("tools-6-locked")
    yield from hand.move(*place(hand, 0.0, 0.0))
    yield from hand.key("L")
    yield from hand.settle()
    same("unlocked", type(steps()[-1]).__name__, "UnlockRegions")

    yield from tool(hand, "isimp.paint_tool.object")
    bpy.context.window_manager.isimp.brush = 25
    yield from drag(hand, (-0.4, 0.0), (0.3, 0.1), ctrl=True, shot="tools-7-paint")
    same("painted a new region", (regions(), type(steps()[-1]).__name__), (before + 1, "PaintFaces"))
    same("and locked it", steps()[-1].lock, True)
    painted = len(steps()[-1].faces)
    yield from drag(hand, (-0.3, 0.0), (-0.3, 0.4))
    same("painted into it", (regions(), steps()[-1].onto >= 0), (before + 1, True))
    yield from hand.undo()
    same("a stroke is one step to undo", len(steps()[-1].faces), painted)
    yield from drag(hand, (-0.4, 0.0), (-0.2, 0.0), ctrl=True, shift=True)
    same("erased", type(steps()[-1]).__name__, "EraseFaces")
    ragged = border()
    yield from drag(hand, (0.1, 0.6), (0.95, 0.3), shift=True, shot="tools-7-smooth")
    same("smoothed", (type(steps()[-1]).__name__, border() < ragged), ("SmoothFaces", True))
    yield from hand.undo()
    same("not smoothed", border(), ragged)
    yield from hand.redo()
    same("smoothed again", border() < ragged, True)
    yield from hand.into_view()
    yield from hand.key("X")
    same("X mirrors", bpy.context.window_manager.isimp.mirror, "X")
    yield from drag(hand, (0.3, -0.4), (0.4, -0.4), ctrl=True)
    same("painted on both sides", [type(step).__name__ for step in steps()[-2:]], ["PaintFaces", "PaintFaces"])
    left, right = (set(step.faces) for step in steps()[-2:])
    assert 0.5 < len(left) / len(right) < 2, (len(left), len(right))
    before = regions()

    yield from tool(hand, "isimp.cut_tool.object")
    yield from drag(hand, (-0.9, -0.15), (0.9, -0.12), shot="tools-8-cut")
    same("cut", (regions(), type(steps()[-1]).__name__), (before + 1, "CutRegion"))
    yield from hand.shot("tools-9-after")
    yield from tool(hand, "builtin.select_box")
    yield 0.3
    same("another tool", (runtime.get().hover, runtime.get().status), (None, ""))
