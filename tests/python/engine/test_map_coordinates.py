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


def test_a_pickled_mesh_stays_where_it_was():
    offset = np.array(OFFSETS["UTM"])
    vertices, triangles = house(5)
    mesh = engine.clean(vertices + offset, triangles)
    again = pickle.loads(pickle.dumps(mesh))  # noqa: S301
    assert again.origin == mesh.origin
    assert (again.vertices == mesh.vertices).all()
