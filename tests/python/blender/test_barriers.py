"""Marks of Blender on a mesh: regions that keep to seams, sharp edges, materials and face sets."""

import bpy
import numpy as np
import pytest
import scans

from isimp.blender.scene import weights
from isimp.recipe import Mesh, PaintFaces, Partition, Recipe


@pytest.fixture
def scan():
    """A cube whose middle, all around, is marked in each way."""
    obj = scans.cube(cells=4)
    mesh, points = obj.data, scans.coordinates(obj.data)
    for edge in mesh.edges:
        edge.use_seam = edge.use_edge_sharp = bool((np.abs(points[list(edge.vertices), 2]) < 1e-6).all())
    mesh.polygons.foreach_set("material_index", above(obj).astype(np.int32))
    if bpy.app.version >= (3, 6):
        mesh.attributes.new(".sculpt_face_set", "INT", "FACE").data.foreach_set("value", above(obj).astype(np.int32))
    mesh.attributes.new("groups", "INT", "FACE").data.foreach_set("value", above(obj).astype(np.int32))
    return obj


def above(obj):
    return np.array([polygon.center.z > 0 for polygon in obj.data.polygons])


OPTIONS = ["seams", "sharp", "materials", "borders"] + (["face_sets"] if bpy.app.version >= (3, 6) else [])


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
@pytest.mark.parametrize("option", OPTIONS)
def test_regions_respect_marked_edges(scan, option, mode):
    bpy.ops.object.mode_set(mode=mode)
    marked = {option: "groups" if option == "borders" else True}
    assert bpy.ops.isimp.partition(proxies=6, **marked) == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    regions, upper = scans.regions(scan), above(scan)
    assert not set(regions[upper]) & set(regions[~upper])
    assert "groups" in weights.face_names(scan)
    assert bpy.ops.isimp.replay(recipe=Recipe((Partition(proxies=6),)).to_json()) == {"FINISHED"}
    regions = scans.regions(scan)
    assert len(set(regions[upper]) & set(regions[~upper])) == 4, "without it the four sides are whole"


def test_marks_that_modifiers_move_away_are_said(scan):
    scan.modifiers.new("More", "SUBSURF").levels = 1
    with pytest.raises(RuntimeError, match="can't be traced through its modifiers: apply them first"):
        bpy.ops.isimp.replay(recipe=Recipe((Partition(proxies=6, seams=True),)).to_json())


def test_slivers_are_not_merged_across_seams(scan):
    """A seam surrounds two faces in a wall. One is a region, and its only neighbour is the other one."""
    mesh = scan.data
    inside = next(pair for pair in zip(mesh.polygons[:-1], mesh.polygons[1:], strict=True) if beside(*pair))
    rim = set(inside[0].edge_keys) ^ set(inside[1].edge_keys)
    for edge in mesh.edges:
        edge.use_seam = tuple(sorted(edge.vertices)) in rim
    first, second = (polygon.index for polygon in inside)
    steps = Partition(proxies=7, seams=True), PaintFaces(faces=(first,), onto=-1)
    bpy.ops.isimp.replay(recipe=Recipe(steps).to_json())
    regions = scans.regions(scan)
    assert (regions == regions[second]).sum() == 1
    assert bpy.ops.isimp.merge_slivers(share=50) == {"FINISHED"}
    regions = scans.regions(scan)
    assert regions[first] == regions[second]
    assert (regions == regions[first]).sum() == 2
    with pytest.raises(RuntimeError, match="No region is that small"):
        bpy.ops.isimp.merge_slivers(share=50)
    assert bpy.ops.isimp.make_editable() == {"FINISHED"}


def beside(one, other):
    return len(set(one.edge_keys) & set(other.edge_keys)) == 1


def test_the_number_is_found_unless_one_is_given(scan):
    bpy.ops.isimp.partition()
    assert len(set(scans.regions(scan))) == 6
    bpy.ops.isimp.partition(proxies=9)
    assert len(set(scans.regions(scan))) == 9


def test_partition_keeps_locked_regions(scan):
    recipe = Recipe((Partition(proxies=6),))
    bpy.ops.isimp.replay(recipe=recipe.to_json())
    bpy.ops.isimp.replay(recipe=recipe.then(PaintFaces(faces=(0, 1), lock=True)).then(Mesh()).to_json())
    bpy.ops.isimp.partition(proxies=10)
    regions = scans.regions(scan)
    assert np.flatnonzero(regions == regions[0]).tolist() == [0, 1]
    assert len(set(regions)) == 10


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_only_the_selected_faces_are_split_again(scan, mode):
    bpy.ops.isimp.partition(proxies=6)
    before = scans.regions(scan)
    side = np.flatnonzero(before == before[0])
    bpy.ops.object.mode_set(mode=mode)
    scans.select_faces(scan)
    with pytest.raises(RuntimeError, match="No face is selected"):
        bpy.ops.isimp.partition(proxies=4, part=True)
    scans.select_faces(scan, *side.tolist())
    bpy.ops.isimp.partition(proxies=4, part=True)
    bpy.ops.object.mode_set(mode="OBJECT")
    after = scans.regions(scan)
    assert len(set(after[side])) == 4
    others = np.setdiff1d(np.arange(len(after)), side)
    assert len(set(zip(before[others].tolist(), after[others].tolist(), strict=True))) == 5
