"""Edits of a partition: merge, split, paint, lock and the heuristics, used like a caller."""

import numpy as np
import pytest

import isimp_engine as engine
import shapes
from headers import struct_fields
from test_partition import pieces

REGIONS = 12


@pytest.fixture(scope="module")
def mesh():
    """A curved sheet of 800 faces."""
    return engine.Mesh(*shapes.bumpy(20))


@pytest.fixture(scope="module")
def part(mesh):
    return engine.partition(mesh, engine.PartitionOptions(proxies=REGIONS))


def disc(mesh, face, radius):
    middles = mesh.vertices[mesh.triangles].mean(axis=1)
    near = np.flatnonzero(np.linalg.norm(middles - middles[face], axis=1) < radius)
    return near if pieces(mesh, near) == 1 else np.array([face])


def test_paint_takes_just_the_faces_and_can_be_locked(mesh, part):
    stroke = disc(mesh, 400, 0.12)
    painted = engine.paint_faces(mesh, part, stroke)
    region = painted.face_region[400]
    assert region == painted.region_count - 1
    assert (painted.face_region[stroke] == region).all()
    locked = engine.lock_regions(mesh, painted, stroke[:1].astype(np.int64))
    assert locked.region_locked.tolist() == [False] * region + [True]
    assert locked.region_locked.dtype == bool
    for face in stroke[:3]:
        with pytest.raises(engine.InvalidInput, match=f"the region of face {face} is locked: unlock it first"):
            engine.delete_proxy(mesh, locked, int(face))


def test_regions_that_are_left_out_are_listed_have_no_distance_and_come_back():
    mesh = engine.Mesh(*shapes.cube(6))
    part = engine.partition(mesh, engine.PartitionOptions(proxies=6))
    without = engine.leave_out_regions(mesh, part, np.array([0]))
    out = int(part.face_region[0])
    assert without.region_left_out.tolist() == without.region_locked.tolist() == [region == out for region in range(6)]
    polygons = engine.polygonize(mesh, without)
    assert sorted(polygons.polygon_region) == [region for region in range(6) if region != out]
    away = engine.within.scan_distances(mesh, without, polygons)
    inside = np.setdiff1d(mesh.triangles[part.face_region == out], mesh.triangles[part.face_region != out])
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(away)), inside)
    assert not engine.unlock_regions(mesh, without, np.array([0])).region_left_out.any()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda m, p: engine.split_along(m, p, 0, [[0.5, 0.4]]), r"line must be an array of shape \(K, 3\)"),
        (lambda m, p: engine.split_along(m, p, 0, np.zeros((2, 3)), [1.0]), "direction must have 3 numbers, got 1"),
        (lambda m, p: engine.paint_faces(m, p, [0.5]), r"faces must be an array of shape \(K,\) and integers"),
        (lambda m, p: engine.paint_faces(m, p, [0], -1), "onto must be a face or None, got -1"),
        (lambda m, p: engine.lock_regions(m, p, np.zeros(0, int)), "there is no face: name one of each region to lock"),
        (lambda m, p: engine.grow_region(m, p, 0, 0), "rings must be at least 1, got 0"),
        (lambda m, p: engine.merge_regions(m, p, 0, 800), r"face must be in \[0, 800\), got 800"),
        (lambda m, p: engine.regions.region_statistics(m, p, 800), r"face must be in \[0, 800\), got 800"),
    ],
)
def test_impossible_edits_are_named(mesh, part, call, message):
    with pytest.raises(engine.InvalidInput, match=message):
        call(mesh, part)


def test_statistics_add_up(mesh, part):
    everything = engine.regions.all_statistics(mesh, part)
    assert [s["region"] for s in everything] == list(range(REGIONS))
    assert sum(s["faces"] for s in everything) == len(mesh.triangles)
    assert sum(s["error"] for s in everything) == pytest.approx(part.error)
    for s in everything:
        assert all(s["region"] in everything[other]["neighbours"] for other in s["neighbours"])
        corners = mesh.vertices[mesh.triangles[part.face_region == s["region"]]]
        heights = corners @ part.region_normal[s["region"]]
        assert np.ptp(heights) / 2 <= s["distance_max"] + 1e-12 <= np.ptp(heights) + 2e-12
        assert 0 < s["distance_rms"] < s["distance_max"]
    assert engine.regions.region_statistics(mesh, part, 17) == everything[part.face_region[17]]
    assert list(everything[0]) == struct_fields("interact/statistics.h", "RegionStatistics")


def test_sides_of_regions_agree_with_their_statistics(mesh, part):
    vertices, triangles, region = (np.asarray(a) for a in (mesh.vertices, mesh.triangles, part.face_region))
    everything = engine.regions.all_statistics(mesh, part)
    area, normal = engine.regions.region_sides(vertices, triangles, region, REGIONS)
    assert area == pytest.approx([s["area"] for s in everything])
    length = np.linalg.norm(normal, axis=1)
    assert (length <= area * (1 + 1e-9)).all()
    assert normal / length[:, None] == pytest.approx(np.asarray(part.region_normal), abs=1e-5)
    single, _ = engine.regions.region_sides(vertices.astype(np.float32), triangles[::-1], region[::-1], REGIONS + 1)
    assert single == pytest.approx([*area, 0.0], rel=1e-4)
    with pytest.raises(engine.InvalidInput, match="must be in"):
        engine.regions.region_sides(vertices, triangles, region, REGIONS - 1)


def test_clutter_of_another_partition_is_refused(mesh, part):
    for region in (-1, part.region_count):
        found = [engine.clutter.Clutter(region, 9, (0.0, 0.0, 0.0))]
        with pytest.raises(
            engine.InvalidInput, match=f"clutter names region {region}, but the partition has {REGIONS} "
        ):
            engine.clutter.without_clutter(mesh, part, found)
