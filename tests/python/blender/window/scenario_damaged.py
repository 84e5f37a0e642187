"""A file with steps of a later version, opened in a window: the panel reports them, and Partition starts again."""

import bpy
import damage
from scenario_main import make_scan, regions, same, scan, show_steps

import isimp


def reopen(path):
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False)
    yield 0.5


def names():
    return {layer.name for layer in scan().data.attributes if "isimp" in layer.name}


def run(hand):
    show_steps()
    isimp.register()
    make_scan(subdivisions=6)  # 20,480 triangles: in Edit Mode they are written in several pieces
    yield 0.5
    yield from hand.open_tab()
    for mode in ("OBJECT", "EDIT"):
        bpy.ops.isimp.partition("EXEC_DEFAULT", True, proxies=14)
        damage.put(damage.last(scan().data), "step", damage.LATER)
        before = damage.dump(scan().data)["nodes"]
        yield from reopen(hand.out / "damaged.blend")
        bpy.ops.object.mode_set(mode=mode)
        bpy.ops.ed.undo_push(message="opened")
        yield 0.5
        yield from hand.shot(f"damaged-1-opened-{mode.lower()}")
        same("opened", damage.dump(scan().data)["nodes"], before)
        assert "'future_step' is not a step of this version" in damage.panels()
        with bpy.context.temp_override(window=hand.window, area=hand.area, region=hand.region("WINDOW")):
            same("the tool says why it can't", bpy.ops.isimp.point("INVOKE_DEFAULT"), {"CANCELLED"})
        if mode == "OBJECT":
            yield from hand.press("isimp.partition")
        else:
            bpy.ops.isimp.partition("INVOKE_DEFAULT", True)
            yield from hand.settle()
        assert "Kept, as it could not be read: 'isimp_region.kept" in damage.panels()
        yield from hand.shot(f"damaged-2-anew-{mode.lower()}")
        anew = regions(), names()
        assert anew[0] > 3, anew
        yield from hand.undo()
        same("kept names after undo", names() < anew[1], True)
        assert "'future_step'" in damage.panels()
        yield from hand.redo()
        same("redone", (regions(), names()), anew)
        yield from reopen(hand.out / "damaged.blend")
        same("reopened", (regions(), names() == anew[1]), (anew[0], True))
        assert all(node in damage.dump(scan().data)["nodes"] for node in before)
        bpy.ops.object.mode_set(mode="OBJECT")
