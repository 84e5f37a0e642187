"""Partitions that keep to cuts and to a part; tests/cpp/simplify/test_constraints.cpp has more of them."""

import numpy as np
import pytest

import isimp_engine as engine
import shapes
from isimp_engine import guided, guides
from isimp_engine.guided import Guides, partition_guided


def options(**fields):
    return engine.PartitionOptions(**fields)


def middles(mesh):
    return mesh.vertices[mesh.triangles].mean(axis=1)


def open_edges(polygons):
    """Pairs of polygon corners that only one polygon has."""
    count = {}
    ends = [*polygons.loop_start[1:], len(polygons.loops)]
    for start, end in zip(polygons.loop_start, ends, strict=True):
        loop = polygons.loops[start:end].tolist()
        for pair in zip(loop, [*loop[1:], loop[0]], strict=True):
            count[tuple(sorted(pair))] = count.get(tuple(sorted(pair)), 0) + 1
    return np.array([pair for pair, n in count.items() if n == 1]).reshape(-1, 2)


def test_without_guides_it_is_partition():
    mesh = engine.Mesh(*shapes.bumpy(20))
    plain, same = engine.partition(mesh, options(proxies=9)), partition_guided(mesh, options(proxies=9))
    np.testing.assert_array_equal(plain.face_region, same.face_region)


def seam(mesh, wanted):
    """The edges with both ends where `wanted` holds."""
    edges, _, _ = guides.inner_edges(mesh)
    ends = mesh.vertices[edges]
    return edges[wanted(ends[:, 0]) & wanted(ends[:, 1])]


def test_a_cut_that_ends_inside_a_side_of_a_cube_splits_that_side():
    mesh = engine.Mesh(*shapes.cube(8))
    on_top = seam(mesh, lambda p: np.isclose(p[:, 2], 1) & np.isclose(p[:, 0], 0.5) & (p[:, 1] < 0.55))
    assert len(on_top) == 4
    part = partition_guided(mesh, options(proxies=6), guides=Guides(cuts=on_top))
    assert part.region_count == 7
    polygons = engine.polygonize(mesh, part)
    assert polygons.report["closed"]
    ends = mesh.vertices[polygons.source_vertex]
    assert (np.isclose(ends, [0.5, 0, 1]).all(axis=1)).any(), "the cut begins at a corner of the polygons"


def test_a_bound_is_kept_where_cuts_split_regions():
    mesh = engine.Mesh(*shapes.torus(60, 30))
    cuts = seam(mesh, lambda p: np.isclose(p[:, 2], p[:, 2].max()) & (p[:, 0] > 0))
    assert len(cuts)
    part = partition_guided(mesh, options(bound=0.05), guides=Guides(cuts=cuts))
    assert part.bound == 0.05
    away = np.einsum("fkd,fd->fk", mesh.vertices[mesh.triangles], part.region_normal[part.face_region])
    assert np.abs(away - part.region_offset[part.face_region][:, None]).max() <= 0.05 * (1 + 1e-9)


def test_edits_keep_to_barriers_where_cuts_split_regions():
    mesh = engine.Mesh(*shapes.cube(8))
    cuts = seam(mesh, lambda p: np.isclose(p[:, 2], 1) & np.isclose(p[:, 0], 0.5) & (p[:, 1] < 0.55))
    part = partition_guided(mesh, options(proxies=6), guides=Guides(cuts=cuts))
    face = int(np.flatnonzero(np.isclose(middles(mesh)[:, 2], 1))[0])
    for edit in (engine.add_proxy, engine.split_region, engine.grow_region):
        part = edit(mesh, part, face)
        assert guided.inside_regions(mesh, part, cuts) == 0, edit


@pytest.mark.parametrize("method", ["hierarchy", "lloyd", "teleport", "naive", "queued", "hybrid"])
def test_only_a_part_is_split_again(method):
    mesh = engine.Mesh(*shapes.bumpy(40))
    base = engine.partition(mesh, options(proxies=30))
    faces = np.flatnonzero(np.linalg.norm(middles(mesh)[:, :2] - 0.5, axis=1) < 0.3)
    wanted = Guides(faces=faces, before=base)
    part = partition_guided(mesh, options(proxies=25, method=method), guides=wanted)
    inside = np.zeros(len(mesh.triangles), bool)
    inside[faces] = True
    assert len(set(part.face_region[inside])) == 25
    assert not set(part.face_region[inside]) & set(part.face_region[~inside])
    # Outside two faces are in one region if and only if they were, but where a region fell apart.
    for region in set(part.face_region[~inside]):
        assert len(set(base.face_region[part.face_region == region])) == 1
    polygons = engine.polygonize(mesh, part)
    assert polygons.report["manifold"]
    rim = mesh.vertices[polygons.source_vertex[open_edges(polygons).ravel()]][:, :2]
    assert (np.isclose(rim, 0) | np.isclose(rim, 1)).any(axis=1).all(), "no crack but along the sheet's own border"


def test_a_part_without_neighbours():
    mesh = engine.Mesh(*shapes.cube(6))
    top = np.flatnonzero(np.isclose(middles(mesh)[:, 2], 1))
    part = partition_guided(mesh, options(proxies=3), guides=Guides(faces=top))
    assert (part.face_region >= 0).sum() == len(top)
    assert part.region_count == 3
    of_numbers = "faces must be an array of shape .* and integers, got shape "
    for faces, message in (
        ([], "no face is given"),
        ([3, 9999], r"faces must be in \[0, 432\), got 9999"),
        (np.array([3, 2**63], np.uint64), r"faces\[1\] is 9223372036854775808, which no index can be"),
        ([0.5, np.nan], of_numbers + r"\(2,\) and float64"),
        (["a"], of_numbers + r"\(1,\) and <U1"),
        ([[0, 1]], of_numbers + r"\(1, 2\)"),
    ):
        with pytest.raises(engine.InvalidInput, match=message):
            partition_guided(mesh, options(proxies=3), guides=Guides(faces=faces))
