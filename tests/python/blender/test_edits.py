"""Edits at faces and by error, in both modes, undone and redone; each is one step of the recipe."""

import dataclasses

import bpy
import numpy as np
import pytest
import scans

from isimp import recipe as rcp
from isimp.blender.controls import settings
from isimp.blender.scene import pointed, store


def scan():
    return bpy.data.objects["Scan"]


def count():
    return len(set(scans.regions(scan()).tolist()))


def steps():
    return store.load(scan()).steps


@pytest.fixture(params=["OBJECT", "EDIT"])
def parted(request):
    """A cube in its six sides, 50 faces each, in both modes; regions are found by a face: face // 50 is the side."""
    scans.cube(cells=5)
    bpy.ops.isimp.partition(proxies=6)
    assert len({tuple(scans.regions(scan())[50 * side : 50 * side + 50]) for side in range(6)}) == 6
    scans.mode(request.param)
    scans.push("mode")
    return scan()


def undone_and_redone(before, after):
    bpy.ops.ed.undo()
    assert (scans.regions(scan()).tolist(), len(steps())) == (before, 1)
    bpy.ops.ed.redo()
    assert (scans.regions(scan()).tolist(), len(steps())) == (after, 2)


@pytest.mark.parametrize(
    ("call", "settings", "wanted"),
    [
        ("add_proxy", {"face": 70}, 7),
        ("delete_proxy", {"face": 0}, 5),
        ("merge", {"face": 0, "other": 120}, 5),
        ("split", {"face": 0}, 7),
        ("grow", {"face": 0, "rings": 2}, 6),
        ("grow", {"face": 0, "shrink": True}, 6),
        ("paint_faces", {"painted": "-1:0,1,2,3"}, 7),
        ("paint_faces", {"painted": "0:100,101,102,103"}, 6),
        ("cut_region", {"face": 0, "line": (-1, -1, 0.1, -1, 1, 0.1), "direction": (1, 0, 0)}, 7),
        ("add_worst", {"times": 2}, 8),
        ("delete_least", {"times": 1}, 5),
        ("merge_cheapest", {"times": 2}, 4),
        ("improve", {}, 6),
        ("regularise", {}, 6),
        ("align", {"face": 0, "to": "upright"}, 6),
    ],
)
def test_each_edit_is_a_step_to_undo(parted, call, settings, wanted):
    before = scans.regions(scan()).tolist()
    getattr(bpy.ops.isimp, call)("EXEC_DEFAULT", True, **settings)
    assert count() == wanted
    assert len(steps()) == 2
    undone_and_redone(before, scans.regions(scan()).tolist())
    assert steps()[1].kind in rcp.KINDS.values()


def test_edits_act_on_the_selection(parted):
    scans.select_faces(scan(), 3, 7, 120)
    bpy.ops.isimp.merge()
    assert (count(), len(steps())) == (5, 2)
    scans.select_faces(scan(), 160, 210)
    bpy.ops.isimp.split()
    assert (count(), len(steps())) == (7, 4)
    scans.select_faces(scan(), 250, 251, 252, 253)
    bpy.ops.isimp.paint_faces()
    assert steps()[-1] == rcp.PaintFaces(faces=(250, 251, 252, 253))
    label = scans.regions(scan())
    assert len(set(label[250:254])) == 1
    assert np.count_nonzero(label == label[250]) == 4


def test_all_faces_selected_as_importers_leave_them_are_no_edit_of_each_region():
    obj = scans.dimple(scans.cube())
    bpy.ops.isimp.partition(proxies=24)
    before = count()
    scans.select_faces(obj, *range(len(obj.data.polygons)))
    for name in ("split", "add_proxy", "delete_proxy", "grow", "merge", "paint_faces", "lock"):
        with pytest.raises(RuntimeError, match=r"All 432 faces are selected: select a few|at most 100"):
            getattr(bpy.ops.isimp, name)()
    assert (count(), len(steps())) == (before, 1)
    bpy.ops.isimp.lock(face=0)
    assert bpy.ops.isimp.lock(unlock=True) == {"FINISHED"}, "all regions can be meant"


def test_a_refusal_names_the_region_where_several_are_selected(parted):
    label = scans.regions(scan())
    bpy.ops.isimp.lock(face=120)
    scans.select_faces(scan(), 3, 120)
    with pytest.raises(RuntimeError, match=f"Region {label[120]}: [Tt]his region is locked"):
        bpy.ops.isimp.split()
    with pytest.raises(RuntimeError, match=r"^Error: This region is locked"):
        bpy.ops.isimp.split(face=120)


def test_a_locked_region_stays(parted):
    side = scans.regions(scan()) == scans.regions(scan())[0]
    bpy.ops.isimp.lock(face=0)
    assert store.numbers(scan())["locked"] == 1
    bpy.ops.isimp.grow(face=120, rings=3)
    after = scans.regions(scan())
    assert ((after == after[0]) == side).all()
    with pytest.raises(RuntimeError, match="lock"):
        bpy.ops.isimp.split(face=0)
    bpy.ops.isimp.lock(face=0, unlock=True)
    assert store.numbers(scan())["locked"] == 0
    bpy.ops.isimp.split(face=0)
    assert count() == 7


def test_a_region_is_left_out_and_restored(parted):
    bpy.ops.isimp.leave_out(face=0)
    assert store.numbers(scan())["regions_left_out"] == 1
    assert store.numbers(scan())["locked"] == 0
    bpy.ops.isimp.mesh()
    assert len(bpy.context.object.data.polygons) == 5
    bpy.ops.isimp.leave_out(face=0, box=True)
    bpy.ops.isimp.mesh()
    assert len(bpy.context.object.data.polygons) == 5 + 6
    bpy.ops.isimp.partition(proxies=7)
    assert (count(), store.numbers(scan())["regions_left_out"]) == (8, 1), "a number does not count it"
    bpy.ops.isimp.lock(face=0, unlock=True)
    assert "regions_left_out" not in store.numbers(scan())


def test_clutter_is_selected_where_polygons_show_it(parted):
    with pytest.raises(RuntimeError, match="press Mesh first"):
        bpy.ops.isimp.select_by(by="CLUTTER")
    bpy.ops.isimp.mesh()
    bpy.context.view_layer.objects.active = scan()
    bpy.ops.isimp.select_by(by="CLUTTER")
    assert not any(polygon.select for polygon in scan().data.polygons), "a cube has no clutter"


def test_a_painted_step_can_be_changed_afterwards(parted):
    bpy.ops.isimp.paint_faces(painted="-1:0,1,2,3")
    bpy.ops.isimp.partition(proxies=6)
    recipe = rcp.Recipe((rcp.Partition(proxies=6), rcp.PaintFaces(faces=(0, 1, 2, 3)), rcp.SplitRegion(face=60)))
    bpy.ops.isimp.replay(recipe=recipe.to_json())
    assert count() == 8
    bpy.ops.isimp.step_switch(step=1)
    assert count() == 7


def test_all_borders_are_evened_out_in_one_step_that_undo_takes_back():
    scan = scans.dimple(scans.cube(cells=12))
    bpy.ops.isimp.partition(proxies=8)
    middles = {p.index: p.center for p in scan.data.polygons if p.normal[2] > 0.8}
    half = [face for face, at in middles.items() if at.x < (-0.2 if int(6 * at.y + 60) % 2 else 0.2)]  # with teeth
    bpy.ops.isimp.paint_faces(painted="-1:" + ",".join(map(str, half)))
    scans.push("before")
    before, pairs = scans.regions(scan), scans.face_pairs(scan.data)
    assert bpy.ops.isimp.even_borders() == {"FINISHED"}
    scans.push("even")
    after = scans.regions(scan)
    assert [step.kind for step in store.load(scan).steps][-2:] == ["paint", "even_borders"]
    lengths = [int((label[pairs[:, 0]] != label[pairs[:, 1]]).sum()) for label in (before, after)]
    assert lengths[1] < lengths[0]
    assert len(set(before)) == len(set(after))
    bpy.ops.ed.undo()
    scan = bpy.data.objects["Scan"]
    assert (scans.regions(scan) == before).all()
    assert [step.kind for step in store.load(scan).steps][-1] == "paint"


def test_edits_at_several_faces_given_by_number(parted):
    bpy.ops.isimp.lock(chosen="7,120")
    assert steps()[-1].faces == (7, 120)
    with pytest.raises(RuntimeError, match="'1;2' is not a list of faces"):
        bpy.ops.isimp.lock(chosen="1;2")


def test_the_region_clicked_last_leads(parted):
    bpy.ops.isimp.align(to="parallel", length=10.0, chosen="0,60")
    assert steps()[-1].faces == (60, 0)


def test_regions_are_chosen_one_by_one(parted):
    pointed.note(parted, 0)
    for face in (120, 290):
        pointed.collect(parted, face)
    assert pointed.faces(parted) == (0, 120, 290)
    pointed.collect(parted, 131)  # a face of a chosen region
    assert (pointed.faces(parted), pointed.face(parted)) == ((0, 290), 290)
    pointed.note(parted, -1)
    assert (pointed.faces(parted), pointed.region(parted)) == ((), -1)


def test_edits_on_other_regions_after_another_number_are_counted_and_outlined():
    scan = scans.dimple(scans.cube(cells=12))
    bpy.ops.isimp.partition(proxies=60)
    bpy.ops.isimp.add_proxy(face=3)
    assert not bpy.ops.isimp.choose_moved.poll()
    settings.group(bpy.context, rcp.Partition).proxies = 6
    step = dataclasses.replace(store.load(scan).steps[0], proxies=6)
    fewer = store.load(scan).replaced(0, step)
    assert bpy.ops.isimp.replay(recipe=fewer.to_json()) == {"FINISHED"}
    assert store.numbers(scan)["moved"] == [3]
    assert bpy.ops.isimp.choose_moved() == {"FINISHED"}
    assert pointed.faces(scan) == (3,)


def test_a_part_has_more_regions_until_it_is_removed():
    scan = scans.dimple(scans.cube(cells=12))
    bpy.ops.isimp.partition(proxies=40)
    label = scans.regions(scan)
    at = scans.coordinates(scan.data)[list(scan.data.polygons[0].vertices)].mean(axis=0)
    assert bpy.ops.isimp.more_here(place=at) == {"FINISHED"}
    (part,) = store.load(scan).steps[0].more
    assert part == (*(pytest.approx(x) for x in at), 1.0)
    assert store.numbers(scan)["regions"] == 40
    assert (scans.regions(scan) != label).any()
    bpy.ops.isimp.partition(proxies=30)
    assert len(store.load(scan).steps[0].more) == 1, "it belongs to the scan"
    bpy.ops.isimp.more_here(place=(9, 9, 9), size=0)
    assert store.load(scan).steps[0].more == ()
