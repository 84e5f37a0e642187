"""The line between scan and result: the drawing at either side of it, and the restored state afterwards."""

import bpy
import numpy as np
from scans import material_of
from scenario_main import make_scan, same, scan

import isimp

SKIPPED = 40  # pixels next to the line, where its grip and labels are


def pixels(hand, name):
    """(H, W, 3) of the part of the viewport that neither sidebar nor header nor labels cover."""
    yield from hand.shot(name)
    image = bpy.data.images.load(str(hand.out / f"{name}.png"))
    wide, high = image.size
    found = np.empty(4 * wide * high, np.float32)
    image.pixels.foreach_get(found)
    bpy.data.images.remove(image)
    view, side = hand.region("WINDOW"), hand.region("UI")
    right = side.x if side.width > 1 else view.x + view.width
    found = found.reshape(high, wide, 4)[:, :, :3]
    return found[view.y + 90 : view.y + view.height - 150, view.x + 80 : right - 10], view.x + 80


def run(hand):
    isimp.register()
    make_scan()
    yield 0.5
    yield from hand.open_tab()
    with bpy.context.temp_override(window=hand.window, area=hand.area, region=hand.region("WINDOW")):
        bpy.ops.view3d.view_selected()
    hand.area.spaces.active.overlay.show_floor = False
    bpy.ops.isimp.partition(proxies=40)
    bpy.ops.isimp.mesh()
    yield 0.5
    result = bpy.context.object
    yield from hand.press("isimp.compare")
    from isimp.blender.scene import runtime

    made = runtime.get().comparison
    same("both are hidden", (scan().hide_get(), result.hide_get()), (True, True))
    view = hand.region("WINDOW")
    middle, height = view.x + view.width * 0.4, view.y + view.height * 0.4
    yield from hand.move(middle + 200, height)
    hand.event("LEFTMOUSE", "PRESS")
    yield 0.1
    yield from hand.move(middle, height)
    hand.event("LEFTMOUSE", "RELEASE")
    yield 0.2
    same("the line is where the mouse let it go", round(made.share, 2), 0.4)
    for look in ("PLAIN", "REGIONS"):
        same("look", made.look, look)
        both, left = yield from pixels(hand, f"compare-{look.lower()}")
        alone = []
        for share in (0.0, 1.0):
            made.share = share
            hand.area.tag_redraw()
            yield 0.3
            shot, _ = yield from pixels(hand, f"compare-{look.lower()}-{share:.0f}")
            alone.append(shot)
        made.share = 0.4
        line = int(middle) - left
        result_alone, scan_alone = alone
        assert np.abs(result_alone - scan_alone).max() > 0.1, "scan and result look different"
        same("left: scan", float(np.abs(both - scan_alone)[:, : line - SKIPPED].max()) < 0.02, True)
        same("right: result", float(np.abs(both - result_alone)[:, line + SKIPPED :].max()) < 0.02, True)
        yield from hand.into_view()
        yield from hand.key("C")
    same("around", made.look, "PLAIN")
    before = np.array(hand.area.spaces.active.region_3d.view_matrix)
    yield from hand.into_view()
    yield from hand.key("NUMPAD_1")
    yield 0.5
    assert not np.allclose(before, np.array(hand.area.spaces.active.region_3d.view_matrix)), "the view can be turned"
    yield from hand.key("X")  # would delete
    yield from hand.key("ESC")
    yield 0.3
    same("over", runtime.get().comparison, None)
    same("as before", (scan().hide_get(), result.hide_get(), bpy.context.object.name), (True, False, "Scan.simplified"))
    same("selected", [obj.name for obj in bpy.context.selected_objects], ["Scan.simplified"])
    yield from hand.press("isimp.compare")
    yield from hand.press("isimp.swap")  # a press outside the view ends it, and is done
    same("ended by a button", runtime.get().comparison, None)
    yield from textured(hand)


def textured(hand):
    """A scan with an image: both sides show it, and neither is grey."""
    mesh = scan().data
    image = bpy.data.images.new("Picture", 64, 64)
    image.generated_type = "COLOR_GRID"
    mesh.materials.append(material_of("Painted", image))
    bpy.ops.isimp.mesh()
    yield 0.5
    yield from hand.press("isimp.compare")
    from isimp.blender.scene import runtime

    made = runtime.get().comparison
    same("look", made.look, "TEXTURE")
    made.share = 0.4
    shot, left = yield from pixels(hand, "compare-texture")
    line = int(hand.region("WINDOW").width * 0.4) + hand.region("WINDOW").x - left
    for half in (shot[:, : line - SKIPPED], shot[:, line + SKIPPED :]):
        coloured = np.ptp(half, axis=2) > 0.1
        assert coloured.mean() > 0.2, coloured.mean()
    isimp.unregister()  # in the middle of it
    yield 0.5
    same("given back", (scan().hide_get(), bpy.context.object.hide_get()), (True, False))
