"""Mesh: the result next to the scan."""

from math import radians

import bpy
import numpy as np
import pytest
import scans
from mathutils import Matrix

from isimp.blender.scene import store
from isimp.blender.texts import text
from isimp.session import engine


def simplify(proxies=6):
    assert bpy.ops.isimp.partition(proxies=proxies) == {"FINISHED"}
    assert bpy.ops.isimp.mesh() == {"FINISHED"}
    return bpy.context.object


def outward(obj):
    """Whether a closed mesh has its faces turned outwards. Blender turns them with a mirroring transform."""
    obj.data.calc_loop_triangles()
    points = scans.coordinates(obj.data)
    corners = np.array([triangle.vertices[:] for triangle in obj.data.loop_triangles])
    a, b, c = (points[corners[:, k]] for k in range(3))
    return np.einsum("ij,ij->", a - points.mean(axis=0), np.cross(b - a, c - a)) > 0


def test_the_result_is_a_valid_mesh_of_polygons_next_to_the_hidden_scan():
    scan = scans.dimple(scans.cube())
    before = scans.geometry(scan.data)
    result = simplify(proxies=14)
    assert result.name == "Scan.simplified"
    assert result.select_get()
    assert bpy.context.selected_objects == [result]
    assert scan.hide_get()
    assert scan.name in bpy.context.scene.objects
    assert scans.geometry(scan.data) == before
    assert not result.data.validate(verbose=True)
    assert max(len(polygon.vertices) for polygon in result.data.polygons) > 3
    assert set(scans.regions(result)) == set(range(14))
    assert not any(polygon.use_smooth for polygon in result.data.polygons)
    assert len(result.data.edges) > 0


def test_mesh_again_refreshes_the_same_object():
    scans.dimple(scans.cube())
    first = simplify(proxies=14)
    count = len(first.data.polygons)
    scans.mode("OBJECT")
    assert bpy.ops.isimp.mesh(chord_tolerance=0.1) == {"FINISHED"}
    assert bpy.context.object == first
    assert simplify(proxies=30) == first
    assert len(first.data.polygons) > count
    assert not first.data.validate()
    assert sorted(obj.name for obj in bpy.data.objects) == ["Scan", "Scan.simplified"]
    assert len(bpy.data.meshes) == 2


def test_partition_from_the_result_works_on_its_scan():
    scan = scans.dimple(scans.cube())
    result = simplify()
    assert bpy.context.object == result
    assert bpy.ops.isimp.partition(proxies=9) == {"FINISHED"}
    assert bpy.context.object == scan
    assert not scan.hide_get()
    assert result.hide_get()
    assert len(np.unique(scans.regions(scan))) == 9


def test_a_deleted_result_is_made_again():
    scan = scans.cube()
    bpy.data.objects.remove(simplify())
    scan.hide_set(False)
    scans.activate(scan)
    assert simplify().name == "Scan.simplified"


def test_a_foreign_object_of_that_name_is_left_alone():
    foreign = scans.cube(name="Scan.simplified", cells=1)
    scans.cube()
    result = simplify()
    assert result != foreign
    assert len(foreign.data.polygons) == 12


def test_a_renamed_scan_keeps_its_result():
    scan = scans.cube()
    first = simplify()
    scan.name = "Other"
    assert simplify() == first


def test_swap_shows_the_one_and_hides_the_other():
    scan = scans.cube()
    result = simplify()
    assert bpy.ops.isimp.swap() == {"FINISHED"}
    assert (scan.hide_get(), result.hide_get(), bpy.context.object) == (False, True, scan)
    assert bpy.ops.isimp.swap() == {"FINISHED"}
    assert (scan.hide_get(), result.hide_get(), bpy.context.object) == (True, False, result)


@pytest.mark.parametrize(
    ("scale", "parented"),
    [((1, 1, 1), False), ((2, 0.5, 5), False), ((-1, 1, 1), False), ((-2, 3, 0.1), False), ((1, -2, 1), True)],
)
def test_the_result_lies_where_the_scan_is_seen(scale, parented):
    scan = scans.cube()
    scan.location, scan.scale = (10, -20, 30), scale
    scan.rotation_euler = (radians(30), radians(20), radians(50))
    if parented:
        scans.hang(scan, scale=(1, 3, 1))
    bpy.context.view_layer.update()
    wanted = scans.world(scan)
    turned = outward(scan)
    result = simplify()
    bpy.context.view_layer.update()
    seen = scans.world(result)
    assert len(seen) == 8
    assert seen.min(axis=0) == pytest.approx(wanted.min(axis=0), abs=1e-4)
    assert seen.max(axis=0) == pytest.approx(wanted.max(axis=0), abs=1e-4)
    assert outward(result) == turned


def test_regions_belong_to_the_visible_shape():
    """A scan squeezed by its transform and one squeezed for good get the same regions."""
    squeezed, applied = scans.dimple(scans.cube(name="A")), scans.dimple(scans.cube(name="B"))
    squeezed.scale = (1, 1, 0.25)
    squeezed.rotation_euler = (1, 2, 3)
    applied.data.transform(Matrix.Diagonal((1, 1, 0.25, 1)))
    bpy.context.view_layer.update()
    labels = []
    for scan in (squeezed, applied):
        scans.activate(scan)
        bpy.ops.isimp.partition(proxies=12)
        labels.append(scans.regions(scan).tolist())
    assert labels[0] == labels[1]


def test_a_bound_is_kept_by_the_polygons_too(monkeypatch):
    monkeypatch.setattr(engine.within, "SLACK", 0.8)  # nearer than the regions' own planes have to be
    scan = scans.cube()
    places = scans.coordinates(scan.data) + np.random.default_rng(1).normal(0, 0.05, (len(scan.data.vertices), 3))
    scan.data.vertices.foreach_set("co", places.astype(np.float32).ravel())
    assert bpy.ops.isimp.partition(count_by="bound", bound=0.1) == {"FINISHED"}
    before = store.numbers(scan)["regions"]
    assert bpy.ops.isimp.mesh() == {"FINISHED"}
    numbers = store.numbers(scan)
    assert numbers["scan_distance"] <= numbers["scan_distance_allowed"] == pytest.approx(0.08)
    assert numbers["regions"] == len(np.unique(scans.regions(scan))) > before
    lines = [line for line, amiss in text.report_lines(numbers, "NONE", 1.0) if not amiss]
    assert f"{numbers['regions'] - before} regions added to keep the bound" in lines
