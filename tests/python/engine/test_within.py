"""A bound kept by the polygons too."""

import numpy as np
import pytest

import isimp_engine as engine
import shapes
from isimp_engine import within


def partition_within(mesh, options):
    """Regions and their polygons, which keep a bound too."""
    part = engine.partition(mesh, options)
    return within.polygonize_within(mesh, part, made=within.Made(options))


def test_a_cube_is_where_its_polygons_are():
    mesh = engine.Mesh(*shapes.cube(6))
    part = engine.partition(mesh, engine.PartitionOptions(proxies=6))
    poly = engine.polygonize(mesh, part)
    assert within.triangles_of(poly) == 12
    away = within.scan_distances(mesh, part, poly)
    assert away.shape == (len(mesh.vertices),)
    assert away.max() < 1e-9


@pytest.mark.parametrize("bound", [0.01, 0.03, 0.08])
def test_the_polygons_keep_one_and_a_half_times_the_bound(bound):
    mesh = engine.Mesh(*shapes.torus(120, 60))
    result = partition_within(mesh, engine.PartitionOptions(bound=bound))
    assert result.distance <= 1.5 * bound
    away = within.scan_distances(mesh, result.partition, result.polygons)
    assert result.distance >= np.nanmax(away) - 1e-12
    assert result.polygons.report["closed"]
    report = result.report
    assert (report["scan_distance"], report["scan_distance_allowed"]) == (result.distance, pytest.approx(1.5 * bound))


def test_regions_are_made_again_only_if_it_is_known_how(monkeypatch):
    monkeypatch.setattr(within, "SLACK", 0.6)  # the first polygons are further off
    mesh, options = engine.Mesh(*shapes.torus(48, 24)), engine.PartitionOptions(bound=0.05)
    part = engine.partition(mesh, options)
    as_it_is = within.polygonize_within(mesh, part)
    assert as_it_is.partition is part
    assert as_it_is.distance > as_it_is.allowed
    anew = within.polygonize_within(mesh, part, made=within.Made(options))
    assert anew.distance <= anew.allowed == pytest.approx(0.6 * 0.05)
    assert anew.partition.region_count > part.region_count
    assert anew.tries > as_it_is.tries


def test_one_job_shows_how_far_all_the_tries_are(monkeypatch):
    monkeypatch.setattr(within, "SLACK", 0.7)
    mesh, options, job, seen = engine.Mesh(*shapes.torus(48, 24)), engine.PartitionOptions(bound=0.05), engine.Job(), []
    real = within.polygonize
    monkeypatch.setattr(
        within, "polygonize", lambda *args, **given: (seen.append((job.progress, job.stage)), real(*args, **given))[1]
    )
    within.polygonize_within(mesh, engine.partition(mesh, options), job=job, made=within.Made(options))
    assert seen[:3] == [(0, "meshing"), (0.5, "meshing"), (0.75, "meshing")]
    shares = [share for share, _ in seen]
    assert shares == sorted(set(shares))
    assert shares[-1] < job.progress <= 1


def test_without_a_bound_nothing_is_measured():
    mesh = engine.Mesh(*shapes.cube(6))
    result = partition_within(mesh, engine.PartitionOptions(proxies=6))
    assert (result.partition.region_count, result.distance, result.allowed) == (6, None, None)
    assert "scan_distance" not in result.report
