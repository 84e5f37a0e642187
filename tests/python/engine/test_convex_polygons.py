"""`MeshingOptions.convex`: no concave polygon, and nothing else changes."""

import numpy as np
import pytest

import isimp_engine as engine
import shapes
from bench.generators import hollow_solids


def depths(poly):
    """How far the corners of each polygon are behind the line between their neighbours, as share of the size."""
    size = np.linalg.norm(np.ptp(poly.vertices, axis=0))
    found = []
    for loop in poly.faces():
        points = poly.vertices[loop] - poly.vertices[loop[0]]
        before, after = np.roll(points, 1, axis=0), np.roll(points, -1, axis=0)
        normal = np.cross(points, after).sum(axis=0)
        turn = np.cross(points - before, after - points) @ (normal / np.linalg.norm(normal))
        found.append(-turn / np.linalg.norm(after - before, axis=1) / size)
    return found


def areas(poly):
    """The area of each region's polygons."""
    sums = np.zeros(poly.polygon_region.max() + 1)
    for loop, region in zip(poly.faces(), poly.polygon_region, strict=True):
        points = poly.vertices[loop] - poly.vertices[loop[0]]
        sums[region] += np.linalg.norm(np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)) / 2
    return sums


@pytest.mark.parametrize("name", ["room", "cabinet", "flight"])
def test_concave_polygons_are_cut_and_nothing_else_changes(name):
    scan = hollow_solids.twin(hollow_solids.SOLIDS[name]())
    plain, convex = (
        engine.simplify(scan, planar=True, keep_openings=True, regularise=True, convex=on).polygons
        for on in (False, True)
    )
    reflex = np.array([(depth > 1e-7).sum() for depth in depths(plain)])
    assert plain.report["concave"] == (reflex > 0).sum() > 0
    assert np.concatenate(depths(convex)).max() < 1e-6
    added = len(convex.loop_start) - len(plain.loop_start)
    assert (convex.report["concave"], convex.report["cut_to_be_convex"]) == (0, added)
    assert np.ceil(reflex / 2).sum() <= added < reflex.sum()
    assert np.array_equal(np.unique(convex.vertices, axis=0), np.unique(plain.vertices, axis=0))
    assert areas(convex) == pytest.approx(areas(plain))
    assert convex.report["planar"]
    for key in ("closed", "manifold", "euler", "crossing", "flipped", "intersecting", "distance_max"):
        assert convex.report[key] == plain.report[key]


def test_bent_polygons_and_round_parts_are_cut_too():
    vertices, faces = shapes.torus()
    options = engine.MeshingOptions(convex=True)
    mesh = engine.clean(vertices, faces)
    poly = engine.polygonize(mesh, engine.partition(mesh, engine.PartitionOptions(proxies=40)), options)
    assert poly.report["concave"] == 0
    assert np.concatenate(depths(poly)).max() < 1e-6
    solid = hollow_solids.twin(hollow_solids.table())
    round_parts = engine.simplify(solid, curved=True, planar=True, convex=True).polygons
    assert round_parts.report["concave"] == 0


def test_a_convex_result_stays_bit_for_bit():
    mesh = engine.clean(*shapes.cube(8))
    part = engine.partition(mesh, engine.PartitionOptions(proxies=6))
    plain, convex = (engine.polygonize(mesh, part, engine.MeshingOptions(convex=on)) for on in (False, True))
    assert np.array_equal(plain.loops, convex.loops)
    assert np.array_equal(plain.vertices, convex.vertices)
    assert convex.report["cut_to_be_convex"] == 0


def test_the_report_is_of_the_polygons_after_the_cuts():
    dart = np.array([[0, 0, 0], [2, 0, 0], [0.5, 0.5, 0.001], [0, 2, 0]])  # one bent quad, or two planar triangles
    mesh = engine.Mesh(dart, np.array([[0, 1, 2], [0, 2, 3]], np.int32))
    part = engine.partition(mesh, engine.PartitionOptions(proxies=1))
    for on, polygons in ((False, 1), (True, 2)):
        poly = engine.polygonize(mesh, part, engine.MeshingOptions(convex=on))
        assert len(poly.faces()) == polygons
        assert poly.report["planar"] == on
