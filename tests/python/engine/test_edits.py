"""Edits of a partition: merge, split, paint, lock and the heuristics, used like a caller."""

import numpy as np
import pytest

import isimp_engine as engine
import shapes
from headers import struct_fields
from test_partition import check, pieces

hypothesis = pytest.importorskip("hypothesis")
from hypothesis import given, settings  # noqa: E402
from hypothesis import strategies as st  # noqa: E402

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


EDITS = {
    "add": lambda mesh, part, face, size: engine.add_proxy(mesh, part, face),
    "delete": lambda mesh, part, face, size: engine.delete_proxy(mesh, part, face),
    "split": lambda mesh, part, face, size: engine.split_region(mesh, part, face),
    "cut": lambda mesh, part, face, size: engine.split_along(
        mesh, part, face, np.array([[0.4, 0.1 + 0.1 * size, 0], [0.5, 0.2, 0], [0.9, 0.3, 0]]), np.array([0, 0, 1.0])
    ),
    "merge": lambda mesh, part, face, size: engine.merge_regions(mesh, part, face, (face * 7 + size) % 800),
    "paint": lambda mesh, part, face, size: engine.paint_faces(mesh, part, disc(mesh, face, 0.04 * size)),
    "paint onto": lambda mesh, part, face, size: engine.paint_faces(mesh, part, disc(mesh, face, 0.05 * size), face),
    "erase": lambda mesh, part, face, size: engine.erase_faces(mesh, part, disc(mesh, face, 0.05 * size)),
    "grow": lambda mesh, part, face, size: engine.grow_region(mesh, part, face, size),
    "shrink": lambda mesh, part, face, size: engine.shrink_region(mesh, part, face, size),
    "worst": lambda mesh, part, face, size: engine.add_worst(mesh, part, size),
    "least": lambda mesh, part, face, size: engine.delete_least(mesh, part, size),
    "cheapest": lambda mesh, part, face, size: engine.merge_cheapest(mesh, part, size),
    "improve": lambda mesh, part, face, size: engine.improve(mesh, part),
    "even": lambda mesh, part, face, size: engine.even_borders(mesh, part, size / 5),
    "lock": lambda mesh, part, face, size: engine.lock_regions(mesh, part, np.array([face])),
    "unlock": lambda mesh, part, face, size: engine.unlock_regions(mesh, part, np.array([face])),
    "leave out": lambda mesh, part, face, size: engine.leave_out_regions(mesh, part, np.array([face])),
}
step = st.tuples(st.sampled_from(sorted(EDITS)), st.integers(0, 799), st.integers(1, 5))


def locked_sets(part):
    return {np.flatnonzero(part.face_region == r).tobytes() for r in np.flatnonzero(part.region_locked)}


@settings(max_examples=25, deadline=None)
@given(steps=st.lists(step, min_size=1, max_size=12))
def test_any_chain_of_edits_keeps_the_promises_of_a_partition(mesh, part, steps):
    """Connected, every face in a region, none empty, locked faces unchanged; and the same again on a second run."""
    runs = []
    for _ in range(2):
        now = part
        for name, face, size in steps:
            locked = locked_sets(now)
            try:
                after = EDITS[name](mesh, now, face, size)
            except engine.InvalidInput:
                continue
            check(mesh, after, after.region_count)
            if name not in ("unlock", "paint onto"):
                assert locked <= locked_sets(after)
            now = after
        runs.append(now)
    np.testing.assert_array_equal(runs[0].face_region, runs[1].face_region)
    assert runs[0].error == runs[1].error


def test_counts_are_exact(mesh, part):
    assert engine.split_region(mesh, part, 5).region_count == REGIONS + 1
    assert engine.add_worst(mesh, part, 7).region_count == REGIONS + 7
    assert engine.delete_least(mesh, part, 7).region_count == REGIONS - 7
    assert engine.merge_cheapest(mesh, part, 7).region_count == REGIONS - 7
    assert engine.improve(mesh, part).region_count == REGIONS
    with pytest.raises(engine.InvalidInput, match="only 11 of 12 can be done: no region is left that could be merged"):
        engine.merge_cheapest(mesh, part, 12)


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


def test_no_polygon_is_made_of_a_region_that_is_left_out():
    mesh = engine.Mesh(*shapes.cube(6))
    part = engine.partition(mesh, engine.PartitionOptions(proxies=6))
    without = engine.leave_out_regions(mesh, part, np.array([0]))
    out = int(part.face_region[0])
    assert without.region_left_out.tolist() == [region == out for region in range(6)]
    assert without.region_locked.tolist() == without.region_left_out.tolist()
    polygons = engine.polygonize(mesh, without)
    assert sorted(polygons.polygon_region) == [region for region in range(6) if region != out]
    assert (polygons.report["closed"], polygons.report["manifold"]) == (False, True)
    away = engine.within.scan_distances(mesh, without, polygons)
    inside = np.setdiff1d(mesh.triangles[part.face_region == out], mesh.triangles[part.face_region != out])
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(away)), inside)
    again = engine.partition_from(mesh, np.where(part.face_region == out, -1, part.face_region))
    same = engine.polygonize(mesh, again)  # its regions have other numbers
    np.testing.assert_allclose(np.unique(same.vertices, axis=0), np.unique(polygons.vertices, axis=0), atol=1e-12)
    back = engine.unlock_regions(mesh, without, np.array([0]))
    assert not back.region_left_out.any()
    assert engine.polygonize(mesh, back).report["closed"]


def test_a_cut_parts_faces_by_the_side_of_the_line():
    mesh = engine.Mesh(*shapes.plane(10))
    one = engine.partition(mesh, engine.PartitionOptions(proxies=1))
    two = engine.split_along(mesh, one, 0, [[0.5, 0.4, 3.0], [0.5, 0.6, 3.0]])
    x = mesh.vertices[mesh.triangles].mean(axis=1)[:, 0]
    np.testing.assert_array_equal(two.face_region, x > 0.5)


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
