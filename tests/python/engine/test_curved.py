"""Round parts: cylinders, cones, spheres, surfaces of revolution and extrusions as regular segments."""

import copy
import itertools
import json
import tracemalloc

import numpy as np
import pytest

import isimp_engine as engine
import meshfiles
import shapes
from bench.generators import round_shapes
from isimp_engine import cli
from isimp_engine.cli import words
from isimp_engine.dents import dent_rows


def turned(profile, steps=96):
    """A closed solid of revolution around z; profile: (radius, height) from the bottom to the top."""
    profile = np.asarray(profile, float)
    angle = np.arange(steps) * 2 * np.pi / steps
    rho, z = profile.T
    vertices = np.stack(
        [np.outer(rho, np.cos(angle)), np.outer(rho, np.sin(angle)), np.repeat(z[:, None], steps, 1)], -1
    ).reshape(-1, 3)
    i, k = (a.ravel() for a in np.meshgrid(np.arange(len(rho) - 1), np.arange(steps), indexing="ij"))
    a, b = i * steps + k, i * steps + (k + 1) % steps
    c, d = b + steps, a + steps
    last, n = (len(rho) - 1) * steps, len(vertices)
    ends = np.arange(steps)
    after = (ends + 1) % steps
    low, high = np.full(steps, n), np.full(steps, n + 1)
    triangles = np.concatenate(
        [np.stack(t, 1) for t in ((a, b, c), (a, c, d), (low, after, ends), (high, last + ends, last + after))]
    )
    return np.concatenate([vertices, [[0, 0, z[0]], [0, 0, z[-1]]]]), triangles.astype(np.int32)


def star(n=48, radius=1.0, reach=1.8):
    """A sphere with two pipes along each axis, of another radius for each, as a cube's sides with n x n squares."""
    u, v = (x.ravel() for x in np.meshgrid(*[np.linspace(-1, 1, n + 1)] * 2, indexing="ij"))
    ring = np.maximum(np.abs(u), np.abs(v))[:, None]  # a pipe ends at 0.5 and begins at 0.75
    cube = np.stack([u, v, ring[:, 0]], axis=1)
    cube /= np.maximum(np.linalg.norm(cube, axis=1), 1e-9)[:, None]
    k = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    a, b, c, d = (x.ravel() for x in (k[:-1, :-1], k[1:, :-1], k[1:, 1:], k[:-1, 1:]))
    square = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    sides = []
    for turn, pipe in enumerate((0.45, 0.38, 0.31)):
        foot = np.sqrt(radius**2 - pipe**2)
        circle = np.stack([u, v], axis=1) * (pipe / np.maximum(np.hypot(u, v), 1e-9))[:, None]
        share = np.clip(4 * ring - 3, 0, 1)
        ball = (1 - share) * np.c_[circle, np.full(len(u), foot)] + share * radius * cube
        ball *= radius / np.linalg.norm(ball, axis=1)[:, None]
        tube = np.c_[circle * np.minimum(2 * ring, 1), foot + (reach - foot) * np.clip(3 - 4 * ring, 0, 1)]
        side = np.where(ring >= 0.75, ball, tube)
        sides += [np.roll(side * [sign, 1, sign], turn, axis=1) for sign in (1, -1)]
    vertices, number = np.unique(np.round(np.concatenate(sides), 9), axis=0, return_inverse=True)
    return vertices, number.reshape(6, -1)[:, square].reshape(-1, 3).astype(np.int32)


def can(upper=1.0):
    lids = np.arange(1, 8) / 8
    side = np.linspace(0, 1, 41)
    return turned(
        [(r, -1.5) for r in lids]
        + [(1 + (upper - 1) * t, -1.5 + 3 * t) for t in side]
        + [(upper * r, 1.5) for r in lids[::-1]]
    )


def vase():
    lids = np.arange(1, 6) / 6
    z = np.linspace(-2, 2, 60)
    side = 0.9 + 0.35 * np.sin(1.3 * z + 0.4)
    return turned(
        [(r * side[0], -2) for r in lids] + list(zip(side, z, strict=True)) + [(r * side[-1], 2) for r in lids[::-1]]
    )


ROUND = engine.PartitionOptions(detail=0.005, noise=0, curved=True)


@pytest.fixture(scope="module")
def mesh():
    return engine.Mesh(*can())


@pytest.fixture(scope="module")
def part(mesh):
    return engine.partition(mesh, ROUND)


def test_a_can_is_a_prism(part):
    (found,) = part.curved
    assert found.kind == found["kind"] == "cylinder"
    assert abs(found.axis[2]) == pytest.approx(1, abs=1e-6)
    assert found.radius == pytest.approx(1, abs=0.002)
    assert (found.rings, len(found.regions)) == (1, found.segments)
    assert part.report["curved"] == [dict(found)]
    json.dumps(part.report["curved"])
    with pytest.raises(AttributeError):
        found.colour  # noqa: B018


def test_a_can_far_from_zero_has_its_place(part):
    vertices, triangles = can()
    far = engine.partition(engine.Mesh(vertices + [1e6, 0, 0], triangles), ROUND)
    assert far.curved[0].point[0] == pytest.approx(1e6, abs=1e-3)
    assert far.curved[0].segments == part.curved[0].segments


def test_without_the_option_there_are_none(mesh):
    plain = engine.partition(mesh, engine.PartitionOptions(detail=0.005, noise=0))
    assert plain.curved == []
    assert plain.report["curved"] == []


def test_a_vase_is_rings_of_quads():
    mesh = engine.Mesh(*vase())
    plain = engine.partition(mesh, engine.PartitionOptions(detail=0.005, noise=0))
    part = engine.partition(mesh, ROUND)
    (found,) = part.curved
    assert found.kind == "revolution"
    assert found.rings > 1
    assert len(found.regions) == found.segments * found.rings
    assert part.region_count <= 1.08 * plain.region_count + 1
    poly, before = engine.polygonize(mesh, part), engine.polygonize(mesh, plain)
    corners = np.diff(np.append(poly.loop_start, len(poly.loops)))
    cell = np.isin(poly.polygon_region, found.regions)
    assert (corners[cell] == 4).mean() > 0.9
    far, far_before = (engine.within.scan_distances(mesh, p, q).mean() for p, q in ((part, poly), (plain, before)))
    assert far < far_before
    assert poly.report["manifold"]
    assert poly.report["closed"]


@pytest.mark.parametrize("seed", [3, 4])
def test_dents_of_a_wall_are_named_with_place_and_depth(seed):
    shape, vertices, triangles = round_shapes.turned_shape("dented can", seed, 0.002, 44)
    mesh = engine.clean(vertices, triangles)
    part = engine.partition(mesh, engine.PartitionOptions(curved=True))
    (found,) = part.curved
    rows = dent_rows(mesh, part)
    assert [row["part"] for row in rows] == [found.number] * 2
    axis = np.asarray(shape.parts[0].axis)
    for row, depth, height in zip(rows, (0.06, 0.03), (0.3, -0.6), strict=True):
        assert row["depth"] == pytest.approx(depth, abs=0.015)
        assert np.dot(row["place"], axis) == pytest.approx(height, abs=0.3)
        assert 0.001 < row["area_share"] < 0.05


def test_an_even_wall_has_no_dents(mesh, part):
    assert dent_rows(mesh, part) == []


def test_dents_take_no_memory_where_nothing_is_round(sheet):
    part = engine.partition(sheet, engine.PartitionOptions(detail=0.02))
    assert part.tolerance > 0
    tracemalloc.start()
    try:
        assert dent_rows(sheet, part) == []
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < len(sheet.triangles)  # bytes


def test_an_oval_can_is_an_extrusion():
    vertices, triangles = can()
    mesh = engine.Mesh(vertices * [2, 1, 1], triangles)
    plain, part = engine.partition(mesh, engine.PartitionOptions(detail=0.005, noise=0)), engine.partition(mesh, ROUND)
    (found,) = part.curved
    assert (found.kind, found.full, found.rings) == ("extrusion", True, 1)
    assert abs(found.axis[2]) == pytest.approx(1, abs=1e-6)
    assert abs(np.dot(found.axis, found.across)) < 1e-9
    assert found.radius == pytest.approx(2, abs=0.1)  # from a point amid the faces
    assert len(found.regions) == found.segments <= plain.region_count
    assert np.abs(part.region_normal[found.regions] @ found.axis).max() < 1e-9
    poly, before = engine.polygonize(mesh, part), engine.polygonize(mesh, plain)
    corners = np.diff(np.append(poly.loop_start, len(poly.loops)))
    assert (corners[np.isin(poly.polygon_region, found.regions)] == 4).all()
    far, far_before = (engine.within.scan_distances(mesh, p, q).mean() for p, q in ((part, poly), (plain, before)))
    assert far * part.region_count < far_before * plain.region_count
    again = copy.deepcopy(part)
    face = int(part.region_seed[found.regions[0]])
    ten = engine.set_segments(mesh, again, face, 10).curved[0]
    assert (ten.kind, ten.segments, len(ten.regions)) == ("extrusion", 10, 10)
    with pytest.raises(engine.InvalidInput, match=r"segments must be in \[3, 120\], got 121"):
        engine.set_segments(mesh, part, face, 121)
    with pytest.raises(engine.InvalidInput, match=r"rings must be in \[0, 1\], got 2"):
        engine.set_segments(mesh, part, face, 10, 2)
    side = plain.region_seed[np.abs(plain.region_normal[:, 2]) < 0.5]
    assert engine.make_round(mesh, plain, side, "extrusion").curved[0].full


def test_the_wall_of_a_dented_can_is_one_extrusion():
    vertices, triangles = round_shapes.made(round_shapes.extruded()["oval"], 48)
    x, y, z = round_shapes.with_noise(vertices, 0.001, 1).T
    y = y - 0.04 * np.exp(-(z**2) / 0.2) * (np.abs(z) < 1.15) * (y > 0)
    part = engine.partition(engine.clean(np.stack([x, y, z], 1), triangles), engine.PartitionOptions(curved=True))
    assert [patch.kind for patch in part.curved] == ["extrusion"]


@pytest.mark.parametrize(("noise", "share"), [(0.001, 1.0), (0.003, 0.85)])
def test_a_rough_wall_has_fewer_segments(noise, share):
    """The last segments of a noisy wall would bring less than a region had there."""
    vertices, triangles = round_shapes.made(round_shapes.shapes()["capped"])
    mesh = engine.clean(round_shapes.with_noise(vertices, noise, 811), triangles)
    plain, part = (engine.partition(mesh, engine.PartitionOptions(curved=curved)) for curved in (False, True))
    (wall,) = part.curved
    assert wall.kind == "cylinder"
    assert wall.segments == pytest.approx(share * (plain.region_count - 2), abs=2)


def test_few_segments_are_planar_and_keep_the_volume(mesh, part):
    """The planes of six segments meet a tenth of the radius outside the scan."""
    six = engine.set_segments(mesh, part, int(part.region_seed[part.curved[0].regions[0]]), 6)
    for planar in (False, True):
        poly = engine.polygonize(mesh, six, engine.MeshingOptions(planar=planar))
        assert len(poly.loop_start) == 8
        assert poly.planarity.max() < 4e-3
        loops = np.split(np.asarray(poly.loops), np.asarray(poly.loop_start)[1:])
        fans = [(loop[0], a, b) for loop in loops for a, b in itertools.pairwise(loop[1:])]
        a, b, c = np.asarray(poly.vertices)[np.array(fans).T]
        assert (a * np.cross(b, c)).sum() / 6 == pytest.approx(3 * np.pi, rel=0.01)
    assert poly.planarity.max() < 4e-6


@pytest.mark.parametrize(("name", "seed"), [("vase", 1), ("vase", 2), ("capsule", 1)])
def test_cells_of_a_noisy_part_meet_on_their_planes(name, seed):
    vertices, triangles = round_shapes.made(round_shapes.shapes()[name], 40)
    mesh = engine.clean(round_shapes.with_noise(vertices, 0.003, seed), triangles)
    part = engine.partition(mesh, engine.PartitionOptions(curved=True))
    cells = np.concatenate([each.regions for each in part.curved])
    some_corners = {4} | {each.segments for each in part.curved}  # a cap at a pole has as many as there are segments
    poly = engine.polygonize(mesh, part)
    start = np.append(poly.loop_start, len(poly.loops))
    points, corners, region = np.asarray(poly.vertices), np.diff(start), np.asarray(poly.polygon_region)
    for i in np.flatnonzero(np.isin(region, cells)):
        away = (
            points[poly.loops[start[i] : start[i + 1]]] @ part.region_normal[region[i]] - part.region_offset[region[i]]
        )
        assert np.abs(away).max() < 1e-9
        assert corners[i] in some_corners
    planar = engine.polygonize(mesh, part, engine.MeshingOptions(planar=True))
    assert (np.bincount(planar.polygon_region)[cells] == 1).all()


@pytest.mark.parametrize(
    ("name", "seed", "kind"),
    [
        ("fillet", 203, "cylinder"),
        ("moulding", 203, "extrusion"),
        ("moulding", 12, "extrusion"),
        ("soap", 0, "cylinder"),
    ],
)
def test_rounded_edges_stay_cylinders_and_waves_are_extrusions(name, seed, kind):
    if name == "soap":
        _, vertices, triangles = round_shapes.turned_shape(name, 701, 0.003, 48)
    else:
        vertices, triangles = round_shapes.made((round_shapes.shapes() | round_shapes.extruded())[name])
        vertices = round_shapes.with_noise(vertices, 0.001, seed)
    part = engine.partition(engine.clean(vertices, triangles), engine.PartitionOptions(curved=True))
    assert {p.kind for p in part.curved} == {kind}


@pytest.mark.parametrize("seed", [1, 2, 23])
def test_a_torus_is_one_part(seed):
    vertices, triangles = round_shapes.made(round_shapes.shapes()["torus"], 48)
    mesh = engine.clean(round_shapes.with_noise(vertices, 0.001, seed), triangles)
    part = engine.partition(mesh, engine.PartitionOptions(curved=True))
    (found,) = part.curved
    assert found.kind == "revolution"
    assert found.full
    assert np.isin(part.face_region, found.regions).all()


@pytest.mark.parametrize(
    ("name", "seed", "kinds"), [("silo", 11, {"cylinder", "cone"}), ("baluster", None, {"revolution"})]
)
def test_profiles_are_near_all_of_a_joined_part(name, seed, kinds):
    """A cone ends at the axis on its own line; a join keeps the surface that is near more of both parts."""
    shape = round_shapes.shapes()[name]
    clean, triangles = round_shapes.made(shape)
    vertices = clean if seed is None else round_shapes.with_noise(clean, 0.001, seed)
    mesh = engine.clean(vertices, triangles)
    part = engine.partition(mesh, engine.PartitionOptions(curved=True))
    assert {each.kind for each in part.curved} == kinds
    is_round = round_shapes.part_of_faces(shape, clean, triangles)[np.asarray(mesh.source_face)] >= 0
    regions = np.concatenate([each.regions for each in part.curved])
    assert np.isin(part.face_region[is_round], regions).mean() > 0.99


def test_all_segments_of_a_cone_meet_in_its_apex():
    vertices, triangles = round_shapes.made(round_shapes.shapes()["silo"])
    mesh = engine.clean(round_shapes.with_noise(vertices, 0.001, 201), triangles)
    part = engine.partition(mesh, engine.PartitionOptions(curved=True))
    (cone,) = (each for each in part.curved if each.kind == "cone")
    for planar in (False, True):
        poly = engine.polygonize(mesh, part, engine.MeshingOptions(planar=planar))
        corners = np.split(poly.loops, poly.loop_start[1:])
        cells = [set(loop) for loop, region in zip(corners, poly.polygon_region, strict=True) if region in cone.regions]
        assert len(cells) == cone.segments  # each whole
        (apex,) = set.intersection(*cells)
        on_axis = np.asarray(cone.point) - cone.radius / cone.slope * np.asarray(cone.axis)
        assert poly.vertices[apex] == pytest.approx(on_axis, abs=0.002 * mesh.report["diagonal"])
        assert np.mean([len(cell) == 3 for cell in cells]) > 0.7


def test_pipes_and_their_bend_meet_in_shared_corners():
    vertices, triangles = round_shapes.made(round_shapes.shapes()["elbow"], 48)
    mesh = engine.Mesh(round_shapes.with_noise(vertices, 0.001, 1), triangles)
    part = engine.partition(mesh, engine.PartitionOptions(curved=True))
    assert sorted((each["kind"], each["segments"] * each["rings"]) for each in part.curved) == [
        ("cylinder", 9),
        ("cylinder", 9),
        ("revolution", 27),
    ]
    assert engine.polygonize(mesh, part, engine.MeshingOptions(planar=True)).report["whole"] > 0.95
    regular = engine.regularise(mesh, part)  # as one rigid body
    assert any(abs(each.axis[2]) == 1 for each in regular.curved)
    assert not any(abs(each.axis[2]) == 1 for each in part.curved)
    assert [each.radius for each in part.curved] == [each.radius for each in regular.curved]
    for old, new in zip(itertools.permutations(part.curved, 2), itertools.permutations(regular.curved, 2), strict=True):
        was, now = (
            (np.dot(one.axis, other.axis), np.linalg.norm(np.subtract(one.point, other.point)))
            for one, other in (old, new)
        )
        assert now == pytest.approx(was, abs=1e-9)


def test_remains_of_regions_next_to_a_dome_stay_flat():
    vertices, triangles = round_shapes.made(round_shapes.shapes()["dome"], 40)
    mesh = engine.clean(round_shapes.with_noise(vertices, 0.003, 1), triangles)

    def away(curved):
        part = engine.partition(mesh, engine.PartitionOptions(curved=curved))
        return part, engine.within.scan_distances(mesh, part, engine.polygonize(mesh, part))

    part, distances = away(True)
    assert np.nanmean(distances) < np.nanmean(away(False)[1])
    cells = np.concatenate([each.regions for each in part.curved])
    off_polygons = off_planes = 0
    for region in np.setdiff1d(part.face_region, cells):
        some = np.unique(mesh.triangles[part.face_region == region])
        points = mesh.vertices[some] - mesh.vertices[some].mean(0)
        off_polygons += distances[some].mean()
        off_planes += np.abs(points @ np.linalg.svd(points, full_matrices=False)[2][2]).mean()  # the least possible
    assert off_polygons < 1.05 * off_planes


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


def tilted(radius, low, high, degrees, towards, at):
    """A closed cylinder whose axis leans by this angle."""
    lids, side = np.arange(1, 5) / 5, np.linspace(low, high, 17)
    vertices, triangles = turned(
        [(radius * r, low) for r in lids] + [(radius, z) for z in side] + [(radius * r, high) for r in lids[::-1]], 48
    )
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    axis = np.array([s * np.cos(towards), s * np.sin(towards), c])
    x = np.array([c, 0, -axis[0]]) / np.hypot(c, axis[0])
    return vertices @ np.array([x, np.cross(axis, x), axis]) + at, triangles


@pytest.fixture(scope="module")
def columns():
    """Three columns that lean by one to two degrees, the first with a drum above it; noise of .1 % of the diagonal."""
    parts = [
        tilted(1, -1.5, 1.5, 1.5, 0.3, (0, 0, 0)),
        tilted(1.015, -1.5, 1.5, 1, 2, (4, 0, 0)),
        tilted(0.99, -1.5, 1.5, 2, 4, (8, 0, 0)),
        tilted(0.6, 2.2, 3.6, 0.4, 1, (0.03, 0.02, 0)),
    ]
    first = np.cumsum([0] + [len(v) for v, _ in parts])
    vertices = np.concatenate([v for v, _ in parts])
    triangles = np.concatenate([t + n for (_, t), n in zip(parts, first, strict=False)]).astype(np.int32)
    size = np.linalg.norm(np.ptp(vertices, axis=0))
    noise = np.random.default_rng(5).normal(scale=0.001 * size, size=vertices.shape)
    mesh = engine.Mesh(vertices + noise, triangles)
    return mesh, engine.partition(mesh, engine.PartitionOptions(detail=0.005, curved=True))


def distance(mesh, part, patch):
    """Return the root mean square distance of the face centers of a round part from the planes of its cells."""
    middle = mesh.vertices[mesh.triangles].mean(1)
    region = part.face_region
    mine = np.isin(region, patch.regions)
    normal, offset = part.region_normal[region[mine]], part.region_offset[region[mine]]
    return np.sqrt((((normal * (middle[mine] - mesh.origin)).sum(1) - offset) ** 2).mean())


@pytest.mark.parametrize("up", ["z", "none"])
def test_regularise_makes_axes_upright_parallel_coaxial_and_radii_equal(columns, up):
    mesh, part = columns
    before = [dict(p) for p in part.curved]
    assert len({p["radius"] for p in before}) == len(before) == 4
    assert min(np.hypot(*p["axis"][:2]) for p in before) > 0.005
    regular = engine.regularise(mesh, part, engine.RegulariseOptions(length=0.06, up=up))
    found = regular.curved
    axes = np.array([p.axis for p in found])
    assert len({tuple(axis * np.sign(axis[2]) + 0.0) for axis in axes}) == 1
    assert (np.abs(axes[0]).tolist() == [0, 0, 1]) == (up == "z")
    large, (small,) = [p for p in found if p.radius > 0.8], [p for p in found if p.radius < 0.8]
    assert len({p.radius for p in large}) == 1
    near = min(large, key=lambda p: abs(p.point[0]))
    assert np.linalg.norm(np.cross(np.subtract(near.point, small.point), small.axis)) < 1e-12
    kind = "upright" if up == "z" else "parallel"
    names = ("upright", "level", "parallel", "free")
    expected = {name: 4 * (name == kind) for name in names} | {"coaxial": 2, "equal_radii": 3}
    assert regular.regularity["axes"] == expected
    for patch, was in zip(found, part.curved, strict=True):
        cells = np.array(patch.regions)
        assert np.abs(regular.region_normal[cells] @ patch.axis).max() < 1e-15
        assert distance(mesh, regular, patch) < distance(mesh, part, was) + 0.06
    assert [dict(p) for p in part.curved] == before
    polygons = engine.polygonize(mesh, regular, engine.MeshingOptions(planar=True))
    assert (polygons.report["whole"], polygons.report["crossing"], polygons.report["flipped"]) == (1, 0, 0)


def test_regularise_leaves_axes_where_the_scan_would_be_too_far(columns):
    mesh, part = columns
    regular = engine.regularise(mesh, part, engine.RegulariseOptions(length=1e-5))
    assert [dict(p) for p in regular.curved] == [dict(p) for p in part.curved]
    cells = np.concatenate([p.regions for p in part.curved])
    assert np.array_equal(regular.region_normal[cells], part.region_normal[cells])
    assert np.array_equal(regular.region_offset[cells], part.region_offset[cells])
    assert regular.regularity["axes"] == dict.fromkeys(
        ("upright", "level", "parallel", "coaxial", "equal_radii"), 0
    ) | {"free": 4}


def test_the_command_reports_round_parts(tmp_path, capsys):
    scan, report = tmp_path / "can.ply", tmp_path / "report.json"
    meshfiles.ply_ascii(scan, *can())
    options = ["--noise", "0", "--curved", "--report", str(report)]
    assert cli.main(["simplify", str(scan), str(tmp_path / "out.obj"), *options]) == 0
    (found,) = json.loads(report.read_text())["curved"]
    assert found["kind"] == "cylinder"
    assert len(found["regions"]) == found["segments"]
    wide, many = 2 * found["radius"], found["segments"]
    assert f"round: 1 cylinder, diameter {wide:.4g}, {many} segments; 2 planes" in capsys.readouterr().out


@pytest.mark.parametrize("name", ["scan/bunny_69k.ply", "scan/armadillo_86k.ply"])
def test_scans_of_figures_stay_as_they_are(data, name):
    mesh = engine.clean(*engine.read(str(data / name)))
    plain = engine.partition(mesh, engine.PartitionOptions())
    assert np.array_equal(engine.partition(mesh, engine.PartitionOptions(curved=True)).face_region, plain.face_region)


def test_strips_of_a_scanned_can_are_parallel(data):
    mesh = engine.clean(*engine.read(str(data / "real/meat_can_16k.ply")))
    part = engine.partition(mesh, engine.PartitionOptions(curved=True))
    (found,) = part.curved
    poly = engine.polygonize(mesh, part)
    start = np.append(poly.loop_start, len(poly.loops))
    owners = {}
    for i in np.flatnonzero(np.isin(poly.polygon_region, found.regions)):
        loop = poly.loops[start[i] : start[i + 1]]
        for edge in zip(loop, np.roll(loop, -1), strict=True):
            owners.setdefault(frozenset(edge), []).append(i)
    edges = [sorted(edge) for edge, polygons in owners.items() if len(polygons) == 2]
    assert len(edges) == found.segments
    along = np.diff(np.asarray(poly.vertices)[edges], axis=1)[:, 0]
    cosine = np.minimum(np.abs(along @ found.axis) / np.linalg.norm(along, axis=1), 1)
    off_axis = np.sort(np.degrees(np.arccos(cosine)))
    assert off_axis[-4] < 0.1  # the planes at some corners are nearly parallel
    assert off_axis[-1] < 2
    planar = engine.polygonize(mesh, part, engine.MeshingOptions(planar=True))
    assert (np.bincount(planar.polygon_region)[found.regions] == 1).mean() > 0.85


@pytest.mark.parametrize(
    ("made", "why"),
    [
        (lambda: shapes.cube(16), "flat"),
        (lambda: shapes.bumpy(60), "free"),
        (lambda: noisy_cylinder(0.03), "noise"),
    ],
)
def test_the_reason_why_no_round_part_is_found_is_known(made, why):
    result = engine.simplify(made(), curved=True)
    assert not result.partition.curved
    assert result.report["not_round"] == why
    assert words.round_parts([], 6, why).startswith("no round parts found: ")
    assert engine.simplify(made(), curved=True, proxies=6).report["not_round"] in (None, "flat", "free"), (
        "no noise known"
    )


def noisy_cylinder(share):
    vertices, triangles = round_shapes.made(round_shapes.shapes()["capped"])
    return round_shapes.with_noise(vertices, share, 1), triangles


def test_pipes_into_a_sphere_keep_their_own_axes():
    patches = engine.simplify(star(), curved=True, detail=0.007).partition.curved
    found = [(np.argmax(np.abs(p.axis)), p.radius) for p in patches if p.kind == "cylinder"]
    assert len({axis for axis, _ in found}) > 1
    assert all(radius == pytest.approx({2: 0.45, 0: 0.38, 1: 0.31}[axis], rel=0.01) for axis, radius in found)


def test_a_ball_of_few_squares_is_a_sphere_and_a_prism_keeps_its_sides():
    angle = np.linspace(0.02, np.pi - 0.02, 9)
    ball = finer(*turned(np.stack([np.sin(angle), -np.cos(angle)], axis=1), 16))
    assert [p.kind for p in engine.simplify(ball, curved=True, detail=0.0025).partition.curved] == ["sphere"]
    prism = finer(*turned([(1, 0), (1, 1.5)], 16))
    assert engine.simplify(prism, curved=True).partition.region_count == 18


@pytest.mark.parametrize(("sides", "noise", "seed"), [(6, 0.002, 1), (7, 0.002, 2), (7, 0.003, 1), (8, 0.001, 1)])
def test_a_socket_with_flat_sides_stays_planes_under_noise(sides, noise, seed):
    profile = [(0.4, 0), (0.4, 0.5), (0.16, 0.5), (0.06, 0.5), (0.06, 0.35), (0.06, 0.2)]
    vertices, triangles = finer(*turned(profile, sides), 4)
    scan = round_shapes.with_noise(vertices, noise, seed), triangles
    part = engine.simplify(scan, curved=True).partition
    assert not part.curved
    assert part.region_count == 2 * sides + 3


def finer(vertices, triangles, times=2):
    """A mesh whose triangles are split in four, some times."""
    for _ in range(times):
        edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        ends, middle = np.unique(edges, axis=0, return_inverse=True)
        a, b, c = triangles.T
        x, y, z = middle.reshape(-1, 3).T + len(vertices)
        vertices = np.concatenate([vertices, vertices[ends].mean(axis=1)])
        parts = ((a, x, z), (x, b, y), (z, y, c), (x, y, z))
        triangles = np.concatenate([np.stack(part, 1) for part in parts]).astype(np.int32)
    return vertices, triangles
