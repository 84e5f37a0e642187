"""Round parts: cylinders, cones, spheres, surfaces of revolution and extrusions as regular segments."""

import copy
import itertools
import json

import numpy as np
import pytest

import isimp_engine as engine
import meshfiles
import shapes
from bench.generators import round_shapes
from isimp_engine import cli
from isimp_engine.cli import words
from isimp_engine.dents import dent_rows
from round_meshes import can, finer, star, tilted, turned, vase

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


def test_an_oval_can_is_an_extrusion():
    vertices, triangles = can()
    mesh = engine.Mesh(vertices * [2, 1, 1], triangles)
    plain, part = engine.partition(mesh, engine.PartitionOptions(detail=0.005, noise=0)), engine.partition(mesh, ROUND)
    (found,) = part.curved
    assert found.kind == "extrusion"
    assert abs(np.dot(found.axis, found.across)) < 1e-9
    assert found.radius == pytest.approx(2, abs=0.1)  # from a point amid the faces
    assert len(found.regions) == found.segments <= plain.region_count
    assert np.abs(part.region_normal[found.regions] @ found.axis).max() < 1e-9
    poly, before = engine.polygonize(mesh, part), engine.polygonize(mesh, plain)
    corners = np.diff(np.append(poly.loop_start, len(poly.loops)))
    assert (corners[np.isin(poly.polygon_region, found.regions)] == 4).all()
    far, far_before = (engine.within.scan_distances(mesh, p, q).mean() for p, q in ((part, poly), (plain, before)))
    assert far * part.region_count < far_before * plain.region_count
    face = int(part.region_seed[found.regions[0]])
    ten = engine.set_segments(mesh, copy.deepcopy(part), face, 10).curved[0]
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
    assert (found["kind"], len(found["regions"])) == ("cylinder", found["segments"])
    wide, many = 2 * found["radius"], found["segments"]
    assert f"round: 1 cylinder, diameter {wide:.4g}, {many} segments; 2 planes" in capsys.readouterr().out


def test_a_scan_of_a_figure_stays_as_it_is(data):
    mesh = engine.clean(*engine.read(str(data / "scan" / "bunny_69k.ply")))
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
    along = np.diff(np.asarray(poly.vertices)[edges], axis=1)[:, 0]
    height = np.linalg.norm(along, axis=1).max()
    assert (np.linalg.norm(along, axis=1) > height / 2).sum() >= found.segments - 1  # a seam parts two of them
    cosine = np.minimum(np.abs(along @ found.axis) / np.linalg.norm(along, axis=1), 1)
    off_axis = np.sort(np.degrees(np.arccos(cosine)))
    assert off_axis[-2] < 0.1
    assert off_axis[-1] < 4  # the planes at the seam are nearly parallel
    planar = engine.polygonize(mesh, part, engine.MeshingOptions(planar=True))
    assert (np.bincount(planar.polygon_region)[found.regions] == 1).mean() > 0.85


@pytest.mark.parametrize(
    ("made", "why"),
    [(lambda: shapes.cube(16), "flat"), (lambda: shapes.bumpy(60), "free"), (lambda: noisy_cylinder(0.03), "noise")],
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
