"""Text PLY files with any line ends, and damaged ones, which are named; and the memory that reading takes."""

import subprocess
import sys

import numpy as np
import pytest

import shapes
from meshfiles import assert_same, read_rows

VERTEX = ("float x", "float y", "float z")
DOUBLES = ("double x", "double y", "double z")
FACE = ("list uchar int vertex_indices",)


def head(vertices, faces, vertex=VERTEX, face=FACE, form="ascii"):
    rows = ["ply", f"format {form} 1.0", f"element vertex {vertices}", *(f"property {p}" for p in vertex)]
    return [*rows, f"element face {faces}", *(f"property {p}" for p in face), "end_header"]


def sheet():
    vertices, triangles = shapes.plane(10)
    places = [f"{x:.17g} {y:.17g} {z:.17g}" for x, y, z in vertices]
    return places, [" ".join(map(str, [3, *face])) for face in triangles.tolist()]


def read(tmp_path, rows):
    return read_rows(tmp_path / "a.ply", rows)


@pytest.mark.parametrize(
    "mend",
    [
        lambda rows: [" ".join(rows)],  # all in one line
        lambda rows: [rows[0].replace(" ", "\n"), *rows[1:]],
        lambda rows: [f"{rows[0]} {rows[1]}", "", *rows[2:]],
        lambda rows: ["\r".join(rows)],
        lambda rows: [f"\t{row.replace(' ', '  ')} " for row in rows],
        lambda rows: [*rows[:-1], rows[-1] + " 5 6 7"],
    ],
)
def test_rows_that_are_no_lines_are_read_too(tmp_path, mend):
    places, faces = sheet()
    rows = head(len(places), len(faces))
    assert_same(read(tmp_path, rows + mend(places + faces)), read(tmp_path, rows + places + faces))


PEAK = """
import sys
import isimp_engine as engine
def peak():
    status = open("/proc/self/status").read().split("VmHWM:")[1]
    return 1024 * int(status.split()[0])
before = peak()
arrays = engine.read(sys.argv[1], threads=2)
print((peak() - before - sum(array.nbytes for array in arrays)) / len(arrays[1]))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="asks Linux for the peak of memory")
@pytest.mark.parametrize("kind", ["binary.ply", "text.ply", "text.obj"])
def test_reading_takes_the_arrays_the_file_and_little_more_memory(tmp_path, kind):
    vertices, triangles = shapes.plane(350)
    path = tmp_path / kind
    if kind == "binary.ply":
        rows = np.zeros(len(triangles), dtype=[("n", "u1"), ("v", "<i4", 3)])
        rows["n"], rows["v"] = 3, triangles
        text = "\n".join([*head(len(vertices), len(triangles), DOUBLES, form="binary_little_endian"), ""]).encode()
        path.write_bytes(text + vertices.astype("<f8").tobytes() + rows.tobytes())
    else:
        is_ply = kind == "text.ply"
        places = [("" if is_ply else "v ") + f"{x:.6f} {y:.6f} {z:.6f}" for x, y, z in vertices.tolist()]
        faces = triangles.tolist() if is_ply else (triangles + 1).tolist()
        faces = [("3" if is_ply else "f") + f" {a} {b} {c}" for a, b, c in faces]
        path.write_text("\n".join((head(len(places), len(faces)) if is_ply else []) + places + faces))
    assert path.stat().st_size > 25 * len(triangles)
    own = {"PYTHONPATH": ":".join(p for p in sys.path if p)}
    done = subprocess.run([sys.executable, "-c", PEAK, str(path)], env=own, capture_output=True, text=True, check=True)
    assert float(done.stdout) < 20 + path.stat().st_size / len(triangles)
