"""The Paint tool with a real mouse and keys: each stroke is one step of the recipe and one to undo."""

import numpy as np
import scans
from actions import (
    begin,
    drag,
    labels,
    last,
    place,
    regions,
    same,
    scan,
    settings,
    state,
    steps,
    tool,
    undone_and_redone,
)


def border():
    """The number of edges of the scan between regions."""
    label = labels()
    pairs = scans.face_pairs(scan().data)
    return int(np.count_nonzero(label[pairs[:, 0]] != label[pairs[:, 1]]))


def strokes(hand):
    before = regions()
    yield from drag(hand, (-0.4, 0.0), (0.3, 0.1), ctrl=True, shot="paint-1-new")
    same("painted a new region", (regions(), last(), steps()[-1].lock), (before + 1, "PaintFaces", True))
    yield from undone_and_redone(hand, "a new region", state)
    first = set(steps()[-1].faces)
    yield from drag(hand, (-0.3, 0.0), (-0.3, 0.4))
    same("painted into it", (regions(), last(), steps()[-1].onto in first), (before + 1, "PaintFaces", True))
    yield from undone_and_redone(hand, "into it", state)
    yield from drag(hand, (-0.4, 0.0), (-0.2, 0.0), ctrl=True, shift=True)
    same("erased", (regions(), last()), (before + 1, "EraseFaces"))
    yield from undone_and_redone(hand, "erased", state)
    settings().lock_painted = False
    yield from drag(hand, (-0.5, -0.45), (0.2, -0.5), ctrl=True)
    same("another one, not locked", (regions(), steps()[-1].lock), (before + 2, False))
    settings().lock_painted, ragged, before = True, border(), state()
    yield from drag(hand, (-0.6, -0.45), (0.2, -0.62), shift=True, shot="paint-2-smooth")
    same("smoothed", (last(), state() != before, border() <= ragged), ("SmoothFaces", True, True))
    yield from undone_and_redone(hand, "smoothed", state)
    before, settings().stroke = regions(), "finer"
    yield from drag(hand, (-0.6, 0.6), (0.3, 0.6), shot="paint-3-finer")
    settings().stroke = "paint"
    same("finer", (regions() > before, last()), (True, "SplitRegion"))
    split = len(steps())
    yield from hand.undo()
    same("finer, undone", (regions(), len(steps()) < split), (before, True))


def mirrored(hand):
    yield from hand.into_view()
    yield from hand.key("X")
    same("X mirrors", settings().mirror, "X")
    before = regions()
    yield from drag(hand, (0.3, -0.4), (0.4, -0.4), ctrl=True)
    same("painted on both sides", [type(step).__name__ for step in steps()[-2:]], ["PaintFaces", "PaintFaces"])
    same("two regions", regions(), before + 2)
    left, right = (set(step.faces) for step in steps()[-2:])
    assert 0.5 < len(left) / len(right) < 2, (len(left), len(right))
    yield from hand.undo()
    same("one step to undo for both", regions(), before)
    yield from hand.redo()
    same("and to redo", regions(), before + 2)
    yield from hand.into_view()
    yield from hand.key("X")
    same("X again", settings().mirror, "NONE")


def half_in_vain(hand):
    """One side is painted although the other has nothing to paint; a stroke that paints nothing is no step."""
    start, settings().lock_painted = state(), False
    yield from drag(hand, (0.5, 0.0), (0.5, 0.25), ctrl=True)
    settings().mirror, before, ours = "X", steps(), set(steps()[-1].faces)
    yield from drag(hand, (0.5, 0.05), (0.5, 0.15))  # the other side is of one region
    same("nothing to paint on either side", steps(), before)
    yield from drag(hand, (0.5, 0.1), (0.25, 0.1))
    same("one side painted", [type(step).__name__ for step in steps()[len(before) :]], ["PaintFaces"])
    same("into the region", steps()[-1].onto in ours, True)
    yield from undone_and_redone(hand, "one side", state)
    settings().mirror, settings().lock_painted = "NONE", True
    yield from hand.undo()
    yield from hand.undo()
    same("as before", state(), start)


def radius(hand):
    count = len(steps())
    yield from hand.into_view()
    x, y = hand.at
    yield from hand.key("F")
    yield from hand.move(x + 30, y)
    yield from hand.shot("paint-3-radius")
    yield from hand.key("ESC")
    same("Esc: as before", settings().brush, 25)
    yield from hand.move(x, y)
    yield from hand.key("F")
    yield from hand.move(x + 30, y)
    yield from hand.click(x + 30, y)
    same("F and a click", (settings().brush, len(steps())), (55, count))


def dropped(hand):
    before = state()
    yield from hand.move(*place(hand, 0.5, 0.5))
    hand.event("LEFTMOUSE", "PRESS")
    yield 0.1
    yield from hand.move(*place(hand, 0.0, 0.5))
    yield from hand.key("ESC")
    hand.event("LEFTMOUSE", "RELEASE")
    yield 0.3
    same("Esc drops a stroke", state(), before)


def run(hand):
    yield from begin(hand)
    yield from tool(hand, "isimp.paint_tool.object")
    settings().brush = 25
    yield from half_in_vain(hand)
    yield from strokes(hand)
    yield from mirrored(hand)
    yield from dropped(hand)
    yield from radius(hand)
    settings().brush, settings().stroke = 25, "new"  # set in the tool's settings, without a key
    yield from hand.into_view()
    yield from hand.key("TAB")
    yield 0.5
    yield from tool(hand, "isimp.paint_tool.edit_mesh")
    before = regions()
    yield from drag(hand, (0.5, 0.4), (0.5, 0.7))
    same("a new region in Edit Mode", (scan().mode, regions()), ("EDIT", before + 1))
    yield from undone_and_redone(hand, "in Edit Mode", state)
    yield from hand.shot("paint-4-edit")
