"""`isimp simplify --flat` and `merge_flat`: coplanar faces as polygons, and nothing else."""

import json

import numpy as np
import pytest

import isimp_engine as engine
import meshfiles
import shapes
from commands import called, check_line, ran
from isimp_engine.cli import flat, guiding
from isimp_engine.cli.command import parser
from isimp_engine.cli.errors import UsageError


def merged(vertices, triangles, **more):
    return engine.merge_flat(engine.Mesh(vertices, triangles), **more)


def test_vertices_equal_the_scan():
    vertices, triangles = shapes.facade()
    mesh = engine.clean(vertices, triangles)
    poly, region = engine.merge_flat(mesh)
    assert {tuple(v) for v in poly.vertices} <= {tuple(v) for v in mesh.vertices}
    assert region.shape == (len(mesh.triangles),)
    assert set(region.tolist()) == set(poly.polygon_region.tolist()) == set(range(poly.report["regions"]))
    assert len(poly.loop_start) < 0.3 * len(triangles)
    assert poly.report["manifold"]


@pytest.mark.parametrize(
    "name", ["building/frankfurt_tile_49k.ply", "building/fandisk_13k.ply", "nasty/ogre_124k_44comp.ply"]
)
def test_topology_of_real_meshes_stays(data, name):
    """The slivers of the tile, which lose all between their ends, must not double an edge."""
    mesh = engine.clean(*engine.read(data / name))
    for angle in (0.01, 5.0):
        poly, _ = engine.merge_flat(mesh, angle)
        assert poly.report["manifold"]
        assert poly.report["euler"] == mesh.report["euler"]
        assert len(poly.loop_start) < len(mesh.triangles)


def test_the_command_merges_and_reports(tmp_path):
    source, out, report, labels = (tmp_path / name for name in ("in.ply", "out.ply", "r.json", "labels.npy"))
    meshfiles.ply_binary(source, *(part.tolist() if k else part for k, part in enumerate(shapes.cube(5))))
    done = ran("simplify", source, out, "--flat", "--report", report, "--labels", labels)
    assert "6 flat parts -> 6 polygons" in done.stdout
    told = json.loads(report.read_text())
    assert (told["regions"], told["output"]["polygons"], told["output"]["corners"]) == (6, 6, 24)
    assert (told["output"]["vertices"], told["options"]["flat"]) == (8, 0.01)
    found = np.load(labels)
    assert len(found) == 300
    assert np.bincount(found).tolist() == [50] * 6
    vertices, _, start = engine.reading.read_polygons(out)
    assert len(start) == 6
    assert {tuple(v) for v in vertices.tolist()} == {(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)}


def test_options_of_the_repair_and_of_files_are_used(tmp_path):
    source, out, report = (tmp_path / name for name in ("in.ply", "out.obj", "r.json"))
    vertices, triangles = shapes.cube(4)
    meshfiles.ply_binary(source, vertices, triangles[1:].tolist())
    place = ",".join(map(str, vertices[triangles[0]].mean(axis=0)))
    used = "--fill-holes 2 --weld 0 --grid off --stitch 0 --threads 1 --unit mm --keep-openings --quiet"
    for more, filled in ((), 1), (("--keep-opening", place), 0):
        given = [*used.split(), "--crs", "25832", "--report", report, "--labels", tmp_path / "l.npy", *more]
        done = called("simplify", source, out, "--flat", *given)
        assert (done.returncode, done.stderr) == (0, "")
        assert json.loads(report.read_text())["repair"]["filled_holes"] == filled


def test_an_angle_can_be_given(tmp_path):
    source = tmp_path / "in.ply"
    meshfiles.ply_binary(source, *(part.tolist() if k else part for k, part in enumerate(shapes.bumpy(20))))
    counts = []
    for angle in ([], ["10"]):
        out = tmp_path / "out.ply"
        assert called("simplify", source, out, "--flat", *angle).returncode == 0
        counts.append(len(engine.reading.read_polygons(out)[2]))
    assert counts[0] > 2 * counts[1]


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--proxies", "7"], "--flat and --proxies"),
        (["--texture"], "--flat and --texture"),
        (["--lods", "7,3"], "--flat and --lods"),
        (["--planar"], "--flat and --planar"),
        (["--regularise"], "--flat and --regularise"),
        (["--backend", "cuda"], "--flat and --backend"),
    ],
)
def test_what_flat_does_not_do_is_refused(tmp_path, more, said):
    source = tmp_path / "in.ply"
    meshfiles.ply_binary(source, *(part.tolist() if k else part for k, part in enumerate(shapes.cube(2))))
    check_line(called("simplify", source, tmp_path / "out.obj", "--flat", *more), 2, said)
    check_line(called("simplify", source, tmp_path / "out.obj", "--flat", "100"), 2, "[0, 90]")
    assert not (tmp_path / "out.obj").exists()


@pytest.mark.parametrize(
    "option",
    [
        "--triangles 500",
        "--curved",
        "--preset cad",
        "--clutter box",
        "--angle 0",
        "--no-snap",
        "--sharp-edges",
        "--straight-rims 0",
        "--snap-sizes 1",
        "--strict",
        *(f"--{name} x.npy" for name in guiding.FILES),
    ],
)
def test_no_option_without_effect_is_taken(option):
    arguments = parser().parse_args(["simplify", "in.ply", "out.obj", "--flat", *option.split()])
    with pytest.raises(UsageError, match=f"^--flat and {option.split()[0]} exclude each other"):
        flat.check(arguments)
