"""Parts of a scan up to their necks, and the regions that they get."""

import numpy as np
import pytest

import isimp_engine as engine
from isimp_engine import parts
from isimp_engine import recipe as rcp


def snowman(around=120, rings=240):
    """A ball of radius 1 at the origin and one of .5 on top of it, with a neck of radius .2 at z = .9."""
    z = np.cos(np.linspace(np.pi, 0, rings)) * 1.45 + 0.45
    low, high = 1 - z**2, 0.25 - (z - 1.4) ** 2
    radius = np.sqrt(np.maximum(np.maximum(low, high), np.where((z > 0.8) & (z < 1.2), 0.04, 1e-6)))
    turn = np.linspace(0, 2 * np.pi, around, endpoint=False)
    ring = np.stack([np.cos(turn), np.sin(turn), np.zeros(around)], axis=1)
    at = radius[:, None, None] * ring + z[:, None, None] * np.array([0, 0, 1])
    i, k = (each.ravel() for each in np.meshgrid(np.arange(rings - 1), np.arange(around), indexing="ij"))
    a, b = i * around + k, i * around + (k + 1) % around
    faces = np.concatenate([np.stack([a, b, b + around], axis=1), np.stack([a, b + around, a + around], axis=1)])
    return at.reshape(-1, 3), faces


@pytest.mark.parametrize(("place", "least"), [((0, 0, 1.9), 0.95), ((0.1, 0, 1.89), 0.9)])
def test_a_part_ends_at_its_neck(place, least):
    vertices, triangles = snowman()
    found = parts.Distances(vertices + 100, triangles, tuple(np.add(place, 100)))
    assert found.has_neck
    height = vertices[triangles].mean(axis=1)[:, 2]
    inside = found.inside(1.0)
    assert inside[height > 1.3].mean() >= least
    assert not inside[height < 0.5].any()
    assert found.inside(0.5).sum() < inside.sum() < found.inside(1.5).sum()


def test_without_a_neck_a_part_has_a_usual_area():
    vertices, triangles = snowman()
    ball = triangles[vertices[triangles].mean(axis=1)[:, 2] < 0.5]
    found = parts.Distances(vertices, ball, (0, 0, -1))
    assert not found.has_neck
    highest = vertices[ball].mean(axis=1)[found.inside(1.0)][:, 2].max()
    assert -0.95 < highest < -0.6, "the lowest 6 % of a ball of this height end at -.91"


def test_a_part_reaches_over_the_gap_between_two_pieces():
    vertices, triangles = snowman()
    high = vertices[triangles].mean(axis=1)[:, 2]
    found = parts.Distances(vertices, triangles[np.abs(high - 1.4) > 0.02], (0, 0, 1.8))
    assert np.isfinite(found.away).all()


@pytest.mark.parametrize("away", [0.0, 5e5])
def test_a_recipe_with_a_part_makes_more_regions_there_of_the_same_number(away):
    vertices, triangles = snowman()
    vertices = vertices + away
    counts = []
    for more in ((), ((away, away, away + 1.9, 1.0),)):
        recipe = rcp.Recipe((rcp.Partition(proxies=60, more=more), rcp.Mesh()))
        assert rcp.Recipe.from_json(recipe.to_json()) == recipe
        made = engine.simplify((vertices, triangles), recipe=recipe)
        part, points = made.partition, np.asarray(made.mesh.vertices)
        seeds = points[np.asarray(made.mesh.triangles)[np.asarray(part.region_seed)]].mean(axis=1)
        counts.append((part.region_count, int((seeds[:, 2] > away + 1.05).sum())))
    assert counts[0][0] == counts[1][0] == 60
    assert 1.3 < counts[1][1] / counts[0][1] <= 4


def test_the_part_nearest_to_a_place_loses_its_regions_again():
    step = rcp.Partition(proxies=60, more=((0, 0, 0, 1.0), (0, 0, 5, 2.0)))
    assert step.without_nearest((0, 1, 4)) == ((0, 0, 0, 1.0),)
    assert rcp.Partition().without_nearest((0, 0, 0)) == ()
    with pytest.raises(ValueError, match="4 numbers"):
        rcp.Partition(more=((0, 0, 0),))
