"""Vertex groups and armatures on the result."""

import bpy
import numpy as np
import pytest
import scans
from mathutils import Matrix

pytestmark = pytest.mark.usefixtures("scene")


def figure():
    """A tall box whose upper half an armature's second bone bends, and the armature, at rest."""
    scan = scans.cube()
    for vertex in scan.data.vertices:
        vertex.co = [vertex.co[0], vertex.co[1], 4 * vertex.co[2]]
    z = np.array([vertex.co.z for vertex in scan.data.vertices])
    middle, height = z.mean(), np.ptp(z)
    bpy.ops.object.armature_add()
    rig = bpy.context.object
    bpy.ops.object.mode_set(mode="EDIT")
    lower, upper = rig.data.edit_bones[0], rig.data.edit_bones.new("upper")
    lower.name = "lower"
    lower.head, lower.tail = (0, 0, middle - height / 2), (0, 0, middle)
    upper.head, upper.tail = (0, 0, middle), (0, 0, middle + height / 2)
    bpy.ops.object.mode_set(mode="OBJECT")
    for name, weight in (("lower", z <= middle), ("upper", z > middle)):
        group = scan.vertex_groups.new(name=name)
        group.add(np.flatnonzero(weight).tolist(), 0.75, "REPLACE")
    scan.vertex_groups.new(name="empty")
    scan.modifiers.new("Rig", "ARMATURE").object = rig
    scans.activate(scan)
    return scan, rig


def bend(rig):
    rig.pose.bones["upper"].matrix_basis = Matrix.Rotation(np.pi / 2, 4, "X")
    bpy.context.view_layer.update()


def points(obj):
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return np.array([vertex.co[:] for vertex in evaluated.data.vertices])


def simplify():
    assert bpy.ops.isimp.partition(proxies=6) == {"FINISHED"}
    assert bpy.ops.isimp.mesh() == {"FINISHED"}
    return bpy.context.object


def weights(obj, index):
    return {obj.vertex_groups[g.group].name: round(g.weight, 6) for g in obj.data.vertices[index].groups}


def test_a_rigged_figure_bends_as_its_scan_does():
    scan, rig = figure()
    before = points(scan)
    result = simplify()
    assert [group.name for group in result.vertex_groups] == ["lower", "upper", "empty"]
    corners = points(result)
    same = np.array([np.abs(before - corner).sum(axis=1).argmin() for corner in corners])
    assert np.abs(before[same] - corners).max() < 1e-5
    for own, of in enumerate(same.tolist()):
        assert weights(result, own) == weights(scan, of) != {}
    bend(rig)
    assert np.abs(points(scan) - before).max() > 0.5
    assert np.abs(points(result) - points(scan)[same]).max() < 1e-5


def test_mesh_again_keeps_one_armature():
    figure()
    result = simplify()
    assert bpy.ops.isimp.mesh(chord_tolerance=0.1) == {"FINISHED"}
    assert bpy.context.object == result
    assert [modifier.type for modifier in result.modifiers] == ["ARMATURE"]
    assert len(result.vertex_groups) == 3


def test_a_posed_figure_is_not_bent_twice():
    scan, rig = figure()
    bend(rig)
    bent = points(scan)
    result = simplify()
    assert len(result.modifiers) == 0
    assert [group.name for group in result.vertex_groups] == ["lower", "upper", "empty"]
    for corner in points(result):
        assert np.abs(bent - corner).sum(axis=1).min() < 0.2
