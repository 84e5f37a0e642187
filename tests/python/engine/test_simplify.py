"""`simplify` makes the results of the command, from a scan in any form."""

import json
import pickle
from types import SimpleNamespace

import numpy as np
import pytest

import isimp_engine as engine
import meshfiles
import shapes
from bench.generators import houses
from isimp_engine.cli import main

SCANS = {
    "bumpy": lambda: shapes.bumpy(20),
    "cube": lambda: shapes.cube(6),
    "room": lambda: shapes.room(16),
    "house": lambda: (lambda house: (house.vertices, house.triangles))(houses.make(0.002, 3)),
}
OPTIONS = [
    {},
    {"proxies": 30},
    {"detail": 0.02, "planar": True},
    {"triangles": 120},
    {"tolerance": 0.05},
    {"bound": 0.2},
    {"proxies": 40, "regularise": True},
    {"curved": True, "detail": 0.01},
    {"proxies": 25, "clutter": "box", "keep_openings": True},
    {"angle": 40.0, "seed": 3, "adaptivity": 0.25, "snap": False, "detail": 0.02, "leave_out": 0.0},
]
TIMES = ("seconds", "peak_mb")


def flags(options):
    for name, value in options.items():
        flag = "--" + name.replace("_", "-")
        yield from ["--no-" + name] if value is False else [flag] if value is True else [flag, str(value)]


def written(folder, scan, *options):
    """The polygons, labels and report of the command."""
    out, labels, report = folder / "o.ply", folder / "l.npy", folder / "r.json"
    done = ["simplify", str(scan), str(out), "--labels", str(labels), "--report", str(report), "--quiet"]
    assert main([*done, *map(str, options)]) == 0
    return out.read_bytes(), np.load(labels), json.loads(report.read_text())


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scans")
    for name, make in SCANS.items():
        vertices, triangles = make()
        meshfiles.ply_binary(folder / f"{name}.ply", vertices, np.asarray(triangles).tolist())
    return folder


@pytest.mark.parametrize(
    ("name", "options"),
    [("bumpy", {}), ("house", {}), *((name, options) for name in ("cube", "room") for options in OPTIONS)],
    ids=str,
)
def test_it_makes_what_the_command_makes(files, tmp_path, name, options):
    scan = files / f"{name}.ply"
    polygons, labels, report = written(tmp_path, scan, *flags(options))
    made = engine.simplify(scan, **options)
    made.write(tmp_path / "p.ply")
    assert (tmp_path / "p.ply").read_bytes() == polygons
    np.testing.assert_array_equal(made.labels, labels)
    del report["output"]["path"], report["step"]
    mine = json.loads(json.dumps(made.report))
    for files_of_guides in ("weights", "borders", "cuts", "part", "base"):
        assert report["options"]["guides"].pop(files_of_guides) is None
    for values in (report, mine):
        for time in TIMES:
            values.pop(time, None)
    assert mine == report


def same(made, other):
    for name in ("vertices", "loops", "loop_start", "polygon_region"):
        np.testing.assert_array_equal(getattr(made.polygons, name), getattr(other.polygons, name))


def test_a_scan_may_be_given_in_any_form(files):
    path = files / "room.ply"
    wanted = engine.simplify(path, proxies=30)
    vertices, triangles = engine.read(path)
    forms = {
        "text": str(path),
        "arrays": (vertices, triangles),
        "lists": (vertices.tolist(), triangles.tolist()),
        "faces": SimpleNamespace(vertices=vertices, faces=triangles.astype(np.int64)),
        "triangles": SimpleNamespace(vertices=vertices, triangles=triangles),
        "repaired": engine.clean(vertices, triangles),
        "soup": engine.read_textured(path),
    }
    for scan in forms.values():
        made = engine.simplify(scan, proxies=30)
        same(made, wanted)
        np.testing.assert_array_equal(made.labels, wanted.labels)
    assert wanted.report["closed_below"] > 0, "openings are closed in all of them"


def test_faces_may_have_any_number_of_corners(tmp_path):
    vertices = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    mixed = [[0, 1, 3], [0, 3, 2], *quads[1:]]
    for faces in (quads, np.array(quads), mixed, [np.array(face) for face in mixed]):
        meshfiles.obj(tmp_path / "a.obj", vertices, [list(face) for face in faces])
        made, wanted = engine.simplify((vertices, faces)), engine.simplify(tmp_path / "a.obj")
        same(made, wanted)
        assert len(made.labels) == len(faces)
        assert sorted(set(made.labels)) == list(range(6))


def test_the_faces_of_the_polygons_are_lists_and_triangles(files):
    poly = engine.simplify(files / "cube.ply", proxies=6).polygons
    faces, triangles = poly.faces(), poly.triangles()
    assert [len(face) for face in faces] == [4] * 6
    assert all(face.dtype == np.int32 for face in faces)
    np.testing.assert_array_equal(np.concatenate(faces), poly.loops)
    np.testing.assert_array_equal(triangles, engine.regions.triangulate(poly.vertices, poly.loops, poly.loop_start)[0])
    assert triangles.shape == (12, 3)


def test_the_result_can_be_edited_and_sent(files):
    made = engine.simplify(files / "bumpy.ply", proxies=20)
    part = engine.add_proxy(made.mesh, made.partition, 5)
    assert part.region_count == made.partition.region_count + 1
    assert "20 regions" in repr(made)
    same(pickle.loads(pickle.dumps(made)), made)  # noqa: S301


def test_arrays_of_faces_guide_it(files, tmp_path):
    vertices, triangles = engine.read(files / "bumpy.ply")
    weights = np.linspace(0, 4, len(triangles))
    np.save(tmp_path / "w.npy", weights)
    np.save(tmp_path / "c.npy", triangles[:3, :2])
    options = ["--proxies=20", "--weights", tmp_path / "w.npy", "--cuts", tmp_path / "c.npy"]
    _, labels, _ = written(tmp_path, files / "bumpy.ply", *options)
    made = engine.simplify((vertices, triangles), proxies=20, weights=weights, cuts=triangles[:3, :2])
    np.testing.assert_array_equal(made.labels, labels)
    base = engine.simplify((vertices, triangles), proxies=20).labels
    part = engine.simplify((vertices, triangles), proxies=4, part=np.flatnonzero(base == 3), base=base)
    assert part.partition.region_count > 20


def test_a_recipe_is_done(files, tmp_path):
    steps = [{"step": "partition", "proxies": 15}, {"step": "improve"}, {"step": "add_worst", "times": 2}]
    recipe = {"isimp_recipe": 1, "steps": [*steps, {"step": "mesh", "flatten": 5}]}
    (tmp_path / "steps.json").write_text(json.dumps(recipe))
    polygons, _, _ = written(tmp_path, files / "bumpy.ply", "--recipe", tmp_path / "steps.json")
    for given in (recipe, tmp_path / "steps.json"):
        made = engine.simplify(files / "bumpy.ply", recipe=given)
        made.write(tmp_path / "p.ply")
        assert (tmp_path / "p.ply").read_bytes() == polygons
    assert engine.simplify(files / "bumpy.ply", recipe=recipe, proxies=9).partition.region_count == 11


def test_a_texture_is_kept(tmp_path):
    vertices, triangles = shapes.cube(4)
    colors = np.zeros((len(vertices), 3), np.uint8) + np.array([200, 40, 10], np.uint8)
    made = engine.simplify(engine.TexturedSoup(vertices, triangles, colors=colors), proxies=6, texture=64)
    assert made.texture.image.shape[:2] == (64, 64)
    made.write(tmp_path / "o.glb")
    assert (tmp_path / "o.glb").read_bytes()[:4] == b"glTF"
    with pytest.raises(engine.InvalidInput, match="no texture to keep"):
        engine.simplify((vertices, triangles), texture=True)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"proxies": 0}, "proxies must be at least 1, got 0"),
        ({"proxies": 3, "detail": 0.1}, "detail and proxies each set the number of regions"),
        ({"clutter": "drop"}, "clutter must be one of keep, leave-out, box, got 'drop'"),
        ({"weights": np.ones(3)}, r"weights: must be \(800\) numbers, is \(3,\) float64"),
        ({"base": np.zeros(800, int)}, "base needs part"),
    ],
)
def test_what_is_wrong_is_named(files, options, words):
    with pytest.raises(engine.InvalidInput, match=words):
        engine.simplify(files / "bumpy.ply", **options)


def test_a_scan_or_an_option_of_another_kind_is_named():
    for scan in (3, object(), (1, 2, 3)):
        with pytest.raises(engine.InvalidInput, match="a scan is a path"):
            engine.simplify(scan)
    with pytest.raises(TypeError, match=r"no option 'regions'; it has .*proxies"):
        engine.simplify(shapes.cube(), regions=4)
    with pytest.raises(engine.InvalidInput, match="stitch is of the repair, which a Mesh has had"):
        engine.simplify(engine.clean(*shapes.cube()), stitch=0.1)
    with pytest.raises(engine.FileError, match="nowhere"):
        engine.simplify("nowhere.ply")


def with_dropped(vertices, triangles):
    """The arrays with vertices that no face uses before them, and faces without area after them."""
    triangles = np.asarray(triangles) + 3
    thin = np.repeat(triangles[:2, :1], 3, axis=1)
    return np.vstack([vertices[:3] + 9, vertices]), np.vstack([triangles, thin])


def test_a_mesh_without_its_last_faces_is_reported_and_takes_arrays_of_all_of_them():
    vertices, triangles = with_dropped(*shapes.cube(6))
    mesh, count = engine.clean(vertices, triangles), len(triangles)
    assert mesh.source_face.max() == count - 3
    for scan in (mesh, (vertices, triangles)):
        made = engine.simplify(scan, proxies=6)
        assert made.report["repaired_at"]["repeated_index_faces"] == [count - 2, count - 1]
        assert len(made.labels) == count
    side = np.arange(count) % 2
    wanted = engine.simplify((vertices, triangles), proxies=40, borders=side, weights=1.0 + side)
    for more in (0, 4):  # more of them may have been dropped than the report has places
        borders = np.append(side, [0] * more)
        made = engine.simplify(mesh, proxies=40, borders=borders, weights=1.0 + borders)
        np.testing.assert_array_equal(made.labels, wanted.labels)
    chosen = np.arange(count)[::3]
    part = engine.simplify(mesh, proxies=9, part=np.append(chosen, count + 3), base=side)
    np.testing.assert_array_equal(
        part.labels, engine.simplify((vertices, triangles), proxies=9, part=chosen, base=side).labels
    )
    with pytest.raises(engine.InvalidInput, match=rf"weights: must be \({count} or more\) numbers, is \(3,\)"):
        engine.simplify(mesh, weights=np.ones(3))


def test_a_mesh_takes_cuts_by_the_vertices_that_it_was_made_of():
    vertices, triangles = with_dropped(*shapes.cube(6))
    mesh = engine.clean(vertices, triangles)
    far = np.flatnonzero(vertices[:, 0] == 1)
    edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    cuts = edges[np.isin(edges, far).all(axis=1) & (np.abs(vertices[edges, 2] - 0.5) < 1e-9).all(axis=1)]
    cuts = np.vstack([cuts, edges[edges[:, 1] >= len(mesh.vertices)]])
    assert cuts.max() >= len(mesh.vertices)
    made, wanted = (engine.simplify(scan, proxies=6, cuts=cuts) for scan in (mesh, (vertices, triangles)))
    np.testing.assert_array_equal(made.labels, wanted.labels)
    assert made.partition.region_count > 6
    with pytest.raises(engine.InvalidInput, match=r"cuts: row 1 .* names vertex -1; the vertices of the scan begin"):
        engine.simplify(mesh, cuts=[[3, 4], [3, -1]])
    with pytest.raises(engine.InvalidInput, match=r"cuts: row 0 .* the vertices of the scan are 0 to 217"):
        engine.simplify(engine.Mesh(*shapes.cube(6)), cuts=[[3, 218]])


def test_labels_and_the_report_are_made_once():
    made = engine.simplify(shapes.cube(4), proxies=6)
    assert made.labels is made.labels
    assert made.report is made.report
    same(pickle.loads(pickle.dumps(made)), made)  # noqa: S301


def test_a_job_shows_its_progress_and_cancels_it(files):
    job = engine.Job()
    engine.simplify(files / "room.ply", detail=0.05, job=job)
    assert job.progress == 1
    job = engine.Job()
    job.cancel()
    with pytest.raises(engine.Cancelled):
        engine.simplify(files / "room.ply", job=job)


def test_real_scans_are_made_as_the_command_makes_them(data, tmp_path):
    for name in ("real/tin_16k.ply", "nasty/thingi_88566.ply"):
        polygons, _, _ = written(tmp_path, data / name, "--proxies", 80)
        engine.simplify(data / name, proxies=80).write(tmp_path / "p.ply")
        assert (tmp_path / "p.ply").read_bytes() == polygons
