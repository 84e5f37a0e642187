"""Reading and writing in pieces: the actions of the window meanwhile, one step to undo, and drags that settle."""

import bpy
from actions import (
    labels,
    make_scan,
    regions,
    running,
    same,
    scan,
    settings,
    settled,
    shown,
    state,
    steps,
    undone_and_redone,
    view,
)

import isimp
from isimp.blender import reading
from isimp.blender.scene import mesh_io, runtime, selection, weights
from isimp.blender.work import modal


def slow_down():
    """Makes every piece take a turn of its own, as for a million faces."""
    modal._AT_ONCE, reading.SPAN, mesh_io._PIECE, selection._PIECE, weights._PIECE = 0.0, 0.0, 100, 100, 20


def weighed(hand):
    """A vertex group is read in pieces, in Object Mode; Esc drops that too."""
    upper = [vertex.index for vertex in scan().data.vertices if vertex.co.z > 0]
    scan().vertex_groups.new(name="Upper").add(upper, 1.0, "REPLACE")
    yield 0.3
    before, count = state(), len(steps())
    yield from pressed(hand, 40, weights="Upper", influence=2.0)
    same("read so far", len(runtime.get().groups), 1)
    same("not all", next(iter(runtime.get().groups.values())).values, None)
    yield from hand.into_view()
    yield from hand.key("ESC")
    yield from hand.settle()
    same("Esc", (state(), len(steps())), (before, count))
    yield from pressed(hand, 40, weights="Upper", influence=2.0)
    yield from hand.settle(120)
    same("weighed", (regions(), steps()[0].weights), (40, "Upper"))
    above = {label for label, polygon in zip(labels(), scan().data.polygons, strict=True) if polygon.center.z > 0}
    assert len(above) > 24, len(above)  # half of them without weights
    yield from hand.undo()
    same("undone", (state(), len(steps())), (before, count))
    yield from hand.redo()
    same("redone", (regions(), steps()[0].weights), (40, "Upper"))
    runtime.get().groups.clear()
    settings().partition.proxies = 44
    yield from settled()
    same("dragged", regions(), 44)


def selected_in_pieces(hand):
    """Faces are selected in pieces in Edit Mode: other actions wait; one step to undo."""
    same("in Edit Mode", scan().mode, "EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    bpy.ops.ed.undo_push(message="none")
    done = []
    with hand.within():
        done.append(bpy.ops.isimp.select_by("INVOKE_DEFAULT", True, by="SIZE", share=100.0))
    same("under way", done, [{"RUNNING_MODAL"}])
    yield from hand.into_view()
    yield from hand.key("X")  # would open a menu of things to delete
    faces = len(scan().data.polygons)
    for _ in range(300):
        if scan().data.total_face_sel == faces:
            break
        yield 0.05
    yield 0.3
    same("all are selected", (scan().data.total_face_sel, scan().mode), (faces, "EDIT"))
    yield from hand.undo()
    same("one step to undo", scan().data.total_face_sel, 0)
    yield from hand.redo()
    same("and to redo", scan().data.total_face_sel, faces)
    bpy.ops.mesh.select_all(action="DESELECT")
    bpy.ops.ed.undo_push(message="none")


def pressed(hand, proxies, **more):
    with hand.within():
        bpy.ops.isimp.partition("INVOKE_DEFAULT", True, proxies=proxies, **more)
    yield 0.3
    same("under way", running(), True)


def run(hand):
    isimp.register()
    make_scan(5)
    yield 0.5
    yield from hand.open_view()
    yield from view(hand)
    settings().outline = False
    yield from hand.into_view()
    yield from hand.key("TAB")
    yield 0.3
    slow_down()
    faces = len(scan().data.polygons)
    yield from pressed(hand, 14)
    yield from hand.into_view()
    yield from hand.key("ESC")
    yield from hand.key("X")  # would open a menu of things to delete
    yield from hand.key("TAB")
    same("nothing else is done meanwhile", (running(), scan().mode), (True, "EDIT"))
    yield from hand.shot("pieces-1-writing")
    yield from hand.settle(120)
    same("all is written", (regions(), scan().mode, len(scan().data.polygons)), (14, "EDIT", faces))
    yield from pressed(hand, 20)
    yield from hand.settle(120)
    same("once more", regions(), 20)
    yield from hand.undo()
    same("one step to undo", (regions(), settings().partition.proxies), (14, 14))
    yield from hand.redo()
    same("and to redo", (regions(), settings().partition.proxies), (20, 20))

    before = state()
    settings().partition.proxies = 30
    seen = set()
    for _ in range(600):
        seen.add(shown())
        if running():
            break
        yield 0.05
    same("drawn before it is written", 30 in seen, True)
    same("and while it is", (running(), shown()), (True, 30))
    yield from settled()
    yield from hand.settle(120)
    same("settled", (regions(), state() != before, len(steps())), (30, True, 1))
    yield from hand.undo()
    same("undone", (state() == before, settings().partition.proxies), (True, 20))
    yield from hand.redo()
    same("redone", (regions(), settings().partition.proxies), (30, 30))
    bpy.ops.isimp.add_proxy("INVOKE_DEFAULT", True, face=100)
    yield from hand.settle(120)
    same("added", regions(), 31)
    yield from undone_and_redone(hand, "added", state)
    yield from selected_in_pieces(hand)
    yield from hand.into_view()
    yield from hand.key("TAB")
    yield 0.3
    same("in Object Mode", (scan().mode, regions()), ("OBJECT", 31))
    yield from weighed(hand)
