"""Use of the result: defective polygons selected, regions selected, modelling as with any other mesh."""

import bmesh
import bpy
import numpy as np
import pytest
import scans

from isimp import applying, session


def simplify(proxies=6):
    bpy.ops.isimp.partition(proxies=proxies)
    bpy.ops.isimp.mesh()
    return bpy.context.object


def selected(obj):
    obj.update_from_editmode()
    flags = np.empty(len(obj.data.polygons), bool)
    obj.data.polygons.foreach_get("select", flags)
    return np.flatnonzero(flags).tolist()


def flatness(obj, face):
    """The largest distance of a polygon's corner from its mean plane."""
    points = scans.coordinates(obj.data)[list(obj.data.polygons[face].vertices)]
    return np.linalg.svd(points - points.mean(axis=0))[1][2]


def test_problem_polygons_are_shown(monkeypatch):
    monkeypatch.setattr(applying, "defects", lambda report: {"bent": [1, 4], "crossing": [4]})
    scans.cube(cells=3)  # no other test has this one: outcomes are kept
    result = simplify()
    bpy.ops.isimp.swap()
    bpy.ops.isimp.show_problems()
    assert (bpy.context.object, result.mode, selected(result)) == (result, "EDIT", [1, 4])
    assert tuple(bpy.context.scene.tool_settings.mesh_select_mode) == (False, False, True)


def test_no_problem_polygons_is_said_too():
    scans.cube(cells=4)
    result = simplify()
    bpy.ops.isimp.show_problems()
    assert (result.mode, selected(result)) == ("OBJECT", [])


def test_defects_are_sorted_by_kind_and_excused_ones_are_not_counted():
    entries = [("bent", 3), ("bent", 1), ("intersecting", 2), ("intersecting", 2), ("excused", 9)]
    report = {"imperfect": [{"flaw": kind, "polygon": polygon} for kind, polygon in entries]}
    assert session.defects(report) == {"bent": [1, 3], "intersecting": [2]}


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_the_faces_of_a_region_are_selected(mode):
    scan = scans.cube(cells=4)
    bpy.ops.isimp.partition(proxies=6)
    region = scans.regions(scan)
    scans.mode(mode)
    bpy.ops.isimp.select_region(face=40)
    first = np.flatnonzero(region == region[40]).tolist()
    assert selected(scan) == first
    bpy.ops.isimp.select_region(face=150, extend=True)
    assert selected(scan) == sorted(first + np.flatnonzero(region == region[150]).tolist())
    scans.select_faces(scan, 3)
    bpy.ops.isimp.select_region()
    assert selected(scan) == np.flatnonzero(region == region[3]).tolist()


def test_selecting_a_region_without_a_face_has_a_remedy():
    scan = scans.cube(cells=4)
    bpy.ops.isimp.partition(proxies=6)
    scans.select_faces(scan)
    with pytest.raises(RuntimeError, match="select one in Edit Mode"):
        bpy.ops.isimp.select_region()


def edit(result, face):
    scans.mode("EDIT")
    bpy.context.scene.tool_settings.mesh_select_mode = (False, False, True)
    scans.select_faces(result, face)


def closed(obj):
    made = bmesh.new()
    made.from_mesh(obj.data)
    sound = all(len(edge.link_faces) == 2 for edge in made.edges)
    made.free()
    return sound


@pytest.fixture
def sculpture():
    """The result of a rounded cube: polygons with many corners."""
    scans.dimple(scans.cube(cells=8))
    result = simplify(14)
    assert max(len(face.vertices) for face in result.data.polygons) > 4
    return result


def test_a_face_extruded_stays_flat_and_the_mesh_closed(sculpture):
    face = max(sculpture.data.polygons, key=lambda face: face.area).index
    before, normal = flatness(sculpture, face), sculpture.data.polygons[face].normal.copy()
    corners, count = len(sculpture.data.polygons[face].vertices), len(sculpture.data.polygons)
    edit(sculpture, face)
    bpy.ops.mesh.extrude_region_shrink_fatten(TRANSFORM_OT_shrink_fatten={"value": 0.5})
    scans.mode("OBJECT")
    assert len(sculpture.data.polygons) == count + corners
    assert closed(sculpture)
    pushed = next(face.index for face in sculpture.data.polygons if face.select)
    assert flatness(sculpture, pushed) == pytest.approx(before, abs=1e-4)
    assert sculpture.data.polygons[pushed].normal.dot(normal) == pytest.approx(1, abs=1e-4)


def test_a_face_pushed_along_its_normal_stays_flat(sculpture):
    for face in range(len(sculpture.data.polygons)):
        before, normal = flatness(sculpture, face), sculpture.data.polygons[face].normal.copy()
        for vertex in sculpture.data.polygons[face].vertices:
            sculpture.data.vertices[vertex].co += 0.1 * normal
        assert flatness(sculpture, face) == pytest.approx(before, abs=1e-5)


@pytest.mark.parametrize(
    "change",
    [
        lambda: bpy.ops.mesh.bevel(offset=0.02),
        lambda: bpy.ops.mesh.subdivide(number_cuts=2),
        lambda: bpy.ops.mesh.inset(thickness=0.05),
        lambda: bpy.ops.mesh.poke(),
        lambda: bpy.ops.mesh.quads_convert_to_tris(),
    ],
    ids=["bevel", "subdivide", "inset", "poke", "triangulate"],
)
def test_modelling_continues(sculpture, change):
    corners = len(sculpture.data.loops)
    edit(sculpture, max(sculpture.data.polygons, key=lambda face: face.area).index)
    assert change() == {"FINISHED"}
    scans.mode("OBJECT")
    assert len(sculpture.data.loops) > corners
    assert scans.regions(sculpture).min() >= 0
    assert closed(sculpture)
    assert not sculpture.data.validate()


def test_two_polygons_dissolve_into_one(sculpture):
    count = len(sculpture.data.polygons)
    edge = sculpture.data.edges[0].key
    pair = [face.index for face in sculpture.data.polygons if edge in face.edge_keys]
    scans.mode("EDIT")
    bpy.context.scene.tool_settings.mesh_select_mode = (False, False, True)
    scans.select_faces(sculpture, *pair)
    bpy.ops.mesh.dissolve_faces()
    scans.mode("OBJECT")
    assert len(sculpture.data.polygons) == count - 1
    assert closed(sculpture)
    assert not sculpture.data.validate()
