"""The examples of docs/python.md work, those with other packages where these are installed."""

import re
from pathlib import Path

import numpy as np
import pytest

import isimp_engine as engine
import meshfiles
import shapes

PAGE = (Path(__file__).resolve().parents[3] / "docs" / "python.md").read_text(encoding="utf-8")
#: (title of the section, code)
EXAMPLES = [
    (part.partition("\n")[0].strip("# "), code)
    for part in re.split(r"^## ", PAGE, flags=re.MULTILINE)
    for code in re.findall(r"^```python\n(.*?)^```", part, re.MULTILINE | re.DOTALL)
]
PACKAGES = {"trimesh": "trimesh", "pyvista": "pyvista", "Open3D": "open3d", "numpy-stl": "stl"}


def test_every_example_is_found():
    assert len(EXAMPLES) == PAGE.count("```python") >= 7
    assert set(PACKAGES) < {title for title, _ in EXAMPLES}


@pytest.mark.parametrize(("title", "code"), EXAMPLES, ids=[title for title, _ in EXAMPLES])
def test_an_example_runs(title, code, tmp_path, monkeypatch):
    vertices, triangles = shapes.bumpy(20)
    meshfiles.ply_binary(tmp_path / "scan.ply", vertices, triangles.tolist())
    meshfiles.stl_binary(tmp_path / "scan.stl", vertices, triangles.tolist())
    monkeypatch.chdir(tmp_path)
    if title in PACKAGES:
        pytest.importorskip(PACKAGES[title], exc_type=ImportError)  # a library of the system may be missing
    made = {}
    exec(compile(code, "docs/python.md", "exec"), made)  # noqa: S102 (that is the point)
    if title not in PACKAGES:
        return
    wanted = engine.simplify(tmp_path / ("scan.stl" if title == "numpy-stl" else "scan.ply"), proxies=40)
    assert wanted.partition.region_count == 40
    if title != "numpy-stl":  # np.unique sorts the vertices
        np.testing.assert_array_equal(made["poly"].loops, wanted.polygons.loops)
        np.testing.assert_allclose(made["poly"].vertices, wanted.polygons.vertices, rtol=1e-6)
    assert len(made["poly"].loop_start) == pytest.approx(len(wanted.polygons.loop_start), rel=0.1)
