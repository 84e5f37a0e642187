"""The distance of the polygons from the scan, as Mesh in the add-on reports it."""

import re

import numpy as np
import pytest

import shapes
from isimp import messages
from isimp import recipe as rcp
from isimp.session import Session
from session_scans import scan_of


def meshed(vertices, triangles, **partition):
    recipe = rcp.Recipe((rcp.Partition(**partition), rcp.Mesh()))
    return Session().replay(scan_of(vertices, triangles), recipe)


def test_a_flat_sheet_is_not_off_at_all():
    outcome = meshed(*shapes.plane(8), proxies=1)
    assert outcome.numbers["away_max"] == pytest.approx(0, abs=1e-6)
    assert outcome.region_distance == pytest.approx([0], abs=1e-6)


def test_a_single_bump_is_off_by_its_height_where_it_is():
    vertices, triangles = shapes.plane(8)
    top = int(np.linalg.norm(vertices[:, :2] - vertices[:, :2].mean(axis=0), axis=1).argmin())
    vertices[top, 2] = 0.1
    outcome = meshed(vertices, triangles, proxies=1, snap=False, smooth=0.0)
    assert outcome.numbers["away_max"] == pytest.approx(0.1, rel=0.2)
    assert outcome.numbers["away_mean"] < 0.2 * outcome.numbers["away_max"]
    region = outcome.face_region[np.flatnonzero((triangles == top).any(axis=1))[0]]
    assert outcome.region_distance.argmax() == region
    assert outcome.region_distance.max() == pytest.approx(outcome.numbers["away_max"])


def test_more_regions_are_nearer_and_numbers_have_the_reasons_of_divided_polygons():
    few, many = (meshed(*shapes.bumpy(20), proxies=proxies) for proxies in (4, 60))
    assert many.numbers["away_mean"] < 0.5 * few.numbers["away_mean"]
    assert set(few.numbers["split"]) >= {"split_for_holes", "split_for_repair"}
    assert few.numbers["scan"] == many.numbers["scan"] != ""


@pytest.mark.parametrize("planar", [False, True])
def test_the_causes_of_more_polygons_than_regions_add_up(planar):
    vertices, triangles = shapes.plane(12)  # with waves that few regions can't follow
    across = vertices[:, :2] / np.ptp(vertices[:, :2])
    vertices[:, 2] = 0.3 * np.ptp(vertices[:, :2]) * np.sin(15 * across).prod(axis=1)
    step = rcp.Partition(proxies=20, count_by="proxies", snap=False, smooth=0.0, close_openings=False)
    outcome = Session().replay(scan_of(vertices, triangles), rcp.Recipe((step, rcp.Mesh(planar=planar))))
    numbers, said = outcome.numbers, messages.why_more(outcome.numbers)
    more, *causes = [int(number) for number in re.findall(r"\d+", said)]
    assert more == numbers["polygons"] - numbers["regions"] == sum(causes) > 0, said
    assert numbers["split"]["split_for_repair"] > 0
    assert "split because they bend" in said
    assert ("corners cut to keep faces flat" in said) == planar
