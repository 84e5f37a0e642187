"""The planes of regions: where they are, and what is promised of their distances."""

import numpy as np
import pytest

import isimp_engine as engine
import shapes

OFFSETS = {"near": (0, 0, 0), "UTM": (5e5, 4.6e6, 100.0)}


def farthest(mesh: engine.Mesh, part: engine.Partition, some=None) -> float:
    """The largest distance of a vertex from the plane of its region, as the documentation states the plane."""
    faces = np.flatnonzero(part.face_region >= 0)
    if some is not None:
        faces = faces[np.isin(part.face_region[faces], some)]
    region = np.repeat(part.face_region[faces], 3)
    places = mesh.vertices[mesh.triangles[faces].ravel()]
    return float(np.abs((part.region_normal[region] * places).sum(1) - part.region_offset[region]).max())


def rough_house(offset=(0, 0, 0)) -> engine.Mesh:
    """A rough box whose walls are a few degrees off the axes."""
    vertices, triangles = shapes.cube(12)
    rng = np.random.default_rng(5)
    bent = vertices + 0.03 * np.sin(4 * vertices[:, [1, 2, 0]]) + rng.normal(0, 0.004, vertices.shape)
    return engine.clean(10 * bent + offset, triangles)


def can(offset=(0, 0, 0)) -> engine.Mesh:
    vertices, triangles = shapes.cube(24)
    x, y = 2 * vertices[:, :2].T - 1
    square, length = np.maximum(abs(x), abs(y)), np.maximum(np.hypot(x, y), 1e-9)
    round_ = np.stack([x * square / length, y * square / length, 3 * vertices[:, 2]], axis=1)
    return engine.clean(round_ + offset, triangles)


@pytest.mark.parametrize("offset", OFFSETS.values(), ids=OFFSETS)
def test_offsets_are_in_the_callers_coordinates(offset) -> None:
    mesh = rough_house(offset)
    part = engine.partition(mesh, engine.PartitionOptions(bound=0.3))
    assert farthest(mesh, part) == pytest.approx(part.distance_max, abs=1e-8)
    free = engine.partition(mesh, engine.PartitionOptions(proxies=20))
    for held in (engine.regularise(mesh, free), engine.align_planes(mesh, free, [0, 150], "level", length=20)):
        assert farthest(mesh, held) < 2


@pytest.mark.parametrize("offset", OFFSETS.values(), ids=OFFSETS)
def test_planes_beside_round_parts_go_through_their_regions(offset) -> None:
    mesh = can(offset)
    part = engine.partition(mesh, engine.PartitionOptions(proxies=30, curved=True))
    assert len(part.curved) == 1
    assert farthest(mesh, part) < 0.2
    cell = int(np.flatnonzero(np.isin(part.face_region, part.curved[0].regions))[0])
    for changed in (
        engine.release_round(mesh, part, cell),
        engine.set_segments(mesh, part, cell, 12),
        engine.add_proxy(mesh, part, cell),
        engine.regularise(mesh, part),
    ):
        assert farthest(mesh, changed) < 0.5


@pytest.mark.parametrize("bound", [0.1, 0.2, 0.4])
def test_snapped_planes_keep_the_bound(bound: float) -> None:
    mesh = rough_house()
    part = engine.partition(mesh, engine.PartitionOptions(bound=bound))
    found = engine.regularise(mesh, part)
    assert (found.region_held == 1).any()
    assert found.bound == bound
    assert found.distance_max == pytest.approx(farthest(mesh, found), abs=1e-12)
    assert found.distance_max <= bound


def test_planes_that_a_person_sets_drop_the_bound() -> None:
    mesh = rough_house()
    part = engine.partition(mesh, engine.PartitionOptions(bound=0.3))
    aligned = engine.align_planes(mesh, part, [0], "level", length=20)
    assert (aligned.bound, aligned.distance_max) == (None, None)
    mesh = can()
    part = engine.partition(mesh, engine.PartitionOptions(bound=0.1))
    side = np.flatnonzero(np.abs(part.region_normal[part.face_region][:, 2]) < 0.1)
    made = engine.make_round(mesh, part, side)
    assert (made.bound, made.distance_max) == (None, None)


@pytest.mark.parametrize("power", [1, 10, 20, -10, -20])
@pytest.mark.parametrize("shape", [can, rough_house], ids=["can", "house"])
def test_results_do_not_depend_on_the_unit(shape, power: int) -> None:
    mesh = shape()
    scaled = engine.clean(mesh.vertices * 2.0**power, mesh.triangles)
    made = []
    for each, unit in ((mesh, 1.0), (scaled, 2.0**power)):
        for options in ({"proxies": 40}, {"proxies": 40, "curved": True}, {"curved": True}):
            part = engine.partition(each, engine.PartitionOptions(**options))
            snapped = engine.regularise(each, part)
            for some in (part, snapped):
                poly = engine.polygonize(each, some, engine.MeshingOptions(planar=True))
                made.append((some.face_region, some.region_normal, poly.loops, poly.vertices / unit))
            made.append(tuple(np.array([snapped.report[name]]) for name in ("directions", "planes")))
    half = len(made) // 2
    for one, other in zip(made[:half], made[half:], strict=True):
        for a, b in zip(one, other, strict=True):
            assert np.array_equal(a, b)
