"""The metric by which borders go: polygons are nearer to the scan with distances in it, edits keep it."""

import numpy as np
import pytest

import isimp_engine as engine
import shapes


@pytest.fixture(scope="module")
def scan():
    return engine.Mesh(*shapes.figure(40))


def split(mesh, metric, **options):
    return engine.partition(mesh, engine.PartitionOptions(metric=metric, threads=1, **options))


def planes(mesh, part):
    """Mean square distance of the faces from the planes of least squares of their regions."""
    corners = np.asarray(mesh.vertices)[np.asarray(mesh.triangles)]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    total = 0.0
    for region in range(part.region_count):
        inside = part.face_region == region
        points, weights = corners[inside].reshape(-1, 3), np.repeat(area[inside] / 3, 3)
        points = points - np.average(points, axis=0, weights=weights)
        total += np.linalg.eigvalsh((points * weights[:, None]).T @ points)[0]
    return total / area.sum()


@pytest.mark.parametrize("options", [{"proxies": 60}, {"detail": 0.01}], ids=str)
def test_regions_are_nearer_to_their_planes(scan, options):
    normals, mixed, distance = (split(scan, metric, **options) for metric in ("normals", "mixed", "distance"))
    assert normals.region_count == mixed.region_count == distance.region_count
    assert planes(scan, mixed) < 0.85 * planes(scan, normals)
    assert planes(scan, distance) < 0.85 * planes(scan, normals)
    assert normals.error < mixed.error < 1.4 * normals.error
    assert (normals.metric, mixed.metric, distance.metric) == ("normals", "mixed", "distance")


def test_it_is_mixed_unless_told_otherwise(scan):
    part = engine.partition(scan, engine.PartitionOptions(proxies=60, threads=1))
    assert part.metric == "mixed"
    assert np.array_equal(part.face_region, split(scan, "mixed", proxies=60).face_region)


def test_other_methods_go_by_normals(scan):
    assert split(scan, "mixed", proxies=20, method="lloyd").metric == "normals"


@pytest.mark.parametrize("metric", ["normals", "mixed", "distance"])
def test_a_cube_comes_out_as_ever(metric):
    part = split(engine.Mesh(*shapes.cube(8)), metric, proxies=6)
    assert part.error < 1e-12


def test_edits_keep_the_metric_and_hardly_move_other_borders(scan):
    part = split(scan, "mixed", proxies=60)
    face = int(np.flatnonzero(part.face_region == 7)[0])
    added = engine.add_proxy(scan, part, face)
    assert added.metric == "mixed"
    back = engine.delete_proxy(scan, added, face)
    assert back.region_count == part.region_count
    assert planes(scan, added) < planes(scan, part)
    assert planes(scan, back) < 1.1 * planes(scan, part)


def test_improving_and_evening_out_keep_it(scan):
    part = split(scan, "mixed", proxies=60)
    for edited in (engine.improve(scan, part), engine.even_borders(scan, part, 0.5)):
        assert edited.metric == "mixed"
        assert planes(scan, edited) < 0.95 * planes(scan, split(scan, "normals", proxies=60))
