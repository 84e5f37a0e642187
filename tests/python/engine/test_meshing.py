"""polygonize: polygons of regions, used like a caller."""

import copy
import itertools

import numpy as np
import pytest

import isimp_engine as engine
import shapes


def polygons(poly):
    return np.split(poly.loops, poly.loop_start[1:])


def simplified(arrays, **options):
    mesh = engine.Mesh(*arrays)
    part = engine.partition(mesh, engine.PartitionOptions(**options))
    return mesh, part, engine.polygonize(mesh, part)


def edge_uses(poly):
    """The number of uses of each directed edge."""
    uses = {}
    for corners in polygons(poly):
        for edge in zip(corners, np.roll(corners, -1), strict=True):
            uses[edge] = uses.get(edge, 0) + 1
    return uses


def check(mesh, part, poly):
    """The promises for every result, and a report that agrees with it."""
    w, q = len(poly.vertices), len(poly.loop_start)
    assert (poly.vertices.dtype, poly.vertices.shape) == (np.float64, (w, 3))
    assert {a.dtype for a in (poly.loops, poly.loop_start, poly.polygon_region, poly.source_vertex)} == {
        np.dtype(np.int32)
    }
    assert (poly.planarity.dtype, poly.planarity.shape, poly.polygon_region.shape) == (np.float64, (q,), (q,))
    assert poly.source_vertex.shape == (w,)
    assert np.isfinite(poly.vertices).all()
    sizes = [len(set(corners)) for corners in polygons(poly)]
    assert [len(corners) for corners in polygons(poly)] == sizes
    assert min(sizes) >= 3
    assert set(poly.loops) == set(range(w))
    assert set(poly.polygon_region) == set(range(part.region_count))
    uses = edge_uses(poly)
    assert set(uses.values()) == {1}, "an edge is used twice in one direction"
    border = [edge for edge in uses if edge[::-1] not in uses]
    report = poly.report
    assert (report["polygons"], report["corners"], report["vertices"]) == (q, len(poly.loops), w)
    assert report["regions"] == part.region_count
    assert report["regions_split"] == sum(np.bincount(poly.polygon_region) > 1)
    assert report["closed"] is (not border)
    assert report["closed"] == mesh.report["closed"]
    assert report["manifold"] is True
    edges = len({frozenset(edge) for edge in uses})
    assert report["euler"] == w - edges + q == mesh.report["euler"]
    assert report["planarity_max"] == pytest.approx(poly.planarity.max())
    assert report["planarity_mean"] <= report["planarity_max"]


@pytest.mark.parametrize(("side", "height", "seed", "proxies"), [(20, 0.3, 0, 133), (30, 0.1, 2, 75)])
def test_a_region_that_its_neighbours_give_more_faces_than_it_has_keeps_its_polygon(side, height, seed, proxies):
    x, y = np.meshgrid(np.arange(side), np.arange(side))
    z = height * np.random.default_rng(seed).standard_normal((side, side))
    first = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    triangles = np.concatenate([first[:, None] + [0, 1, side], first[:, None] + [1, side + 1, side]])
    points = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)
    _, part, poly = simplified((points, triangles.astype(np.int32)), proxies=proxies)
    assert set(poly.polygon_region) == set(range(part.region_count))


@pytest.mark.parametrize("proxies", [4, 12, 60])
@pytest.mark.parametrize("shape", [shapes.cube, shapes.torus, shapes.bumpy, shapes.two_cubes])
def test_the_result_is_sound_and_the_report_true(shape, proxies):
    check(*simplified(shape(), proxies=proxies))


@pytest.mark.parametrize(
    "field", sorted(set(engine.MeshingOptions().as_dict()) - {"flatness_from"})
)  # any number will do
def test_an_option_out_of_its_range_is_named(cube, field):
    part = engine.partition(cube, engine.PartitionOptions(proxies=6))
    with pytest.raises(engine.InvalidInput, match=field.replace("_", ".")):
        engine.polygonize(cube, part, engine.MeshingOptions(**{field: -1}))


def test_flatness_follows_the_tolerance_that_found_the_regions():
    mesh = engine.clean(*shapes.bumpy(60))
    found = engine.partition(mesh, engine.PartitionOptions(detail=0.005))
    given = engine.partition_from(mesh, found.face_region)  # the same regions, without a tolerance
    options = engine.MeshingOptions(flatness_from=10, flatness=0.002)
    loose, tight = engine.polygonize(mesh, found, options), engine.polygonize(mesh, given, options)
    limit = options.flatness * mesh.report["diagonal"]
    assert 2 * found.tolerance > limit
    assert limit < loose.planarity.max() <= 2 * found.tolerance
    assert tight.planarity.max() <= limit
    assert loose.report["polygons"] < tight.report["polygons"]


def test_a_small_window_is_no_triangle():
    """The largest triangle in a rectangle leaves out half of it, which is less than other polygons may.

    Where two of its sides are one region, the window has fewer than four neighbours.
    """
    solid = np.ones((40, 40, 4), bool)
    solid[19:21, 19:21, 3] = False
    vertices, triangles = shapes.voxels(solid)
    mesh = engine.Mesh(vertices, triangles)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    normal, face = np.cross(b - a, c - a), np.arange(len(triangles))
    axis = np.abs(normal).argmax(axis=1)
    plane = np.stack([axis, a[face, axis], normal[face, axis] > 0], 1)
    label = np.unique(plane, axis=0, return_inverse=True)[1].ravel()
    window = np.flatnonzero(np.bincount(label) < 20)
    assert len(window) == 5
    for first, second in itertools.combinations(window, 2):
        region = np.unique(np.where(label == second, first, label), return_inverse=True)[1]
        poly = engine.polygonize(mesh, engine.partition_from(mesh, region.astype(np.int32)))
        assert min(len(corners) for corners in polygons(poly)) >= 4


def reflex_sum(poly):
    """Degrees by which the corners of flat polygons are above 180, all together."""
    ends, total = np.append(poly.loop_start, len(poly.loops)), 0.0
    for begin, end in itertools.pairwise(ends):
        corners = poly.vertices[poly.loops[begin:end], :2]
        into, out = corners - np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0) - corners
        turn = np.arctan2(into[:, 0] * out[:, 1] - into[:, 1] * out[:, 0], (into * out).sum(axis=1))
        total += np.degrees(np.maximum(0, -turn)).sum()
    return total


def test_a_zigzag_without_shape_becomes_straighter():
    mesh = engine.Mesh(*shapes.plane(36))
    x, y, _ = mesh.vertices[mesh.triangles].mean(axis=1).T
    left = x < 0.5 + 0.12 * np.arcsin(np.sin(6 * np.pi * (y + 0.0625)))
    part = engine.partition_from(mesh, np.where(left, 0, 1))
    stays, slides = (
        engine.polygonize(mesh, part, engine.MeshingOptions(chord_tolerance=0.05, reach=reach)) for reach in (0, 0.2)
    )
    assert len(stays.vertices) == len(slides.vertices)
    assert reflex_sum(stays) > 600
    assert reflex_sum(slides) < 0.65 * reflex_sum(stays)


def torn_sheet(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """A wavy or flat sheet without some of its faces."""
    rng = np.random.default_rng(seed)
    n, m = rng.integers(12, 40, 2)
    x, y = np.meshgrid(np.arange(n), np.arange(m), indexing="ij")
    z = rng.choice([0, 0.3, 1]) * np.sin(x / 3) * np.cos(y / 4)
    vertices = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)
    i = (np.arange(n - 1)[:, None] * m + np.arange(m - 1)).ravel()
    triangles = np.concatenate([np.stack([i, i + m, i + m + 1], 1), np.stack([i, i + m + 1, i + 1], 1)])
    return vertices, triangles[rng.random(len(triangles)) > rng.choice([0, 0.02, 0.1, 0.2])]


@pytest.mark.parametrize("method", ["teleport", "lloyd"])
@pytest.mark.parametrize("first", range(0, 60, 20))
def test_every_region_with_an_area_has_a_polygon(method: str, first: int) -> None:
    for seed in range(first, first + 20):
        mesh = engine.clean(*torn_sheet(seed))
        count = int(np.random.default_rng(seed).integers(2, len(mesh.triangles) // 3))
        part = engine.partition(mesh, engine.PartitionOptions(proxies=count, method=method))
        poly = engine.polygonize(mesh, part)
        corners = mesh.vertices[mesh.triangles]
        areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
        for region in np.setdiff1d(np.arange(part.region_count), poly.polygon_region):
            assert areas[part.face_region == region].sum() < 1e-3, f"region {region} of seed {seed}"


@pytest.mark.parametrize("reach", [5e-324, 1e-200, 1e-160])
def test_rims_within_a_length_below_rounding_follow_the_border(reach):
    mesh = engine.Mesh(*shapes.bumpy(20))
    part = engine.partition(mesh, engine.PartitionOptions(proxies=12))
    poly, plain = (engine.polygonize(mesh, part, engine.MeshingOptions(straight_rims=x)) for x in (reach, 0.0))
    assert np.isfinite(poly.vertices).all()
    assert np.array_equal(poly.vertices, plain.vertices)
    assert np.array_equal(poly.loops, plain.loops)


def test_a_mesh_of_the_same_arrays_has_the_same_polygons() -> None:
    vertices, triangles = shapes.bumpy(24)
    rng = np.random.default_rng(3)
    for face in triangles[rng.choice(len(triangles), 60, replace=False)]:
        vertices[face[0]] = (vertices[face[1]] + vertices[face[2]]) / 2
    mesh = engine.clean(vertices, triangles)
    assert mesh.report["turned_edges"] > 20
    one, other = (
        engine.polygonize(each, engine.partition(each, engine.PartitionOptions(proxies=60)))
        for each in (mesh, copy.deepcopy(mesh))
    )
    assert np.array_equal(one.loops, other.loops)
    assert np.array_equal(one.vertices, other.vertices)


def test_corners_stay_at_vertices_in_no_rounds(sheet):
    part = engine.partition(sheet, engine.PartitionOptions(proxies=12))
    poly = engine.polygonize(sheet, part, engine.MeshingOptions(flatten=0, straight_rims=0.0))
    moved = np.asarray(poly.vertices) - np.asarray(sheet.vertices)[poly.source_vertex]
    assert (np.linalg.norm(moved, axis=1) == 0).mean() > 0.5  # the others slide
