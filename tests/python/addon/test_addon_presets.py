"""The presets: recipes that can be saved, and that serve their purpose."""

import pytest

import shapes
from bench.generators import houses, real_scans, scanned
from isimp.presets import BY_NAME, PRESETS
from isimp.recipe import Recipe
from isimp.session import Session
from session_scans import scan_of


def test_there_are_six_with_names_of_their_own():
    assert len(BY_NAME) == len(PRESETS) == 6
    assert [preset.label for preset in PRESETS] == [
        "Figure",
        "Building",
        "City Tile",
        "CAD",
        "Generated Mesh",
        "Low Poly",
    ]


@pytest.mark.parametrize("preset", PRESETS, ids=BY_NAME)
def test_each_is_a_recipe_that_makes_a_closed_mesh(preset):
    assert Recipe.from_json(preset.recipe.to_json()) == preset.recipe
    assert preset.partition.count_by == "detail"
    outcome = Session().replay(scan_of(*shapes.torus(120, 60)), preset.recipe)
    assert outcome.polygons.report["closed"]
    assert outcome.numbers["regions"] > 20


@pytest.mark.parametrize("preset", [p for p in PRESETS if p.partition.adaptivity == 0], ids=lambda p: p.name)
def test_those_for_planes_find_the_sides_of_a_cube(preset):
    assert Session().replay(scan_of(*shapes.cube(10)), preset.recipe).numbers["regions"] == 6


def test_a_building_is_planar_unless_that_would_cut_more_than_a_tenth():
    clean, noisy = houses.make(0.001, 2), scanned.make(4, 0.004, 1.2)
    recipe = BY_NAME["building"].recipe
    house = Session().replay(scan_of(clean.vertices, clean.triangles), recipe)
    assert house.polygons.report["planar"]
    assert "cut_if_planar" not in house.numbers
    scan = Session().replay(scan_of(*noisy), recipe)
    assert not scan.polygons.report["planar"]
    assert 0.1 < scan.numbers["cut_if_planar"] < 1
    assert scan.numbers["polygons"] < 1.15 * scan.numbers["regions"]


def test_a_low_poly_figure_has_fewer_polygons_than_a_figure():
    scan = scan_of(*shapes.torus(120, 60))
    few, many = (Session().replay(scan, BY_NAME[name].recipe).numbers["polygons"] for name in ("low_poly", "figure"))
    assert 0 < 1.5 * few < many


def test_a_generated_mesh_has_the_planes_of_its_shape():
    """An occupancy grid of a house that is turned against it."""
    outcome = Session().replay(scan_of(*real_scans.grid_house(3, turn=31.0)), BY_NAME["generated"].recipe)
    assert outcome.numbers["repairs"]["smoothed_vertices"] > 0
    assert abs(outcome.numbers["regions"] - real_scans.house_planes(3)) <= 2  # 30 without the preset
