"""Next to the scan the tools turn the view and move nothing; buttons act on the region clicked last; lines stay."""

from contextlib import suppress

import bpy
import numpy as np
from actions import begin, labels, last, make_scan, place, regions, same, scan, sketched, state, steps, tool

from isimp.blender.scene import pointed, runtime
from isimp.blender.view import overlay

BESIDE, FURTHER = (-1.12, 1.12), (-1.0, 1.16)  # places next to the scan


def seen(hand):
    """The place of the scan, its selection, its steps, and the rotation of the view."""
    turned = hand.area.spaces.active.region_3d.view_rotation
    return tuple(scan().matrix_basis.translation), scan().select_get(), len(steps()), tuple(turned)


def pulled(hand, begin, end, **held):
    """As `drag`, in few moves."""
    yield from hand.move(*place(hand, *begin))
    hand.event("LEFTMOUSE", "PRESS", **held)
    yield
    for x, z in (np.mean([begin, end], axis=0), end):
        yield from hand.move(*place(hand, x, z))
    hand.event("LEFTMOUSE", "RELEASE", **held)
    yield 0.1


def beside(hand):
    view = hand.area.spaces.active.region_3d
    front = view.view_rotation.copy()
    for name, held in (("region", {}), ("paint", {}), ("cut", {"ctrl": True}), ("grow", {}), ("opening", {})):
        yield from tool(hand, f"isimp.{name}_tool.object")
        before = seen(hand)
        yield from hand.click(*place(hand, *BESIDE), **held)
        same(f"{name}: a click does nothing", seen(hand), before)
        yield from pulled(hand, BESIDE, FURTHER, **held)
        after = seen(hand)
        same(f"{name}: a drag moves nothing", after[:3], before[:3])
        same(f"{name}: it turns the view", after[3] != before[3], True)
        yield from hand.move(*place(hand, 0.0, 0.0))
        same(f"{name}: until the release", seen(hand), after)
        view.view_rotation, view.view_perspective = front, "ORTHO"
        yield


def press(hand, name):
    """Runs the action of a button; a refusal is no exception."""
    with suppress(RuntimeError), hand.within("UI"):
        getattr(bpy.ops.isimp, name)("INVOKE_DEFAULT", True)
    yield from hand.settle()


def chosen(hand):
    """The faces that an importer has left selected are none that the buttons act on."""
    yield from tool(hand, "isimp.region_tool.object")
    scan().data.polygons.foreach_set("select", np.ones(len(scan().data.polygons), bool))
    before = regions()
    yield from press(hand, "split")
    same("no region is chosen", regions(), before)
    yield from hand.click(*place(hand, 0.0, 0.0), shift=True)
    yield from hand.settle()
    scan().data.polygons.foreach_set("select", np.ones(len(scan().data.polygons), bool))
    face = pointed.face(scan())
    same("in the region in the middle", labels()[face] == labels()[middle()], True)
    yield from hand.move(*place(hand, *BESIDE))
    yield from hand.shot("off_scan-1-chosen")
    yield from press(hand, "split")
    same("the region clicked last", (regions(), last(), steps()[-1].face), (before + 1, "SplitRegion", face))
    yield from press(hand, "lock")
    same("locked, and no other", (last(), steps()[-1].faces), ("LockRegions", (face,)))
    yield from hand.undo()
    yield from hand.undo()
    yield from hand.click(*place(hand, *BESIDE))
    count = len(steps())
    yield from press(hand, "lock")
    same("a click beside the scan chooses none", len(steps()), count)


def middle():
    """The face in the middle of the scan's front."""
    return scan().ray_cast((0, -9, 0), (0, 1, 0))[3]


def kept(hand):
    """After an edit the old polygons stay, fainter, until the polygons of the new regions are there."""
    yield from sketched()
    tick, overlay._tick = overlay._tick, lambda: None
    before, edited = state(), runtime.get().drawings[overlay._key(bpy.context, scan())]
    bpy.ops.isimp.split("INVOKE_DEFAULT", True, face=middle())
    yield from hand.settle()
    same("edited", state() != before, True)
    with hand.within():
        now = overlay._drawing(bpy.context, scan()).sketch
        same("new borders at once", (len(now.borders) > len(edited.sketch.borders), len(now.outline)), (True, 0))
        same("old polygons", overlay._former(bpy.context, scan()) is edited, True)
    with hand.within("UI"):
        same("old report", overlay.reported(bpy.context, scan()), (edited.sketch.numbers, False))
    yield from hand.shot("off_scan-2-kept")
    overlay._tick = tick
    for _ in range(200):
        overlay.redraw()
        yield 0.1
        with hand.within():
            if overlay._former(bpy.context, scan()) is None:
                return
    raise AssertionError("no new polygons")


def on_the_result(hand):
    """No tool works on it, and none moves it."""
    bpy.ops.isimp.mesh("EXEC_DEFAULT", True)
    result = bpy.context.object
    yield from tool(hand, "isimp.region_tool.object")
    yield from pulled(hand, (0.0, 0.0), (0.4, 0.3))
    same("on the result", tuple(result.matrix_basis.translation), (0.0, 0.0, 0.0))
    bpy.ops.isimp.swap()
    yield 0.3


def left(hand):
    """The region under the mouse is highlighted, and nothing while the mouse is in the sidebar."""
    for _ in range(100):
        yield from hand.move(*place(hand, 0.2, 0.21))
        if runtime.get().hover is not None:
            break
        yield 0.1
    side = hand.region("UI")
    yield from hand.move(side.x + side.width / 2, side.y + side.height / 3)
    yield 0.5
    same("in the sidebar", runtime.get().hover, None)


def run(hand):
    yield from begin(hand, make=lambda: make_scan(4), bars=True)
    yield from beside(hand)
    yield from on_the_result(hand)
    yield from left(hand)
    yield from kept(hand)
    yield from chosen(hand)
