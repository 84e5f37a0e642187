"""The presets: recipes that can be saved, and that serve their purpose."""

from dataclasses import replace

import numpy as np
import pytest
from isimp.recipe.presets import BY_NAME, PRESETS

import shapes
from bench.generators import houses, real_scans, scanned
from isimp import recipe as rcp
from isimp.engine import engine
from isimp.outcome import EXACT
from isimp.recipe import Recipe
from isimp.session import Session
from session_scans import scan_of


def test_there_are_seven_kinds_of_scans_and_a_style():
    assert len(BY_NAME) == len(PRESETS) == 8
    kinds = [preset.label for preset in PRESETS if preset.is_kind]
    assert kinds == ["Statue", "Building", "Room", "Machine Part", "City", "Drawn", "Generated"]
    assert [preset.label for preset in PRESETS if not preset.is_kind] == ["Low Poly"]
    assert len({preset.icon for preset in PRESETS}) == 8


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


def test_polygons_left_bent_are_counted_and_may_be_made_flat():
    building, scan = BY_NAME["building"], scan_of(*scanned.make(4, 0.004, 1.2))
    left = Session().replay(scan, building.recipe)
    bent = np.asarray(left.polygons.planarity) > EXACT * left.numbers["diagonal"]
    assert left.numbers["not_flat"] == bent.sum() > 0
    flat = Session().replay(scan, building.recipe.then(replace(building.mesh, planar_most=1.0)))
    assert "not_flat" not in flat.numbers
    assert flat.polygons.planarity.max() < EXACT * flat.numbers["diagonal"]


def tube(noise):
    """A cylinder of radius 1 and height 2, open at both ends, with noise."""
    around, rings = 120, 40
    turn, height = np.meshgrid(np.arange(around) * 2 * np.pi / around, np.linspace(-1, 1, rings), indexing="ij")
    vertices = np.stack([np.cos(turn), np.sin(turn), height], axis=-1).reshape(-1, 3)
    i, k = (each.ravel() for each in np.meshgrid(np.arange(around), np.arange(rings - 1), indexing="ij"))
    a, b = i * rings + k, (i + 1) % around * rings + k
    faces = np.concatenate([np.stack([a, b, b + 1], axis=1), np.stack([a, b + 1, a + 1], axis=1)])
    return vertices + np.random.default_rng(2).normal(0, noise, vertices.shape), faces


def test_a_scanned_part_has_larger_features_than_a_drawn_one():
    session, cad = Session(), BY_NAME["cad"]
    drawn, scanned_tube = scan_of(*tube(0.0)), scan_of(*tube(0.002))
    assert not session.is_scanned(drawn)
    assert session.is_scanned(scanned_tube)
    assert cad.partition_for(False) == cad.partition
    step = cad.partition_for(True)
    assert (step.detail, step.noise) == (cad.scanned_detail, rcp.Partition().noise)
    outcome = session.replay(scanned_tube, Recipe((step, cad.mesh)))
    (part,) = outcome.numbers["round"]
    assert part[0] == "cylinder"
    assert part[1] == pytest.approx(1, abs=0.01)
    assert outcome.numbers["regions"] == part[2]


def test_a_scanned_tin_is_one_cylinder(data):
    scan, session = scan_of(*engine.read(data / "real" / "tin_16k.ply")), Session()
    cad = BY_NAME["cad"]
    outcome = session.replay(scan, Recipe((cad.partition_for(session.is_scanned(scan)), cad.mesh)))
    (part,) = outcome.numbers["round"]
    assert part[0] == "cylinder"
    assert part[1] == pytest.approx(0.05, abs=0.001)
    assert outcome.numbers["regions"] < 80  # 336 with the settings of a drawn model


def test_a_low_poly_figure_has_fewer_polygons_than_a_figure():
    scan = scan_of(*shapes.torus(120, 60))
    few, many = (Session().replay(scan, BY_NAME[name].recipe).numbers["polygons"] for name in ("low_poly", "figure"))
    assert 0 < 1.5 * few < many


def test_a_generated_mesh_has_the_planes_of_its_shape():
    """An occupancy grid of a house that is turned against it."""
    outcome = Session().replay(scan_of(*real_scans.grid_house(3, turn=31.0)), BY_NAME["generated"].recipe)
    assert outcome.numbers["repairs"]["smoothed_vertices"] > 0
    assert abs(outcome.numbers["regions"] - real_scans.house_planes(3)) <= 2  # 30 without the preset
