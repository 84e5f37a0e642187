"""The main job with the real buttons, in both modes: Partition, a live setting, Regions, Mesh; undo and redo."""

import bmesh
import bpy
import scans
from actions import labels, last, locked, make_scan, regions, same, scan, settings, settled, show_edits, shown, steps

import isimp
from isimp.blender.scene import store


def drag_field(hand, name, pixels):
    """Drags over a number field as its user does; returns the numbers of regions that were visible meanwhile."""
    yield from hand.find(name)
    x, y = hand.at
    hand.event("LEFTMOUSE", "PRESS")
    yield
    seen = set()
    for step in range(1, 25):
        hand.at = (x + pixels * step / 24, y)
        hand.event("MOUSEMOVE", "NOTHING")
        yield 0.06
        seen.add(shown())
    hand.event("LEFTMOUSE", "RELEASE")
    yield from settled()
    return seen


def setting(hand):
    """The number of regions, typed and dragged: shown at once, and written as one step to undo."""
    yield from hand.type_into("partition.proxies", "30")
    yield from settled()
    same("typed", regions(), 30)
    yield from hand.undo()
    same("one step to undo", (regions(), settings().partition.proxies), (14, 14))
    yield from hand.redo()
    same("redone", (regions(), settings().partition.proxies), (30, 30))
    yield from hand.undo()

    seen = yield from drag_field(hand, "partition.proxies", 60)
    values = [regions()]
    print("seen while dragged:", sorted(seen), flush=True)
    assert len(seen) > 2, "nothing was shown while dragged"
    same("dragged", (settings().partition.proxies, values[0] > 14), (values[0], True))
    while values[-1] != 14:  # one step to undo, and one more for each place where a slow machine made the mouse rest
        assert len(values) < 8, values
        yield from hand.undo()
        values.append(settings().partition.proxies)
        same("undone", regions(), values[-1])

    for face in (100, 5000):
        bpy.ops.isimp.add_proxy("EXEC_DEFAULT", True, face=face)
    yield from hand.type_into("partition.proxies", "20")
    yield from settled()
    same("edits are done again", (regions(), len(steps())), (22, 3))
    for _ in range(3):
        yield from hand.undo()
    same("and undone", (regions(), len(steps())), (14, 1))


def select(faces):
    edit = bmesh.from_edit_mesh(scan().data)
    edit.faces.ensure_lookup_table()
    for face in edit.faces:
        face.select_set(face.index in faces)
    bmesh.update_edit_mesh(scan().data)
    bpy.ops.ed.undo_push(message="select")


def left_out():
    return store.numbers(scan()).get("regions_left_out", 0)


def pressed(hand, name, seen, wanted, lesser=None):
    """Presses a button, of two next to each other the lesser one or not; checks the step, and undoes it."""
    yield from hand.find(f"bpy.ops.isimp.{name}")
    if lesser is not None:
        side = hand.region("UI")
        yield from hand.move(side.x + (side.width - 20) * (0.75 if lesser else 0.3), hand.at[1])
        same("beside", hand.under_mouse(), f"bpy.ops.isimp.{name}")
    yield from hand.click(*hand.at)
    yield from hand.settle()
    same(name, (seen(), last()), wanted)
    if name != "lock":
        yield from hand.undo()


def buttons(hand):
    """The buttons under Regions act on the selection."""
    pairs, label, count = scans.face_pairs(scan().data), labels(), regions()
    face, other = next(pair for pair in pairs.tolist() if label[pair[0]] != label[pair[1]])
    select({face})
    yield from pressed(hand, "split", regions, (count + 1, "SplitRegion"))
    yield from pressed(hand, "grow", regions, (count, "GrowRegion"), lesser=False)
    yield from pressed(hand, "grow", regions, (count, "ShrinkRegion"), lesser=True)
    yield from pressed(hand, "lock", locked, (1, "LockRegions"), lesser=False)
    yield from pressed(hand, "lock", locked, (0, "UnlockRegions"), lesser=True)
    yield from pressed(hand, "leave_out", left_out, (1, "LeaveOutRegions"))
    select({face, other})
    yield from pressed(hand, "merge", regions, (count - 1, "MergeRegions"))


def run(hand):
    show_edits()
    isimp.register()
    make_scan()
    yield 0.5
    yield from hand.open_tab()
    yield from hand.shot("1-start")

    settings().partition.count_by = "proxies"
    yield from hand.type_into("partition.proxies", "14")
    same("typed", (settings().partition.proxies, regions()), (14, 0))
    yield from hand.find("bpy.ops.isimp.partition")
    place = hand.at
    yield from hand.press("isimp.partition")
    same("regions", regions(), 14)
    yield from hand.move(*place)
    same("the button stays under the mouse", hand.under_mouse(), "bpy.ops.isimp.partition")
    same("shading", hand.area.spaces.active.shading.color_type, "VERTEX")
    yield from hand.shot("2-partition")
    yield from setting(hand)

    yield from hand.into_view()
    yield from hand.key("TAB")
    yield from hand.key("THREE")
    yield 0.3
    same("mode", scan().mode, "EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    yield from hand.into_view()
    yield from hand.click(*hand.at)
    same("selected", scan().data.total_face_sel, 1)
    yield from hand.press("isimp.add_proxy")
    same("regions after Add", regions(), 15)
    yield from hand.shot("3-add")
    yield from hand.press("isimp.delete_proxy")
    same("regions after Delete", regions(), 14)
    for wanted in (15, 14):
        yield from hand.undo()
        same("after undo", regions(), wanted)
    for wanted in (15, 14):
        yield from hand.redo()
        same("after redo", regions(), wanted)
    yield from hand.undo()
    yield from buttons(hand)

    yield from hand.into_view()
    yield from hand.key("TAB")
    yield 0.3
    same("mode", scan().mode, "OBJECT")
    same("regions in Object Mode", regions(), 15)
    yield from hand.press("isimp.mesh")
    same("and so does this one", hand.under_mouse(), "bpy.ops.isimp.mesh")
    with hand.within():
        same("no tool on the result", bpy.ops.isimp.point("INVOKE_DEFAULT"), {"CANCELLED"})
        same("nor the other", bpy.ops.isimp.paint("INVOKE_DEFAULT"), {"CANCELLED"})
    result = bpy.context.object
    same("result", result.name, "Scan.simplified")
    same("scan hidden", scan().hide_get(), True)
    assert 15 <= len(result.data.polygons) <= 25, len(result.data.polygons)
    assert not result.data.validate()
    same("shading", hand.area.spaces.active.shading.color_type, "MATERIAL")
    yield from hand.shot("4-mesh")

    yield from hand.undo()
    same("after undo", (bpy.context.object.name, scan().hide_get(), regions()), ("Scan", False, 15))
    same("shading", hand.area.spaces.active.shading.color_type, "VERTEX")
    yield from hand.redo()
    same("after redo", (bpy.context.object.name, scan().hide_get()), ("Scan.simplified", True))
    yield from hand.press("isimp.swap")
    same("swapped", (bpy.context.object.name, scan().hide_get()), ("Scan", False))
    yield from hand.shot("5-swap")
