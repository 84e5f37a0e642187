"""Scans far from zero, as in map coordinates: results lie where the input lay, without loss."""

import pickle

import numpy as np
import pytest

import isimp_engine as engine
import shapes
from isimp_engine.cli import main

OFFSETS = {"UTM": (5e5, 4.6e6, 100.0), "ECEF": (4e6, 6e5, 4.9e6), "5e7": (5e7, 5e7, 5e7)}


def house(size):
    """A rough box of some size, open below."""
    vertices, triangles = shapes.smoothed(*shapes.cube(12), 1)
    rough = vertices + np.random.default_rng(1).normal(0, 0.001, vertices.shape)
    keep = rough[triangles].mean(axis=1)[:, 2] > 0.01
    return size * (rough - 0.5), triangles[keep]


@pytest.mark.parametrize("offset", OFFSETS.values(), ids=OFFSETS)
def test_vertices_are_returned_bit_for_bit(offset):
    vertices, triangles = house(5)
    mesh = engine.clean(vertices + offset, triangles)
    assert (mesh.vertices == (vertices + offset)[mesh.source_vertex]).all()
    assert np.abs(mesh.vertices - mesh.origin).max() < 10
    assert not mesh.vertices.flags.writeable
    assert engine.clean(vertices, triangles).origin == (0, 0, 0)


@pytest.mark.parametrize("size", [5, 20, 200])
@pytest.mark.parametrize("offset", OFFSETS.values(), ids=OFFSETS)
def test_polygons_are_as_many_and_as_sound_as_at_zero(size, offset):
    vertices, triangles = house(size)
    found = []
    for by in ((0, 0, 0), offset):
        mesh = engine.clean(vertices + by, triangles)
        poly = engine.polygonize(mesh, engine.partition(mesh, engine.PartitionOptions(proxies=100)))
        assert poly.report["imperfect"] == []
        found.append((len(poly.loop_start), poly.vertices - by))
        moved = np.linalg.norm(poly.vertices - mesh.vertices[poly.source_vertex], axis=1).max()
        assert moved <= 1.01 * engine.MeshingOptions().reach * mesh.report["diagonal"]
    assert abs(found[1][0] - found[0][0]) <= 0.02 * found[0][0]
    for one, other in ((0, 1), (1, 0)):  # as sets, up to the rounding at the offset
        low, high = found[one][1].min(axis=0), found[one][1].max(axis=0)
        np.testing.assert_allclose(low, found[other][1].min(axis=0), atol=0.02 * size)
        np.testing.assert_allclose(high, found[other][1].max(axis=0), atol=0.02 * size)


@pytest.mark.parametrize("ending", ["obj", "ply"])
def test_files_keep_map_coordinates(tmp_path, ending):
    offset = np.array(OFFSETS["UTM"])
    vertices, triangles = house(5)
    mesh = engine.clean(vertices + offset, triangles)
    poly = engine.polygonize(mesh, engine.partition(mesh, engine.PartitionOptions(proxies=40)))
    path = tmp_path / f"house.{ending}"
    engine.write(path, poly)
    assert (engine.read(path)[0] == poly.vertices).all()


def test_the_command_takes_a_small_building_in_map_coordinates(tmp_path):
    offset = np.array(OFFSETS["UTM"])
    vertices, triangles = house(20)
    scan, out = tmp_path / "scan.obj", tmp_path / "out.obj"
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in vertices + offset]
    lines += [f"f {a} {b} {c}" for a, b, c in triangles + 1]
    scan.write_text("\n".join(lines))
    assert main(["simplify", str(scan), str(out), "--proxies", "300", "--quiet"]) == 0
    placed = engine.read(out)[0] - offset
    assert np.abs(placed).max() < 11


def test_edits_and_lines_take_map_coordinates():
    offset = np.array(OFFSETS["ECEF"])
    vertices, triangles = shapes.plane(8)
    mesh = engine.Mesh(vertices + offset, triangles)
    one = engine.partition(mesh, engine.PartitionOptions(proxies=1))
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    middle = (low + high) / 2
    line = [offset + [middle[0], low[1], 0], offset + [middle[0], high[1], 0]]
    two = engine.split_along(mesh, one, 0, line, direction=(0.0, 0.0, 1.0))
    assert np.bincount(two.face_region).tolist() == [len(triangles) / 2] * 2


def test_a_pickled_mesh_stays_where_it_was():
    offset = np.array(OFFSETS["UTM"])
    vertices, triangles = house(5)
    mesh = engine.clean(vertices + offset, triangles)
    again = pickle.loads(pickle.dumps(mesh))  # noqa: S301
    assert again.origin == mesh.origin
    assert (again.vertices == mesh.vertices).all()
