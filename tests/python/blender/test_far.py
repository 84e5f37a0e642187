"""Scans whose data lie far from zero, as in map coordinates: results lose nothing, and earlier losses are reported."""

from math import radians

import bpy
import numpy as np
import pytest
import scans
from mathutils import Matrix

from isimp.blender.scene import mesh_io, store
from isimp.blender.texts import text
from isimp.session import engine

FAR = np.array([2.0**20, -(2.0**20), 0.0])  # float32 has every eighth of a unit there


def far_cube(shift=FAR, cells=8):
    """A cube of 64 units whose corners are whole numbers, moved in its data."""
    scan = scans.cube(cells=cells)
    move(scan, 32 * scans.coordinates(scan.data) + shift)
    bpy.context.view_layer.update()
    return scan


def move(scan, points):
    scan.data.vertices.foreach_set("co", points.astype(np.float32).ravel())
    scan.data.update()
    assert (scans.coordinates(scan.data) == points).all()


def simplify():
    assert bpy.ops.isimp.partition(proxies=6) == {"FINISHED"}
    assert bpy.ops.isimp.mesh() == {"FINISHED"}
    bpy.context.view_layer.update()
    return bpy.context.object


def origin_of(scan):
    """The offset that the engine subtracts, for a scan whose transform keeps its shape."""
    data = scan.data
    data.calc_loop_triangles()
    return engine.clean(scans.coordinates(data), [face.vertices[:] for face in data.loop_triangles]).origin


def box(points):
    return [*points.min(axis=0), *points.max(axis=0)]


def test_the_shift_is_the_results_place_and_nothing_is_lost():
    scan = far_cube()
    before, seen = scans.geometry(scan.data), scans.world(scan)
    result = simplify()
    origin = origin_of(scan)
    assert origin[0] > 1e6 > 0 == origin[2]
    assert result.matrix_world == scan.matrix_world @ Matrix.Translation(origin)
    assert len(result.data.vertices) == 8
    assert box(scans.world(result)) == pytest.approx(box(seen), abs=1e-4, rel=0)
    assert np.abs(scans.coordinates(result.data)).max() < 100
    assert scans.geometry(scan.data) == before


def test_a_scan_near_zero_has_its_result_in_its_own_space():
    scan = far_cube(shift=np.array([64.0, 0, 0]))
    scan.location = (2.0**20, 0, 0)  # its place does not matter
    bpy.context.view_layer.update()
    result = simplify()
    assert result.matrix_world == scan.matrix_world
    assert box(scans.coordinates(result.data)) == pytest.approx([32, -32, -32, 96, 32, 32], abs=1e-4)


def exact_place(obj):
    return np.array(obj.matrix_world, np.float64)


@pytest.mark.parametrize("scale", [(1, 1, 1), (0.01, 0.01, 0.01), (2, -0.5, 3)])
@pytest.mark.parametrize("parented", [False, True])
def test_a_scan_that_is_turned_scaled_and_parented(scale, parented):
    """Blender rounds the place in the world to float32: the vertices make up for it."""
    scan = far_cube()
    scan.location, scan.scale = (10, -20, 30), scale
    scan.rotation_euler = (radians(30), radians(20), radians(50))
    if parented:
        scans.hang(scan, location=(7, 8, 9), rotation_euler=(0, 0, 1))
    bpy.context.view_layer.update()
    seen, place = scans.world(scan), exact_place(scan)
    result = simplify()
    mapped = np.linalg.inv(place) @ exact_place(result)
    assert mapped[:3, :3] == pytest.approx(np.eye(3), abs=1e-5)
    assert mapped[:2, 3] == pytest.approx(FAR[:2], abs=100)
    assert np.abs(scans.coordinates(result.data)).max() < 200
    size = np.linalg.norm(np.ptp(seen, axis=0))
    assert box(scans.world(result)) == pytest.approx(box(seen), abs=3e-6 * size, rel=0)


def test_a_sheared_scan_has_its_result_in_the_worlds_axes():
    scan = far_cube()
    scans.hang(scan, scale=(1, 3, 1))
    scan.rotation_euler = (0, 0, 0.7)
    bpy.context.view_layer.update()
    seen = scans.world(scan)
    result = simplify()
    assert exact_place(result)[:3, :3].tolist() == np.eye(3).tolist()
    assert box(scans.world(result)) == pytest.approx(box(seen), abs=1e-3, rel=0)
    assert np.abs(scans.coordinates(result.data)).max() < 300


def test_mesh_again_follows_when_the_scan_has_moved():
    scan = far_cube()
    points = scans.coordinates(scan.data) - FAR
    result = simplify()
    first = result.matrix_world.copy()
    for shift in (2 * FAR, np.zeros(3), FAR):
        scan.hide_set(False)
        scans.activate(scan)
        move(scan, points + shift)
        bpy.context.view_layer.update()
        assert simplify() == result
        assert box(scans.world(result)) == pytest.approx(box(scans.world(scan)), abs=1e-4, rel=0)
        assert result.matrix_world == scan.matrix_world @ Matrix.Translation(origin_of(scan))
    assert result.matrix_world == first
    assert len(bpy.data.objects) == 2


def test_undo_takes_place_and_vertices_back_together():
    scan = far_cube()
    scans.push("cube")
    bpy.ops.isimp.partition("EXEC_DEFAULT", True, proxies=6)
    bpy.ops.isimp.mesh("EXEC_DEFAULT", True)
    name = scan.name

    def seen():
        bpy.context.view_layer.update()
        result = bpy.data.objects["Scan.simplified"]
        return box(scans.world(result)), result.matrix_world.translation[:]

    first, points = seen(), scans.coordinates(scan.data) - FAR
    scan.hide_set(False)
    scans.activate(scan)
    move(scan, points + 2 * FAR)
    scans.push("moved")
    bpy.ops.isimp.partition("EXEC_DEFAULT", True, proxies=6)
    bpy.ops.isimp.mesh("EXEC_DEFAULT", True)
    second = seen()
    assert second[0] == pytest.approx(box(scans.world(bpy.data.objects[name])), abs=1e-4, rel=0)
    assert second[1] != first[1]
    for _ in range(3):
        bpy.ops.ed.undo()
    assert seen() == first
    for _ in range(3):
        bpy.ops.ed.redo()
    assert seen() == second


def test_partition_reports_lost_detail_once(capfd):
    scan = far_cube()
    lines = text.lost_detail(scan, bpy.context.scene.unit_settings)
    assert len(lines) == 1
    assert "Blender's coordinates have steps of 0.12 m" in lines[0]
    said = []
    for proxies in (6, 8):
        capfd.readouterr()
        assert bpy.ops.isimp.partition(proxies=proxies) == {"FINISHED"}
        said.append(capfd.readouterr().out)
    assert lines[0] in said[0]
    assert "Blender's coordinates have steps" not in said[1]
    assert store.numbers(scan)["regions"] == 8


def test_of_a_scan_near_zero_nothing_is_said(capfd):
    scan = scans.cube()
    scan.location = (5e5, 4.6e6, 0)
    bpy.context.view_layer.update()
    assert mesh_io.lost_detail(scan) is None
    assert bpy.ops.isimp.partition(proxies=6) == {"FINISHED"}
    assert "Blender's coordinates have steps" not in capfd.readouterr().out
