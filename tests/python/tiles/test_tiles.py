"""`isimp tiles`: one scan in tiles gives the polygons of one piece, for any tiles and workers."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import isimp_engine as engine
import meshfiles
import shapes
import tilesets
from batches import wait_for
from commands import ENVIRONMENT, called, ran
from isimp_engine import batch, tiles
from isimp_engine.guides import shared_edges
from isimp_engine.tiles import results, splitting, store
from isimp_engine.tiles.plan import Plan

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="tiles need fork")

P = 12


@pytest.fixture(scope="module")
def whole():
    return tilesets.hilly()


@pytest.fixture(scope="module")
def one_piece(whole):
    return engine.partition(engine.Mesh(*whole), engine.PartitionOptions(proxies=P))


def judged(vertices, triangles, label):
    """The L2,1 error of labels, and the length of the borders between regions."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a) / 2
    count = label.max() + 1
    sums = np.stack([np.bincount(label, normal[:, k], count) for k in range(3)], 1)
    area = np.linalg.norm(normal, axis=1)
    ends = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    order = np.lexsort(ends.T)
    edge, side = ends[order], np.repeat(label, 3)[order]
    between = (edge[1:] == edge[:-1]).all(1) & (side[1:] != side[:-1])
    length = np.linalg.norm(vertices[edge[1:][between, 0]] - vertices[edge[1:][between, 1]], axis=1).sum()
    return 2 * (area.sum() - np.linalg.norm(sums, axis=1).sum()), length


def error_of(vertices, triangles, label):
    return judged(vertices, triangles, label)[0]


@pytest.fixture(scope="module")
def four(tmp_path_factory, whole):
    """The folder of four tiles, their polygons and their labels."""
    folder = tmp_path_factory.mktemp("four")
    tilesets.write(folder / "in", tilesets.cut(*whole, 2, 2))
    return folder / "in", *run_bits(folder / "in", folder / "out.ply")


def check_that_no_border_of_regions_follows_a_border_of_tiles(whole, parts, label):
    tile = np.empty(len(label), int)
    for k, (_, _, own) in enumerate(parts):
        tile[own] = k
    f, g = shared_edges(whole[1])[0].T
    crossing = tile[f] != tile[g]
    cut = label[f] != label[g]
    assert crossing.sum() >= 4 * 48
    assert cut[crossing].mean() < 2 * cut[~crossing].mean() + 0.02


@pytest.mark.parametrize(("columns", "rows"), [(1, 1), (3, 1), (3, 3)])
def test_tiles_give_as_many_regions_and_as_small_an_error_as_one_piece(tmp_path, whole, one_piece, columns, rows):
    parts = tilesets.cut(*whole, columns, rows)
    folder = tilesets.write(tmp_path / "in", parts)
    outcome = tiles.run(folder, tmp_path / "out.obj", proxies=P, labels=tmp_path / "labels")
    label = tilesets.labels_of(tmp_path / "labels", parts, len(whole[1]))
    if columns == rows == 3:
        check_that_no_border_of_regions_follows_a_border_of_tiles(whole, parts, label)
    assert sorted(set(label.tolist())) == list(range(P))
    assert tilesets.regions_are_connected(whole[1], label)
    error = error_of(*whole, label)
    assert error == pytest.approx(outcome.report["error"], rel=1e-3)
    assert error < 1.03 * error_of(*whole, one_piece.face_region)
    out = outcome.report["output"]
    assert out["manifold"]
    assert out["polygons"] <= P + 3
    assert not (tmp_path / ".out.obj.tiles").exists()
    if columns > 1:
        assert outcome.report["border_edges"] - outcome.report["unmatched_edges"] >= 2 * 48 * (columns - 1)


@pytest.fixture
def thinned(monkeypatch):
    """Small scans are thinned too, to a quarter: their tiles have long borders, which stay."""
    module = sys.modules["isimp_engine.tiles.run"]
    monkeypatch.setattr(module, "_FEW", 0)
    monkeypatch.setattr(module, "_SHARE", 0.25)


@pytest.mark.parametrize(("columns", "rows"), [(1, 1), (3, 3)])
def test_thinned_tiles_have_the_regions_of_one_piece(tmp_path, whole, one_piece, thinned, columns, rows):
    parts = tilesets.cut(*whole, columns, rows)
    folder = tilesets.write(tmp_path / "in", parts)
    report = tiles.run(folder, tmp_path / "out.obj", proxies=P, labels=tmp_path / "labels").report
    assert report["thinned_faces"] < 0.4 * len(whole[1])
    label = tilesets.labels_of(tmp_path / "labels", parts, len(whole[1]))
    assert sorted(set(label.tolist())) == list(range(P))
    assert error_of(*whole, label) < 1.1 * error_of(*whole, one_piece.face_region)
    assert report["output"]["manifold"]
    assert report["output"]["polygons"] <= P + 3
    if columns == 3:
        assert report["unmatched_edges"] == 4 * 48


@pytest.fixture(scope="module")
def town():
    mesh = tilesets.town()
    return mesh, judged(
        *mesh, engine.partition(engine.Mesh(*mesh), engine.PartitionOptions(proxies=60, metric="normals")).face_region
    )


@pytest.mark.parametrize(("columns", "rows"), [(1, 1), (4, 2)])
def test_error_and_borders_of_a_town_are_those_of_one_piece(tmp_path, town, columns, rows):
    town, one = town
    parts = tilesets.cut(*town, columns, rows)
    folder = tilesets.write(tmp_path / "in", parts)
    tiles.run(folder, tmp_path / "out.obj", proxies=60, labels=tmp_path / "labels", options={"metric": "normals"})
    error, borders = judged(*town, tilesets.labels_of(tmp_path / "labels", parts, len(town[1])))
    assert error < 1.01 * one[0]
    assert borders == pytest.approx(one[1], rel=0.05)


def test_detail_weighs_borders_as_one_piece_does(tmp_path, data):
    mesh = engine.clean(*engine.read(data / "scan" / "bunny_69k.ply"))
    bunny = mesh.vertices, mesh.triangles
    part = engine.partition(mesh, engine.PartitionOptions(detail=0.005))
    one = judged(*bunny, part.face_region)
    parts = tilesets.cut(*bunny, 2, 1)
    folder = tilesets.write(tmp_path / "in", parts)
    report = tiles.run(folder, tmp_path / "out.obj", options={"detail": 0.005}, labels=tmp_path / "labels").report
    error, borders = judged(*bunny, tilesets.labels_of(tmp_path / "labels", parts, len(bunny[1])))
    assert report["regions"] == pytest.approx(part.region_count, rel=0.1)
    assert error < 1.02 * one[0]
    assert borders == pytest.approx(one[1], rel=0.05)


@pytest.mark.parametrize(("columns", "rows"), [(1, 1), (3, 2)])
def test_detail_finds_the_planes_that_one_piece_finds(tmp_path, whole, columns, rows):
    one = engine.partition(engine.clean(*whole), engine.PartitionOptions(detail=0.01))
    folder = tilesets.write(tmp_path / "in", tilesets.cut(*whole, columns, rows))
    report = tiles.run(folder, tmp_path / "out.obj", options={"detail": 0.01}).report
    assert report["tolerance"] == pytest.approx(one.report["tolerance"], rel=1e-6)
    assert report["noise"] == pytest.approx(one.report["noise"], rel=0.2)
    assert report["regions"] == pytest.approx(one.region_count, abs=max(1, one.region_count // 10))


def test_a_tolerance_is_a_length_and_its_number_is_said(tmp_path):
    parts = tilesets.cut(*shapes.cube(10), 2, 2)
    folder = tilesets.write(tmp_path / "in", parts)
    done = called("tiles", folder, tmp_path / "a.obj", "--tolerance", 0.02, "--noise", 0)
    assert (done.returncode, done.stderr) == (0, "")
    assert "6 regions found at a tolerance of 0.02, noise 0, the number of planes it is made of" in done.stdout
    by_default = tiles.run(folder, tmp_path / "b.obj").report
    assert (by_default["regions"], by_default["options"]["detail"]) == (6, 0.005)


def test_the_open_border_is_complete(four):
    vertices, loops, start = engine.reading.read_polygons(four[0].with_name("out.ply"))
    ends = {}
    for q in np.split(loops, start[1:]):
        for a, b in zip(q, np.roll(q, -1), strict=True):
            ends[frozenset((int(a), int(b)))] = ends.get(frozenset((int(a), int(b))), 0) + 1
    border = [vertices[list(e)] for e, count in ends.items() if count == 1]
    length = sum(float(np.linalg.norm((b - a)[:2])) for a, b in border)
    assert length == pytest.approx(4, abs=0.1)


def run_bits(folder, out, **options):
    tiles.run(folder, out, proxies=P, labels=out.with_suffix(".labels"), **options)
    return out.read_bytes(), labels_in(out.with_suffix(".labels"))


def run_on(jobs, folder, out):
    return run_bits(folder, out, children=batch.Children(jobs))


def labels_in(folder):
    return [path.read_bytes() for path in sorted(folder.iterdir())]


@pytest.mark.parametrize("thin", [False, True])
def test_the_result_is_the_same_bits_for_any_number_of_workers(request, tmp_path, whole, thin):
    if thin:
        request.getfixturevalue("thinned")
    folder = tilesets.write(tmp_path / "in", tilesets.cut(*whole, 3, 1))
    assert run_on(1, folder, tmp_path / "a.ply") == run_on(2, folder, tmp_path / "b.ply")


@pytest.mark.parametrize("step", ["prepare/000003", "mend", "thin/000001"])
def test_a_run_that_was_killed_goes_on_and_gives_the_same_bits(tmp_path, four, step):
    folder, polygons, labels = four
    command = [sys.executable, "-m", "isimp_engine", "tiles", folder, tmp_path / "a.ply", "--proxies", P]
    command += ["--work", tmp_path / "work", "--labels", tmp_path / "a.labels"]
    process = subprocess.Popen([*map(str, command)], env=ENVIRONMENT, stderr=subprocess.DEVNULL)
    wait_for((tmp_path / "work" / step).exists)
    process.kill()
    process.wait()
    assert not (tmp_path / "a.ply").exists()
    done = ran(*command[3:])
    assert done.stderr.startswith("isimp: continues an earlier run, which did ")
    assert len(done.stderr.splitlines()) == 1
    assert (tmp_path / "a.ply").read_bytes() == polygons
    assert labels_in(tmp_path / "a.labels") == labels


def test_other_options_or_other_tiles_begin_anew(tmp_path, whole):
    parts = tilesets.cut(*whole, 2)
    folder = tilesets.write(tmp_path / "in", parts)
    states = []
    run = {"work": tmp_path / "work", "watch": lambda state: states.append(state.before)}
    assert tiles.run(folder, tmp_path / "a.obj", proxies=P, **run).report["regions"] == P
    assert tiles.run(folder, tmp_path / "a.obj", proxies=P - 4, **run).report["regions"] == P - 4
    assert max(states) == 0
    tiles.run(folder, tmp_path / "a.obj", proxies=P - 4, **run)
    assert max(states) == 2 + 1 + 2 + 1, "prepare, mend, thin and mesh"


def test_another_buffer_of_a_tile_begins_anew(tmp_path):
    vertices, triangles = shapes.cube(2)
    (tmp_path / "in").mkdir()
    meshfiles.gltf(tmp_path / "in" / "a.gltf", vertices, triangles)
    meshfiles.gltf(tmp_path / "a.gltf", 2 * vertices, triangles)
    states = []
    for _ in range(2):
        tiles.run(tmp_path / "in", tmp_path / "a.obj", proxies=6, work=tmp_path / "work", watch=states.append)
    assert states[-1].before == 1 + 1 + 1 + 1, "prepare, mend, thin and mesh"
    (tmp_path / "a.bin").replace(tmp_path / "in" / "a.bin")
    tiles.run(tmp_path / "in", tmp_path / "a.obj", proxies=6, work=tmp_path / "work", watch=states.append)
    assert states[-1].before == 0


@pytest.mark.parametrize("off", [1e-6, 1e-3])
def test_borders_that_are_off_are_welded(tmp_path, whole, off):
    random = np.random.default_rng(1)
    parts = tilesets.cut(*whole, 2, 2)
    moved = [(v + random.uniform(-off / 4, off / 4, v.shape), t, f) for v, t, f in parts]
    folder = tilesets.write(tmp_path / "in", moved)
    if off == 1e-6:  # vertices that are further apart are not equal either
        assert tiles.run(folder, tmp_path / "a.obj", proxies=P).report["unmatched_share"] == 1
    report = tiles.run(folder, tmp_path / "b.obj", proxies=P, weld=off, labels=tmp_path / "labels").report
    assert report["unmatched_edges"] == 4 * 48
    assert report["regions"] == P
    label = tilesets.labels_of(tmp_path / "labels", parts, len(whole[1]))
    assert tilesets.regions_are_connected(whole[1], label)


def test_vertices_inside_edges_of_another_tile_are_put_into_them(tmp_path):
    left, right = shapes.grid(8, (0, 0, 0), (1, 0, 0), (0, 1, 0)), shapes.grid(24, (1, 0, 0), (1, 0, 0.3), (0, 1, 0))
    folder = tilesets.write(tmp_path / "in", [(*left, None), (*right, None)])
    report = tiles.run(folder, tmp_path / "a.obj", proxies=2, labels=tmp_path / "labels").report
    assert report["t_junctions"] == 16
    assert report["unmatched_edges"] == 3 * 8 + 3 * 24
    assert len(np.load(tmp_path / "labels" / "tile_00.npy")) == 128
    assert report["output"]["polygons"] == 2
    vertices, loops, start = engine.reading.read_polygons(tmp_path / "a.obj")
    assert len(vertices) == 6, "the two sheets share an edge"
    assert sorted(np.diff(np.append(start, len(loops)))) == [4, 4]


def test_map_coordinates_stay(tmp_path, whole):
    offset = np.array([512_345.25, 5_043_210.5, 117.0])
    parts = tilesets.cut(whole[0] * 40, whole[1], 2, 2)
    folder = tilesets.write(tmp_path / "here", parts)
    there = tilesets.write(tmp_path / "there", [(v + offset, t, f) for v, t, f in parts])
    tiles.run(folder, tmp_path / "a.obj", proxies=P)
    report = tiles.run(there, tmp_path / "b.obj", proxies=P).report
    assert report["unmatched_edges"] == 4 * 48
    a, b = engine.reading.read_polygons(tmp_path / "a.obj"), engine.reading.read_polygons(tmp_path / "b.obj")
    assert b[0].min(0) == pytest.approx(offset + a[0].min(0), abs=0.2)
    assert report["output"]["manifold"]
    assert report["output"]["polygons"] <= P + 3


@pytest.mark.parametrize("suffix", [".ply", ".obj"])
def test_a_single_scan_is_cut_into_tiles(tmp_path, whole, suffix):
    writer = {".ply": meshfiles.ply_binary, ".obj": meshfiles.obj}[suffix]
    path = tmp_path / f"scan{suffix}"
    writer(path, whole[0], whole[1].tolist())
    outcome = tiles.run(path, tmp_path / "a.obj", proxies=P, labels=tmp_path / "labels", tile_faces=900)
    assert outcome.report["tiles"] >= 5
    assert outcome.report["unmatched_edges"] == 4 * 48
    label = np.load(tmp_path / "labels" / "scan.npy")
    assert sorted(set(label.tolist())) == list(range(P))
    assert tilesets.regions_are_connected(whole[1], label)


def test_there_may_be_more_tiles_than_open_files(tmp_path, whole, monkeypatch):
    resource = pytest.importorskip("resource")
    meshfiles.ply_binary(tmp_path / "scan.ply", whole[0], whole[1].tolist())
    monkeypatch.setattr(splitting, "_CHUNK", 500)
    limits = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (len(os.listdir("/dev/fd")) + 20, limits[1]))
    try:
        found = splitting.split_scan(tmp_path / "scan.ply", tmp_path / "tiles", 50)
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, limits)
    assert found["tiles"] > 80
    polygons = [store.load(tmp_path / "tiles" / store.tile_name(tile), "polygon") for tile in range(found["tiles"])]
    assert sorted(np.concatenate(polygons).tolist()) == list(range(len(whole[1])))
    assert all((np.diff(polygon) > 0).all() for polygon in polygons)


def test_a_polygon_in_several_tiles_has_the_region_with_most_of_its_area(tmp_path):
    rows = {  # tile: polygon, region of the triangle, its area
        0: [(0, 4, 3.0), (1, 5, 1.0), (2, 5, 1.0), (3, -1, 1.0)],
        1: [(0, -1, 4.0), (1, 6, 2.0), (2, 6, 1.5), (2, 5, 1.0), (4, 7, 1.0)],
    }
    for tile, found in rows.items():
        polygon, _, area = zip(*found, strict=True)
        thin = store.of_tile(tmp_path, "thin", tile)
        store.save(thin, polygon=np.int32(polygon), area=np.float32(area), to=np.arange(len(found), dtype=np.int32))
        store.save_values(thin, {"thinned_faces": len(found)})
    region = [region for found in rows.values() for _, region, _ in found]
    store.save(store.of_tile(tmp_path, "mesh", 0), region=np.int32(region))
    split = store.of_tile(tmp_path, "split", 0)
    split.mkdir(parents=True)
    store.save_values(split, {"faces": 6})
    results.write_labels(Plan([("scan.ply", Path("scan.ply"))], True, tmp_path / "a.obj", tmp_path, {}), tmp_path)
    assert np.load(tmp_path / "scan.npy").tolist() == [4, 6, 5, -1, 7, -1]


def test_a_closed_component_over_several_tiles_gets_its_four_regions(tmp_path):
    vertices, triangles = shapes.cube(10)
    parts = tilesets.cut(vertices, triangles, 2, 2)
    report = tiles.run(tilesets.write(tmp_path / "in", parts), tmp_path / "a.obj", proxies=6).report
    assert (report["regions"], report["unmatched_edges"]) == (6, 0)
    assert report["error"] < 0.02
    assert report["output"]["closed"]
    assert report["output"]["polygons"] == 6
    assert tiles.run(tmp_path / "in", tmp_path / "a.obj", proxies=1).report["regions"] == 4


def test_specks_are_left_out_and_tiles_without_faces_are_tiles(tmp_path):
    cube, speck = shapes.cube(8), shapes.cube(1)
    speck = (speck[0] * 0.01 + [3, 0, 0], speck[1])
    flat = (np.zeros((3, 3)), np.array([[0, 1, 1]]))
    parts = [(*cube, None), (*speck, None), (*flat, None)]
    folder = tilesets.write(tmp_path / "in", parts)
    report = tiles.run(folder, tmp_path / "a.obj", proxies=6, labels=tmp_path / "labels").report
    assert (report["parts_left_out"], report["regions"]) == (1, 6)
    assert set(np.load(tmp_path / "labels" / "tile_00.npy")) == set(range(6))
    assert np.load(tmp_path / "labels" / "tile_01.npy").tolist() == [-1] * 12
    assert np.load(tmp_path / "labels" / "tile_02.npy").tolist() == [-1]


def test_all_kinds_of_files_and_polygons_are_read(tmp_path):
    """Squares of a cube of three kinds of files, one tile a side."""
    folder = tmp_path / "in"
    folder.mkdir()
    sides = [(meshfiles.ply_ascii, ".ply"), (meshfiles.off, ".off"), (meshfiles.obj, ".obj")]
    sides += [(meshfiles.stl_ascii, ".stl"), (meshfiles.ply_binary, ".ply"), (meshfiles.ply_big, ".ply")]
    x, y, z = np.eye(3)
    frames = [(0 * x, y, x), (z, x, y), (0 * x, x, z), (y, z, x), (0 * x, z, y), (x, y, z)]
    for k, ((writer, suffix), frame) in enumerate(zip(sides, frames, strict=True)):
        vertices, triangles = shapes.grid(4, *frame)
        squares = np.concatenate([triangles[:16], triangles[16:, 2:]], 1)  # (a, b, c) and (a, c, d)
        writer(folder / f"{k}{suffix}", vertices, (triangles if suffix == ".stl" else squares).tolist())
    report = tiles.run(folder, tmp_path / "a.ply", proxies=6, labels=tmp_path / "labels").report
    assert report["unmatched_edges"] == 0
    assert report["output"]["closed"]
    assert report["output"]["polygons"] == 6
    sizes = [len(np.load(tmp_path / "labels" / f"{k}.npy")) for k in range(6)]
    assert sizes == [16, 16, 16, 32, 16, 16]
    assert len({tuple(set(np.load(tmp_path / "labels" / f"{k}.npy"))) for k in range(6)}) == 6


def test_the_command_writes_results_labels_and_a_report(tmp_path, whole):
    folder = tilesets.write(tmp_path / "in", tilesets.cut(*whole, 2))
    report = tmp_path / "r.json"
    done = called("tiles", folder, tmp_path / "a.obj", "--proxies", P, "--labels", tmp_path / "l", "--report", report)
    assert (done.returncode, done.stderr) == (0, "")
    assert "4,608 faces in 2 tiles" in done.stdout
    assert f"of {P} regions" in done.stdout
    said = json.loads(report.read_text())
    assert said["regions"] == P
    assert said["peak_mb"]["thin"] > 10
    assert said["output"]["path"] == str(tmp_path / "a.obj")
    assert sorted(p.name for p in (tmp_path / "l").iterdir()) == ["tile_00.npy", "tile_01.npy"]
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.obj", "in", "l", "r.json"]


@pytest.mark.parametrize(
    ("arguments", "status", "said"),
    [
        (("nowhere", "a.obj", "--proxies", 5), 2, "there is no such folder or scan"),
        (("empty", "a.obj", "--proxies", 5), 2, "there is no scan"),
        (("in", "a.stl", "--proxies", 5), 2, "OUTPUT must end in one of .ply, .obj"),
        (("in", "no/a.obj", "--proxies", 5), 2, "there is no folder no to write to"),
        (("in", "a.obj", "--proxies", 0), 2, "--proxies must be at least 1, got 0"),
        (("in", "a.obj", "--proxies", 5, "--smooth", 2), 2, "--smooth must be in [0, 1], got 2"),
        (("in", "a.obj", "--proxies", 5, "--detail", 0.1), 2, "--proxies and --detail contradict each other"),
        (("in", "a.obj", "--detail", 2), 2, "--detail must be in (0, 1], got 2"),
        (("in", "a.obj", "--proxies", 5, "--weld", -1), 2, "the length to weld within must be at least 0"),
        (("in", "a.obj", "--proxies", 5, "--jobs", 0), 2, "the number of jobs must be at least 1"),
        (("in", "a.obj", "--proxies", 100_000), 2, "100,000 regions of 4,608 faces can't be made"),
        (("torn", "a.obj", "--proxies", 5), 3, "tile_01.ply: "),
    ],
)
def test_what_is_wrong_is_said_in_one_line(tmp_path, whole, arguments, status, said):
    parts = tilesets.cut(*whole, 2)
    tilesets.write(tmp_path / "in", parts)
    tilesets.write(tmp_path / "torn", parts, meshfiles.ply_binary, ".ply")
    torn = tmp_path / "torn" / "tile_01.ply"
    torn.write_bytes(torn.read_bytes()[:-100])
    (tmp_path / "empty").mkdir()
    done = called("tiles", *arguments, cwd=tmp_path)
    assert (done.returncode, len(done.stderr.splitlines())) == (status, 1), done.stderr
    assert said in done.stderr
    assert not (tmp_path / "a.obj").exists()


@pytest.mark.parametrize("name", ["proxy", "curved", "tile_faces", "threads"])
def test_an_option_that_tiles_do_not_have_is_refused(tmp_path, whole, name):
    folder = tilesets.write(tmp_path / "in", tilesets.cut(*whole, 2))
    with pytest.raises(tiles.TilesError, match=rf"no option '{name}'; there are detail, .*planar, proxies"):
        tiles.run(folder, tmp_path / "a.obj", options={name: 1})


def test_every_option_that_is_listed_is_taken(tmp_path):
    listed = {"tolerance": 0.1, "noise": 0.0, "snap": False, "metric": "normals", "smooth": 0.4}
    more = {"leave_out": 0.0, "seed": 1, "planar": True}
    (tmp_path / "in").mkdir()
    meshfiles.ply_binary(tmp_path / "in" / "a.ply", *(part.tolist() for part in shapes.cube(2)))
    report = tiles.run(tmp_path / "in", tmp_path / "a.obj", options=listed | more).report
    assert report["options"] == listed | more | {"weld": 0.0}


def test_a_result_that_leads_to_a_tile_is_refused(tmp_path, whole):
    folder = tilesets.write(tmp_path / "in", tilesets.cut(*whole, 2), meshfiles.ply_binary, ".ply")
    first = sorted(folder.iterdir())[0]
    before = first.read_bytes()
    (folder / "city.ply").symlink_to(first.name)
    done = called("tiles", folder, folder / "city.ply", "--proxies", P)
    assert (done.returncode, len(done.stderr.splitlines())) == (2, 1), done.stderr
    assert f"leads to the tile {first}" in done.stderr
    assert first.read_bytes() == before


def test_ctrl_c_ends_it_and_the_next_run_goes_on(tmp_path, whole):
    folder = tilesets.write(tmp_path / "in", tilesets.cut(*whole, 3, 2))
    command = [sys.executable, "-m", "isimp_engine", "tiles", folder, tmp_path / "a.obj", "--proxies", P]
    process = subprocess.Popen([*map(str, command)], env=ENVIRONMENT, stderr=subprocess.PIPE, text=True)
    wait_for((tmp_path / ".a.obj.tiles" / "mend").exists)
    process.send_signal(signal.SIGINT)
    said = process.communicate(timeout=20)[1]
    assert process.returncode == 130
    assert said.splitlines()[-1].endswith("; the same command continues from there")
    done = called(*command[3:])
    assert done.returncode == 0
    assert "continues an earlier run" in done.stderr
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.obj", "in"]


def test_two_runs_do_not_work_in_one_folder(tmp_path, whole):
    from isimp_engine.batch.table import Lock

    folder = tilesets.write(tmp_path / "in", tilesets.cut(*whole, 2))
    with Lock(tmp_path / "work"), pytest.raises(tiles.TilesError, match=rf"process {os.getpid()} on .* works on it"):
        tiles.run(folder, tmp_path / "a.obj", proxies=P, work=tmp_path / "work")


def test_the_package_stays_importable_by_steps_alone():
    code = "from isimp_engine.tiles import tasks; print('thin' in tasks._STEPS)"
    done = subprocess.run([sys.executable, "-c", code], env=ENVIRONMENT, capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("True\n", "")
    assert Path(engine.__file__).with_name("tiles").is_dir()
