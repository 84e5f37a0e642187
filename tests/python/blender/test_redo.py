"""The panel of the last operation (F9): a setting changed there has the same effect as at once, for every operator."""

import json

import bpy
import numpy as np
import pytest
import scans

from isimp import blender
from isimp.blender.operators.files import Writes
from isimp.blender.scene import store, targets
from isimp.blender.work.modal import RecipeOperator
from test_texture import textured_cube

RECIPES = [
    json.dumps({"isimp_recipe": 1, "steps": [{"step": "partition", "proxies": count, "count_by": "proxies"}]})
    for count in (6, 9)
]


def parted():
    """A cube in its six sides, 50 faces each."""
    scans.cube(cells=5)
    bpy.ops.isimp.partition(proxies=6)


def rounded():
    scans.dimple(scans.cube())
    bpy.ops.isimp.partition(proxies=10)


def stepped():
    parted()
    bpy.ops.isimp.grow(face=0)
    bpy.ops.isimp.paint_faces(painted="-1:60,61,62,63")


def opened():
    scans.pierced()
    bpy.ops.isimp.partition(proxies=8)


def slivered():
    parted()
    bpy.ops.isimp.paint_faces(painted="-1:0")
    bpy.ops.isimp.paint_faces(painted="-1:60,61,62,63,64,65,66,67")


def divided():
    scans.tube()
    bpy.ops.isimp.partition(proxies=1, snap=False)
    bpy.ops.isimp.mesh()


def meshed():
    parted()
    bpy.ops.isimp.mesh()


def textured():
    textured_cube()
    bpy.ops.isimp.partition(proxies=6)
    bpy.ops.isimp.mesh()


def columned():
    scan = scans.column()
    bpy.ops.isimp.partition(proxies=14)
    scans.select_faces(scan, *range(24 * 48))


def turned():
    scans.column()
    bpy.ops.isimp.partition(proxies=14, curved=True)


def furnished():
    scan = scans.cube(cells=6)
    scan.data.vertices.foreach_set("co", (np.array([3.0, 2.0, 1.0]) * scans.coordinates(scan.data)).ravel())
    bpy.ops.isimp.partition(proxies=12)


CUT = {"face": 0, "direction": (1, 0, 0)}
#: operator, the state before, its settings at first and then
CHANGES = [
    ("partition", scans.cube, {"proxies": 8, "count_by": "proxies"}, {"proxies": 12, "count_by": "proxies"}),
    ("keep_opening", opened, {"place": (2, 0, 0)}, {"place": (0, 2, 0)}),
    ("add_proxy", rounded, {"face": 0}, {"face": 300}),
    ("delete_proxy", parted, {"face": 0}, {"face": 120}),
    ("merge", parted, {"face": 0, "other": 120}, {"face": 0, "other": 220}),
    ("split", rounded, {"face": 0}, {"face": 300}),
    ("lock", parted, {"face": 0}, {"face": 120}),
    ("leave_out", parted, {"face": 0}, {"face": 120}),
    ("leave_out", parted, {"face": 0}, {"face": 0, "box": True}),
    ("grow", parted, {"face": 0, "rings": 1}, {"face": 0, "rings": 2}),
    ("grow", parted, {"face": 0}, {"face": 0, "shrink": True}),
    ("paint_faces", parted, {"painted": "-1:0,1,2,3"}, {"painted": "-1:0,1"}),
    ("paint_faces", parted, {"painted": "-1:0,1,2,3"}, {"painted": "-1:0,1,2,3", "lock": True}),
    ("move_border", parted, {"painted": "0:120,121"}, {"painted": "0:120,121,122,123"}),
    ("erase_faces", rounded, {"painted": "0:0,1"}, {"painted": "0:0,1,2,3"}),
    ("smooth_faces", rounded, {"painted": "-1:" + "0,1,2,3,4,5"}, {"painted": "-1:" + ",".join(map(str, range(400)))}),
    ("finer", rounded, {"face": 0}, {"face": 300}),
    ("cut_region", parted, CUT | {"line": (-1, -1, 0.1, -1, 1, 0.1)}, CUT | {"line": (-1, 0.1, -1, -1, 0.1, 1)}),
    ("make_round", columned, {"kind": "cylinder"}, {"kind": "revolution"}),
    ("round_segments", turned, {"face": 0, "segments": 8}, {"face": 0, "segments": 16}),
    ("explode_round", turned, {"face": 0}, {"face": 500}),
    ("add_worst", rounded, {"times": 1}, {"times": 3}),
    ("delete_least", rounded, {"times": 1}, {"times": 3}),
    ("merge_cheapest", rounded, {"times": 1}, {"times": 3}),
    ("even_borders", rounded, {"strength": 0.0}, {"strength": 1.0}),
    ("regularise", rounded, {"angle": 8.0}, {"angle": 2.0}),
    ("align", parted, {"face": 0, "to": "upright"}, {"face": 0, "to": "free"}),
    ("align", parted, {"face": 0, "to": "upright"}, {"face": 0, "to": "upright", "length": 0.5}),
    ("set_length", meshed, {"chosen": "0,50", "length": 3.0}, {"chosen": "0,50", "length": 5.0}),
    ("merge_slivers", slivered, {"share": 10.0}, {"share": 50.0}),
    ("merge_flat", rounded, {"angle": 0.001}, {"angle": 1.0}),
    ("colliders", meshed, {"names": "unreal"}, {"names": "godot"}),
    ("more_here", rounded, {"place": (1, 1, 1), "size": 1.0}, {"place": (1, 1, 1), "size": 4.0}),
    ("leave_out_furniture", furnished, {"smallest": 1.0}, {"smallest": 50.0}),
    ("make_lods", rounded, {"counts": (30, 12, 0)}, {"counts": (30, 12, 6)}),
    ("make_editable", rounded, {"chord_tolerance": 0.35}, {"chord_tolerance": 0.05}),
    ("mesh", rounded, {"chord_tolerance": 0.35}, {"chord_tolerance": 0.05}),
    ("texture", textured, {"size": 64}, {"size": 128}),
    ("flatten", rounded, {"chord_tolerance": 0.35}, {"chord_tolerance": 0.05}),
    ("show_problems", divided, {"kind": "DEFECTIVE"}, {"kind": "DIVIDED"}),
    ("step_switch", stepped, {"step": 1}, {"step": 2}),
    ("step_move", stepped, {"step": 1, "later": True}, {"step": 2, "later": False}),
    ("step_delete", stepped, {"step": 1}, {"step": 2}),
    ("replay", scans.cube, {"recipe": RECIPES[0]}, {"recipe": RECIPES[1]}),
    ("select_region", parted, {"face": 0}, {"face": 120}),
    ("select_region", turned, {"part": 0}, {"face": 0}),
    ("select_by", parted, {"by": "SIZE", "share": 100.0}, {"by": "DIRECTION"}),
    ("select_by", parted, {"by": "DIRECTION"}, {"by": "DIRECTION", "direction": (0.0, 1.0, 0.0)}),
]
SAME = {"step_move"}  # both settings change places of the same two steps
WITHOUT_SETTINGS = {"improve", "keep_lod"}
OF_FILES = {"import_scan"}  # test_imports.py


def operators():
    return [cls for cls in blender._CLASSES if issubclass(cls, bpy.types.Operator)]


def test_operators_that_change_the_scan_have_the_panel_of_the_last_operation():
    """F9 shows the settings of an operator with REGISTER, and needs UNDO to repeat it."""
    changing = [cls for cls in operators() if issubclass(cls, RecipeOperator) and not issubclass(cls, Writes)]
    changing = [cls for cls in changing if "INTERNAL" not in cls.bl_options]
    assert len(changing) >= 20
    assert [cls.bl_idname for cls in changing if set(cls.bl_options) != {"REGISTER", "UNDO"}] == []


def test_each_operator_with_settings_there_is_tried():
    with_panel = {cls for cls in operators() if {"REGISTER", "UNDO"} <= set(getattr(cls, "bl_options", ()))}
    names = {cls.bl_idname.removeprefix("isimp.") for cls in with_panel}
    assert names == {name for name, *_ in CHANGES} | WITHOUT_SETTINGS | OF_FILES
    for name in WITHOUT_SETTINGS:
        assert len(getattr(bpy.ops.isimp, name).get_rna_type().properties) == 1, "the type alone"


def seen():
    """All that an operator may have changed: steps, regions, locks, selection, the result, its image, new objects."""
    scan = bpy.data.objects["Scan"]
    found = [store.load(scan).steps, store.numbers(scan).get("locked"), bpy.context.mode]
    result = targets.result_of(bpy.context.scene, scan)
    for obj in (scan, result) if result is not None else (scan,):
        obj.update_from_editmode()
        chosen = np.empty(len(obj.data.polygons), bool)
        obj.data.polygons.foreach_get("select", chosen)
        found += [chosen.tolist(), scans.coordinates(obj.data).tolist()]
        found += [[list(polygon.vertices) for polygon in obj.data.polygons]]
    found += [scans.regions(scan).tolist(), tuple(scan.scale), len(bpy.context.object.data.polygons)]
    found.append(sorted(tuple(image.size) for image in bpy.data.images if image.users))
    found.append(sorted(obj.name for obj in bpy.data.objects))
    return found


@pytest.mark.parametrize(("name", "make", "first", "then"), CHANGES)
def test_a_setting_changed_after_the_operator_equals_setting_it_at_once(name, make, first, then):
    """The steps of F9: undo, then again with the other setting."""
    made, once = [], None
    for settings in ([first, then], [then]):
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        make()
        bpy.ops.ed.undo_push(message="before")
        for number, each in enumerate(settings):
            if number:
                once = seen()
                bpy.ops.ed.undo()
            assert getattr(bpy.ops.isimp, name)("EXEC_DEFAULT", True, **each) == {"FINISHED"}
        made.append(seen())
    assert made[0] == made[1]
    assert (once == made[0]) == (name in SAME), "the setting makes a difference"
