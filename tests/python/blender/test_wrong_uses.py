"""Wrong uses as a table: each gives one plain line with the fault and the remedy, and changes nothing."""

import json
import re

import bpy
import pytest
import scans

from isimp.blender.scene import mesh_io, runtime, store

OPS = bpy.ops.isimp
#: Words of programs and of the papers, which no line to a user has
JARGON = re.compile(r"proxy|proxies|Traceback|Error in|NoneType|invalid input|\bgot -?\d|\[\d+, \d+\]|-> 1 regions")


def parted():
    scan = scans.dimple(scans.cube(cells=5))
    assert OPS.partition(proxies=8) == {"FINISHED"}
    return scan


def locked():
    scan = parted()
    OPS.lock(face=0)
    return scan


def meshed():
    scan = parted()
    OPS.mesh()
    return scan


def edited(make=parted):
    scan = make()
    scans.mode("EDIT")
    scans.select_faces(scan)
    return scan


def selected(*faces):
    scan = parted()
    scans.select_faces(scan, *faces)
    return scan


def unselected():
    return selected()


def sides(lean=0.0):
    scan = scans.cube()
    for vertex in scan.data.vertices:
        vertex.co.x += lean * vertex.co.z
    OPS.partition(proxies=6)
    return scan


def leaning():
    return sides(lean=0.1)


def recipe(**step):
    return json.dumps({"isimp_recipe": 1, "steps": [{"step": "partition"}, step]})


#: the state, the action, the message
USES = [
    ("too many regions", scans.cube, lambda: OPS.partition(proxies=10**6), "at most 432 regions are possible"),
    ("delete a locked region", locked, lambda: OPS.delete_proxy(face=0), "locked: press L over it, or Unlock"),
    ("add in a locked region", locked, lambda: OPS.add_proxy(face=0), "locked: press L over it, or Unlock"),
    ("split a locked region", locked, lambda: OPS.split(face=0), "locked: press L over it, or Unlock"),
    ("grow a locked region", locked, lambda: OPS.grow(face=0), "locked: press L over it, or Unlock"),
    ("shrink a locked region", locked, lambda: OPS.grow(face=0, shrink=True), "locked: press L over it, or Unlock"),
    ("merge with itself", parted, lambda: OPS.merge(face=0, other=0), "one region: there is nothing to merge"),
    ("merge far ones", parted, lambda: OPS.merge(face=12, other=62), "only neighbouring regions"),
    ("merge nothing", edited, lambda: OPS.merge(face=0), "Only one region is selected|No face is selected"),
    ("no such face", parted, lambda: OPS.add_proxy(face=10**6), "there is no face 1000000: the mesh has 300 faces"),
    ("no such face to delete", parted, lambda: OPS.delete_proxy(face=10**6), "there is no face 1000000"),
    ("no such face to select", parted, lambda: OPS.select_region(face=10**6), "No face is selected"),
    ("cut beside the region", parted, lambda: OPS.cut_region(face=0, line=(9, 9, 9, 9, 9, 8)), "does not cross"),
    ("cut by a point", parted, lambda: OPS.cut_region(face=0, line=(0, 0, 0, 0, 0, 0)), "line"),
    ("strokes that are none", parted, lambda: OPS.paint_faces(painted="x"), "not a list of strokes"),
    ("strokes far apart", parted, lambda: OPS.paint_faces(painted="-1:0,299"), "do not hang together"),
    ("paint a locked region", locked, lambda: OPS.paint_faces(painted="299:0"), "already, or locked|hang together"),
    ("too many deletions", parted, lambda: OPS.delete_least(times=99), "only \\d+ of 99 can be done"),
    ("too many merges", parted, lambda: OPS.merge_cheapest(times=99), "only \\d+ of 99 can be done"),
    ("weights that are not there", scans.cube, lambda: OPS.partition(weights="None"), "no vertex group.*'None'"),
    ("barriers not there", scans.cube, lambda: OPS.partition(borders="None"), "no face attribute 'None'"),
    ("part of nothing", edited, lambda: OPS.partition(part=True), "No face is selected"),
    ("a recipe that is none", scans.cube, lambda: OPS.replay(recipe="hello"), "recipe"),
    ("a recipe of the future", scans.cube, lambda: OPS.replay(recipe='{"isimp_recipe": 99, "steps": []}'), "version"),
    ("an unknown step", scans.cube, lambda: OPS.replay(recipe=recipe(step="fly")), "fly"),
    ("a wrong setting", scans.cube, lambda: OPS.replay(recipe=recipe(step="mesh", speed=3)), "speed"),
    ("a recipe's face", scans.cube, lambda: strict(recipe(step="add_proxy", face=999)), "there is no face 999"),
    ("a recipe of no file", scans.cube, lambda: OPS.recipe_import(filepath="//none.json"), "can't be read"),
    ("no name of a file", parted, lambda: OPS.recipe_export(), "No file is named"),
    ("no such folder", parted, lambda: OPS.recipe_export(filepath="/no/such/folder/a.json"), "can't be written"),
    ("no such step", parted, lambda: OPS.step_delete(step=7), "There is no step 8: the recipe has 1"),
    ("the first step further up", parted, lambda: OPS.step_move(step=0), "first already"),
    ("the last step further down", parted, lambda: OPS.step_move(step=0, later=True), "last already"),
    ("nothing is selected", unselected, lambda: OPS.add_proxy(), "No face is selected"),
    ("all faces are selected", lambda: selected(*range(300)), lambda: OPS.add_proxy(), "each would become a region"),
    ("merge one selected region", lambda: selected(0, 1), lambda: OPS.merge(), "Only one region is chosen"),
    ("select in a flattened scan", lambda: flattened(parted), lambda: OPS.select_by(), "scaled to nothing"),
    ("a scan scaled to nothing", lambda: flattened(), lambda: OPS.partition(proxies=6), "scaled to nothing"),
    ("one plane parallel", parted, lambda: OPS.align(face=0, to="parallel"), "one region.*select faces of two or more"),
    ("a wall level", sides, lambda: OPS.align(face=0, to="level"), "is at right angles to the plane that it should"),
    ("a plane too far", leaning, lambda: OPS.align(face=0, to="upright", length=0.001), "needs .* cm, allowed 1 mm"),
    ("no such face to align", parted, lambda: OPS.align(face=99_999), "There is no face 99999"),
    ("nothing to align", unselected, lambda: OPS.align(), "No face is selected"),
    ("a texture of none", meshed, lambda: OPS.texture(), "no UV map, so it has no texture"),
]
#: the state, the button, and its tooltip
BUTTONS = [
    ("edit before partition", scans.cube, "add_proxy", "no regions yet: press Partition first"),
    ("delete before partition", scans.cube, "delete_proxy", "no regions yet: press Partition first"),
    ("flatten before partition", scans.cube, "flatten", "no regions yet: press Partition first"),
    ("even out before partition", scans.cube, "even_borders", "no regions yet: press Partition first"),
    ("select before partition", scans.cube, "select_by", "no regions yet: press Partition first"),
    ("export before partition", scans.cube, "recipe_export", "no regions yet: press Partition first"),
    ("swap before mesh", parted, "swap", "no result yet: press Mesh first"),
    ("texture before mesh", parted, "texture", "no result yet: press Mesh first"),
    ("show defects before mesh", parted, "show_problems", "no result yet: press Mesh first"),
    ("swap in edit mode", lambda: edited(meshed), "swap", "Leave Edit Mode first"),
    ("nothing selected", edited, "add_proxy", "No face is selected: click one"),
    ("nothing selected to align", edited, "align", "No face is selected"),
    ("no object", lambda: thing(None, active=False), "partition", "No object is active"),
    ("an empty is active", lambda: thing(None), "partition", "'Thing' is an empty.*click the scan"),
    ("a curve is active", lambda: thing(bpy.data.curves.new("C", "CURVE")), "mesh", "'Thing' is a curve.*convert it"),
    ("sculpting", lambda: in_mode("SCULPT"), "partition", "Leave this mode first"),
    ("painting weights", lambda: in_mode("WEIGHT_PAINT"), "mesh", "Leave this mode first"),
    ("the camera is active", lambda: thing(bpy.data.cameras.new("C")), "partition", "'Thing' is a camera, not a mesh"),
    ("a text is active", lambda: thing(bpy.data.curves.new("T", "FONT")), "mesh", "is a text, not a mesh: convert it"),
    ("points only", lambda: scans.add("Cloud", [(0, 0, 0)], []), "partition", "points but no faces"),
    ("nothing at all", lambda: scans.add("Nothing", [], []), "partition", "is empty: import a scan first"),
    ("the scan was subdivided", lambda: subdivided(), "mesh", r"has changed since \(300 -> [\d,]+ faces\): press"),
]


def strict(text):
    return OPS.replay(recipe=text, strict=True)


def in_mode(name):
    scan = parted()
    scans.mode(name)
    return scan


def thing(data, active=True):
    made = bpy.data.objects.new("Thing", data)
    bpy.context.scene.collection.objects.link(made)
    bpy.context.view_layer.objects.active = made if active else None
    return made


def flattened(make=scans.cube):
    scan = make()
    scan.scale = (1, 1, 0)
    bpy.context.view_layer.update()
    return scan


def subdivided():
    scan = parted()
    scans.mode("EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide()
    scans.mode("OBJECT")
    return scan


def state(scan):
    found = [mesh_io.state_of(scan), store.load(scan)]
    if scan.mode == "OBJECT":
        found.append(scans.geometry(scan.data))
        if "isimp_region" in scan.data.attributes:
            found += [scans.regions(scan).tolist(), scans.colors(scan).tolist()]
    return found


def plain(line):
    assert "\n" not in line, line
    assert not JARGON.search(line), line
    assert len(line) < 200, line


def test_there_are_enough():
    assert len(USES) + len(BUTTONS) >= 50
    assert len({name for name, *_ in USES + BUTTONS}) == len(USES) + len(BUTTONS)


@pytest.mark.parametrize(("make", "use", "said"), [use[1:] for use in USES], ids=[use[0] for use in USES])
def test_a_wrong_use_gives_one_plain_line_and_changes_nothing(make, use, said):
    scan = make()
    before = state(scan)
    with pytest.raises(RuntimeError) as caught:
        use()
    lines = [line for line in str(caught.value).strip().splitlines() if line and not line.startswith("Location")]
    assert len(lines) == 1, lines
    line = lines[0].removeprefix("Error: ")
    assert re.search(said, line, re.IGNORECASE), line
    plain(line)
    assert before == state(scan)


@pytest.mark.parametrize(("make", "name", "said"), [use[1:] for use in BUTTONS], ids=[use[0] for use in BUTTONS])
def test_a_disabled_button_has_the_reason(make, name, said):
    make()
    assert not getattr(OPS, name).poll()
    with pytest.raises(RuntimeError) as caught:
        getattr(OPS, name)()
    told = str(caught.value).strip().splitlines()[0]
    assert re.search(said, told), told
    plain(told.partition(".poll() ")[2])


def test_an_internal_error_leaves_its_traceback_in_the_log(monkeypatch, caplog):
    scan = parted()
    before = state(scan)
    monkeypatch.setattr(runtime.get().session, "replay", lambda *_: {}["inside"])
    with pytest.raises(RuntimeError, match=r"Internal error in iSimp: KeyError: 'inside'\. Nothing was changed"):
        OPS.mesh()
    (record,) = caplog.records
    assert (record.levelname, record.exc_info[0]) == ("ERROR", KeyError)
    assert before == state(scan)
