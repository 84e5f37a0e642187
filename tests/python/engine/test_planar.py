"""Exactly planar polygons and snapped planes, on houses whose planes are known."""

import json
import pathlib
import pickle

import numpy as np
import pytest

import isimp_engine as engine
import meshfiles
import shapes
from bench.generators import houses, known_shapes, scanned
from isimp_engine.cli import main
from isimp_engine.within import scan_distances


def bends(poly: engine.PolygonMesh) -> float:
    """The largest distance of a corner, rounded to float32, from the best plane of its polygon."""
    at = np.asarray(poly.vertices) - np.asarray(poly.vertices).mean(0)
    at = at.astype(np.float32).astype(float)
    most = 0.0
    for loop in np.split(poly.loops, poly.loop_start[1:]):
        points = at[loop] - at[loop].mean(0)
        normal = np.linalg.svd(points, full_matrices=False)[2][2]
        most = max(most, float(np.abs(points @ normal).max()))
    return most


def made(house: houses.House) -> tuple[engine.Mesh, engine.Partition]:
    mesh = engine.Mesh(house.vertices, house.triangles)
    return mesh, engine.partition_from(mesh, house.label.astype(np.int32))


@pytest.mark.parametrize(
    ("seeds", "noise", "rounding", "whole", "faces"),
    [((2, 3), 0.002, 0.8, 0.88, 1.28), ((4, 5), 0.004, 1.2, 0.69, 2.1)],
)
def test_scans_as_of_photographs_are_cut_little(
    seeds: tuple[int, ...], noise: float, rounding: float, whole: float, faces: float
) -> None:
    distances = []
    for seed in seeds:
        mesh = engine.clean(*scanned.make(seed, noise, rounding))
        part = engine.partition(mesh, engine.PartitionOptions(proxies=300))
        before = engine.polygonize(mesh, part)
        poly = engine.polygonize(mesh, part, engine.MeshingOptions(planar=True))
        assert poly.report["planar"] is True
        assert poly.report["whole"] >= whole
        assert len(poly.loop_start) <= faces * len(before.loop_start)
        for key in ("crossing", "flipped", "intersecting", "closed", "manifold", "euler"):
            assert poly.report[key] == before.report[key], key
        by_normals = engine.partition(mesh, engine.PartitionOptions(proxies=300, metric="normals"))
        bent = engine.polygonize(mesh, by_normals)
        distances.append([scan_distances(mesh, p, q).mean() for p, q in ((by_normals, bent), (part, poly))])
    with_bends, planar = np.sum(distances, axis=0)
    assert planar <= 1.03 * with_bends  # bent polygons of regions by normals alone are further off


def test_polygons_of_a_curve_without_noise_stay_as_near_to_it() -> None:
    vertices, triangles = shapes.plane(60)
    vertices = np.asarray(vertices, float) / np.ptp(vertices, axis=0).max()
    vertices[:, 2] = np.sqrt(0.5 - (vertices[:, 0] - 0.5) ** 2)
    mesh = engine.Mesh(vertices, triangles)
    part = engine.partition(mesh, engine.PartitionOptions(proxies=100))
    before = scan_distances(mesh, part, engine.polygonize(mesh, part))
    poly = engine.polygonize(mesh, part, engine.MeshingOptions(planar=True))
    after = scan_distances(mesh, part, poly)
    assert poly.report["planar"] is True
    assert after.mean() <= 1.05 * before.mean()
    assert np.quantile(after, 0.99) <= 1.25 * np.quantile(before, 0.99)


@pytest.mark.parametrize(("name", "most"), [("nasty/lionstatue_63k_misoriented", 130), ("scan/bunny_69k", 150)])
def test_cuts_and_splits_that_became_needless_are_taken_back(data: pathlib.Path, name: str, most: int) -> None:
    """Else there are 139 and 166 polygons."""
    mesh = engine.clean(*engine.read(data / f"{name}.ply"))
    part = engine.partition(mesh, engine.PartitionOptions(proxies=100))
    before = engine.polygonize(mesh, part)
    poly = engine.polygonize(mesh, part, engine.MeshingOptions(planar=True))
    assert poly.report["planar"] is True
    assert bends(poly) <= 1e-6 * np.linalg.norm(np.ptp(mesh.vertices, axis=0))
    assert before.report["polygons"] <= poly.report["polygons"] <= most
    for key in ("crossing", "flipped", "bent", "intersecting", "closed", "manifold", "euler"):
        assert poly.report[key] == before.report[key], key


def test_it_is_left_off_where_it_would_cut_more_than_is_allowed() -> None:
    mesh = engine.clean(*scanned.make(4, 0.004, 1.2))
    snapped = engine.regularise(mesh, engine.partition(mesh, engine.PartitionOptions(proxies=150)))
    exact, without = (engine.polygonize(mesh, snapped, engine.MeshingOptions(planar=on)) for on in (True, False))
    cut = 1 - exact.report["whole"]
    assert cut > 0.1
    assert exact.report["planar"] is True
    assert exact.report["left_off"] is False
    left = engine.polygonize(mesh, snapped, engine.MeshingOptions(planar=True, planar_most=0.1))
    assert left.report["left_off"] is True
    assert left.report["planar"] is False
    assert 1 - left.report["whole"] == cut
    assert left.report["faces_added"] == 0
    for name in ("vertices", "loops", "loop_start", "polygon_region"):
        assert np.array_equal(getattr(left, name), getattr(without, name)), name
    assert pickle.loads(pickle.dumps(left)).report == left.report  # noqa: S301
    allowed = engine.polygonize(mesh, snapped, engine.MeshingOptions(planar=True, planar_most=cut))
    assert allowed.report["left_off"] is False
    assert np.array_equal(allowed.vertices, exact.vertices)


def test_a_house_has_five_directions() -> None:
    house = houses.make(0.002, 3)
    mesh, part = made(house)
    snapped = engine.regularise(mesh, part, engine.RegulariseOptions(angle=8.0, length=None, up="z"))
    truth = len({tuple(np.round(n * np.sign(n[np.argmax(abs(n))]), 6)) for n in normals(house)})
    assert snapped.report["directions"] == truth == 5
    assert snapped.report["rms_added"] <= 0.1 * snapped.report["rms"]
    assert np.array_equal(snapped.face_region, part.face_region)
    poly = engine.polygonize(mesh, snapped, engine.MeshingOptions(planar=True))
    assert poly.report["planar"]
    assert poly.report["whole"] >= 0.98


@pytest.mark.parametrize(("shape", "square"), [(known_shapes.washer(), True), (known_shapes.wedge(), False)])
def test_a_part_that_stands_askew_has_right_angles_of_its_own(shape: known_shapes.Shape, square: bool) -> None:
    random = np.random.default_rng(5)
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    vertices = shape.vertices + random.normal(0, 0.0005 * shape.longest_side, shape.vertices.shape)
    mesh = engine.clean(vertices @ (turn * np.linalg.det(turn)).T, shape.faces)
    snapped = engine.regularise(mesh, engine.partition(mesh))
    angles = np.abs(snapped.region_normal @ snapped.region_normal.T)
    assert (snapped.report["directions"] == 3 and angles[angles < 0.5].max() < 1e-12) == square


@pytest.mark.parametrize("noise", [0.001, 0.002, 0.004])
def test_the_planes_of_a_house_are_found(noise: float) -> None:
    for seed in (1, 2, 4):
        house = houses.make(noise, seed, turn=48.0)
        snapped = engine.regularise(*made(house))
        assert snapped.report["planes"] == len(np.unique(house.label)), seed


def test_snapped_planes_together_add_little_unless_a_length_is_given() -> None:
    rows = np.linspace(0, 3 * np.pi, 60)
    x, y = np.meshgrid(rows, rows)
    first = (np.arange(59)[:, None] * 60 + np.arange(59)).ravel()
    triangles = np.concatenate([first[:, None] + [0, 1, 60], first[:, None] + [1, 61, 60]])
    waves = np.stack([x.ravel(), y.ravel(), (np.sin(x) * np.cos(y)).ravel()], axis=1)
    mesh = engine.Mesh(waves, triangles.astype(np.int32))
    part = engine.partition(mesh, engine.PartitionOptions(proxies=150))

    def added(length: float | None) -> tuple[float, float]:
        report = engine.regularise(mesh, part, engine.RegulariseOptions(length=length)).report
        return report["rms_added"] / (report["rms"] - report["rms_added"]), report["length"]

    share, length = added(None)
    assert 0.05 < share <= 0.1 + 1e-9
    assert added(length)[0] > 0.1


def normals(house: houses.House) -> np.ndarray:
    """The true normal of each plane."""
    a, b, c = (house.clean[house.triangles[:, k]] for k in range(3))
    n = np.cross(b - a, c - a)
    n /= np.linalg.norm(n, axis=1)[:, None]
    return n[np.unique(house.label, return_index=True)[1]]


@pytest.mark.parametrize("name", ["house", "facade"])
def test_snapped_planes_add_no_defect(name: str) -> None:
    """With so few regions, keeping all planes would need flipped polygons and more of them, so some are released."""
    if name == "house":
        house = houses.make(0.003, 3)
        mesh = engine.Mesh(house.vertices, house.triangles)
    else:
        mesh = engine.Mesh(*shapes.facade())
    part = engine.partition(mesh, engine.PartitionOptions(proxies=100))
    snapped = engine.regularise(mesh, part)
    before, after = engine.polygonize(mesh, part), engine.polygonize(mesh, snapped)
    assert np.array_equal(before.loops, after.loops)
    for kind in ("polygons", "crossing", "flipped", "bent", "intersecting"):
        assert after.report[kind] == before.report[kind], kind
    gone = np.asarray(after.planes_let_go)
    assert 0 < len(gone) == after.report["planes_let_go"] < snapped.region_held.sum()
    assert (snapped.region_held[gone] == 1).all()
    assert np.array_equal(pickle.loads(pickle.dumps(after)).planes_let_go, gone)  # noqa: S301

    def off(poly: engine.PolygonMesh) -> float:
        """Mean distance of corners from the snapped planes that are kept."""
        region = np.repeat(poly.polygon_region, np.diff([*poly.loop_start, len(poly.loops)]))
        at = np.asarray(poly.vertices)[poly.loops] - mesh.origin
        away = np.abs((at * snapped.region_normal[region]).sum(1) - snapped.region_offset[region])
        return float(away[~np.isin(region, gone)].mean())

    assert off(after) < 0.85 * off(before)


@pytest.mark.parametrize("seed", [1, 2, 5, 12])
def test_corners_of_released_planes_move_no_further_than_others(seed: int) -> None:
    house = houses.make(0.003, seed)
    mesh = engine.Mesh(house.vertices, house.triangles)
    diagonal = mesh.report["diagonal"]
    part = engine.partition(mesh, engine.PartitionOptions(proxies=40))
    snapped = engine.regularise(mesh, part, engine.RegulariseOptions(length=0.02 * diagonal))
    options = engine.MeshingOptions(planar=True, reach=0.002)
    poly = engine.polygonize(mesh, snapped, options)
    # A region may release its plane for some of its polygons only, and still hold it for others.
    corners = np.diff([*poly.loop_start, len(poly.loops)])
    region = np.repeat(poly.polygon_region, corners)
    at = np.asarray(poly.vertices)[poly.loops] - mesh.origin
    away = np.abs((at * snapped.region_normal[region]).sum(1) - snapped.region_offset[region])
    on_plane = (np.maximum.reduceat(away, poly.loop_start) < 1e-6 * diagonal) & (corners > 3)
    held = np.flatnonzero(snapped.region_held)
    kept = np.union1d(np.setdiff1d(held, poly.planes_let_go), np.intersect1d(held, poly.polygon_region[on_plane]))
    at_kept = poly.loops[np.isin(region, kept)]
    others = np.setdiff1d(poly.loops, at_kept)
    assert len(others) > 10
    moved = np.linalg.norm(poly.vertices - mesh.vertices[poly.source_vertex], axis=1) / diagonal
    assert moved[others].max() <= options.reach + 1.5 * options.planar_reach + 1e-9
    assert moved[at_kept].max() <= options.reach + 6 * options.planar_reach + 1e-9


def test_the_command_has_both(tmp_path: pathlib.Path) -> None:
    house = houses.make(0.002, 3)
    scan, out, report = tmp_path / "house.obj", tmp_path / "out.obj", tmp_path / "report.json"
    meshfiles.obj(scan, house.vertices, house.triangles)
    arguments = ["simplify", str(scan), str(out), "--proxies", "110", "--planar", "--report", str(report), "--quiet"]
    assert main([*arguments, "--regularise"]) == 0
    found = json.loads(report.read_text())
    assert found["output"]["planar"] is True
    assert found["partition"]["directions"] < 20
    assert found["options"]["regularise"]["angle"] == 8.0
    assert main([*arguments, "--regularise", "5"]) == 0
    assert json.loads(report.read_text())["options"]["regularise"]["angle"] == 5.0
    assert main([*arguments, "--regularise", "90"]) == 2
