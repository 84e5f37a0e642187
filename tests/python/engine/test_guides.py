"""Barriers from the marks of a mesh, kept by regions and polygons; a new split of a part alone."""

import os
from pathlib import Path

import numpy as np
import pytest

import isimp_engine as engine
import shapes
from isimp_engine import guides
from isimp_engine.jobs import OneJob
from isimp_engine.marks import Marks, guides_of
from isimp_engine.repairs import Meshes, Repair
from isimp_engine.source import source_of

DATA = Path(os.environ.get("ISIMP_DATA", Path(__file__).resolve().parents[4] / "shared" / "data"))
METHODS = ["hierarchy", "lloyd", "teleport", "naive", "queued"]


def edges_of(polygons):
    """Pairs of the scan's vertices that polygon edges run between."""
    ends = [*polygons.loop_start[1:], len(polygons.loops)]
    source, pairs = polygons.source_vertex, set()
    for start, end in zip(polygons.loop_start, ends, strict=True):
        loop = source[polygons.loops[start:end]]
        pairs |= {(min(a, b), max(a, b)) for a, b in zip(loop, np.roll(loop, -1), strict=True)}
    return pairs


def crossed(mesh, part, barriers):
    """The number of barriers with the same region on both sides."""
    edges, a, b = guides.inner_edges(mesh)
    wanted = {tuple(sorted(pair)) for pair in barriers.tolist()}
    chosen = np.array([tuple(pair) in wanted for pair in edges.tolist()])
    return int((part.face_region[a][chosen] == part.face_region[b][chosen]).sum())


@pytest.mark.parametrize("method", METHODS)
def test_seams_of_a_cube_are_kept_by_regions_and_polygons(method):
    mesh = engine.Mesh(*shapes.cube(8))
    middle = mesh.vertices[mesh.triangles].mean(axis=1)
    barriers = guides.attribute_borders(mesh, middle[:, 0] > 0.5)  # a seam around the middle of the cube
    assert len(barriers) == 4 * 8
    part = engine.partition(mesh, engine.PartitionOptions(proxies=10, method=method), barriers=barriers)
    assert crossed(mesh, part, barriers) == 0
    polygons = engine.polygonize(mesh, part)
    # The seam is a square: its corners are vertices of the polygons, and its sides are made of their edges.
    corners = mesh.vertices[polygons.source_vertex]
    on_seam = np.isclose(corners[:, 0], 0.5)
    pairs = [pair for pair in edges_of(polygons) if all(np.isclose(mesh.vertices[list(pair), 0], 0.5))]
    length = sum(np.linalg.norm(mesh.vertices[a] - mesh.vertices[b]) for a, b in pairs)
    assert on_seam.sum() >= 4
    assert length == pytest.approx(4)
    moved = polygons.vertices[on_seam]
    np.testing.assert_allclose(moved[:, 0], 0.5, atol=engine.MeshingOptions().reach * np.sqrt(3))


def test_an_attribute_needs_a_value_for_each_face():
    with pytest.raises(engine.InvalidInput, match=r"one value for each of the 108 faces, got \(3,\)"):
        guides.attribute_borders(engine.Mesh(*shapes.cube(3)), np.zeros(3))


@pytest.mark.skipif(not (DATA / "textured").is_dir(), reason="no data folder")
def test_parts_of_a_city_tile_are_kept_apart():
    (path,) = (DATA / "textured" / "frankfurt_tile").glob("*.obj")
    mesh = engine.clean(*engine.read(path))
    height = mesh.vertices[mesh.triangles].mean(axis=1)
    up = int(np.ptp(mesh.vertices, axis=0).argmin())
    roofs = height[:, up] > np.quantile(height[:, up], 0.6)
    barriers = guides.attribute_borders(mesh, roofs)
    assert len(barriers) > 300
    part = engine.partition(mesh, engine.PartitionOptions(proxies=600), barriers=barriers)
    assert crossed(mesh, part, barriers) == 0
    polygons = engine.polygonize(mesh, part)
    # Each polygon is of one side: the region's faces all are roofs or none is.
    share = np.bincount(part.face_region[part.face_region >= 0], roofs[part.face_region >= 0], part.region_count)
    size = np.bincount(part.face_region[part.face_region >= 0], minlength=part.region_count)
    assert (np.isin(share, [0]) | (share == size)).all()
    assert len(polygons.loop_start) >= part.region_count * 0.9


def test_labels_from_elsewhere_become_a_partition():
    mesh = engine.Mesh(*shapes.two_cubes(3))
    base = engine.partition(mesh, engine.PartitionOptions(proxies=12))
    again = engine.partition_from(mesh, base.face_region * 7)
    assert again.region_count == 12
    assert again.error == pytest.approx(base.error, abs=1e-9)
    assert engine.partition_from(mesh, np.zeros(len(mesh.triangles), int)).region_count == 2, "two pieces"
    for labels, message in (
        (np.zeros(3, int), r"^there are 3 labels, but the mesh has 216 faces"),
        (np.full(216, -2), "^the label of face 0 is -2"),
        (np.full(216, -1), "^no face is in a region"),
    ):
        with pytest.raises(engine.InvalidInput, match=message):
            engine.partition_from(mesh, labels)


def test_shared_edges_of_two_triangles_and_of_a_fin():
    pairs, edges = guides.shared_edges(np.array([[0, 1, 2], [1, 0, 3]], np.int32))
    assert (pairs.tolist(), edges.tolist()) == ([[0, 1]], [[0, 1]])
    fin, _ = guides.shared_edges(np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4]], np.int32))
    assert fin.tolist() == [[0, 1], [1, 2], [0, 2]]


def test_shared_edges_of_a_closed_mesh_are_all_its_edges_in_order():
    _, triangles = shapes.cube(4)
    pairs, edges = guides.shared_edges(triangles.astype(np.int64))
    assert len(pairs) == 3 * len(triangles) // 2
    assert (pairs[:, 0] < pairs[:, 1]).all()
    assert edges.tolist() == sorted(edges.tolist())
    for (a, b), (u, v) in zip(pairs.tolist(), edges.tolist(), strict=True):
        assert {u, v} == set(triangles[a]) & set(triangles[b])


def test_shared_edges_refuse_vertices_below_zero():
    with pytest.raises(engine.InvalidInput, match="face 1 uses vertex -1"):
        guides.shared_edges(np.array([[0, 1, 2], [0, -1, 2]]))
    assert len(guides.shared_edges(np.empty((0, 3), np.int32))[0]) == 0


def test_covers_of_an_opening_have_the_weight_and_the_values_of_the_nearest_face():
    vertices, triangles = shapes.plane(8)
    centers = vertices[triangles].mean(axis=1)
    rest = triangles[np.abs(centers - 0.5)[:, :2].max(axis=1) > 0.2]
    right = vertices[rest].mean(axis=1)[:, 0] > 0.5
    repair = Repair.by(engine.CleanOptions(fill_holes=9.0))
    repaired = Meshes().repaired(source_of((vertices, rest)), repair, OneJob(None))
    made = guides_of(Marks(weights=np.full(len(rest), 4.0), borders=(right,)), None, repaired, engine.Job())
    assert (made.weights == 4).all()
    edges, a, b = guides.inner_edges(repaired.mesh)
    in_cover = {tuple(pair) for pair in edges[(repaired.mesh.source_face[[a, b]] < 0).all(axis=0)].tolist()}
    assert in_cover & {tuple(pair) for pair in made.barriers.tolist()}, "the border runs on through the cover"
