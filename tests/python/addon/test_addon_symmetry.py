"""The add-on's report on a scan that mirrors."""

import pytest

import shapes
from isimp.recipe import AddProxy, Mesh, Partition, Recipe
from isimp.session import Session
from session_scans import scan_of


def scan(lump=0.0):
    return scan_of(*shapes.figure(lump=lump))


@pytest.fixture(scope="module")
def figure():
    return scan()


@pytest.mark.parametrize("symmetry", ["x", "found"])
def test_the_numbers_have_the_axis_and_the_mirrored_parts(figure, symmetry):
    step = Partition(proxies=40, symmetry=symmetry)
    regions = Session().replay(figure, Recipe((step,))).numbers
    assert regions["symmetry"] == "X"
    assert 36 <= regions["mirrored_regions"] <= 40
    polygons = Session().replay(figure, Recipe((step, Mesh()))).numbers
    assert polygons["symmetry"] == "X"
    assert 0 < polygons["mirrored_corners"] <= polygons["vertices"]


def test_an_edit_keeps_the_axis_and_not_the_number(figure):
    steps = Partition(proxies=40, symmetry="x"), AddProxy(100)
    numbers = Session().replay(figure, Recipe(steps)).numbers
    assert numbers["symmetry"] == "X"
    assert "mirrored_regions" not in numbers


def test_a_missing_mirror_plane_is_reported():
    lumpy = scan(lump=1.2)
    numbers = Session().replay(lumpy, Recipe((Partition(proxies=300, symmetry="found"),))).numbers
    assert numbers["symmetry"] == "none"
    assert "symmetry" not in Session().replay(lumpy, Recipe((Partition(proxies=300),))).numbers
