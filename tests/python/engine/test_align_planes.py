"""Planes of regions that are set by hand, on houses whose planes are known."""

import pickle

import numpy as np
import pytest

import isimp_engine as engine
from bench.generators import houses

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


def test_planes_are_set_exactly(house: House) -> None:
    mesh, part = house
    wall, other = largest(mesh, part, 0)[0], largest(mesh, part, 1)[0]
    floor = largest(mesh, part, 2)[0]
    level = aligned(house, [floor], "level")
    assert abs(level.region_normal[floor, 2]) == 1
    assert level.region_held.tolist() == [2 if region == floor else 0 for region in range(part.region_count)]
    upright = aligned(house, [wall, other], "upright")
    assert np.abs(upright.region_normal[[wall, other], 2]).max() < 1e-12
    square = engine.align_planes(mesh, upright, [face_in(part, wall), face_in(part, other)], "perpendicular")
    assert abs(square.region_normal[wall] @ square.region_normal[other]) < 1e-12
    assert np.array_equal(square.region_normal[wall], upright.region_normal[wall])
    walls = largest(mesh, part, 0)[:2]
    parallel = aligned(house, walls, "parallel")
    assert abs(parallel.region_normal[walls[0]] @ parallel.region_normal[walls[1]]) > 1 - 1e-12
    assert {"by_hand": 2}.items() <= parallel.report["snapped_to"].items()


def test_coplanar_regions_get_one_plane(house: House) -> None:
    mesh, part = house
    wall = largest(mesh, part, 0)[0]
    split = engine.split_region(mesh, part, face_in(part, wall))
    first, second = face_in(part, wall), face_in(split, split.region_count - 1)
    one = engine.align_planes(mesh, split, [first, second], "coplanar")
    a, b = one.face_region[[first, second]]
    assert a != b
    assert np.abs(one.region_normal[a] - one.region_normal[b]).max() < 1e-12
    assert one.region_offset[a] == pytest.approx(one.region_offset[b], abs=1e-12)


def test_what_needs_more_than_is_allowed_is_refused_with_both_numbers(
    house: House,
) -> None:
    mesh, part = house
    wall = largest(mesh, part, 0)[0]
    up = (0.3, 0.0, 1.0)
    normal, _, spread, _ = engine.regions.region_fits(mesh, part)
    wanted = normal[wall] - np.array(up) * (normal[wall] @ up) / (np.array(up) @ up)
    wanted /= np.linalg.norm(wanted)
    adds = np.sqrt(wanted @ spread[wall] @ wanted - normal[wall] @ spread[wall] @ normal[wall])
    message = f"the region of face {face_in(part, wall)} needs {adds:.4g}, allowed 0.001"
    with pytest.raises(engine.InvalidInput, match=message):
        aligned(house, [wall], "upright", up_direction=up, length=0.001)
    within = aligned(house, [wall], "upright", up_direction=up, length=1.01 * adds)
    assert abs(within.region_normal[wall] @ up) < 1e-12


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


def test_regularise_keeps_planes_set_by_hand_and_leaves_freed_ones(
    house: House,
) -> None:
    mesh, part = house
    wall, other, floor = largest(mesh, part, 0)[0], largest(mesh, part, 1)[0], largest(mesh, part, 2)[0]
    lead = aligned(house, [wall], "upright", up_direction=(0.0, 0.02, 1.0))
    lead = engine.align_planes(mesh, lead, [face_in(part, floor)], "free")
    snapped = engine.regularise(mesh, lead)
    assert np.array_equal(snapped.region_normal[wall], lead.region_normal[wall])
    assert snapped.region_offset[wall] == lead.region_offset[wall]
    assert snapped.region_held[[wall, floor]].tolist() == [2, 3]
    assert snapped.region_held[other] == 1
    held = np.flatnonzero(snapped.region_held == 1)
    assert len(held) > 0.8 * part.region_count


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


def test_set_planes_survive_pickling_and_edits_elsewhere(house: House) -> None:
    mesh, part = house
    wall, other = largest(mesh, part, 0)[0], largest(mesh, part, 1)[0]
    upright = aligned(house, [wall, other], "upright")
    back = pickle.loads(pickle.dumps(upright))  # noqa: S301
    assert back.report == upright.report
    for name in ("region_held", "region_offset", "region_normal"):
        assert np.array_equal(getattr(back, name), getattr(upright, name))
    floor = largest(mesh, part, 2)[0]
    edited = engine.split_region(mesh, upright, face_in(part, floor))
    for region in (wall, other):
        now = edited.face_region[face_in(part, region)]
        assert edited.region_held[now] == 2
        assert np.array_equal(edited.region_normal[now], upright.region_normal[region])
    anew = engine.guided.partition_guided(
        mesh,
        engine.PartitionOptions(proxies=3),
        None,
        engine.guided.Guides(faces=np.flatnonzero(part.face_region == floor), before=upright),
    )
    assert anew.region_held[anew.face_region[face_in(part, wall)]] == 2


def test_polygons_keep_to_set_planes(house: House) -> None:
    mesh, part = house
    wall = largest(mesh, part, 0)[0]
    upright = aligned(house, [wall], "upright")
    poly = engine.polygonize(mesh, upright, engine.MeshingOptions(planar=True))
    for polygon in np.flatnonzero(poly.polygon_region == wall):
        loop = np.split(poly.loops, poly.loop_start[1:])[polygon]
        off = (poly.vertices[loop] - mesh.origin) @ upright.region_normal[wall] - upright.region_offset[wall]
        assert np.abs(off).max() < 1e-6 * mesh.report["diagonal"]
