"""In Edit Mode only changed values are written, and all of them."""

import bmesh
import bpy
import numpy as np
import pytest
import scans

from isimp.blender import reading
from isimp.blender.scene import mesh_io, store
from isimp.blender.work import modal, scene_outcome
from isimp.recipe import AddProxy


def seen(scan):
    """(regions, colours) of the edit mesh, each corner alike."""
    edit = bmesh.from_edit_mesh(scan.data)
    region, color = edit.faces.layers.int["isimp_region"], edit.loops.layers.float_color["isimp_color"]
    assert all(len({tuple(corner[color]) for corner in face.loops}) == 1 for face in edit.faces)
    return [face[region] for face in edit.faces], [tuple(face.loops[0][color]) for face in edit.faces]


@pytest.fixture
def scan():
    scan = scans.dimple(scans.cube(cells=6))
    scans.mode("EDIT")
    bpy.ops.isimp.partition(proxies=10)
    return scan


def written(monkeypatch, do):
    """The number of faces that were written."""
    faces, paint = [], mesh_io._paint

    def noting(face, *values):
        faces.append(face)
        paint(face, *values)

    monkeypatch.setattr(mesh_io, "_paint", noting)
    do()
    return len(faces)


def test_an_edit_writes_the_neighbourhood_and_equals_object_mode(scan, monkeypatch):
    count, made = written(monkeypatch, lambda: bpy.ops.isimp.add_proxy(face=20)), seen(scan)
    assert 0 < count < len(scan.data.polygons) / 2
    scans.mode("OBJECT")
    assert made[0] == scans.regions(scan).tolist()
    other = scans.dimple(scans.cube("Other", cells=6))
    bpy.ops.isimp.partition(proxies=10)
    bpy.ops.isimp.add_proxy(face=20)
    assert made[0] == scans.regions(other).tolist()
    assert np.allclose(made[1], scans.colors(other))


def test_faces_in_another_order_are_all_written(scan, monkeypatch):
    edit = bmesh.from_edit_mesh(scan.data)
    edit.faces.sort(key=lambda face: -face.index)
    edit.faces.index_update()
    bmesh.update_edit_mesh(scan.data)
    assert written(monkeypatch, lambda: bpy.ops.isimp.partition(proxies=8)) == len(scan.data.polygons)
    assert len(set(seen(scan)[0])) == 8


def test_what_was_written_in_pieces_is_not_written_again(scan, monkeypatch):
    """As in a window, which must not wait for all of it at once."""
    monkeypatch.setattr(mesh_io, "_PIECE", 50)
    recipe = store.load(scan).then(AddProxy(face=20))
    work = modal.Work(bpy.context, scan, recipe)
    outcome, before, shares = work.run(), seen(scan), []

    def in_pieces():
        shares.extend(scene_outcome.writing(scan, work, outcome))

    count = written(monkeypatch, in_pieces)
    made = seen(scan)
    assert 0 < count < len(scan.data.polygons) / 2
    assert (len(shares), shares[-1]) == (-(-len(scan.data.polygons) // 50), 1.0)
    assert made[0] == outcome.face_region.tolist() != before[0]
    assert work.target() == scan, "its own state is no change from elsewhere"
    assert written(monkeypatch, lambda: scene_outcome.show_outcome(bpy.context, scan, work, outcome)) == 0
    assert (seen(scan), store.load(scan)) == (made, recipe)


def test_writing_in_pieces_is_nothing_in_object_mode(scan):
    scans.mode("OBJECT")
    work = modal.Work(bpy.context, scan, store.load(scan).then(AddProxy(face=20)))
    assert list(scene_outcome.writing(scan, work, work.run())) == []
    assert len(set(scans.regions(scan).tolist())) == 10


def test_what_was_read_stands_in_edit_mode_until_faces_come(scan):
    known = reading.Known(scan, mesh_io.read(bpy.context, scan))
    assert known.stands(scan)
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide()
    assert not known.stands(scan)


@pytest.mark.parametrize("place", [0.0, float("nan")])
def test_what_was_read_fits_until_a_vertex_moves(scan, place):
    scans.mode("OBJECT")
    scan.data.vertices[0].co.x += place
    known, again = (reading.Known(scan, mesh_io.read(bpy.context, scan)) for _ in range(2))
    again.take_over(known.scan)
    assert known.fits(scan)
    assert again.scan is known.scan
    scan.data.vertices[1].co.x += 1
    assert not known.fits(scan)
