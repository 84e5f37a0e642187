"""Planes of regions that are set by hand, on houses whose planes are known."""

import pickle
import re
from pathlib import Path

import numpy as np
import pytest

import isimp_engine as engine
from bench.generators import houses
from isimp_engine import planes
from isimp_engine.exporting.step import given

House = tuple[engine.Mesh, engine.Partition]


@pytest.fixture(scope="module")
def house() -> House:
    made = houses.make(0.002, 3, turn=0.0)
    mesh = engine.Mesh(made.vertices, made.triangles)
    return mesh, engine.partition_from(mesh, made.label.astype(np.int32))


def largest(mesh: engine.Mesh, part: engine.Partition, axis: int) -> list[int]:
    """The regions that face along an axis within ten degrees, the largest first."""
    normal, _, _, area = engine.regions.region_fits(mesh, part)
    facing = np.flatnonzero(abs(normal[:, axis]) > 0.985)
    found: list[int] = facing[np.argsort(-area[facing], kind="stable")].tolist()
    return found


def face_in(part: engine.Partition, region: int) -> int:
    return int(np.flatnonzero(part.face_region == region)[0])


def aligned(house: House, regions: list[int], to: str, **more: object) -> engine.Partition:
    mesh, part = house
    return engine.align_planes(mesh, part, [face_in(part, region) for region in regions], to, **more)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"faces": np.empty(0, np.int32)}, "there is no face"),
        ({"faces": [-1]}, r"face must be in \[0, "),
        ({"to": "flat"}, "to must be one of level, upright, parallel, perpendicular, coplanar, free, got 'flat'"),
        ({"to": "parallel"}, "name faces of two or more"),
        ({"up_direction": (0, 0, 0)}, "up_direction must be a direction"),
        ({"up_direction": (0.0, 1.0)}, "up_direction must have 3 numbers, got 2"),
        ({"length": -1.0}, "length must be a finite length above 0, got -1"),
        ({"length": np.inf}, "length must be a finite length above 0, got inf"),
        ({"length": np.nan}, "length must be a finite length above 0, got nan"),
    ],
)
def test_wrong_use_is_refused(house: House, changes: dict[str, object], message: str) -> None:
    mesh, part = house
    arguments: dict[str, object] = {"faces": [0], "to": "level"} | changes
    with pytest.raises(engine.InvalidInput, match=message):
        engine.align_planes(mesh, part, **arguments)


def test_up_can_be_any_direction(house: House) -> None:
    mesh, part = house
    turned = houses.make(0.002, 3, turn=0.0).vertices[:, [0, 2, 1]] * (1, -1, 1)
    lying = engine.Mesh(turned, np.asarray(mesh.triangles))
    flat = engine.partition_from(lying, np.asarray(part.face_region))
    there = engine.regularise(mesh, part).report
    here = engine.regularise(lying, flat, up_direction=(0, -2, 0)).report
    assert (here["snapped_to"], here["planes"]) == (there["snapped_to"], there["planes"])
    with pytest.raises(engine.InvalidInput, match="up_direction must be a direction"):
        engine.regularise(lying, flat, up_direction=(0, 0, 0))


def test_set_planes_survive_pickling(house: House) -> None:
    mesh, part = house
    wall, other = largest(mesh, part, 0)[0], largest(mesh, part, 1)[0]
    upright = aligned(house, [wall, other], "upright")
    assert np.flatnonzero(upright.region_held == 2).tolist() == sorted([wall, other])
    assert upright.report["snapped_to"]["by_hand"] == 2
    back = pickle.loads(pickle.dumps(upright))  # noqa: S301
    assert back.report == upright.report
    for name in ("region_held", "region_offset", "region_normal"):
        assert np.array_equal(getattr(back, name), getattr(upright, name))


def test_the_values_of_held_planes_are_those_of_the_engine() -> None:
    header = (Path(__file__).parents[3] / "native/include/isimp/partition/partition.h").read_text(encoding="utf-8")
    found = {name: int(value) for name, value in re.findall(r"constexpr std::uint8_t kPlane(\w+) =\s+(\d+);", header)}
    assert found == {"Snapped": planes.SNAPPED, "ByHand": planes.BY_HAND, "Free": planes.FREE, "Round": planes.OF_CELL}
    values = np.arange(5, dtype=np.uint8)
    assert planes.is_held(values).tolist() == [False, True, True, False, True]
    assert planes.is_fixed(values).tolist() == [False, True, True, False, False]


def test_a_step_file_has_no_given_plane_for_a_released_region(house: House) -> None:
    mesh, _ = house
    wall = largest(*house, 0)[0]
    upright = aligned(house, [wall], "upright")
    poly = engine.polygonize(mesh, upright)
    assert given.Given(poly, upright, mesh).held(wall) is not None
    free = engine.align_planes(mesh, upright, [face_in(upright, wall)], "free")
    assert free.region_held[wall] == planes.FREE
    assert given.Given(poly, free, mesh).held(wall) is None
