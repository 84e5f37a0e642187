"""Openings that the regions can't show are closed by Partition and reported, and Mesh agrees."""

import bpy
import pytest
import scans

from isimp.blender.scene import store
from isimp.blender.texts import text


def test_small_holes_are_closed_and_large_ones_would_stay():
    scan = scans.pierced()
    assert bpy.ops.isimp.partition(proxies=8) == {"FINISHED"}
    numbers = store.numbers(scan)
    assert (numbers["border_loops"], numbers["repairs"]["filled_holes"]) == (4, 4)
    assert text.repair_lines(numbers, "METRIC", 1.0)[0].startswith("Closed: 4 holes")
    assert bpy.ops.isimp.mesh() == {"FINISHED"}
    assert store.numbers(scan)["closed"]
    assert bpy.ops.isimp.partition(proxies=8, close_openings=False) == {"FINISHED"}
    assert bpy.ops.isimp.mesh() == {"FINISHED"}
    assert not store.numbers(scan)["closed"]


def test_an_opening_that_was_clicked_stays_open_through_partition_undo_and_save(tmp_path):
    scan = scans.pierced()
    bpy.ops.ed.undo_push(message="Made")
    assert bpy.ops.isimp.partition(proxies=8) == {"FINISHED"}
    bpy.ops.ed.undo_push(message="Partition")
    place = (2.0, 0.0, 0.0)
    assert bpy.ops.isimp.keep_opening(place=place) == {"FINISHED"}
    bpy.ops.ed.undo_push(message="Keep")
    numbers = store.numbers(scan)
    assert (numbers["repairs"]["filled_holes"], numbers["kept_open"]) == (3, 1)
    assert text.repair_lines(numbers, "METRIC", 1.0)[1] == "Kept open: 1 opening"
    assert text.has_openings(numbers)
    assert bpy.ops.isimp.partition(proxies=7) == {"FINISHED"}
    assert store.numbers(scan)["kept_open"] == 1
    assert store.load(scan).whole()[1].keep_openings == (place,)
    assert bpy.ops.isimp.mesh() == {"FINISHED"}
    assert not store.numbers(scan)["closed"]
    bpy.context.view_layer.objects.active = scan
    assert bpy.ops.isimp.keep_opening(place=place, close=True) == {"FINISHED"}
    assert (store.numbers(scan)["repairs"]["filled_holes"], store.numbers(scan)["kept_open"]) == (4, 0)
    assert bpy.ops.isimp.keep_opening(place=place) == {"FINISHED"}
    path = str(tmp_path / "kept.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    scan = bpy.data.objects["Scan"]
    assert store.load(scan).whole()[1].keep_openings == (place,)
    assert bpy.ops.isimp.mesh() == {"FINISHED"}
    assert store.numbers(scan)["kept_open"] == 1


def test_nothing_is_kept_where_nothing_is_closed():
    scan = scans.pierced()
    with pytest.raises(RuntimeError, match="Partition"):
        bpy.ops.isimp.keep_opening(place=(2, 0, 0))
    assert bpy.ops.isimp.partition(proxies=8, close_openings=False) == {"FINISHED"}
    with pytest.raises(RuntimeError, match="Close Openings"):
        bpy.ops.isimp.keep_opening(place=(2, 0, 0))
    assert not text.has_openings(store.numbers(scan))
