"""Lines of OBJ files of all kinds, and damaged ones, which are named."""

import numpy as np
import pytest

import isimp_engine as engine
import shapes
from meshfiles import assert_same, read_rows


def lines():
    """The lines of an OBJ file, some of which are skipped."""
    vertices, triangles = shapes.plane(10)
    rows = ["mtllib a.mtl", "o sheet"] + [f"v {x:.17g} {y:.17g} {z:.17g} 0.5 0.5 0.5" for x, y, z in vertices]
    rows += ["vt 0 0", "vn 0 0 1", "", "# faces", "usemtl a"]
    forms = ("{}", "{}/1", "{}//1", "{}/1/1")
    return rows + ["f " + " ".join(forms[k % 4].format(v + 1) for v in face) for k, face in enumerate(triangles)]


def read(tmp_path, rows):
    return read_rows(tmp_path / "a.obj", rows)


@pytest.mark.parametrize(
    ("row", "faces"),
    [
        ("f 1 2 3 4 5", [[0, 1, 2, 3, 4]]),
        ("f -1 -2 -3", [[120, 119, 118]]),
        ("f 1 2 \\\n 3", [[0, 1, 2]]),
        ("f 1 2 3 # 4", [[0, 1, 2]]),
        ("fo 1 2 3", [[0, 1, 2]]),
        ("\tf 1 2 3\rf 3 2 1", [[0, 1, 2], [2, 1, 0]]),
        ("f", [[]]),
        ("f\r", [[]]),
        ("f\v1 2 3", [[0, 1, 2]]),
    ],
)
def test_lines_of_all_kinds_are_read(tmp_path, row, faces):
    rows = lines()
    _, loops, start = read(tmp_path, [*rows, row])
    found = [part.tolist() for part in np.split(loops, start[1:])]
    assert found[-len(faces) :] == faces
    assert len(found) == 200 + len(faces)


@pytest.mark.parametrize(
    ("row", "said"),
    [
        ("v 1 2", 'line 329: expected three coordinates after "v", got ""'),
        ("v 1 x 3", 'line 329: expected three coordinates after "v", got "x"'),
        ("f 1 2 x", 'line 329: expected the number of a vertex .* got "x"'),
        ("f 1 0 2", 'line 329: expected the number of a vertex .* got "0"'),
        ("f 1 2 999", "face 200 .* uses vertex 999, but there are 121 vertices, the first of them 1"),
        ("f 1 2 99999999999", "face 200 .* uses an impossible vertex"),
    ],
)
def test_damage_is_named_with_its_line(tmp_path, row, said):
    rows = lines()
    assert len(rows) == 328
    with pytest.raises(engine.FileError, match=said):
        read(tmp_path, [*rows, row])


def test_a_file_without_a_last_line_end_and_one_without_faces(tmp_path):
    assert_same(read(tmp_path, ["v 1 2 3", "v 4 5 6"])[:1], [np.array([[1, 2, 3], [4, 5, 6]])])
    assert [len(a) for a in read(tmp_path, ["v 1 2 3", "f 1 1 1"])] == [1, 3, 1]
    with pytest.raises(engine.FileError, match='it has no line that begins with "v "'):
        read(tmp_path, ["# nothing"])
