"""A bound kept by the polygons too."""

import numpy as np
import pytest

import isimp_engine as engine
import shapes
from isimp_engine import within


def test_distances_are_to_planes_sides_and_corners():
    corners = np.array([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]] * 4)
    points = np.array([[0.2, 0.2, 3.0], [0.5, -2, 0], [4, 0, 4], [0.2, 0.2, 0]])
    np.testing.assert_allclose(within._to_triangles(points, corners), [3, 2, 5, 0])


def test_a_cube_is_where_its_polygons_are():
    mesh = engine.Mesh(*shapes.cube(6))
    part = engine.partition(mesh, engine.PartitionOptions(proxies=6))
    away = within.scan_distances(mesh, part, engine.polygonize(mesh, part))
    assert away.shape == (len(mesh.vertices),)
    assert away.max() < 1e-9


@pytest.mark.parametrize("bound", [0.01, 0.03, 0.08])
def test_the_polygons_keep_one_and_a_half_times_the_bound(bound):
    mesh = engine.Mesh(*shapes.torus(120, 60))
    result = within.partition_within(mesh, engine.PartitionOptions(bound=bound))
    assert result.distance <= 1.5 * bound
    away = within.scan_distances(mesh, result.partition, result.polygons)
    assert result.distance >= np.nanmax(away) - 1e-12
    assert result.polygons.report["closed"]
    report = result.report
    assert (report["scan_distance"], report["scan_distance_allowed"]) == (result.distance, pytest.approx(1.5 * bound))


def test_without_a_bound_nothing_is_measured():
    mesh = engine.Mesh(*shapes.cube(6))
    result = within.partition_within(mesh, engine.PartitionOptions(proxies=6))
    assert (result.partition.region_count, result.distance, result.allowed) == (6, None, None)
    assert "scan_distance" not in result.report
