"""Vertex groups and armatures on the result."""

import bpy
import numpy as np
import pytest
import scans
from mathutils import Matrix

from isimp.engine import engine


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


@pytest.mark.parametrize("place", [0.0, float("nan")])
def test_mesh_again_keeps_one_armature(place):
    figure()[0].data.vertices[0].co.x += place
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
    reach = engine.MeshingOptions().reach * np.linalg.norm(np.ptp(bent, axis=0))
    for corner in points(result):
        assert np.linalg.norm(bent - corner, axis=1).min() < 1.001 * reach


def key_of(obj, name, move, value=0.0):
    """A shape key that moves each vertex by `move(coordinates)`."""
    if obj.data.shape_keys is None:
        obj.shape_key_add(name="Basis", from_mix=False)
    key = obj.shape_key_add(name=name, from_mix=False)
    for point in key.data:
        point.co = np.array(point.co) + move(np.array(point.co))
    key.value = value
    return key


def keys_of(obj):
    return obj.data.shape_keys.key_blocks


def test_a_shape_key_moves_the_result_as_the_scan():
    scan = scans.cube()
    key_of(scan, "wide", lambda p: [p[0], 0, 0.25 * p[1]])
    result = simplify()
    assert [key.name for key in keys_of(result)] == ["Basis", "wide"]
    before = points(result)
    assert np.abs(np.abs(before) - 1).max() < 1e-5
    keys_of(result)["wide"].value = 1
    bpy.context.view_layer.update()
    expected = before + np.stack([before[:, 0], 0 * before[:, 0], 0.25 * before[:, 1]], axis=1)
    assert np.abs(points(result) - expected).max() < 1e-5


def test_keys_that_are_on_are_not_added_twice():
    scan = scans.cube()
    scan.scale = (2, 1, 1)  # visible lengths differ from the mesh's
    key_of(scan, "wide", lambda p: [p[0], 0, 0], 0.5)
    group = scan.vertex_groups.new(name="upper")
    group.add([v.index for v in scan.data.vertices if v.co.z > 0], 1.0, "REPLACE")
    key_of(scan, "up", lambda p: [0, 0, 1], 1.0).vertex_group = "upper"
    bpy.context.view_layer.update()
    seen = points(scan)
    result = simplify()
    assert [round(key.value, 6) for key in keys_of(result)][1:] == [0.5, 1.0]
    for corner in points(result):
        assert np.abs(seen - corner).sum(axis=1).min() < 1e-4
    for obj in (scan, result):
        for key in keys_of(obj)[1:]:
            key.value = 0
    bpy.context.view_layer.update()
    assert np.abs(np.abs(points(result)) - 1).max() < 1e-4


def test_mesh_again_keeps_how_far_keys_of_the_result_are_on():
    scan = scans.cube()
    key_of(scan, "wide", lambda p: [p[0], 0, 0], 1.0)
    result = simplify()
    keys_of(scan)["wide"].value = 0
    assert bpy.ops.isimp.mesh() == {"FINISHED"}
    assert keys_of(result)["wide"].value == 0, "that of the scan, where it was not moved on the result"
    keys_of(result)["wide"].value = 0.75
    assert bpy.ops.isimp.mesh(chord_tolerance=0.1) == {"FINISHED"}
    assert bpy.context.object == result
    assert [key.name for key in keys_of(result)] == ["Basis", "wide"]
    assert keys_of(result)["wide"].value == 0.75
    keys_of(result)["wide"].data[0].co.x += 0.5
    assert bpy.ops.isimp.mesh(chord_tolerance=0.05) == {"FINISHED"}
    assert bpy.context.object != result, "an edited key makes the result an edited one, which is kept"


def test_a_posed_figure_gets_no_shape_keys():
    scan, rig = figure()
    key_of(scan, "wide", lambda p: [p[0], 0, 0])
    bend(rig)
    assert simplify().data.shape_keys is None


def colors_of(mesh, name):
    layer = mesh.color_attributes[name]
    values = np.empty(4 * len(layer.data), np.float32)
    layer.data.foreach_get("color", values)
    return values.reshape(-1, 4)


@pytest.mark.parametrize("quads", [False, True])
@pytest.mark.parametrize("kind", ["FLOAT_COLOR", "BYTE_COLOR"])
def test_colours_of_vertices_and_of_corners_are_carried(quads, kind):
    scan = scans.cube(quads=quads)
    mesh = scan.data
    place = scans.coordinates(mesh)
    smooth = mesh.color_attributes.new(name="smooth", type=kind, domain="POINT")
    smooth.data.foreach_set("color", np.c_[place / 2 + 0.5, np.ones(len(place))].astype(np.float32).ravel())
    sides = mesh.color_attributes.new(name="sides", type=kind, domain="CORNER")
    normals = np.array([mesh.polygons[i].normal for i in np.repeat(np.arange(len(mesh.polygons)), 4 if quads else 3)])
    sides.data.foreach_set("color", np.c_[normals / 2 + 0.5, np.ones(len(normals))].astype(np.float32).ravel())
    result = simplify()
    made = result.data
    assert [(c.name, c.data_type, c.domain) for c in made.color_attributes] == [
        ("smooth", kind, "POINT"),
        ("sides", kind, "CORNER"),
    ]
    close = 0.01 if kind == "BYTE_COLOR" else 1e-5
    assert np.abs(colors_of(made, "smooth")[:, :3] - (scans.coordinates(made) / 2 + 0.5)).max() < close
    of_corner = np.array([p.normal for p in made.polygons for _ in p.loop_indices])
    assert np.abs(colors_of(made, "sides")[:, :3] - (of_corner / 2 + 0.5)).max() < close
    assert bpy.ops.isimp.mesh(chord_tolerance=0.1) == {"FINISHED"}
    assert bpy.context.object == result
    assert len(made.color_attributes) == 2


def test_painted_colours_of_a_result_are_kept():
    scan = scans.cube()
    scan.data.color_attributes.new(name="paint", type="FLOAT_COLOR", domain="CORNER")
    result = simplify()
    result.data.color_attributes["paint"].data[0].color = (1, 0, 0, 1)
    assert bpy.ops.isimp.mesh(chord_tolerance=0.1) == {"FINISHED"}
    assert bpy.context.object != result
    assert colors_of(result.data, "paint")[0].tolist() == [1, 0, 0, 1]


def test_further_uv_maps_are_carried():
    scan = scans.cube()
    place = scans.coordinates(scan.data)
    ends = np.array([loop.vertex_index for loop in scan.data.loops])
    scan.data.uv_layers.new(name="Texture")
    detail = scan.data.uv_layers.new(name="Detail")
    detail.data.foreach_set("uv", (place[ends] @ [[1, 2], [3, 4], [5, 6]]).astype(np.float32).ravel())
    result = simplify()
    assert [layer.name for layer in result.data.uv_layers] == ["Detail"]
    values = np.empty(2 * len(result.data.loops), np.float32)
    result.data.uv_layers["Detail"].data.foreach_get("uv", values)
    at = scans.coordinates(result.data)[[loop.vertex_index for loop in result.data.loops]]
    assert np.abs(values.reshape(-1, 2) - at @ [[1, 2], [3, 4], [5, 6]]).max() < 1e-4
