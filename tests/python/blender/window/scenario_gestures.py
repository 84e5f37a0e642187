"""Gestures that change a region as a whole, with a real mouse: split, cut, grow and shrink; undo and redo of each."""

import bpy
import numpy as np
from actions import begin, drag, labels, last, place, regions, same, scan, state, steps, tool, undone_and_redone

from isimp.blender.scene import pointed, runtime


def region_at(x, z):
    """The region at a place of the scan's front."""
    found, _, _, face = scan().ray_cast((1.5 * x, -9, 1.5 * z), (0, 1, 0))
    assert found
    return int(labels()[face])


def size_of(x, z):
    """The number of faces of that region."""
    return int(np.count_nonzero(labels() == region_at(x, z)))


def pressed(hand, x, z, **held):
    yield from hand.click(*place(hand, x, z), **held)
    yield from hand.settle()


def chosen(hand):
    """Shift-clicks choose regions; a pie on the right button does something with all of them; Esc chooses none."""
    before, places, seen = regions(), [], set()
    for x, z in [(0.0, 0.0), (-0.6, 0.85), *((x / 4, z / 4) for x in range(-3, 1) for z in range(-3, 4))]:
        if region_at(x, z) not in seen and len(places) < 3:
            seen.add(region_at(x, z))
            places.append((x, z))
    for x, z in places:
        yield from pressed(hand, x, z, shift=True)
    same("three chosen, none split", (len(pointed.faces(scan())), regions()), (3, before))
    assert len(pointed.outline(scan()))
    yield from pressed(hand, *places[2], shift=True)
    same("and one not again", len(pointed.faces(scan())), 2)
    yield from hand.click(*place(hand, 0.3, 0.3), button="RIGHTMOUSE")
    yield from hand.shot("gestures-1-pie")
    yield from hand.move(hand.at[0] - 120, hand.at[1] + 70)  # upper left: the fifth button
    hand.event("LEFTMOUSE", "PRESS")
    yield
    hand.event("LEFTMOUSE", "RELEASE")
    yield from hand.settle()
    same("merged from the pie", (regions(), last()), (before - 1, "MergeRegions"))
    yield from undone_and_redone(hand, "merged", regions)
    yield from hand.undo()
    yield from hand.move(*place(hand, 0.3, 0.3))
    yield from hand.key("ESC")
    same("Esc chooses none", pointed.faces(scan()), ())


def border(hand):
    """A border lights up under the mouse; a drag moves it, as one step to undo; a click there adds a region."""
    x = next(x for x in np.linspace(0, -0.98, 200) if region_at(x, 0.0) != region_at(0.0, 0.0))
    before, outer, count = size_of(0, 0), region_at(x, 0.0), regions()
    yield from hand.move(*place(hand, x + 0.3, 0.0))
    yield 0.3
    same("not in the middle", runtime.get().hover.text.startswith("Region"), True)
    yield from hand.move(*place(hand, x + 0.02, 0.0))
    yield 0.3
    same("it lights up", (runtime.get().hover.text, len(runtime.get().hover.lines)), ("Drag to move this border", 2))
    yield from hand.shot("gestures-1-lit")
    yield from drag(hand, (x + 0.02, 0.0), (x - 0.15, 0.0), shot="gestures-1-border")
    same("the border is moved", (last(), size_of(0, 0) > before), ("PaintFaces", True))
    same("the undo step", bpy.context.window_manager.operators[-1].bl_label, "Move Border")
    assert region_at(x - 0.05, 0.0) != outer
    yield from undone_and_redone(hand, "a border", state)
    yield from hand.undo()
    yield from pressed(hand, x + 0.02, 0.0)
    same("a click adds", (last(), regions()), ("AddProxy", count + 1))
    yield from hand.undo()
    yield from drag(hand, (x + 0.02, 0.0), (x + 0.25, 0.0))
    same("and back", (last(), size_of(0, 0) < before), ("PaintFaces", True))
    yield from hand.undo()
    same("undone", size_of(0, 0), before)


def corner(hand):
    """A drag that begins at a corner of three regions moves the corner, as one step to undo."""
    line = np.arange(-47, 48) / 50
    label = np.array([[region_at(x, z) for z in line] for x in line])
    met = np.sort(np.stack([label[:-1, :-1], label[1:, :-1], label[:-1, 1:], label[1:, 1:]]), axis=0)
    corners = line[np.argwhere((np.diff(met, axis=0) != 0).sum(axis=0) > 1)] + 0.01
    at = corners[np.argmin(np.abs(corners).max(axis=1))]  # the one nearest to the middle
    inwards = -0.25 * at / np.linalg.norm(at)
    behind = at + 0.6 * inwards
    before, count = region_at(*behind), len(steps())
    yield from drag(hand, at, at + inwards, shot="gestures-1-corner")
    same("the corner is moved", (last(), region_at(*behind) != before), ("PaintFaces", True))
    yield from hand.undo()  # a step for each region that grows, and one undo for all
    same("undone", (region_at(*behind), len(steps())), (before, count))


def without_keys(hand):
    """Each mode of the bar replaces a key."""
    panel, before = bpy.context.window_manager.isimp, regions()
    other = next((x, z) for x in (0.4, 0.7, 0.9) for z in (0.5, 0.9) if region_at(x, z) != region_at(0, 0))
    for hand_mode, to, change, kind in (
        ("delete", None, -1, "DeleteProxy"),
        ("cut", (0.3, 0.1), 1, "CutRegion"),
        ("finer", (0.1, 0.0), 1, "SplitRegion"),
    ):
        panel.hand = hand_mode
        if to is None:
            yield from pressed(hand, 0.0, 0.0)
        else:
            yield from drag(hand, (-0.3, -0.1) if hand_mode == "cut" else (0.0, 0.0), to)
        same(hand_mode, (regions() - before, last()), (change, kind))
        yield from hand.undo()
    panel.hand = "more"
    yield from drag(hand, (0.0, 0.0), (0.3, 0.0), shot="gestures-1-more")
    (part,) = steps()[0].more
    same("more here, larger by the drag", (len(steps()), regions(), part[3] > 1), (1, before, True))
    yield from hand.undo()
    same("undone", steps()[0].more, ())
    yield from hand.key("ESC")
    panel.hand = "choose"
    yield from pressed(hand, 0.0, 0.0)
    yield from pressed(hand, *other)
    same("chosen", (len(pointed.faces(scan())), bpy.context.mode, last()), (2, "OBJECT", "Partition"))
    yield from hand.shot("gestures-1-modes")
    yield from hand.key("ESC")
    panel.hand = "merge"
    x = next(x for x in np.linspace(0, -0.98, 200) if region_at(x, 0.0) != region_at(0.0, 0.0))
    yield from drag(hand, (x + 0.02, 0.0), (x - 0.05, 0.0))
    same("merged from a border", (regions() - before, last()), (-1, "MergeRegions"))
    yield from hand.undo()
    yield from hand.into_view()
    yield from hand.key("ESC")
    panel.hand = "add"


def split_and_cut(hand):
    yield from tool(hand, "isimp.region_tool.object")
    before = regions()
    yield from without_keys(hand)
    yield from chosen(hand)
    yield from border(hand)
    yield from corner(hand)
    yield from drag(hand, (-0.9, -0.1), (0.9, -0.1), shift=True, shot="gestures-1-cut")
    same("shift-drag cuts", (regions(), last()), (before + 1, "CutRegion"))
    low, high = np.array(steps()[-1].line)
    assert low[0] * high[0] < 0 < 0.2 - abs(low[2]), steps()[-1].line  # from left to right, as drawn
    yield from undone_and_redone(hand, "cut", regions)
    yield from hand.undo()

    yield from tool(hand, "isimp.cut_tool.object")
    yield from pressed(hand, 0.1, 0.1)
    same("a click of the Cut tool splits", (regions(), last()), (before + 1, "SplitRegion"))
    yield from hand.undo()
    yield from hand.move(*place(hand, -0.5, 0.0))
    hand.event("LEFTMOUSE", "PRESS")
    yield 0.1
    yield from hand.move(*place(hand, 0.5, 0.0))
    yield from hand.key("ESC")
    hand.event("LEFTMOUSE", "RELEASE")
    yield 0.3
    same("Esc drops a cut", (regions(), last()), (before, "Partition"))


def by_the_wheel(hand):
    yield from tool(hand, "isimp.region_tool.object")
    before, count = size_of(0, 0), len(steps())
    yield from hand.move(*place(hand, 0.0, 0.0))
    hand.event("WHEELUPMOUSE", "PRESS", ctrl=True)
    yield from hand.settle()
    same("ctrl-wheel grows", (size_of(0, 0) > before, last(), len(steps())), (True, "GrowRegion", count + 1))
    yield from undone_and_redone(hand, "grown", lambda: size_of(0, 0))
    grown = size_of(0, 0)
    yield from hand.move(*place(hand, 0.0, 0.0))
    hand.event("WHEELDOWNMOUSE", "PRESS", ctrl=True)
    yield from hand.settle()
    same("and shrinks", (size_of(0, 0) < grown, last()), (True, "ShrinkRegion"))
    yield from undone_and_redone(hand, "shrunk", lambda: size_of(0, 0))
    yield from hand.undo()
    yield from hand.undo()
    same("as it was", (size_of(0, 0), len(steps())), (before, count))


def by_a_drag(hand, mode):
    """Drags the Grow tool; the preview before the mouse is released equals the result."""
    yield from tool(hand, f"isimp.grow_tool.{mode}")
    live, before, count = runtime.get().live, labels(), len(steps())
    for to, name in (((0.5, 0.0), "GrowRegion"), ((-0.4, 0.0), "ShrinkRegion")):
        x, y = place(hand, 0.0, 0.0)
        yield from hand.move(x, y)
        hand.event("LEFTMOUSE", "PRESS")
        yield 0.1
        yield from hand.move(*place(hand, *to))
        for _ in range(200):
            yield 0.05
            if live.tried is not None:
                break
        yield 0.5
        tried = live.tried.work.task.result.face_region
        same("not written yet", np.array_equal(labels(), before), True)
        words = runtime.get().hover.text
        assert words.startswith(name.removesuffix("Region")), words
        yield from hand.shot(f"gestures-2-{mode}-{name.lower()}")
        hand.event("LEFTMOUSE", "RELEASE")
        yield from hand.settle()
        same("as seen before", (np.array_equal(labels(), tried), last()), (True, name))
        same("nothing is held", (live.tried, live.held), (None, False))
        size = int(np.count_nonzero(labels() != before))
        assert size > 20, size
        yield from undone_and_redone(hand, name, state)
        yield from hand.undo()
        same("undone", (np.array_equal(labels(), before), len(steps())), (True, count))
    yield from hand.move(*place(hand, 0.0, 0.0))
    hand.event("LEFTMOUSE", "PRESS")
    yield 0.1
    yield from hand.move(*place(hand, 0.5, 0.0))
    yield 0.5
    yield from hand.key("ESC")
    hand.event("LEFTMOUSE", "RELEASE")
    yield 0.3
    dropped = np.array_equal(labels(), before), len(steps()), live.tried, live.held
    same("Esc drops it", dropped, (True, count, None, False))
    yield from pressed(hand, 0.0, 0.0)
    same("a click grows by a ring", (last(), steps()[-1].rings), ("GrowRegion", 1))
    yield from hand.undo()
    yield from pressed(hand, 0.0, 0.0, ctrl=True)
    same("a ctrl-click shrinks by one", (last(), steps()[-1].rings), ("ShrinkRegion", 1))
    yield from hand.undo()
    same("undone", (np.array_equal(labels(), before), len(steps())), (True, count))


def run(hand):
    yield from begin(hand)
    yield from split_and_cut(hand)
    yield from by_the_wheel(hand)
    yield from by_a_drag(hand, "object")
    yield from hand.into_view()
    yield from hand.key("TAB")
    yield 0.5
    yield from by_a_drag(hand, "edit_mesh")
