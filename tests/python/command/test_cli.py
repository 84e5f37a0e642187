"""The command `isimp` as people and scripts call it."""

import json
import os
import re
from pathlib import Path

import numpy as np
import pytest

import isimp_engine as engine
import meshfiles
import shapes
from commands import called, check_line, isimp, ran
from isimp_engine.cli.options import simplify_options


@pytest.fixture
def scan(tmp_path):
    path = tmp_path / "scan.ply"
    vertices, triangles = shapes.bumpy(30)
    meshfiles.ply_binary(path, vertices, triangles.tolist())
    return path


@pytest.mark.parametrize("name", ["out.ply", "out.obj"])
def test_simplify_does_the_whole_job(scan, tmp_path, name):
    out, labels, report = tmp_path / name, tmp_path / "labels.npy", tmp_path / "report.json"
    done = isimp("simplify", scan, out, "--proxies", 20, "--labels", labels, "--report", report)
    assert done.returncode == 0, done.stderr
    assert done.stderr == "", "progress is for terminals only"
    assert str(out) in done.stdout

    mesh = engine.clean(*engine.read(scan))
    part = engine.partition(mesh, engine.PartitionOptions(proxies=20))
    poly = engine.polygonize(mesh, part)
    for written, expected in zip(
        engine.reading.read_polygons(out), (poly.vertices, poly.loops, poly.loop_start), strict=True
    ):
        np.testing.assert_array_equal(written, expected)
    values = np.load(labels)
    assert values.dtype == np.int32
    np.testing.assert_array_equal(values, part.face_region)

    said = json.loads(report.read_text())
    assert said["input"]["path"] == str(scan)
    assert (said["input"]["faces"], said["input"]["triangles"]) == (1800, 1800)
    assert (said["repair"], said["options"]["proxies"]) == (mesh.report["repairs"], 20)
    assert said["options"]["method"] == engine.PartitionOptions().method
    assert (said["regions"], said["error"]) == (20, part.error)
    assert said["history"] == part.history.tolist()
    assert {"vertices", "polygons", "corners", "closed", "manifold", "planarity_max", "planarity_mean"} <= set(
        said["output"]
    )
    assert {key: said["output"][key] for key in poly.report} == poly.report
    assert set(said["seconds"]) == {"read", "clean", "partition", "mesh", "write"}
    assert all(seconds >= 0 for seconds in said["seconds"].values())
    assert said["peak_mb"] is None or 5 < said["peak_mb"] < 5000
    assert sorted(os.listdir(tmp_path)) == sorted([scan.name, name, "labels.npy", "report.json"])


def test_every_option_reaches_the_engine(scan, tmp_path):
    report = tmp_path / "r.json"
    given = {"proxies": 7, "seed": 5, "method": "lloyd", "iterations": 3, "leave_out": 0.0, "threads": 1}
    flags = [text for name, value in given.items() for text in (f"--{name.replace('_', '-')}", value)]
    done = called("simplify", scan, tmp_path / "o.ply", *flags, "--backend", "cpu", "--report", report, "--quiet")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    options = json.loads(report.read_text())["options"]
    assert {name: options[name] for name in given} == given
    assert (options["backend"], options["meshing"]["threads"], options["clean"]["threads"]) == ("cpu", 1, 1)


def test_labels_are_of_the_files_polygons_and_minus_one_where_dropped(tmp_path):
    vertices, triangles = shapes.cube(1)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    quads = [quad if shapes.faces_outwards(vertices, quad) else quad[::-1] for quad in quads]
    corners = [*quads[:2], [0, 0, 1], [5], *quads[2:], quads[0]]
    meshfiles.obj(tmp_path / "a.obj", vertices, corners)
    report, labels = tmp_path / "r.json", tmp_path / "l.npy"
    ran("simplify", tmp_path / "a.obj", tmp_path / "o.obj", "--proxies", 12)
    ran("simplify", tmp_path / "a.obj", tmp_path / "o.obj", "--proxies=12", "--labels", labels, "--report", report)
    values, said = np.load(labels), json.loads(report.read_text())
    assert values.shape == (9,)
    np.testing.assert_array_equal(values[[2, 3, 8]], -1)
    assert (values[[0, 1, 4, 5, 6, 7]] >= 0).all()
    assert len(triangles) == said["regions"] == 12
    assert (said["input"]["faces"], said["repaired_at"]["repeated_index_faces"]) == (9, [2])
    assert said["repaired_at"]["duplicate_faces"] == [8]
    assert said["repair"]["duplicate_faces"] == 2  # both triangles of the doubled quad


def test_a_polygon_of_several_regions_has_the_largest_ones_label(tmp_path):
    """A regular fan of 12 corners is cut into 10 triangles, each a region of its own: the label is of a largest."""
    angles = np.arange(12) * np.pi / 6
    rim = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    meshfiles.obj(tmp_path / "a.obj", np.concatenate([rim, [[3, 0, 0]]]), [list(range(12)), [0, 12, 1]])
    ran("simplify", tmp_path / "a.obj", tmp_path / "o.obj", "--proxies=11", "--labels", tmp_path / "l.npy")
    vertices, loops, loop_start = engine.reading.read_polygons(tmp_path / "a.obj")
    triangles, polygon = engine.regions.triangulate(vertices, loops, loop_start)
    mesh = engine.clean(vertices, triangles)
    regions = engine.partition(mesh, engine.PartitionOptions(proxies=11)).face_region
    corners = vertices[triangles]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    largest = regions[(polygon == 0) & (area > area[polygon == 0].max() * (1 - 1e-9))]
    values = np.load(tmp_path / "l.npy")
    assert values[0] in largest
    assert values[1] == regions[10]


def test_what_covers_a_hole_is_counted_and_takes_no_label(tmp_path):
    vertices, triangles = shapes.cube()
    triangles = triangles[(triangles != triangles[0, 0]).all(axis=1)]
    meshfiles.obj(tmp_path / "a.obj", vertices, triangles)
    places = tmp_path / "a.obj", tmp_path / "o.obj"
    done = ran("simplify", *places, "--proxies=6", "--fill-holes=10", "--labels", tmp_path / "l.npy")
    assert "covered" in done.stdout
    assert ", closed" in done.stdout.splitlines()[0]
    values = np.load(tmp_path / "l.npy")
    assert len(values) == len(triangles)
    assert set(values) == set(range(6))
    assert "covered" in called("info", tmp_path / "a.obj", "--fill-holes=10").stdout
    refused = called("info", tmp_path / "a.obj", "--fill-holes=-1")
    assert "--fill-holes must be a finite length, at least 0, got -1" in refused.stderr


def test_a_speck_has_no_label(tmp_path):
    big, small = shapes.plane(20), shapes.plane(1)
    vertices, triangles = shapes.joined((small[0] * 0.01 + [2, 0, 0], small[1]), big)
    meshfiles.ply_ascii(tmp_path / "a.ply", vertices, triangles.tolist())
    done = ran("simplify", tmp_path / "a.ply", tmp_path / "o.ply", "--proxies=3", "--labels", tmp_path / "l.npy")
    assert "left out: 1 part" in done.stdout
    labels = np.load(tmp_path / "l.npy")
    np.testing.assert_array_equal(labels[:2], -1)
    assert labels[2:].min() == 0


def test_a_mesh_of_few_faces_needs_no_proxy_count(tmp_path):
    meshfiles.ply_ascii(tmp_path / "a.ply", [[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    done = ran("simplify", tmp_path / "a.ply", tmp_path / "o.ply")
    assert f"{tmp_path / 'o.ply'}: 1 polygon of 1 region, 3.0 corners each, open, manifold" in done.stdout


def test_the_same_files_on_every_run(scan, tmp_path):
    for name, run in (("a", isimp), ("b", called)):
        run("simplify", scan, tmp_path / f"{name}.ply", "--proxies=15", "--labels", tmp_path / f"{name}.npy")
    assert (tmp_path / "a.ply").read_bytes() == (tmp_path / "b.ply").read_bytes()
    assert (tmp_path / "a.npy").read_bytes() == (tmp_path / "b.npy").read_bytes()


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["simplify"],
        ["simplify", "in.ply"],
        ["simplify", "in.ply", "out.ply", "--proxies", "many"],
        ["simplify", "in.ply", "out.ply", "--colour"],
        ["simplify", "in.ply", "out.ply", "--proxies", "1e99"],
        ["simplify", "in.ply", "out.ply", "--seed", "-1"],
        ["melt", "in.ply"],
        ["info"],
    ],
)
def test_wrong_usage_is_2(arguments):
    done = called(*arguments)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert done.stderr


def test_wrong_usage_that_shows_later_is_2_and_writes_nothing(scan, tmp_path):
    out = tmp_path / "o.ply"
    check_line(called("simplify", scan, out, "--method", "magic"), 2, "--method must be one of", "'lloyd'", "magic")
    check_line(called("simplify", scan, out, "--proxies", 0), 2, "--proxies must be at least 1, got 0")
    check_line(called("simplify", scan, out, "--proxies", 1801), 2, scan, "[1, 1800], got 1801")
    check_line(called("simplify", scan, out, "--leave-out", 1), 2, "--leave-out must be in [0, 1), got 1")
    check_line(called("simplify", scan, out, "--backend", "abacus"), 2, "abacus", "cpu")
    check_line(called("simplify", scan, tmp_path / "o.fbx"), 2, "o.fbx", ".ply, .obj")
    check_line(called("simplify", scan, tmp_path / "no" / "o.ply"), 2, "no")
    check_line(called("simplify", scan, scan), 2, scan, "INPUT and all outputs must be different files")
    check_line(called("simplify", scan, out, "--report", out), 2, out, "named twice")
    check_line(called("simplify", scan, out, "--labels", tmp_path), 2, tmp_path, "folder")
    assert os.listdir(tmp_path) == [scan.name]


def test_input_that_can_not_be_used_is_3_with_one_line(tmp_path):
    out = tmp_path / "o.ply"
    missing = tmp_path / "missing.ply"
    check_line(called("simplify", missing, out), 3, missing)
    check_line(called("info", missing), 3, missing)
    empty = tmp_path / "empty.ply"
    empty.touch()
    check_line(called("simplify", empty, out), 3, empty)
    cloud = tmp_path / "cloud.ply"
    meshfiles.ply_ascii(cloud, [[0, 0, 0]], [])
    check_line(called("simplify", cloud, out), 3, cloud, "no faces")
    nan = tmp_path / "nan.ply"
    meshfiles.ply_ascii(nan, [[float("nan")] * 3] * 3, [[0, 1, 2]])
    check_line(called("simplify", nan, out), 3, nan, "no")
    far = tmp_path / "far.obj"
    far.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n")
    check_line(called("simplify", far, out), 3, far, "9")
    kind = tmp_path / "mesh.fbx"
    kind.touch()
    check_line(called("info", kind), 3, kind, "fbx")
    assert not out.exists()
    for done in (called("simplify", missing, out), called("info", empty)):
        assert done.stderr.count(str(tmp_path)) == 1, "the path is said once"


@pytest.mark.parametrize("text", ["inf", "nan"])
def test_numbers_that_are_not_finite_are_refused_before_the_work(tmp_path, text):
    numbers = {action.dest: action for action in simplify_options()._actions if action.type is float}
    assert len(numbers) > 15
    for action in [*numbers.values(), next(a for a in simplify_options()._actions if a.dest == "grid")]:
        flag = action.option_strings[0]
        done = called("simplify", tmp_path / "none.ply", tmp_path / "o.ply", f"{flag}={text}")
        check_line(done, 2, f"{flag} must be ", f"got {text}")


def test_a_scan_that_is_one_point_has_a_summary(tmp_path):
    path = tmp_path / "point.obj"
    path.write_text("v 0 0 0\n" * 4 + "f 1 2 3\nf 1 3 4\nf 1 4 2\nf 2 4 3\n")
    done = ran("simplify", path, tmp_path / "o.ply")
    assert "flat to 0.000% of the diagonal" in done.stdout


def test_a_budget_of_triangles_that_the_scan_exceeds_is_a_warning(tmp_path):
    path, report = tmp_path / "balls.ply", tmp_path / "r.json"
    vertices, triangles = shapes.joined(shapes.cube(), (shapes.cube()[0] + 5, shapes.cube()[1]))
    meshfiles.ply_binary(path, vertices, triangles.tolist())
    done = ran("simplify", path, tmp_path / "o.ply", "--triangles", 2, "--report", report)
    said = json.loads(report.read_text())
    made = said["output"]["corners"] - 2 * said["output"]["polygons"]
    (warning,) = said["partition"]["warnings"]
    assert warning == f"{made} triangles, 2 were asked for; the scan needs at least 8 regions"
    assert f"  warning: {warning}" in done.stdout
    assert "proxies" not in done.stdout


def test_a_full_disk_is_3_and_leaves_nothing(scan, tmp_path):
    if not Path("/dev/full").exists():
        pytest.skip("no /dev/full here")
    check_line(called("simplify", scan, tmp_path / "o.ply", "--proxies=9", "--report", "/dev/full"), 3, "/dev/full")
    labels = called("simplify", scan, tmp_path / "o.ply", "--proxies=9", "--labels", "/dev/full")
    check_line(labels, 3, "/dev/full", "No space left")
    assert os.listdir(tmp_path) == [scan.name]


def test_an_old_file_stays_when_the_run_fails(scan, tmp_path):
    out = tmp_path / "o.ply"
    out.write_text("precious")
    called("simplify", scan, out, "--proxies", 10**6)
    assert out.read_text() == "precious"


def test_info_prints_the_properties_of_a_mesh_and_its_repairs(tmp_path):
    vertices, triangles = shapes.cube()
    triangles = [*triangles.tolist(), [0, 0, 1], triangles[3].tolist()]
    path = tmp_path / "a.ply"
    meshfiles.ply_ascii(path, vertices, triangles)
    done = ran("info", path)
    assert done.stdout.splitlines() == [
        str(path),
        "  194 faces, 98 vertices",
        "  1 part, closed, Euler characteristic 2",
        "  size 1 x 1 x 1, diagonal 1.73205, area 6",
        "  to repair:",
        "    1 face dropped: a vertex is used twice (face 192)",
        "    1 face dropped: an earlier face has the same vertices (face 193)",
        "  would become 6 polygons of 6 regions",
        "    6 regions found at a tolerance of 0.00968, noise 0, the number of planes it is made of",
    ]
    said = json.loads(called("info", path, "--json").stdout)
    assert said["input"] == {"path": str(path), "vertices": 98, "faces": 194, "triangles": 194}
    assert said["mesh"]["faces"] == 192
    assert said["mesh"]["closed"] is True
    assert said["mesh"]["box"] == [[0, 0, 0], [1, 1, 1]]
    assert (said["repair"]["repeated_index_faces"], said["repaired_at"]["duplicate_faces"]) == (1, [193])


def test_info_on_a_good_mesh_has_nothing_to_repair(scan):
    lines = called("info", scan, "--mesh-only").stdout.splitlines()
    assert lines[1] == "  1,800 faces, 961 vertices"
    assert lines[2] == "  1 part, open, 120 border edges in 1 loop, Euler characteristic 1"
    assert lines[-1] == "  nothing to repair"


def test_info_counts_the_polygons_that_a_run_makes(scan, tmp_path):
    report = tmp_path / "r.json"
    assert called("simplify", scan, tmp_path / "o.ply", "--proxies", 20, "--report", report).returncode == 0
    made = json.loads(report.read_text())["output"]
    said = json.loads(called("info", scan, "--proxies", 20, "--json").stdout)["result"]
    assert (said["polygons"], said["regions"]) == (made["polygons"], 20)
    done = ran("info", scan, "--proxies", 20000)
    assert done.stdout.splitlines()[-1] == "  no polygons: proxies must be in [1, 1800], got 20000"
    assert json.loads(called("info", scan, "--mesh-only", "--json").stdout)["result"] is None


def test_polygons_beyond_the_regions_are_explained(tmp_path):
    vertices, triangles = shapes.room(16)
    path = tmp_path / "plate.ply"
    meshfiles.ply_binary(path, vertices, triangles.tolist())
    said = json.loads(called("info", path, "--proxies", 30, "--keep-openings", "--json").stdout)["result"]
    more = said["polygons"] - said["regions"]
    assert more > 0
    line = next(
        line for line in called("info", path, "--proxies", 30, "--keep-openings").stdout.splitlines() if "more" in line
    )
    numbers = [int(number) for number in re.findall(r"\d+", line)]
    assert numbers[0] == more == sum(numbers[1:])
    done = called("simplify", path, tmp_path / "o.ply", "--proxies", 30, "--keep-openings")
    assert line.strip() in done.stdout


def test_help_and_version():
    done = isimp("--version")
    assert done.stdout == f"isimp {engine.__version__}\n"
    text = called("simplify", "--help").stdout
    for flag in (
        "--proxies",
        "--seed",
        "--method",
        "--iterations",
        "--leave-out",
        "--threads",
        "--backend",
        "--labels",
    ):
        assert flag in text
    assert "--report" in text


def test_the_version_is_the_projects():
    cmake = (Path(__file__).resolve().parents[3] / "CMakeLists.txt").read_text()
    assert f"project(isimp VERSION {engine.__version__} " in cmake


def test_guides_are_kept_to_and_said(scan, tmp_path):
    out, labels, report = tmp_path / "out.ply", tmp_path / "labels.npy", tmp_path / "report.json"
    vertices, triangles = engine.read(scan)
    right = vertices[triangles].mean(axis=1)[:, 0] > 0.5
    np.save(tmp_path / "b.npy", right)
    np.save(tmp_path / "w.npy", np.where(right, 16.0, 1.0))
    outputs = (out, "--labels", labels, "--report", report)
    counts = []
    for more in ((), ("--weights", tmp_path / "w.npy")):
        ran("simplify", scan, *outputs, "--proxies", 20, "--borders", tmp_path / "b.npy", *more)
        regions = np.load(labels)
        assert not set(regions[right]) & set(regions[~right])
        counts.append(len(set(regions[right])))
    assert counts[1] > counts[0]
    assert json.loads(report.read_text())["options"]["guides"]["weights"] == str(tmp_path / "w.npy")

    np.save(tmp_path / "p.npy", np.flatnonzero(right))
    done = called("simplify", scan, out, "--labels", tmp_path / "new.npy", "--proxies", 5, "--part", tmp_path / "p.npy",
                 "--base", labels)  # fmt: skip
    assert done.returncode == 0, done.stderr
    new = np.load(tmp_path / "new.npy")
    assert len(set(new[right])) == 5
    pairs = np.unique(np.stack([regions, new], axis=1)[~right], axis=0)
    assert len(pairs) == len(set(regions[~right])) == len(set(new[~right])), "the others are as they were"


def test_edges_that_are_sharp_or_cut_part_regions(tmp_path):
    path, labels = tmp_path / "cube.ply", tmp_path / "labels.npy"
    vertices, triangles = shapes.cube(4)
    meshfiles.ply_binary(path, vertices, triangles.tolist())
    ran("simplify", path, tmp_path / "out.obj", "--proxies", 1, "--angle", 45, "--labels", labels)
    assert np.load(labels).max() == 5
    edge = triangles[0, :2][None]
    np.save(tmp_path / "e.npy", edge)
    ran("simplify", path, tmp_path / "out.obj", "--proxies", 6, "--cuts", tmp_path / "e.npy", "--labels", labels)
    beside = np.load(labels)[[set(edge[0]) <= set(t) for t in triangles.tolist()]]
    assert len(set(beside)) == 2


def test_a_bound_is_measured_on_the_polygons(scan, tmp_path):
    report = tmp_path / "report.json"
    done = ran("simplify", scan, tmp_path / "out.ply", "--bound", 0.02, "--report", report)
    said = json.loads(report.read_text())
    assert said["partition"]["distance_max"] <= 0.02
    assert 0 < said["output"]["scan_distance"] <= said["output"]["scan_distance_allowed"] == pytest.approx(0.03)
    assert "the scan is at most" in done.stdout


@pytest.mark.parametrize(
    ("flags", "values", "message"),
    [
        (["--angle", "190"], None, "--angle must be in [0, 180], got 190"),
        (["--borders", "f.npy"], np.zeros(3), "f.npy: must be (1800) numbers, is (3,) float64"),
        (["--cuts", "f.npy"], np.zeros((4, 2)), "f.npy: must be (K, 2) integers, is (4, 2) float64"),
        (["--part", "f.npy"], np.array([1800]), "f.npy: faces must be in [0, 1800)"),
        (["--base", "f.npy"], np.zeros(1800, int), "--base needs --part"),
        (["--weights", "f.npy"], None, "f.npy: is not a .npy file of numbers"),
    ],
)
def test_guides_that_cannot_be_used_are_named(scan, tmp_path, flags, values, message):
    if values is None:
        (tmp_path / "f.npy").write_text("nothing")
    else:
        np.save(tmp_path / "f.npy", values)
    check_line(called("simplify", scan, "out.ply", *flags, cwd=tmp_path), 2, message)
