"""Openings that the regions can't show are closed by Partition and reported, and Mesh agrees."""

import bpy
import numpy as np
import pytest
import scans

from isimp.blender.scene import store
from isimp.blender.texts import text


def pierced():
    """A rough sphere with four small holes."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=5, radius=2)
    scan = bpy.context.object
    scan.name = "Scan"
    points = scans.coordinates(scan.data)
    points += np.random.default_rng(1).normal(0, 0.01, points.shape)
    scan.data.vertices.foreach_set("co", points.astype(np.float32).ravel())
    scans.mode("EDIT")
    centers = np.array([polygon.center for polygon in scan.data.polygons])
    places = 2 * np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, 0, 1]])
    near = np.linalg.norm(centers[:, None] - places, axis=2).min(axis=1) < 0.1
    scans.select_faces(scan, *np.flatnonzero(near))
    bpy.ops.mesh.delete(type="FACE")
    scans.mode("OBJECT")
    return scan


def test_small_holes_are_closed_and_large_ones_would_stay():
    scan = pierced()
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
    scan = pierced()
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
    scan = pierced()
    with pytest.raises(RuntimeError, match="Partition"):
        bpy.ops.isimp.keep_opening(place=(2, 0, 0))
    assert bpy.ops.isimp.partition(proxies=8, close_openings=False) == {"FINISHED"}
    with pytest.raises(RuntimeError, match="Close Openings"):
        bpy.ops.isimp.keep_opening(place=(2, 0, 0))
    assert not text.has_openings(store.numbers(scan))
