"""Mesh(vertices, triangles): accepted and refused input, the messages, and the properties."""

import re

import numpy as np
import pytest

import isimp_engine as engine
import shapes

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=np.float64)
HALVES = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32)


@pytest.mark.parametrize("float_type", [np.float32, np.float64, ">f4", ">f8"])
@pytest.mark.parametrize("int_type", [np.int32, np.int64, ">i4", ">i8"])
def test_accepts_both_sizes_and_byte_orders(float_type, int_type):
    mesh = engine.Mesh(SQUARE.astype(float_type), HALVES.astype(int_type))
    assert (mesh.vertices.dtype, mesh.triangles.dtype) == (np.float64, np.int32)
    np.testing.assert_array_equal(mesh.vertices, SQUARE)
    np.testing.assert_array_equal(mesh.triangles, HALVES)


def test_accepts_any_strides():
    wide = np.zeros((8, 7))
    wide[::2, 1:7:2] = SQUARE
    packed = np.zeros(2, dtype=np.dtype([("flag", "u1"), ("corners", "<i4", 3)]))  # corners begin at odd addresses
    packed["corners"] = HALVES
    for vertices in (SQUARE[::-1][::-1], np.asfortranarray(SQUARE), wide[::2, 1:7:2]):
        np.testing.assert_array_equal(engine.Mesh(vertices, packed["corners"]).vertices, SQUARE)
    np.testing.assert_array_equal(engine.Mesh(SQUARE[::-1], HALVES).vertices, SQUARE[::-1])


def test_accepts_nested_lists_of_the_right_kind():
    assert engine.Mesh(SQUARE.tolist(), HALVES.tolist()).report["faces"] == 2


def test_copies_the_callers_arrays():
    vertices = SQUARE.copy()
    mesh = engine.Mesh(vertices, HALVES)
    vertices[:] = 7
    np.testing.assert_array_equal(mesh.vertices, SQUARE)


@pytest.mark.parametrize(
    ("vertices", "got"),
    [
        (SQUARE[:, :2], "shape (4, 2) and float64"),
        (SQUARE[0], "shape (3,) and float64"),
        (SQUARE[None], "shape (1, 4, 3) and float64"),
        (SQUARE.astype(np.int64), "shape (4, 3) and int64"),
        (SQUARE.astype(np.float16), "shape (4, 3) and float16"),
        (SQUARE.astype(complex), "shape (4, 3) and complex128"),
        (SQUARE.astype(str), "shape (4, 3) and <U32"),
        ("a string", "shape () and <U8"),
        (None, "shape () and object"),
        ([[0, 1], [2]], "a list"),
    ],
)
def test_refuses_other_vertices_and_names_the_shapes(vertices, got):
    wanted = "vertices must be an array of shape (V, 3) and float32 or float64, got "
    with pytest.raises(engine.InvalidInput, match=f"^{re.escape(wanted + got)}$"):
        engine.Mesh(vertices, HALVES)


@pytest.mark.parametrize(
    ("triangles", "got"),
    [
        (HALVES[:, :2], "shape (2, 2) and int32"),
        (HALVES.ravel(), "shape (6,) and int32"),
        (HALVES.astype(float), "shape (2, 3) and float64"),
        (HALVES.astype(bool), "shape (2, 3) and bool"),
        (np.array([[0, 1, 2, 3]]), "shape (1, 4) and int64"),
        (object(), "shape () and object"),
    ],
)
def test_refuses_other_triangles_naming_what_it_got_and_wants(triangles, got):
    wanted = "triangles must be an array of shape (F, 3) and integers, got "
    with pytest.raises(engine.InvalidInput, match=f"^{re.escape(wanted + got)}$"):
        engine.Mesh(SQUARE, triangles)


@pytest.mark.parametrize("kind", ["u1", "u2", "u4", "u8", "i1", "i2", "i4", "i8", ">u4", ">i8"])
def test_indices_of_every_integer_type_are_taken(kind):
    np.testing.assert_array_equal(engine.Mesh(SQUARE, HALVES.astype(kind)).triangles, HALVES)


@pytest.mark.parametrize(("kind", "bad"), [(np.uint64, 2**64 - 1), (np.uint32, 2**32 - 1), (np.uint8, 255)])
def test_an_unsigned_index_out_of_range_is_shown_as_it_is(kind, bad):
    triangles = HALVES.astype(kind)
    triangles[1, 2] = bad
    with pytest.raises(engine.InvalidInput, match=f"face 1 uses vertex {bad}, but there are 4 vertices"):
        engine.Mesh(SQUARE, triangles)


@pytest.mark.parametrize("faces", [np.zeros((0, 3), np.int32), np.zeros((0, 3), np.int64)])
def test_a_mesh_without_faces_is_refused(faces):
    with pytest.raises(engine.InvalidInput, match="no faces"):
        engine.Mesh(SQUARE, faces)
    with pytest.raises(engine.InvalidInput, match="no faces"):
        engine.Mesh(np.zeros((0, 3)), faces)


@pytest.mark.parametrize(
    ("triangles", "said"),
    [
        ([[0, 1, 2], [0, 2, 2]], "face 1 uses vertex 2 twice"),
        ([[0, 1, 2], [0, 3, 2]], "faces 0 and 1 have opposite orientations at the edge of vertices 0 and 2"),
        ([[0, 1, 2], [2, 1, 3], [1, 2, 4]], "edge of vertices 1 and 2 has three or more faces, face 2 among them"),
        ([[0, 1, 2], [0, 3, 4]], "faces of vertex 0 form two or more fans"),
    ],
)
def test_unsound_arrays_are_named_and_the_error_points_to_clean(triangles, said):
    vertices = np.concatenate([SQUARE, [[0.5, 0.5, 1]]])
    with pytest.raises(engine.InvalidInput, match=f"{said}.*clean"):
        engine.Mesh(vertices, np.array(triangles))


def test_the_error_is_a_value_error_of_the_package():
    assert issubclass(engine.InvalidInput, ValueError)
    assert issubclass(engine.FileError, engine.InvalidInput)
    assert not issubclass(engine.Cancelled, ValueError)
    assert engine.InvalidInput.__module__ == "isimp_engine"


def test_a_mesh_keeps_the_callers_order(cube):
    vertices, triangles = shapes.cube()
    np.testing.assert_array_equal(cube.vertices, vertices)
    np.testing.assert_array_equal(cube.triangles, triangles)
    np.testing.assert_array_equal(cube.source_face, np.arange(len(triangles)))
    np.testing.assert_array_equal(cube.source_vertex, np.arange(len(vertices)))


def test_the_report_describes_the_mesh(cube):
    report = cube.report
    assert (report["vertices"], report["faces"], report["components"]) == (98, 192, 1)
    assert report["closed"] is True
    assert (report["border_edges"], report["euler"]) == (0, 2)
    assert report["area"] == pytest.approx(6)
    assert report["diagonal"] == pytest.approx(3**0.5)
    assert report["repairs"] == {}
    sheet = engine.Mesh(*shapes.plane(3)).report
    assert (sheet["closed"], sheet["border_edges"], sheet["border_loops"], sheet["euler"]) == (False, 12, 1, 1)


def test_components_are_numbered_by_first_face():
    mesh = engine.Mesh(*shapes.two_cubes(2))
    np.testing.assert_array_equal(mesh.component, np.repeat([0, 1], 48))
    assert mesh.report["closed_components"] == 2


def test_its_repr_describes_it(cube):
    assert repr(cube) == "<Mesh: 192 faces, 98 vertices, 1 component, closed>"
