"""Edits of round parts: made of regions, divided, released; and their pickles."""

import copy

import numpy as np
import pytest

import isimp_engine as engine
import shapes
from round_meshes import can


@pytest.fixture(scope="module")
def mesh():
    return engine.Mesh(*can())


@pytest.fixture(scope="module")
def part(mesh):
    return engine.partition(mesh, engine.PartitionOptions(detail=0.005, noise=0, curved=True))


def test_a_pickle_keeps_round_parts(mesh, part):
    again = copy.deepcopy(part)  # by its pickle
    assert [dict(p) for p in again.curved] == [dict(p) for p in part.curved]
    face = int(part.region_seed[part.curved[0].regions[0]])
    assert engine.set_segments(mesh, again, face, 9).curved[0].segments == 9


CELL = np.dtype([("proxy", "i4"), ("ring", "i4"), ("segment", "i4")])


def damaged(state):
    """States with one damage of the round parts each, by name."""
    numbers, guided, patches, cells, *rest = state
    held = np.frombuffer(numbers[18], np.uint8)

    def with_cells(**values):
        array = np.frombuffer(cells, CELL).copy()
        first = int(np.flatnonzero(array["proxy"] >= 0)[0])
        for name, value in values.items():
            array[name][first] = value
        return numbers, guided, patches, array.tobytes(), *rest

    def with_patch(at, value):
        return numbers, guided, ((*patches[0][:at], value, *patches[0][at + 1 :]), *patches[1:]), cells, *rest

    def with_held(value):
        return (*numbers[:18], value, *numbers[19:]), guided, patches, cells, *rest

    places, knots = (np.frombuffer(patches[0][k], np.float64) for k in (1, 12))
    yield "no cells", (numbers, guided, patches, b"", *rest)
    yield "cells of another type", (numbers, guided, patches, 3, *rest)
    yield "no patches", (numbers, guided, (), cells, *rest)
    yield "a patch of another type", (numbers, guided, (None,), cells, *rest)
    yield "no held planes", with_held(b"")
    yield "an unknown plane", with_held(np.full_like(held, 9).tobytes())
    yield "the plane of no cell", with_held(np.full_like(held, 4).tobytes())
    yield "a cell of no patch", with_cells(proxy=len(patches))
    yield "a negative patch", with_cells(proxy=-2)
    yield "a ring too many", with_cells(ring=patches[0][11])
    yield "a segment too many", with_cells(segment=patches[0][10])
    yield "a negative segment", with_cells(segment=-1)
    yield "no axis", with_patch(1, (places * 0).tobytes())
    yield "a place that is not finite", with_patch(1, (places * np.nan).tobytes())
    yield "no radius", with_patch(2, float("nan"))
    yield "no profile", with_patch(0, 4)
    yield "no segments", with_patch(10, 0)
    yield "too many segments", with_patch(10, 2**31 - 1)
    yield "too few knots", with_patch(12, knots[1:].tobytes())
    yield "knots in no order", with_patch(12, knots[::-1].tobytes())


def test_a_pickle_of_damaged_round_parts_gives_no_object(mesh, part):
    state = engine.set_segments(mesh, part, int(part.region_seed[part.curved[0].regions[0]]), 8, 2).__getstate__()
    part.__new__(type(part)).__setstate__(state)
    for _, damage in damaged(state):
        with pytest.raises(engine.InvalidInput, match="pickle is damaged"):
            part.__new__(type(part)).__setstate__(damage)


def test_segments_and_explode(mesh, part):
    face = int(part.region_seed[part.curved[0].regions[0]])
    assert engine.regions.round_part_at(mesh, part, face) == 0
    nine = engine.set_segments(mesh, part, face, 9)
    assert nine.region_count == 11
    assert len(nine.curved[0].regions) == 9
    loose = engine.release_round(mesh, nine, face)
    assert loose.curved == []
    assert np.array_equal(loose.face_region, nine.face_region)
    assert engine.regions.round_part_at(mesh, loose, face) is None
    with pytest.raises(engine.InvalidInput, match=f"face {face} is in no round part"):
        engine.set_segments(mesh, loose, face, 9)
    with pytest.raises(engine.InvalidInput, match=r"segments must be in \[3, 256\], got 2"):
        engine.set_segments(mesh, part, face, 2)


def test_regions_are_made_round(mesh):
    plain = engine.partition(mesh, engine.PartitionOptions(detail=0.005, noise=0))
    side = plain.region_seed[np.abs(plain.region_normal[:, 2]) < 0.5]
    round_part = engine.make_round(mesh, plain, side, "cylinder")
    assert round_part.curved[0].kind == "cylinder"
    with pytest.raises(engine.InvalidInput, match="kind must be"):
        engine.make_round(mesh, plain, side, "cube")
    with pytest.raises(engine.InvalidInput, match="no face is given"):
        engine.make_round(mesh, plain, np.zeros(0, np.int32))


@pytest.mark.parametrize(("kind", "seed"), [("cone", 0), ("extrusion", 0), ("cylinder", 1)])
@pytest.mark.parametrize("edit", ["lock_regions", "leave_out_regions"])
def test_round_parts_give_no_faces_to_locked_regions(kind, seed, edit):
    """Small pieces of cells and small rests of regions join neighbours."""
    ring = engine.Mesh(*shapes.torus(14, 10))
    part = engine.partition(ring, engine.PartitionOptions(proxies=6))
    chosen = np.random.default_rng(seed).choice(part.region_count, 2, replace=False)
    others = np.setdiff1d(np.arange(part.region_count), chosen)
    kept = getattr(engine, edit)(ring, part, part.region_seed[others])
    round_part = engine.make_round(ring, kept, part.region_seed[chosen], kind)
    face = int(round_part.region_seed[round_part.curved[0].regions[0]])
    most = 256 if kind != "extrusion" else 120
    for after in (round_part, *(engine.set_segments(ring, round_part, face, n) for n in (8, 16, most))):
        now = [np.unique(after.face_region[part.face_region == region]) for region in others]
        assert all(len(each) == 1 for each in now)
        for region, (own,) in zip(others, now, strict=True):
            assert np.array_equal(after.face_region == own, part.face_region == region)


@pytest.mark.parametrize("count", [2, 3, 4])
def test_faces_at_one_height_of_a_sphere_are_one_ring(count):
    """Rings without a length had planes that were not numbers."""
    corners = [[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]
    upper = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]
    octahedron = engine.Mesh(np.array(corners, float), np.array(upper + [[b, a, 5] for a, b, _ in upper], np.int32))
    part = engine.partition(octahedron, engine.PartitionOptions(proxies=8, noise=0))
    round_part = engine.make_round(octahedron, part, np.arange(count, dtype=np.int32), "sphere")
    for after in (round_part, engine.set_segments(octahedron, round_part, 0, 2, 3)):
        assert after.curved[0].rings == 1
        assert np.allclose(np.linalg.norm(after.region_normal, axis=1), 1)
        assert np.isfinite(after.region_offset).all()
