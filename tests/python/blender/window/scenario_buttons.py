"""The buttons under Regions, pressed in the sidebar in Edit Mode; undo and redo of each."""

import bmesh
import bpy
from scenario_main import make_scan, regions, same, scan, show_edits
from scenario_tools import labels, last, locked, state, undone_and_redone

import isimp


def select(faces):
    edit = bmesh.from_edit_mesh(scan().data)
    edit.faces.ensure_lookup_table()
    for face in edit.faces:
        face.select_set(False)
    for face in faces:
        edit.faces[int(face)].select_set(True)
    bmesh.update_edit_mesh(scan().data)
    bpy.ops.ed.undo_push(message="select")


def beside():
    """A face, and one in another region that shares an edge with it."""
    import scans

    pairs, label = scans.face_pairs(scan().data), labels()
    return next(pair for pair in pairs.tolist() if label[pair[0]] != label[pair[1]])


def pressed(hand, name, wanted, kind, before=0):
    """Presses a button; checks the change of the number of regions, the kind of the step, undo and redo."""
    yield from hand.press(name)
    same(name, (regions() - before, last()), (wanted, kind))
    yield from undone_and_redone(hand, name, state)
    yield from hand.undo()


def twins(hand, name, lesser):
    """Two adjacent buttons of one operator: moves to the one with the given flag."""
    yield from hand.find(f"bpy.ops.{name}")
    side = hand.region("UI")
    yield from hand.move(side.x + (side.width - 20) * (0.75 if lesser else 0.3), hand.at[1])
    same("beside", hand.under_mouse(), f"bpy.ops.{name}")
    yield from hand.click(*hand.at)
    yield from hand.settle()


def at_selected_faces(hand):
    count = regions()
    face, other = beside()
    select([face])
    yield from pressed(hand, "isimp.add_proxy", 1, "AddProxy", count)
    yield from pressed(hand, "isimp.delete_proxy", -1, "DeleteProxy", count)
    yield from pressed(hand, "isimp.split", 1, "SplitRegion", count)
    for name, lesser, kind in (("isimp.grow", False, "GrowRegion"), ("isimp.grow", True, "ShrinkRegion")):
        yield from twins(hand, name, lesser)
        same(kind, last(), kind)
        yield from undone_and_redone(hand, kind, state)
        yield from hand.undo()
    select([face, other])
    yield from pressed(hand, "isimp.merge", -1, "MergeRegions", count)


def locks(hand):
    face, _ = beside()
    select([face])
    yield from twins(hand, "isimp.lock", False)
    same("Lock", (last(), locked()), ("LockRegions", 1))
    yield from undone_and_redone(hand, "locked", locked)
    yield from hand.shot("buttons-1-locked")
    yield from twins(hand, "isimp.lock", True)
    same("Unlock", (last(), locked()), ("UnlockRegions", 0))
    yield from undone_and_redone(hand, "unlocked", locked)
    yield from hand.press("isimp.leave_out")
    same("Leave Out", (last(), left_out()), ("LeaveOutRegions", 1))
    yield from undone_and_redone(hand, "left out", left_out)
    yield from hand.shot("buttons-1-left-out")
    yield from hand.undo()


def left_out():
    from isimp.blender.scene import store

    return store.numbers(scan()).get("regions_left_out", 0)


def run(hand):
    show_edits()
    isimp.register()
    make_scan()
    yield 0.5
    yield from hand.open_tab()
    bpy.context.window_manager.isimp.partition.count_by = "proxies"
    bpy.context.window_manager.isimp.partition.proxies = 14
    yield from hand.press("isimp.partition")
    same("regions", regions(), 14)
    yield from hand.into_view()
    yield from hand.key("TAB")
    yield from hand.key("THREE")
    yield 0.3
    yield from at_selected_faces(hand)
    yield from locks(hand)
