"""`isimp report`: the planes of a model as tables, and a page; figures against closed forms and other libraries."""

import csv
import json
import sys

import numpy as np
import pytest

import isimp_engine as engine
import meshfiles
import shapes
from bench.generators import round_shapes
from commands import called, check_line, ran
from isimp_engine import reports
from isimp_engine.reports.page import histogram


def house():
    """A closed house of 4 x 6 x 3 with a gable roof of 45 degrees along y."""
    corners = [(x, y, z) for y in (0, 6) for x, z in ((0, 0), (4, 0), (4, 3), (2, 5), (0, 3))]
    faces = [(0, 1, 2, 3, 4), (9, 8, 7, 6, 5)] + [(k, k + 5, (k + 1) % 5 + 5, (k + 1) % 5) for k in range(5)]
    triangles = [(face[0], face[k], face[k + 1]) for face in faces for k in range(1, len(face) - 1)]
    vertices, triangles = np.array(corners, float), np.array(triangles, np.int32)
    for _ in range(3):
        vertices, triangles = divided(vertices, triangles)
    return vertices, triangles


def divided(vertices, triangles):
    """Each triangle in four."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    points = [a, b, c, (a + b) / 2, (b + c) / 2, (c + a) / 2]
    count = len(triangles)
    index = np.arange(6 * count).reshape(6, count)
    four = [(0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)]
    return shapes.welded(
        np.concatenate(points), np.concatenate([index[list(each)].T for each in four]).astype(np.int32)
    )


@pytest.fixture(scope="module")
def model():
    mesh = engine.Mesh(*house())
    part = engine.partition(mesh, engine.PartitionOptions(proxies=7))
    poly = engine.polygonize(mesh, part)
    return mesh, part, poly, reports.plane_table(mesh, part, poly)


def test_a_place_of_another_shape_is_refused(model):
    for place in (np.eye(3), np.full((4, 4), np.nan), "north"):
        with pytest.raises(engine.InvalidInput, match=r"place must have the shape \(4, 4\) and finite numbers, got \("):
            reports.plane_table(*model[:3], place=place)


def test_the_planes_of_a_house_are_as_built(model):
    rows = sorted(model[3].rows, key=lambda row: (row["tilt"], row["azimuth"] or 0.0))
    assert [row["class"] for row in rows] == ["RoofSurface"] * 2 + ["WallSurface"] * 4 + ["GroundSurface"]
    assert [row["tilt"] for row in rows] == pytest.approx([45, 45, 90, 90, 90, 90, 180])
    assert [row["azimuth"] for row in rows[:6]] == pytest.approx([90, 270, 0, 90, 180, 270])
    assert rows[6]["azimuth"] is None
    slope, gable = 6 * np.hypot(2, 2), 4 * 3 + 4
    assert [row["area"] for row in rows] == pytest.approx([slope, slope, gable, 18, gable, 18, 24])
    assert max(row["distance_max"] for row in rows) < 1e-6
    roof = rows[0]
    assert [roof[f"centre_{axis}"] for axis in "xyz"] == pytest.approx([3, 3, 4])


def test_angles_between_chosen_planes(model):
    rows = sorted(model[3].rows, key=lambda row: (row["tilt"], row["azimuth"] or 0.0))
    chosen = [rows[k]["region"] for k in (0, 1, 6)]
    found = reports.angle_rows(model[3], chosen)
    assert [row["angle"] for row in found] == pytest.approx([90, 135, 135])
    with pytest.raises(KeyError):
        reports.angle_rows(model[3], [0, 99])


def test_geojson_has_a_closed_ring_for_each_polygon(model):
    _, _, poly, table = model
    found = json.loads(reports.write_geojson(table, 25832))
    assert (found["crs"]["properties"]["name"], len(found["features"])) == ("urn:ogc:def:crs:EPSG::25832", 7)
    rings = [ring for each in found["features"] for part in each["geometry"]["coordinates"] for ring in part]
    assert len(rings) == len(poly.loop_start)
    assert all(ring[0] == ring[-1] and len(ring[0]) == 3 for ring in rings)


def test_the_histogram_has_every_known_distance():
    away = np.array([0.0, 0.5, 1.0, np.nan, 40.0])
    counts, ends = histogram(away, 4)
    assert counts.sum() == 4
    assert counts[-1] >= 1
    assert ends[0] == 0


def noisy():
    """A rough facade with planar polygons: of bent ones area and distance depend on how they are cut into triangles."""
    vertices, triangles = shapes.facade(noise=0.01)
    mesh = engine.clean(vertices, triangles)
    part = engine.partition(mesh, engine.PartitionOptions(proxies=60))
    poly = engine.polygonize(mesh, part, engine.MeshingOptions(planar=True))
    return mesh, part, poly, reports.plane_table(mesh, part, poly)


def soup(poly):
    """The polygons as triangles, (vertices, triangles, polygon of each)."""
    return poly.vertices, *engine.regions.triangulate(poly.vertices, poly.loops, poly.loop_start)


def test_areas_equal_trimesh():
    trimesh = pytest.importorskip("trimesh")
    _, _, poly, table = noisy()
    vertices, triangles, polygon = soup(poly)
    shape = trimesh.Trimesh(vertices, triangles, process=False)
    area = np.bincount(poly.polygon_region[polygon], shape.area_faces)
    for row in table.rows:
        assert row["area"] == pytest.approx(area[row["region"]], rel=1e-5)


def test_distances_equal_trimesh():
    trimesh = pytest.importorskip("trimesh")
    mesh, _, poly, table = noisy()
    vertices, triangles, _ = soup(poly)
    for vertex in range(0, len(mesh.vertices), 50):
        place = np.repeat(np.asarray(mesh.vertices)[vertex][None], len(triangles), axis=0)
        closest = trimesh.triangles.closest_point(vertices[triangles], place)
        assert table.away[vertex] == pytest.approx(np.linalg.norm(closest - place, axis=1).min(), abs=1e-9)


def test_sizes_are_true_within_their_uncertainty():
    clean, triangles = house()
    for _ in range(2):
        clean, triangles = divided(clean, triangles)
    true = {"distance": (4, 6), "angle": (90, 90, 90, 90, 90, 90, 90, 90, 90, 45, 45, 90, 90, 90, 90)}
    away = []
    for seed in range(6):
        vertices = clean + np.random.default_rng(seed).normal(0, 0.003, clean.shape)
        mesh = engine.clean(vertices + [4e5, 5e6, 100], triangles)
        part = engine.partition(mesh, engine.PartitionOptions(proxies=7))
        rows = reports.size_rows(mesh, part)
        for kind, values in true.items():
            found = sorted((row for row in rows if row["kind"] == kind), key=lambda row: row["value"])
            assert len(found) == len(values)
            away += [
                (row["value"] - value) / row["uncertainty"] for row, value in zip(found, sorted(values), strict=True)
            ]
        regular = {row["value"] for row in reports.size_rows(mesh, engine.regularise(mesh, part))}
        assert {90.0} < regular
    assert np.mean(np.abs(away) < 1) > 0.9
    assert 0.3 < 2 * np.std(away) < 1.3


def test_a_diameter_is_a_size():
    shape = round_shapes.shapes()["capped"]
    mesh = engine.clean(*round_shapes.made(shape))
    rows = reports.size_rows(mesh, engine.partition(mesh, engine.PartitionOptions(curved=True)))
    (row,) = (row for row in rows if row["kind"] == "diameter")
    assert row["value"] == pytest.approx(2 * shape.parts[0].radius, rel=1e-3)
    assert row["uncertainty"] < 1e-3 * row["value"]


def read(path):
    return list(csv.DictReader(path.read_text().splitlines()))


def test_the_command_writes_tables_and_a_page(tmp_path):
    source, out = tmp_path / "house.ply", tmp_path / "out"
    vertices, triangles = house()
    meshfiles.ply_binary(source, vertices, triangles.tolist())
    ran("report", source, out, "--proxies", "7", "--angles", "0,3", "--crs", "25832")
    assert sorted(path.name for path in out.iterdir()) == [
        "angles.csv",
        "planes.csv",
        "planes.geojson",
        "report.html",
        "sizes.csv",
    ]
    rows = read(out / "planes.csv")
    assert len(rows) == 7
    assert sum(float(row["area"]) for row in rows) == pytest.approx(2 * 6 * np.hypot(2, 2) + 2 * 16 + 2 * 18 + 24)
    assert len(read(out / "angles.csv")) == 1
    page = (out / "report.html").read_text()
    assert "deviation, 95 % are below</td>" in page
    assert "the accuracy of the scan itself is not part of it" in page
    assert page.count("<rect") == 40
    assert "data:image/png;base64," in page
    assert page.count("<tr>") == 11 + 1 + 7


def test_round_parts_have_a_table(tmp_path):
    source, out = tmp_path / "capped.ply", tmp_path / "out"
    vertices, triangles = round_shapes.made(round_shapes.shapes()["capped"])
    meshfiles.ply_binary(source, vertices, triangles.tolist())
    done = ran("report", source, out, "--curved")
    assert "1 round part in planes.csv, round_parts.csv, sizes.csv, planes.geojson, report.html" in done.stdout
    (row,) = read(out / "round_parts.csv")
    axis = np.array([float(row[f"axis_{k}"]) for k in "xyz"])
    away = np.array([float(row[f"point_{k}"]) for k in "xyz"])
    truth = np.array([0.3, 0.2, 1]) / np.linalg.norm([0.3, 0.2, 1])
    assert row["kind"] == "cylinder"
    assert abs(axis @ truth) == pytest.approx(1, abs=1e-6)
    assert np.linalg.norm(away - (away @ truth) * truth) < 1e-3
    assert float(row["radius"]) == pytest.approx(1, abs=1e-3)
    assert float(row["span"]) == pytest.approx(360)
    assert row["slope"] == ""
    assert int(row["segments"]) >= 8
    assert row["rings"] == "1"
    assert float(row["area"]) == pytest.approx(2 * np.pi * 3, rel=0.02)
    assert 0 < float(row["distance_mean"]) <= float(row["distance_rms"]) <= float(row["distance_max"]) < 0.05
    assert "<h2>Round parts</h2>" in (out / "report.html").read_text()


def test_round_parts_are_turned_and_moved_with_the_table():
    vertices, triangles = round_shapes.made(round_shapes.shapes()["cone"])
    mesh = engine.clean(vertices, triangles)
    part = engine.partition(mesh, engine.PartitionOptions(curved=True))
    poly = engine.polygonize(mesh, part)
    place = np.array([[1.0, 0, 0, 10], [0, 0, -1, 20], [0, 1, 0, 30], [0, 0, 0, 1]])  # z becomes -y
    (plain,) = reports.plane_table(mesh, part, poly).round_parts
    (moved,) = reports.plane_table(mesh, part, poly, place=place).round_parts
    for name, shift in (("axis", 0.0), ("point", 1.0)):
        x, y, z = (plain[f"{name}_{k}"] for k in "xyz")
        found = [moved[f"{name}_{k}"] for k in "xyz"]
        assert found == pytest.approx([x + 10 * shift, -z + 20 * shift, y + 30 * shift])
    assert moved["slope"] == plain["slope"] != 0
    assert (moved["area"], moved["distance_max"]) == pytest.approx((plain["area"], plain["distance_max"]))


def test_wrong_uses_are_refused(tmp_path):
    source, out = tmp_path / "house.ply", tmp_path / "out"
    vertices, triangles = house()
    meshfiles.ply_binary(source, vertices, triangles.tolist())
    check_line(called("report", source, out, "--proxies", "7", "--angles", "0,99"), 2, "there is no region 99")
    check_line(called("report", source, out, "--angles=-1,2"), 2, "give two or more numbers of regions")
    assert not out.exists()
    out.write_text("")
    check_line(called("report", source, out), 2, "must be a folder")
    check_line(called("report", tmp_path / "none.ply", tmp_path / "new"), 3, "none.ply")


def test_a_folder_has_the_tables_of_one_report(tmp_path):
    source, out = tmp_path / "house.ply", tmp_path / "out"
    vertices, triangles = house()
    meshfiles.ply_binary(source, vertices, triangles.tolist())
    out.mkdir()
    for name in ("angles.csv", "round_parts.csv", "other.csv"):
        (out / name).write_text("old")
    ran("report", source, out, "--proxies", "7")
    names = ["other.csv", "planes.csv", "planes.geojson", "report.html", "sizes.csv"]
    assert sorted(path.name for path in out.iterdir()) == names
    assert (out / "other.csv").read_text() == "old"


@pytest.mark.skipif(sys.platform == "win32", reason="needs links and permissions as POSIX has them")
def test_neither_the_scan_nor_a_read_only_table_is_overwritten(tmp_path):
    source, out = tmp_path / "house.ply", tmp_path / "out"
    vertices, triangles = house()
    meshfiles.ply_binary(source, vertices, triangles.tolist())
    before = source.read_bytes()
    out.mkdir()
    (out / "planes.geojson").symlink_to("../house.ply")
    check_line(called("report", source, out), 2, "planes.geojson: is named twice")
    assert source.read_bytes() == before
    (out / "planes.geojson").unlink()
    (out / "planes.csv").write_text("precious")
    (out / "planes.csv").chmod(0o444)
    check_line(called("report", source, out), 2, "planes.csv: is read-only")
    assert [path.name for path in out.iterdir()] == ["planes.csv"]
    assert (out / "planes.csv").read_text() == "precious"


def test_planes_of_a_mirrored_place_face_outwards(model):
    table = reports.plane_table(*model[:3], place=np.diag([-1, 1, 1, 1]))
    for plain, mirrored in zip(model[3].rows, table.rows, strict=True):
        turned = {"normal_x": -mirrored["normal_x"], "centre_x": -mirrored["centre_x"], "azimuth": plain["azimuth"]}
        assert mirrored | turned == pytest.approx(plain, abs=1e-9)
