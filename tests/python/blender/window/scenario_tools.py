"""The Region tool and the Openings tool, with a real mouse: clicks, drags and L; undo, redo; the drawing."""

import bpy
import numpy as np
import scans
from actions import (
    begin,
    drag,
    last,
    locked,
    place,
    regions,
    same,
    scan,
    sketched,
    state,
    tool,
    undone_and_redone,
    view,
)

from isimp import messages
from isimp.blender.drawing import late
from isimp.blender.scene import runtime, store
from isimp.blender.view import overlay


def drawn():
    key = overlay._key(bpy.context, scan())
    return runtime.get().drawings[key].sketch


def hovered(hand):
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
    context = bpy.context
    with hand.within():
        same("hovered", overlay.hover_shown(context) is runtime.get().hover is not None, True)
        context.view_layer.objects.active = None
        same("not looked at", overlay.hover_shown(context), None)
        context.view_layer.objects.active = scan()


def refused(hand, words, **held):
    """A click in the middle that can't be done shows the reason, in words for visible things."""
    told, unchanged = [], messages.unchanged
    messages.unchanged = lambda why: told.append(why) or unchanged(why)
    yield from hand.click(*place(hand, 0.0, 0.0), **held)
    yield from hand.settle()
    messages.unchanged = unchanged
    same("refused", told, [words])


def openings(hand):
    """The Openings tool shows a closed opening; a click keeps it open, another one closes it again."""

    def kept():
        numbers = store.numbers(scan())
        return numbers["kept_open"], numbers["repairs"]["filled_holes"]

    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()
    scans.pierced([(0, -1, 0)], radius=1.5)
    bpy.ops.ed.undo_push(message="scan")
    bpy.ops.isimp.partition("EXEC_DEFAULT", True, proxies=8)
    yield from view(hand)
    same("the hole is closed", kept(), (0, 1))
    yield from tool(hand, "isimp.opening_tool.object")
    yield from hand.move(*place(hand, 0.02, 0.0))
    yield 0.3
    hover = runtime.get().hover
    same("the opening is shown", (hover is not None and hover.text.startswith("Hole, "), len(hover.lines)), (True, 3))
    yield from hand.shot("tools-7-closed")
    for at, wanted in (((0.0, 0.0), (1, 0)), ((0.6, 0.6), (1, 0)), ((0.0, 0.0), (0, 1))):
        yield from hand.click(*place(hand, *at))
        yield from hand.settle()
        same("a click keeps it open, one beside it does nothing, another closes it", kept(), wanted)
        yield from hand.move(*place(hand, 0.02, 0.0))
        yield 0.3
        same("the hover text names it", "kept open" in runtime.get().hover.text, wanted == (1, 0))
    yield from hand.undo()
    same("undone", kept(), (1, 0))


def run(hand):
    yield from begin(hand)
    yield from sketched()
    sketch = drawn()
    assert len(sketch.borders)
    assert len(sketch.outline)
    assert len(sketch.corners)
    with hand.within("UI"):
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

    yield from tool(hand, "builtin.select_box")
    yield 0.3
    same("another tool", (runtime.get().hover, runtime.get().status), (None, ""))
    yield from openings(hand)
