"""In Edit Mode only what has changed is written, and nothing of it is missed."""

import bmesh
import bpy
import numpy as np
import pytest
import scans

from isimp.blender import mesh_io

pytestmark = pytest.mark.usefixtures("scene")


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


def written(scan, monkeypatch, do):
    """How many faces were written, and what is seen afterwards; None for all."""
    counts, write = [], mesh_io._write_edit_layers

    def noting(mesh, region, color, state, changed):
        counts.append(None if changed is None else int(changed.sum()))
        write(mesh, region, color, state, changed)

    monkeypatch.setattr(mesh_io, "_write_edit_layers", noting)
    do()
    return counts[-1], seen(scan)


def test_an_edit_writes_the_neighbourhood_and_gives_what_object_mode_gives(scan, monkeypatch):
    count, made = written(scan, monkeypatch, lambda: bpy.ops.isimp.add_proxy(face=20))
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
    count, made = written(scan, monkeypatch, lambda: bpy.ops.isimp.partition(proxies=8))
    assert count is None
    assert len(set(made[0])) == 8
