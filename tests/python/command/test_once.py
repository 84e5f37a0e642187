"""The command computes nothing twice."""

import numpy as np
import pytest

import isimp_engine as engine
import meshfiles
import shapes
from isimp_engine import cli, exporting, repairs
from isimp_engine.exporting import surfaces


@pytest.fixture
def scan(tmp_path):
    vertices, triangles = shapes.cube(8)
    meshfiles.ply_binary(tmp_path / "a.ply", vertices, triangles.tolist())
    return tmp_path / "a.ply"


@pytest.fixture
def calls(monkeypatch):
    """The number of calls of a function of a module."""

    def count(module, name, *others):
        real, made = getattr(module, name), []

        def counted(*arguments, **options):
            made.append(name)
            return real(*arguments, **options)

        for place in (module, *others):
            monkeypatch.setattr(place, name, counted)
        return made

    return count


def test_levels_of_detail_share_one_repaired_mesh(scan, calls, tmp_path):
    cleaned = calls(repairs, "clean")
    assert cli.main(["simplify", str(scan), str(tmp_path / "o.obj"), "--lods", "24,12,6", "--quiet"]) == 0
    assert len(cleaned) == 1


def test_info_repairs_once(scan, calls, capsys):
    cleaned = calls(repairs, "clean")
    assert cli.main(["info", str(scan), "--proxies", "6"]) == 0
    assert len(cleaned) == 1
    assert "would become 6 polygons of 6 regions" in capsys.readouterr().out


@pytest.mark.parametrize("suffix", [".obj", ".city.json"])
def test_surfaces_are_classified_once(scan, calls, tmp_path, suffix):
    found = calls(surfaces, "surfaces_of", exporting, exporting.formats)
    assert cli.main(["simplify", str(scan), str(tmp_path / f"o{suffix}"), "--proxies", "6", "--quiet"]) == 0
    assert len(found) == 1


def test_a_part_of_polygons_uses_its_own_places():
    vertices, triangles = shapes.cube(4)
    mesh = engine.Mesh(vertices, triangles)
    poly = engine.polygonize(mesh, engine.partition(mesh, engine.PartitionOptions(proxies=6)))
    loops = surfaces.rings(poly)
    places, parts = surfaces.part_of(poly, loops, [1, 4])
    assert [len(part) for part in parts] == [4, 4]
    for part, q in zip(parts, (1, 4), strict=True):
        np.testing.assert_array_equal(places[part], poly.vertices[loops[q]])
    assert len(places) == len(set(loops[1]) | set(loops[4]))
