"""Weights that their user painted, from vertex groups and attributes."""

import bpy
import numpy as np
import pytest
import scans

from isimp.blender.scene import store
from isimp.blender.work import panel_changes


@pytest.fixture
def scan():
    """A rounded cube with the upper half painted, in each way."""
    obj = scans.dimple(scans.cube(cells=8))
    points = scans.coordinates(obj.data)
    upper = np.flatnonzero(points[:, 2] > 0.01)
    obj.vertex_groups.new(name="Other").add(range(9), 0.5, "REPLACE")
    obj.vertex_groups.new(name="Group").add(upper.tolist(), 1.0, "REPLACE")
    point = obj.data.attributes.new("Point", "FLOAT", "POINT")
    point.data.foreach_set("value", (points[:, 2] > 0.01).astype(np.float32))
    face = obj.data.attributes.new("Face", "INT", "FACE")
    face.data.foreach_set("value", above(obj).astype(np.int32))
    return obj


def above(obj):
    return np.array([polygon.center.z > 0 for polygon in obj.data.polygons])


def regions_above(obj):
    return len(set(scans.regions(obj)[above(obj)].tolist()))


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
@pytest.mark.parametrize("name", ["Group", "Point", "Face"])
def test_more_regions_where_it_was_painted(scan, name, mode):
    bpy.ops.isimp.partition(proxies=60)
    even = regions_above(scan)
    scans.mode(mode)
    bpy.ops.isimp.partition(proxies=60, weights=name, influence=2.0)
    scans.mode("OBJECT")
    assert regions_above(scan) > 1.2 * even
    assert store.numbers(scan)["regions"] == 60
    assert store.load(scan).steps[0].weights == name


def test_what_is_offered(scan):
    from isimp.blender.scene import weights

    bpy.ops.isimp.partition(proxies=9)
    assert weights.names(scan)[:4] == ["Other", "Group", "Point", "Face"]
    assert not {"isimp_region", "isimp_color"} & set(weights.names(scan))


def test_a_scan_without_weights_ignores_those_of_another(scan):
    panel = bpy.context.window_manager.isimp.partition
    panel.weights = scan.vertex_groups[0].name
    panel_changes.follow(bpy.context)
    assert panel.weights == scan.vertex_groups[0].name
    scans.cube("Other")
    panel_changes.follow(bpy.context)
    assert panel.weights == ""
