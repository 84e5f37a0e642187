"""N-gons through glTF, by FB_ngon_encoding."""

import json

import numpy as np
import pytest

import isimp_engine as engine
import meshfiles
import shapes
from commands import called, ran
from isimp_engine.texturing import ngons


def rings_of(points):
    """Corners of polygons as places, and where each begins."""
    return np.concatenate([np.array(each, float) for each in points]), np.cumsum([0] + [len(e) for e in points[:-1]])


SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
TRIANGLE = [(2, 0, 0), (3, 0, 0), (2, 1, 0)]
ARROW = [(0, 0, 1), (2, -1, 1), (1, 0, 1), (2, 1, 1)]  # only its tip and its notch see all of it
STAR = [(np.cos(a) * r, np.sin(a) * r, 2) for a, r in zip(np.arange(10) * np.pi / 5, [3, 1] * 5, strict=True)]


def encoded(*points):
    places, start = rings_of(points)
    triangles, polygon = engine.regions.triangulate(places, np.arange(len(places)), start)
    return places, start, *ngons.fans(places, start, triangles, polygon)


def areas(places, triangles):
    a, b, c = (places[triangles[:, k]] for k in range(3))
    return np.cross(b - a, c - a)[:, 2] / 2


def test_fans_fill_polygons_and_come_back():
    places, start, triangles, polygon = encoded(SQUARE, TRIANGLE, ARROW)
    assert (areas(places, triangles) > 0).all()
    assert areas(places, triangles).sum() == pytest.approx(1 + 0.5 + 1)
    assert ngons.decoded(triangles).tolist() == polygon.tolist() == [0, 0, 1, 2, 2]
    loops, begin = ngons.rings(triangles, ngons.decoded(triangles))
    assert begin.tolist() == start.tolist()
    for q, ring in enumerate(np.split(loops, begin[1:])):
        wanted = np.arange(len(places))[start[q] :][: len(ring)].tolist()
        assert ring.tolist() in [wanted[k:] + wanted[:k] for k in range(len(wanted))]


def test_a_polygon_that_no_corner_sees_as_a_whole_is_still_drawn_right():
    places, _, triangles, polygon = encoded(STAR, SQUARE)
    shares = areas(places, triangles)
    assert (shares > 0).all()
    whole = sum(x * v - y * u for (x, y, _), (u, v, _) in zip(STAR, STAR[1:] + STAR[:1], strict=True)) / 2
    assert shares[polygon == 0].sum() == pytest.approx(whole)
    found = ngons.decoded(triangles)
    assert found[-1] == found[-2]
    assert len(set(found[polygon == 0])) == (polygon == 0).sum()


@pytest.fixture
def textured(tmp_path):
    """A cube with colours."""
    vertices, triangles = shapes.cube(4)
    x, y, z = vertices.astype(np.float32).T
    grey = np.arange(len(x)).astype(np.uint8)
    columns = {"x": x, "y": y, "z": z, "red": grey, "green": grey, "blue": 255 - grey}
    meshfiles.ply_columns(tmp_path / "cube.ply", columns, [(t,) for t in triangles])
    return tmp_path / "cube.ply"


def test_the_command_writes_and_reads_ngons(textured, tmp_path):
    out, again, report = tmp_path / "out.glb", tmp_path / "again.obj", tmp_path / "r.json"
    ran("simplify", textured, out, "--proxies", "6", "--texture", "64")
    found, _ = meshfiles.of_glb(out.read_bytes())
    assert "FB_ngon_encoding" in found["extensionsUsed"]
    assert all("FB_ngon_encoding" in each["extensions"] for each in found["meshes"][0]["primitives"])
    soup = engine.read_textured(out)
    assert len(soup.triangles) == 12
    assert soup.polygon.tolist() == np.repeat(np.arange(6), 2).tolist()
    ran("simplify", out, again, "--flat", "--report", report)
    told = json.loads(report.read_text())
    assert (told["input"]["faces"], told["input"]["triangles"], told["output"]["polygons"]) == (6, 12, 6)


def test_another_library_reads_the_file(textured, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    out = tmp_path / "out.glb"
    assert called("simplify", textured, out, "--proxies", "6", "--texture", "64").returncode == 0
    (shape,) = trimesh.load(out, process=False).geometry.values()
    assert shape.area == pytest.approx(6.0, rel=1e-5)
    assert ngons.decoded(np.asarray(shape.faces)).max() == 5
