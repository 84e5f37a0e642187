"""partition, add_proxy, delete_proxy: the contract for callers."""

import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import isimp_engine as engine
import shapes
from bench.generators.known_shapes import split_in_four
from bench.quality.shape import borders


def options(**fields):
    return engine.PartitionOptions(**fields)


def normals_and_areas(mesh):
    corners = mesh.vertices[mesh.triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(cross, axis=1)
    return cross / length[:, None], length / 2


def pieces(mesh, faces):
    """The number of connected pieces of a set of faces, across shared edges."""
    faces = {int(f) for f in faces}
    by_edge = {}
    for f in faces:
        a, b, c = mesh.triangles[f]
        for edge in ((a, b), (b, c), (c, a)):
            by_edge.setdefault((min(edge), max(edge)), []).append(f)
    neighbours = {f: set() for f in faces}
    for pair in by_edge.values():
        for f in pair:
            neighbours[f].update(pair)
    count = 0
    while faces:
        count += 1
        stack = [faces.pop()]
        while stack:
            fresh = neighbours[stack.pop()] & faces
            faces -= fresh
            stack += fresh
    return count


def check(mesh, part, regions):
    """All promises of a partition of a mesh without specks."""
    face_region, faces = part.face_region, len(mesh.triangles)
    assert face_region.dtype == np.int32
    assert face_region.shape == (faces,)
    assert part.region_count == regions
    assert set(face_region) == set(range(regions))
    assert part.region_seed.dtype == np.int32
    assert part.region_seed.shape == (regions,)
    np.testing.assert_array_equal(face_region[part.region_seed], np.arange(regions))
    assert part.region_normal.dtype == np.float64
    assert part.region_normal.shape == (regions, 3)
    normal, area = normals_and_areas(mesh)
    for r in range(regions):
        mine = np.flatnonzero(face_region == r)
        assert pieces(mesh, mine) == 1
        mean = (normal[mine] * area[mine, None]).sum(axis=0)
        np.testing.assert_allclose(part.region_normal[r], mean / np.linalg.norm(mean), atol=1e-5)
    error = (area * ((normal - part.region_normal[face_region]) ** 2).sum(axis=1)).sum()
    assert part.error == pytest.approx(error, rel=1e-4, abs=1e-6)
    assert part.history.dtype == np.float64
    assert len(part.history) >= 1
    assert part.error <= part.history.min() * (1 + 1e-9) + 1e-12


def test_exactly_the_requested_number_of_connected_regions(sheet):
    part = engine.partition(sheet, options(proxies=17))
    check(sheet, part, 17)
    assert part.proxies_asked == 17
    assert part.proxies_needed <= 17
    assert (part.parts_left_out, part.area_left_out) == (0, 0.0)


def test_a_closed_part_gets_its_need_and_reports_it():
    mesh = engine.Mesh(*shapes.two_cubes())
    part = engine.partition(mesh, options(proxies=3))
    check(mesh, part, 8)
    assert (part.proxies_asked, part.proxies_needed) == (3, 8)
    assert (part.report["regions"], part.report["proxies_needed"]) == (8, 8)


def test_an_unknown_backend_names_the_known_ones(cube):
    with pytest.raises(engine.InvalidInput, match=r"abacus.*cpu"):
        engine.partition(cube, options(proxies=6, backend="abacus"))


def test_one_mesh_may_be_partitioned_by_several_threads(sheet):
    mesh = engine.Mesh(sheet.vertices, sheet.triangles)
    counts = [20, 200, 2000, 50]
    expected = [engine.partition(sheet, options(proxies=p)).face_region for p in counts]
    with ThreadPoolExecutor(4) as pool:
        parts = list(pool.map(lambda p: engine.partition(mesh, options(proxies=p)), counts * 5))
    for part, faces in zip(parts, expected * 5, strict=True):
        np.testing.assert_array_equal(part.face_region, faces)


def test_the_options_are_those_at_the_call(sheet):
    """Changing them while the engine works changes nothing: they were copied."""
    given = options(proxies=100)
    job = engine.Job()
    results = []
    worker = threading.Thread(target=lambda: results.append(engine.partition(sheet, given, job=job)))
    worker.start()
    given.proxies = 5
    worker.join()
    assert results[0].region_count in (5, 100)
    assert given.proxies == 5


def test_no_region_crosses_a_barrier():
    vertices, triangles = shapes.plane(8)
    mesh = engine.Mesh(vertices, triangles)
    middle = np.flatnonzero(vertices[:, 0] == 0.5)
    barriers = np.stack([middle[:-1], middle[1:]], axis=1)
    part = engine.partition(mesh, options(proxies=2), barriers=barriers)
    left = vertices[triangles].mean(axis=1)[:, 0] < 0.5
    assert len(set(part.face_region[left])) == len(set(part.face_region[~left])) == 1
    assert part.region_count == 2
    more = engine.add_proxy(mesh, part, int(np.flatnonzero(left)[0]))
    assert not set(more.face_region[left]) & set(more.face_region[~left])
    apart = engine.regions.barrier_faces(mesh, more)
    assert apart.shape == (len(barriers), 2)
    assert (left[apart].sum(axis=1) == 1).all()
    shared = [set(triangles[a]) & set(triangles[b]) for a, b in apart]
    assert {frozenset(pair) for pair in barriers} == set(map(frozenset, shared))
    assert engine.regions.barrier_faces(mesh, engine.partition(mesh, options(proxies=2))).shape == (0, 2)


@pytest.mark.parametrize(
    ("guides", "said"),
    [
        ({"weights": np.ones(191)}, "191 weights, but the mesh has 192 faces"),
        ({"weights": np.ones(0)}, "weights is empty"),
        ({"weights": np.full(192, -1.0)}, "weight of face 0 is -1"),
        ({"weights": np.full(192, np.nan)}, "weight of face 0 is .*nan"),
        ({"weights": np.zeros(192)}, "all weights are 0"),
        ({"weights": np.ones((192, 1))}, r"weights must be an array of shape \(F,\) .* got shape \(192, 1\)"),
        ({"weights": np.ones(192, int)}, r"weights must be .* float32 or float64, got shape \(192,\) and int64"),
        ({"barriers": np.array([[0, 97]])}, "barrier 0 runs between vertices 0 and 97"),
        ({"barriers": np.array([[0, 98]])}, "98"),
        ({"barriers": np.array([[0, -1]])}, "-1"),
        ({"barriers": np.array([[0, 2**40]])}, r"barriers\[0\] names 1099511627776"),
        ({"barriers": np.array([0, 1])}, r"barriers must be an array of shape \(K, 2\) and integers"),
        ({"barriers": np.array([[0.0, 1.0]])}, "barriers must be .* float64"),
    ],
)
def test_guides_that_can_not_be_used_are_named(cube, guides, said):
    with pytest.raises(engine.InvalidInput, match=said):
        engine.partition(cube, options(proxies=6), **guides)


@pytest.mark.parametrize("edit", [engine.add_proxy, engine.delete_proxy])
def test_an_edit_at_no_face_names_the_number_of_faces(cube, edit):
    part = engine.partition(cube, options(proxies=6))
    for face in (-1, 192, 2**31 - 1):
        with pytest.raises(engine.InvalidInput, match=rf"{face}.*192|192.*{face}"):
            edit(cube, part, face)
    for face in (1.5, None, "3", True):
        with pytest.raises(engine.InvalidInput, match="face must be an integer, got "):
            edit(cube, part, face)
    with pytest.raises(engine.InvalidInput, match="face must be an integer in"):
        edit(cube, part, 2**31)


@pytest.mark.parametrize(("metric", "rel"), [("normals", 0.05), ("mixed", 0.08)])
def test_borders_are_as_long_on_a_finer_scan(metric, rel):
    mesh = engine.Mesh(*shapes.figure(28, noise=0.004))
    lengths = []
    for _ in range(3):
        part = engine.partition(mesh, engine.PartitionOptions(proxies=200, metric=metric))
        lengths.append(borders(mesh, np.asarray(part.face_region))[0])
        mesh = engine.Mesh(*split_in_four(mesh.vertices, mesh.triangles))
    once, four, sixteen = lengths
    assert four == pytest.approx(once, rel=rel)
    assert sixteen == pytest.approx(four, rel=rel)


def test_faces_that_are_scattered_over_a_large_place_end_the_search_for_details():
    corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0)], float)
    vertices = (corners + 10.0 * np.arange(300)[:, None, None] * (1, 0, 0)).reshape(-1, 3)
    mesh = engine.Mesh(vertices, np.arange(900, dtype=np.int32).reshape(-1, 3))
    options = engine.PartitionOptions(proxies=300, adaptivity=0.5, leave_out=0)
    assert engine.partition(mesh, options).region_count == 300


def error_of(mesh, part, weights=1.0):
    """The sum of weight * area * |n_face - n|^2, n the weighted mean normal of the region, with a bound its plane's."""
    corners = mesh.vertices[mesh.triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(cross, axis=1)
    inside = (part.face_region >= 0) & (length > 0)
    cross, length, region = cross[inside], length[inside], part.face_region[inside]
    weighted = length / 2 * np.broadcast_to(weights, inside.shape)[inside]
    normal, total = cross / length[:, None], np.zeros((part.region_count, 3))
    np.add.at(total, region, normal * weighted[:, None])
    mean = total / np.maximum(np.linalg.norm(total, axis=1), 1e-300)[:, None]
    mean = mean if part.bound is None else part.region_normal
    return (weighted * ((normal - mean[region]) ** 2).sum(axis=1)).sum()


def check_error(mesh, part, weights=1.0):
    assert part.error == pytest.approx(error_of(mesh, part, weights), rel=2e-4)
    every = engine.regions.all_statistics(mesh, part)
    assert part.error == pytest.approx(sum(each["error"] for each in every), rel=1e-9)


def test_the_error_is_by_mean_normals_or_planes_of_a_bound():
    mesh = engine.Mesh(*shapes.bumpy(40))
    check_error(mesh, engine.partition(mesh, options(bound=0.03)))
    part = engine.partition(mesh, options(proxies=20))
    check_error(mesh, part)
    moved = engine.regularise(mesh, part, engine.RegulariseOptions(angle=30, length=0.02))
    assert not np.array_equal(moved.region_normal, part.region_normal)
    assert moved.error == part.error
    tin = engine.Mesh(*shapes.torus(60, 30))
    check_error(tin, engine.partition(tin, options(proxies=40, curved=True)))
    weights = np.linspace(0, 2, len(mesh.triangles))
    check_error(mesh, engine.partition(mesh, options(proxies=20), weights=weights), weights)
    check_error(mesh, engine.partition(mesh, options(bound=0.03), weights=weights), weights)


def test_small_patches_of_openings_do_not_count_in_the_error():
    vertices, triangles = shapes.bumpy(40)
    triangles = np.delete(triangles, [700, 701, 1500, 1501], axis=0)
    mesh = engine.clean(vertices, triangles, engine.CleanOptions(fill_holes=0.5))
    patch = mesh.source_face < 0
    assert mesh.report["filled_holes"] == 2
    check_error(mesh, engine.partition(mesh, options(proxies=20)), ~patch)
    check_error(mesh, engine.partition(mesh, options(detail=0.02)))


@pytest.mark.parametrize("name", ["tin_16k", "brick_16k", "meat_can_16k"])
def test_the_error_of_round_parts_and_patches_of_scans(data, name):
    vertices, triangles = engine.read(data / "real" / f"{name}.ply")
    few = engine.CleanOptions(fill_holes=0.1 * float(np.linalg.norm(np.ptp(vertices, axis=0))))
    mesh = engine.clean(vertices, np.delete(triangles, slice(5000, 5003), axis=0), few)
    patch = mesh.source_face < 0
    assert patch.any()
    check_error(mesh, engine.partition(mesh, options(proxies=60, curved=True)), ~patch)
