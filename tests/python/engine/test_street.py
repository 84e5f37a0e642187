"""Windows and walls of a generated street: a cheap share of bench/quality/street.py."""

import numpy as np
import pytest

import isimp_engine as engine
from bench.generators import houses
from bench.quality import street as bench


@pytest.fixture(scope="module")
def rows():
    """Rows of three houses, 65,760 faces: unchanged, and with snapped planes and planar polygons."""
    return bench.Judge(houses.street(3)).rows()


def test_windows_of_a_street_are_quads(rows):
    for row in rows:
        assert row["window_quads"] >= 0.94 * row["windows"]
        assert (row["reveal_quads"], row["triangles"], row["defects"]) == (row["reveals"], 0, 0)


def test_planes_of_a_street_stay_and_its_polygons_whole(rows):
    _, planar = rows
    assert planar["whole"] >= 0.995
    assert planar["let_go"] == 0
    assert planar["polygons"] <= 1.04 * planar["regions"]


def test_true_faces_of_a_street_are_distinguished():
    judge = bench.Judge(houses.street(1))
    assert judge.part.max() + 1 == 114
    part = engine.partition_from(judge.mesh, judge.part.astype(np.int32))
    found = judge.rectangles(np.asarray(part.face_region), engine.polygonize(judge.mesh, part))
    assert (found["windows"][0], found["reveals"][0]) == (77, 29)
