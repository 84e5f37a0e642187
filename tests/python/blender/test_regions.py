"""Partition, Add Proxy and Delete Proxy on a scan."""

import bpy
import numpy as np
import pytest
import scans


def partition(**settings):
    assert bpy.ops.isimp.partition(**settings) == {"FINISHED"}


@pytest.mark.parametrize("quads", [False, True])
def test_partition_writes_regions_and_colours(quads):
    scan = scans.dimple(scans.cube(quads=quads))
    before = scans.geometry(scan.data)
    partition(proxies=12)
    assert scan.data.attributes["isimp_region"].data_type == "INT"
    assert scan.data.attributes["isimp_region"].domain == "FACE"
    assert np.unique(scans.regions(scan)).tolist() == list(range(12))
    assert scans.geometry(scan.data) == before
    assert scan.data.color_attributes.active_color.name == "isimp_color"


@pytest.mark.parametrize("quads", [False, True])
def test_neighbours_have_different_colours(quads):
    scan = scans.dimple(scans.cube(quads=quads, cells=8))
    partition(proxies=40)
    label, color, pairs = scans.regions(scan), scans.colors(scan), scans.face_pairs(scan.data)
    apart = label[pairs[:, 0]] != label[pairs[:, 1]]
    assert apart.any()
    assert (color[pairs[:, 0]] != color[pairs[:, 1]]).any(axis=1)[apart].all()
    for region in range(40):
        assert (color[label == region] == color[label == region][0]).all()


def test_a_new_region_leaves_the_colours_of_the_others():
    scan = scans.dimple(scans.cube(cells=8))
    partition(proxies=20)
    label, color = scans.regions(scan), scans.colors(scan)
    assert bpy.ops.isimp.add_proxy(face=5) == {"FINISHED"}
    kept = scans.regions(scan) == label
    assert kept.mean() > 0.5
    assert (scans.colors(scan)[kept] == color[kept]).all()


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_add_and_delete_at_the_selected_faces(mode):
    scan = scans.dimple(scans.cube(cells=8))
    partition(proxies=10)
    scans.mode(mode)
    scans.select_faces(scan, 3, 400)
    assert bpy.ops.isimp.add_proxy() == {"FINISHED"}
    label = scans.regions(scan)
    assert np.unique(label).tolist() == list(range(12))
    assert {label[3], label[400]} == {10, 11}
    scans.select_faces(scan, 3)
    assert bpy.ops.isimp.delete_proxy() == {"FINISHED"}
    assert np.unique(scans.regions(scan)).tolist() == list(range(11))
    assert scan.mode == mode


def test_several_faces_of_one_region_delete_it_once():
    scan = scans.dimple(scans.cube(cells=8))
    partition(proxies=10)
    label = scans.regions(scan)
    scans.select_faces(scan, *np.flatnonzero(label == label[0])[:3])
    assert bpy.ops.isimp.delete_proxy() == {"FINISHED"}
    assert len(np.unique(scans.regions(scan))) == 9


def test_the_users_own_colours_come_back():
    scan = scans.cube()
    scan.data.color_attributes.new("mine", "BYTE_COLOR", "POINT")
    scan.data.color_attributes.active_color = scan.data.color_attributes["mine"]
    partition(proxies=6)
    assert scan.data.color_attributes.active_color.name == "isimp_color"
    assert bpy.ops.isimp.mesh() == {"FINISHED"}
    assert scan.data.color_attributes.active_color.name == "mine"


def shading():
    areas = [area for window in bpy.context.window_manager.windows for area in window.screen.areas]
    return [area.spaces.active.shading for area in areas if area.type == "VIEW_3D"]


def test_viewports_show_colours_and_get_their_shading_back():
    scans.cube()
    assert shading()
    for view in shading():
        view.color_type = "SINGLE"
    partition(proxies=6)
    assert {view.color_type for view in shading()} == {"VERTEX"}
    bpy.ops.isimp.partition(proxies=7)
    bpy.ops.isimp.mesh()
    assert {view.color_type for view in shading()} == {"SINGLE"}


def test_show_regions_switches_colours_off_and_on():
    scans.cube()
    partition(proxies=6)
    bpy.ops.isimp.show_regions()
    assert {view.color_type for view in shading()} == {"MATERIAL"}
    bpy.ops.isimp.show_regions()
    assert {view.color_type for view in shading()} == {"VERTEX"}


def test_attributes_of_the_same_names_but_another_kind_are_replaced():
    scan = scans.cube()
    scan.data.attributes.new("isimp_region", "FLOAT", "POINT")
    scan.data.attributes.new("isimp_color", "BYTE_COLOR", "POINT")
    partition(proxies=6)
    assert np.unique(scans.regions(scan)).tolist() == list(range(6))
    assert len(scans.colors(scan)) == len(scan.data.polygons)
