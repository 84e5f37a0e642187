"""Sizes in the panel: a line for each, whose click selects its regions; a known length scales the scan."""

import bpy
import numpy as np
import pytest
import scans
from drawing import controls

from isimp.blender.controls import settings
from isimp.blender.panel import planes, sizes
from isimp.blender.scene import mesh_io, pointed, runtime, store
from isimp.blender.texts import text
from isimp.blender.work import modal
from isimp.recipe import Partition

OPS = bpy.ops.isimp


@pytest.fixture
def scan():
    """A cube of side 2 with little noise, and its polygons with snapped sizes."""
    obj = scans.cube("Scan", 12)
    points = scans.coordinates(obj.data)
    points += np.random.default_rng(1).normal(0, 0.002, points.shape)
    obj.data.vertices.foreach_set("co", points.astype(np.float32).ravel())
    obj.data.update()
    assert OPS.partition(proxies=6) == {"FINISHED"}
    assert OPS.regularise(snap_sizes=0.5) == {"FINISHED"}
    assert OPS.mesh() == {"FINISHED"}
    return obj


def distances(scan):
    return [row for row in store.numbers(scan)["sizes"] if row[1] == "distance"]


def test_the_table_opens_from_the_planes_and_says_what_moved(scan):
    assert ("popover", "ISIMP_PT_sizes") in controls(planes.ISIMP_PT_planes)
    rows = distances(scan)
    assert [row[2] for row in rows] == pytest.approx([2, 2, 2], abs=1e-9)
    assert [row[5] for row in rows] == ["yes"] * 3
    assert text.size(rows[0]).startswith("Distance 2 m, measured ")
    result = bpy.data.objects["Scan.simplified"]
    points = scans.coordinates(result.data)
    wide = [np.ptp(points @ np.array(polygon.normal)) for polygon in result.data.polygons]
    assert wide == pytest.approx([2] * 6, abs=1e-6)
    drawn = controls(sizes.ISIMP_PT_sizes)
    assert ("operator", "isimp.set_length") in drawn


def test_a_line_selects_its_two_planes(scan):
    assert OPS.select_region(size=0) == {"FINISHED"}
    regions = mesh_io.read_regions(scan)
    chosen = {int(regions[polygon.index]) for polygon in scan.data.polygons if polygon.select}
    assert chosen == set(store.numbers(scan)["sizes"][0][-1])


def test_a_known_length_scales_scan_and_result_in_one_step_to_undo(scan):
    before = scans.coordinates(scan.data).copy()
    scans.push("meshed")
    regions = mesh_io.read_regions(scan)
    pointed.choose(scan, tuple(int(np.flatnonzero(regions == region)[0]) for region in distances(scan)[0][-1]))
    scans.activate(scan)
    assert OPS.set_length("EXEC_DEFAULT", True, length=40.0, chosen=",".join(map(str, pointed.faces(scan)))) == {
        "FINISHED"
    }
    scan, result = bpy.data.objects["Scan"], bpy.data.objects["Scan.simplified"]
    assert tuple(scan.scale) == pytest.approx((20, 20, 20), rel=2e-3)
    assert tuple(result.scale) == pytest.approx(tuple(scan.scale))
    assert np.array_equal(scans.coordinates(scan.data), before)
    assert distances(scan)[0][4] == pytest.approx(40, rel=1e-5)
    bpy.ops.ed.undo()
    scan = bpy.data.objects["Scan"]
    assert tuple(scan.scale) == (1, 1, 1)
    assert tuple(bpy.data.objects["Scan.simplified"].scale) == (1, 1, 1)


def test_planes_without_a_distance_are_refused(scan):
    regions = mesh_io.read_regions(scan)
    faces = [
        int(np.flatnonzero(regions == region)[0]) for region in (distances(scan)[0][-1][0], distances(scan)[1][-1][0])
    ]
    with pytest.raises(RuntimeError, match="Choose two parallel planes"):
        OPS.set_length(length=1.0, chosen=",".join(map(str, faces)))
    assert tuple(scan.scale) == (1, 1, 1)


def test_the_scan_is_scaled_once_the_work_has_ended_well(scan, monkeypatch):
    regions = mesh_io.read_regions(scan)
    faces = [str(int(np.flatnonzero(regions == region)[0])) for region in distances(scan)[0][-1]]
    replay, seen = runtime.get().session.replay, []

    def followed(arrays, *more):
        seen.append((tuple(scan.scale), np.ptp(arrays.vertices)))
        return replay(arrays, *more)

    monkeypatch.setattr(runtime.get().session, "replay", followed)
    with monkeypatch.context() as patch:
        patch.setattr(modal.Work, "target", lambda work: None)  # as if the scan was changed meanwhile
        assert OPS.set_length(length=40.0, chosen=",".join(faces)) == {"CANCELLED"}
    assert tuple(scan.scale) == (1, 1, 1)
    assert OPS.set_length(length=40.0, chosen=",".join(faces)) == {"FINISHED"}
    assert [scale for scale, _ in seen] == [(1, 1, 1)] * 2
    assert [size for _, size in seen] == pytest.approx([40, 40], rel=0.05)
    assert tuple(scan.scale) == pytest.approx((20, 20, 20), rel=2e-3)
    assert mesh_io.read(bpy.context, scan).digest == store.numbers(scan)["scan"], "cached outcomes stay valid"


def test_lengths_of_the_recipe_are_scaled_with_the_scan(scan):
    OPS.partition(count_by="bound", bound=0.1)
    OPS.mesh()
    regions = store.numbers(scan)["regions"]
    faces = [str(int(np.flatnonzero(mesh_io.read_regions(scan) == region)[0])) for region in distances(scan)[0][-1]]
    OPS.set_length(length=40.0, chosen=",".join(faces))
    assert store.load(scan).steps[0].bound == pytest.approx(2, rel=0.1)
    assert settings.group(bpy.context, Partition).bound == pytest.approx(2, rel=0.1)
    assert store.numbers(scan)["regions"] == regions
