"""How far the polygons are from the scan, as Mesh in the add-on reports it."""

import numpy as np
import pytest

import shapes
from isimp import recipe as rcp
from isimp.session import Scan, Session


def scan_of(vertices, triangles):
    count = len(triangles)
    return Scan(vertices.astype(np.float32), triangles.astype(np.int32), np.arange(count, dtype=np.int32), count)


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


def test_more_regions_are_nearer_and_the_numbers_say_why_polygons_were_divided():
    few, many = (meshed(*shapes.bumpy(20), proxies=proxies) for proxies in (4, 60))
    assert many.numbers["away_mean"] < 0.5 * few.numbers["away_mean"]
    assert set(few.numbers["split"]) >= {"split_for_holes", "split_for_repair"}
    assert few.numbers["scan"] == many.numbers["scan"] != ""
