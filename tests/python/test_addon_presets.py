"""The presets: recipes that can be saved, and that do what they are for."""

import pytest

import shapes
from isimp.presets import BY_NAME, PRESETS
from isimp.recipe import Recipe
from isimp.session import Session
from session_scans import scan_of


def test_there_are_five_with_names_of_their_own():
    assert len(BY_NAME) == len(PRESETS) == 5
    assert [preset.label for preset in PRESETS] == [
        "Photogrammetry figure",
        "Photogrammetry building",
        "Drone / city tile",
        "CAD",
        "Low poly art",
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


def test_a_low_poly_figure_has_fewer_polygons_than_a_figure():
    scan = scan_of(*shapes.torus(120, 60))
    few, many = (Session().replay(scan, BY_NAME[name].recipe).numbers["polygons"] for name in ("low_poly", "figure"))
    assert 0 < 1.5 * few < many
