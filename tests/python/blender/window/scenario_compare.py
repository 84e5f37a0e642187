"""The drawing in the view: the quick start, a scale of 2, and the line between scan and result."""

import bpy
import numpy as np
from actions import make_scan, same, scan, settings, show_edits
from scans import material_of

import isimp
from isimp.blender import preferences
from isimp.blender.scene import runtime
from isimp.blender.texts import viewport_text
from isimp.blender.view import quick_start

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


def textured(hand):
    """A scan with an image: both sides show it, and neither is grey."""
    mesh = scan().data
    image = bpy.data.images.new("Picture", 64, 64)
    image.generated_type = "COLOR_GRID"
    mesh.materials.append(material_of("Painted", image))
    bpy.ops.isimp.mesh()
    yield 0.5
    yield from hand.press("isimp.compare")
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


def start(hand):
    """The quick start is visible at first, and hidden after a click or the first Partition."""
    wish = preferences.get(bpy.context)
    same("shown", quick_start.is_shown(bpy.context), True)
    shown, _ = yield from pixels(hand, "start-1-shown")
    yield from hand.into_view()
    yield from hand.click(*hand.at)
    yield 0.3
    same("gone after a click", wish.quick_start, False)
    gone, _ = yield from pixels(hand, "start-2-gone")
    same("and no longer drawn", bool(np.abs(shown - gone)[: len(gone) // 2].max() > 0.3), True)
    same("the click selects as ever", [obj.name for obj in bpy.context.selected_objects], ["Scan"])
    wish.quick_start = True
    hand.area.tag_redraw()
    yield 0.3
    settings().partition.count_by, settings().partition.proxies = "proxies", 40
    yield from hand.press("isimp.partition")
    same("gone after Partition", wish.quick_start, False)


def scaled(hand):
    """At a scale of 2 the summary takes more lines and stays clear of the sidebar."""
    drawn, draw = [], viewport_text._draw

    def noted(lines, x, y, scale):
        drawn.append((x + max(map(viewport_text._width, lines)), len(lines)))
        draw(lines, x, y, scale)

    viewport_text._draw = noted
    for scale in (1.0, 2.0):
        bpy.context.preferences.view.ui_scale = scale
        yield 1.0
        drawn.clear()
        hand.area.tag_redraw()
        yield 1.0
        right, lines = drawn[-1]
        same("one line, or more", lines > 1, scale == 2.0)
        same("clear of the sidebar", right <= hand.region("UI").x - hand.region("WINDOW").x, True)
        yield from hand.shot(f"scale-{scale:.0f}")
    viewport_text._draw = draw
    bpy.context.preferences.view.ui_scale = 1.0
    yield 1.0


def compared(hand):
    """The line: the drawing at either side of it, and the restored state afterwards."""
    result = bpy.context.object
    yield from hand.press("isimp.compare")
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


def run(hand):
    show_edits()
    isimp.register()
    preferences.get(bpy.context).quick_start = True
    make_scan()
    yield 0.5
    yield from hand.open_tab()
    with hand.within():
        bpy.ops.view3d.view_selected()
    hand.area.spaces.active.overlay.show_floor = False
    yield from start(hand)
    bpy.ops.isimp.mesh()
    yield 0.5
    yield from scaled(hand)
    yield from compared(hand)
    yield from textured(hand)
