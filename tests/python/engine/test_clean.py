"""clean(vertices, triangles): scanners' files become a mesh, each repair counted and located."""

import numpy as np
import pytest

import isimp_engine as engine
import shapes

KEYS = {
    "non_finite_faces",
    "repeated_index_faces",
    "duplicate_faces",
    "welded_vertices",
    "flipped_faces",
    "cut_edges",
    "split_edges",
    "split_vertices",
    "subdivided_edges",
    "turned_edges",
    "unused_vertices",
    "inner_faces",
    "stitched_vertices",
    "smoothed_vertices",
    "filled_holes",
    "cut_handles",
}


def made(mesh):
    """The repairs that were made, with their counts."""
    return {key: count for key, count in mesh.report["repairs"].items() if count}


def check_sound(mesh):
    """Mesh(...) accepts the result of `clean`."""
    again = engine.Mesh(mesh.vertices, mesh.triangles)
    assert again.report["components"] == mesh.report["components"]
    assert (len(mesh.source_face), len(mesh.source_vertex)) == (len(mesh.triangles), len(mesh.vertices))


def test_a_sound_mesh_does_not_change():
    vertices, triangles = shapes.cube()
    mesh = engine.clean(vertices, triangles)
    np.testing.assert_array_equal(mesh.vertices, vertices)
    np.testing.assert_array_equal(mesh.triangles, triangles)
    np.testing.assert_array_equal(mesh.source_face, np.arange(len(triangles)))
    assert set(mesh.report["repairs"]) == set(mesh.report["repaired_at"]) == KEYS
    assert made(mesh) == {}


def test_broken_faces_are_dropped_and_located():
    vertices, triangles = shapes.cube()
    vertices = np.concatenate([vertices, [[np.nan, 0, 0], [5, 5, 5]]])
    triangles = np.concatenate([triangles[:50], [[0, 1, 98], [3, 3, 4]], triangles[50:], triangles[7:8]])
    mesh = engine.clean(vertices, triangles)
    check_sound(mesh)
    assert made(mesh) == {"non_finite_faces": 1, "repeated_index_faces": 1, "duplicate_faces": 1, "unused_vertices": 2}
    where = mesh.report["repaired_at"]
    assert (where["non_finite_faces"], where["repeated_index_faces"]) == ([50], [51])
    assert (where["duplicate_faces"], where["unused_vertices"]) == ([194], [98, 99])
    np.testing.assert_array_equal(mesh.source_face, [*range(50), *range(52, 194)])
    assert mesh.report["closed"]
    for key, count in mesh.report["repairs"].items():
        assert mesh.report[key] == count


@pytest.mark.parametrize("bad", [9, -1, 2**33])
def test_an_index_out_of_range_is_refused_and_named(bad):
    vertices, triangles = shapes.plane(2)
    triangles = triangles.astype(np.int64)
    triangles[3, 1] = bad
    with pytest.raises(engine.InvalidInput, match=f"face 3 uses vertex {bad}, but there are 9 vertices"):
        engine.clean(vertices, triangles)


def test_a_mesh_without_faces_left_is_refused():
    vertices, triangles = shapes.plane(2)
    with pytest.raises(engine.InvalidInput, match="no face"):
        engine.clean(vertices, triangles[:0])
    with pytest.raises(engine.InvalidInput, match=r"no .*face"):
        engine.clean(vertices * np.nan, triangles)
    with pytest.raises(engine.InvalidInput, match=r"vertices must be an array of shape \(V, 3\)"):
        engine.clean(vertices[:, :2], triangles)
    for bad in (-1.0, np.nan, np.inf):
        with pytest.raises(engine.InvalidInput, match="weld"):
            engine.clean(vertices, triangles, engine.CleanOptions(weld=bad))


def test_small_holes_are_covered_on_request():
    vertices, triangles = shapes.cube()
    rest = triangles[(triangles != triangles[0, 0]).all(axis=1)]
    assert not engine.clean(vertices, rest).report["closed"]
    mesh = engine.clean(vertices, rest, engine.CleanOptions(fill_holes=10.0))
    check_sound(mesh)
    assert mesh.report["closed"]
    assert made(mesh) == {"filled_holes": 1, "unused_vertices": 1}
    covers = mesh.source_face < 0
    assert covers.any()
    np.testing.assert_array_equal(mesh.source_face[~covers], np.arange(len(rest)))
    part = engine.partition(mesh, engine.PartitionOptions(proxies=6))
    assert engine.polygonize(mesh, part).report["closed"]


def test_what_nobody_sees_from_outside_goes_if_asked():
    vertices, triangles = shapes.cube(6)
    small = 0.2 * (vertices - vertices.mean(0))
    at = [vertices.mean(0), vertices.mean(0) + [0.25, 0, 0], vertices.max(0), vertices.max(0) + 1]
    placed = [(vertices, triangles), *((small + place, triangles) for place in at)]
    scraps = [(0.1 * vertices[triangles[:2]].reshape(-1, 3) + at[0], np.arange(6).reshape(2, 3))]
    mesh = engine.clean(*shapes.joined(*placed, *scraps), engine.CleanOptions(outside_only=True))
    assert mesh.report["inner_faces"] == 2 * len(triangles) + 2
    assert mesh.report["components"] == 3  # one crosses the surface, another is outside
    kept = np.concatenate([np.arange(len(triangles)), len(triangles) * 3 + np.arange(2 * len(triangles))])
    assert np.array_equal(mesh.source_face, kept)
    assert engine.clean(*shapes.joined(*placed)).report["inner_faces"] == 0


def test_parts_in_an_open_shell_stay():
    vertices, triangles = shapes.cube(6)
    inner = 0.2 * (vertices - vertices.mean(0)) + vertices.mean(0)
    scan = shapes.joined((vertices, triangles[1:]), (inner, triangles))
    assert engine.clean(*scan, engine.CleanOptions(outside_only=True)).report["inner_faces"] == 0
