"""read, read_polygons, triangulate, write: every kind of file, and the message for one that can't be read."""

import os
import sys

import numpy as np
import pytest

import isimp_engine as engine
import meshfiles
import shapes
from isimp_engine.source import load

HOUSE = [[0, 0, 0], [2, 0, 0], [2, 2, 0], [1, 3, 0], [0, 2, 0], [3, 0, 0], [3, 2, 0]]  # a gable, and a lean-to
WALLS = [[0, 1, 2, 3, 4], [1, 5, 6, 2], [2, 6, 3]]


def faces(loops, loop_start):
    return [list(map(int, p)) for p in np.split(loops, loop_start[1:])]


@pytest.mark.parametrize("kind", meshfiles.POLYGONS)
def test_polygons_keep_the_files_order_and_number(tmp_path, kind):
    path = tmp_path / kind
    meshfiles.POLYGONS[kind](path, HOUSE, WALLS)
    vertices, loops, loop_start = engine.reading.read_polygons(path)
    assert (vertices.dtype, loops.dtype, loop_start.dtype) == (np.float64, np.int32, np.int32)
    np.testing.assert_array_equal(vertices, HOUSE)
    assert faces(loops, loop_start) == WALLS


@pytest.mark.parametrize("kind", meshfiles.TRIANGLES)
def test_triangles_are_the_same_from_every_kind(tmp_path, kind):
    path = tmp_path / kind
    expected, triangles = shapes.cube(3)
    expected = expected.astype(np.float32).astype(np.float64)  # so that every format can store it
    meshfiles.TRIANGLES[kind](path, expected, triangles.tolist())
    vertices, read = engine.read(str(path))
    assert (vertices.dtype, read.dtype) == (np.float64, np.int32)
    np.testing.assert_array_equal(vertices[read], expected[triangles])
    mesh = engine.Mesh(vertices, read)
    assert mesh.report["closed"]
    assert mesh.report["components"] == 1


@pytest.mark.parametrize("call", [engine.read, engine.reading.read_polygons])
def test_fewer_threads_than_none_are_refused(tmp_path, call):
    path = tmp_path / "a.ply"
    meshfiles.ply_ascii(path, HOUSE, WALLS)
    with pytest.raises(engine.InvalidInput, match="threads must be at least 0, got -1"):
        call(path, threads=-1)


@pytest.mark.parametrize("polygons", [WALLS, [[0, 1, 2], [2, 1, 3]], [[0, 1], [2, 1, 3, 4]]])
def test_the_command_cuts_polygons_as_the_engine_does(tmp_path, polygons):
    path = tmp_path / "a.ply"
    meshfiles.ply_ascii(path, HOUSE, polygons)
    source = load(path, engine.Job())
    triangles, polygon = engine.regions.triangulate(*engine.reading.read_polygons(path))
    assert source.faces == len(polygons)
    assert (source.triangles.dtype, source.polygon.dtype) == (np.int32, np.int32)
    np.testing.assert_array_equal(source.triangles, triangles)
    np.testing.assert_array_equal(source.polygon, polygon)


def test_upper_case_extensions_and_path_objects_are_fine(tmp_path, poly):
    engine.write(tmp_path / "A.PLY", poly)
    assert len(engine.reading.read_polygons(str(tmp_path / "A.PLY"))[2]) == len(poly.loop_start)


def test_returned_arrays_belong_to_the_caller(tmp_path):
    path = tmp_path / "a.ply"
    meshfiles.ply_ascii(path, HOUSE, WALLS)
    vertices, triangles = engine.read(path)
    vertices *= 2
    triangles[:] = triangles[:, ::-1]
    np.testing.assert_array_equal(vertices, np.array(HOUSE) * 2)


def test_n_gons_are_cut_and_name_their_polygon(tmp_path):
    path = tmp_path / "a.obj"
    meshfiles.obj(path, HOUSE, WALLS)
    polygons = engine.reading.read_polygons(path)
    triangles, source = engine.regions.triangulate(*polygons)
    np.testing.assert_array_equal(source, [0, 0, 0, 1, 1, 2])
    np.testing.assert_array_equal(triangles, engine.read(path)[1])
    corners = np.array(HOUSE, float)[triangles]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] / 2
    np.testing.assert_allclose(np.bincount(source, areas), [5, 2, 0.5])


@pytest.mark.parametrize(
    ("arrays", "said"),
    [
        (([[0.0, 0, 0]], [0, 0, 1], [0]), "corner 2 uses vertex 1, but there are 1 vertices"),
        (([[0.0, 0, 0]], [0, 0, -1], [0]), "corner 2 uses vertex -1"),
        (([[0.0, 0, 0]], [0, 0, 0], [1]), "loop_start must rise from 0 .* got 1 for polygon 0"),
        (([[0.0, 0, 0]], [0, 0, 0], np.empty(0, np.int32)), "loop_start is empty, but there are 3 corners"),
        (([[0.0, 0, 0]], [0, 0, 0], [0, 4]), "loop_start must rise from 0 .* 3 corners, got 4 for polygon 1"),
        (([[0.0, 0, 0]], [0, 0, 0], [0, 2, 1]), "got 1 for polygon 2"),
        (([[0.0, 0, 0]], [[0, 0, 0]], [0]), r"loops must be an array of shape \(L,\) and integers, got shape"),
        (([[0.0, 0, 0]], [0, 0, 0], [0.5]), r"loop_start must be an array of shape \(Q,\) .* float64"),
        (([[0.0, 0, 0]], [0, 2**40, 0], [0]), r"loops\[1\] is 1099511627776"),
    ],
)
def test_triangulate_refuses_invalid_polygons(arrays, said):
    with pytest.raises(engine.InvalidInput, match=said):
        engine.regions.triangulate(*arrays)


def test_a_file_without_faces_has_none(tmp_path):
    path = tmp_path / "cloud.ply"
    meshfiles.ply_ascii(path, HOUSE, [])
    vertices, triangles = engine.read(path)
    assert len(vertices) == 7
    assert triangles.shape == (0, 3)
    with pytest.raises(engine.InvalidInput, match="no faces"):
        engine.clean(vertices, triangles)


def broken(tmp_path, name, content):
    path = tmp_path / name
    path.write_bytes(content)
    return path


HEADER = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"


def test_a_missing_file_a_folder_and_an_unknown_kind_are_each_named(tmp_path):
    with pytest.raises(engine.FileError, match=r"absent\.ply"):
        engine.read(tmp_path / "absent.ply")
    (tmp_path / "folder.ply").mkdir()
    with pytest.raises(engine.FileError, match="folder"):
        engine.read(tmp_path / "folder.ply")
    (tmp_path / "mesh.fbx").touch()
    with pytest.raises(engine.FileError, match=r"(?i)obj, .*ply.*glb.*gltf.*stl.*off.*3mf"):
        engine.read(tmp_path / "mesh.fbx")
    with pytest.raises(TypeError):
        engine.read(None)


@pytest.mark.skipif(sys.platform == "win32" or os.geteuid() == 0, reason="root reads everything")
def test_a_file_that_may_not_be_read_is_named(tmp_path):
    path = broken(tmp_path, "locked.ply", HEADER)
    path.chmod(0)
    with pytest.raises(engine.FileError, match=r"locked\.ply"):
        engine.read(path)


@pytest.fixture(scope="module")
def poly():
    mesh = engine.Mesh(*shapes.cube())
    return engine.polygonize(mesh, engine.partition(mesh, engine.PartitionOptions(proxies=12)))


def test_interrupts_while_a_path_or_a_number_is_read_are_passed_on():
    class Interrupted(os.PathLike):
        def __fspath__(self):
            raise KeyboardInterrupt

        __index__ = __float__ = __fspath__

    with pytest.raises(KeyboardInterrupt):
        engine.read(Interrupted())
    with pytest.raises(KeyboardInterrupt):
        engine.PartitionOptions(proxies=Interrupted())
    with pytest.raises(KeyboardInterrupt):
        engine.TextureOptions(gutter=Interrupted())


def test_a_link_where_the_draft_would_be_is_not_followed(tmp_path, poly):
    place, elsewhere = tmp_path / "o.ply", tmp_path / "elsewhere.txt"
    for draft in ("o.ply.part", "o.ply.part2"):
        (tmp_path / draft).symlink_to(elsewhere)  # to nowhere
    engine.write(place, poly)
    assert not elsewhere.exists()
    assert not place.is_symlink()
    np.testing.assert_array_equal(engine.reading.read_polygons(place)[1], poly.loops)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["o.ply", "o.ply.part", "o.ply.part2"]
