"""Lines of OBJ files of all kinds, and damaged ones, which are named."""

import numpy as np
import pytest

import shapes
from meshfiles import read_rows


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
