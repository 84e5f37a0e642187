"""Openings that scanning left: closed by default in the command, where the regions can't show them."""

import json

import numpy as np
import pytest

import isimp_engine as engine
import meshfiles
import shapes
from commands import ran
from isimp import recipe as rcp
from isimp.session import Session, StepFailed
from isimp_engine import batch
from isimp_engine.cli.command import parser
from isimp_engine.cli.simplify import run, task_of
from session_scans import scan_of

REGIONS = 30


def simplified(tmp_path, mesh, *options):
    meshfiles.ply_binary(tmp_path / "scan.ply", mesh[0], mesh[1].tolist())
    done = ran("simplify", tmp_path / "scan.ply", tmp_path / "o.ply", "--report=-", *options)
    return json.loads(done.stdout), done.stderr


def test_tunnels_that_the_regions_cannot_show_are_closed_and_named(tmp_path):
    report, said = simplified(tmp_path, shapes.room(24), f"--proxies={REGIONS}")
    assert report["closed_below"] > 4.5
    assert report["repair"]["cut_handles"] == 24
    assert len(report["repaired_at"]["cut_handles"]) > 0
    assert "openings up to" in said
    assert "--keep-openings" in said
    assert report["output"]["closed"]
    assert report["mesh"]["euler"] == 0, "the door and the window make one real handle"
    whole, _ = simplified(tmp_path, shapes.room(0), f"--proxies={REGIONS}")
    kept, _ = simplified(tmp_path, shapes.room(24), f"--proxies={REGIONS}", "--keep-openings")
    assert report["output"]["polygons"] <= 1.1 * whole["output"]["polygons"], "tunnels leave no dents"
    assert kept["output"]["polygons"] > 1.15 * report["output"]["polygons"]


@pytest.mark.parametrize("options", [["--keep-openings"], ["--cut-handles=0.1"], ["--bound=3"]])
def test_all_openings_are_kept_on_request(tmp_path, options):
    asked = [] if options[0].startswith("--bound") else [f"--proxies={REGIONS}"]
    report, said = simplified(tmp_path, shapes.room(16), *asked, *options)
    assert report["closed_below"] is None
    assert (report["repair"]["cut_handles"], report["mesh"]["euler"]) == (0, -32)
    assert "openings up to" not in said


@pytest.mark.parametrize("closes", [None, True, False])
def test_a_recipe_decides_whether_openings_are_closed(tmp_path, closes):
    step = {"step": "partition", "proxies": REGIONS} | ({} if closes is None else {"close_openings": closes})
    (tmp_path / "r.json").write_text(json.dumps({"isimp_recipe": 1, "steps": [step]}))
    report, _ = simplified(tmp_path, shapes.room(16), "--recipe", tmp_path / "r.json")
    assert report["repair"]["cut_handles"] == (0 if closes is False else 16)


def test_a_batch_closes_openings_as_the_command_does(tmp_path):
    report, _ = simplified(tmp_path, shapes.room(16), f"--proxies={REGIONS}")
    for keep, repaired in ((False, 16), (True, 0)):
        options = {"proxies": REGIONS, "keep_openings": keep}
        (row,) = batch.run(tmp_path / "scan.ply", tmp_path / f"out{keep}", options=options, format="ply").rows
        assert row["repaired"] == repaired
    assert (tmp_path / "outFalse" / "scan.ply").read_bytes() == (tmp_path / "o.ply").read_bytes()
    assert report["repair"]["cut_handles"] == 16


def test_drawn_models_keep_their_openings(tmp_path):
    report, _ = simplified(tmp_path, shapes.room(16, noise=0), f"--proxies={REGIONS}")
    assert report["closed_below"] is None
    assert report["mesh"]["euler"] == -32


def test_a_mesh_cut_on_a_grid_loses_handles_of_walls_thinner_than_a_cell():
    for size, euler in ((1, 2), (2, -16)):
        scan = shapes.voxels(shapes.plate(3, 3, 1, size=size))
        found = engine.simplify(scan, preset="generated")
        assert found.mesh.report["euler"] == euler
        assert len(found.mesh.openings) == (9 if size == 1 else 0)
        assert engine.simplify(scan).mesh.report["euler"] == -16


def test_more_regions_show_more_openings(tmp_path):
    few, _ = simplified(tmp_path, shapes.room(16), "--proxies=30")
    many, _ = simplified(tmp_path, shapes.room(16), "--proxies=2000")
    assert (few["repair"]["cut_handles"], many["repair"]["cut_handles"]) == (16, 0)


def test_with_a_detail_the_found_regions_decide_which_openings_are_closed(tmp_path):
    report, _ = simplified(tmp_path, shapes.room(16), "--detail=0.3")
    area = report["mesh"]["area"]
    assert report["repair"]["cut_handles"] == 16
    assert report["closed_below"] <= 0.5 * np.sqrt(area / 6)


def test_the_pinholes_of_a_house_are_filled(tmp_path):
    report, _ = simplified(tmp_path, shapes.mvs_house(), "--proxies=150", "--leave-out=0.002")
    kept, _ = simplified(tmp_path, shapes.mvs_house(), "--proxies=150", "--leave-out=0.002", "--keep-openings")
    assert report["repair"]["filled_holes"] >= 36, "40 vertices are missing"
    assert kept["mesh"]["border_loops"] == 40
    assert report["output"]["polygons"] <= 1.3 * report["output"]["regions"]
    assert report["output"]["polygons"] < kept["output"]["polygons"]


def test_the_length_needs_a_region():
    mesh = engine.clean(*shapes.room(0))
    with pytest.raises(engine.InvalidInput, match="regions must be at least 1, got 0"):
        engine.regions.opening_length(mesh, 0)
    assert engine.regions.opening_length(mesh, 30) > engine.regions.opening_length(mesh, 3000) > 0


def test_the_add_on_closes_them_too_and_edits_the_closed_mesh():
    scan, session = scan_of(*shapes.room(16)), Session()
    steps = rcp.Recipe((rcp.Partition(proxies=REGIONS),))
    outcome = session.replay(scan, steps)
    assert outcome.repair.lengths.handles > 4
    assert outcome.numbers["repairs"]["cut_handles"] == 16
    gone = outcome.face_region < 0
    assert 0 < gone.sum() < 16 * 40, "the walls of the tunnels are in no region"
    kept = session.replay(scan, rcp.Recipe((rcp.Partition(proxies=REGIONS, close_openings=False),)))
    assert kept.repair.lengths.handles == 0
    assert (kept.face_region >= 0).all()
    made = session.replay(scan, steps.then(rcp.Mesh()))
    whole = session.replay(scan_of(*shapes.room(0)), steps.then(rcp.Mesh()))
    assert made.numbers["polygons"] <= 1.1 * whole.numbers["polygons"]
    face = int(np.flatnonzero(~gone)[0])
    edited = session.replay(scan, steps.then(rcp.AddProxy(face=face)))
    assert edited.repair == outcome.repair
    assert edited.numbers["regions"] == REGIONS + 1
    with pytest.raises(StepFailed, match="left out by the repair"):
        session.replay(scan, steps.then(rcp.AddProxy(face=int(np.flatnonzero(gone)[0]))))


def test_the_add_on_closes_the_same_as_the_command(tmp_path):
    report, _ = simplified(tmp_path, shapes.room(16), f"--proxies={REGIONS}")
    outcome = Session().replay(scan_of(*shapes.room(16)), rcp.Recipe((rcp.Partition(proxies=REGIONS),)))
    assert outcome.repair.lengths.holes == pytest.approx(report["options"]["clean"]["fill_holes"], rel=1e-5)
    assert outcome.repair.lengths.handles == pytest.approx(report["options"]["clean"]["cut_handles"], rel=1e-5)


@pytest.mark.parametrize("most", [1, 10**6])
def test_openings_that_are_closed_before_the_regions_are_counted_are_the_same(monkeypatch, tmp_path, most):
    """most: regions up to which the guess is claimed to be right; at one of them it is wrong."""
    steps = rcp.Recipe((rcp.Partition(detail=0.1),))
    counted = Session().replay(scan_of(*shapes.room(16)), steps)
    report, _ = simplified(tmp_path, shapes.room(16), "--detail=0.1")
    scan = scan_of(*shapes.room(16))
    lengths = engine.openings.lengths(engine.clean(scan.vertices, scan.triangles), report["regions"])
    asked = []

    def guess(mesh, options, job):
        asked.append(len(mesh.triangles))
        found = (9.0, 9.0, 9.0) if most == 1 else (lengths.holes, lengths.flat_holes, lengths.handles)
        return *found, most, True

    monkeypatch.setattr(engine.openings, "_guess_opening_lengths", guess)
    guessed = Session().replay(scan_of(*shapes.room(16)), steps)
    assert asked == [len(shapes.room(16)[1])], "on the scan as it is, once"
    assert guessed.repair == counted.repair
    assert np.array_equal(guessed.face_region, counted.face_region)
    arguments = parser().parse_args(["simplify", str(tmp_path / "scan.ply"), str(tmp_path / "p.ply"), "--detail=0.1"])
    done = run(task_of(arguments))
    assert (len(asked), done.report["closed_below"]) == (2, report["closed_below"])
    assert (tmp_path / "p.ply").read_bytes() == (tmp_path / "o.ply").read_bytes()


@pytest.mark.parametrize("shift", [0.0, 4.6e6])
def test_openings_of_a_repaired_mesh_are_closed_as_by_a_repair_of_the_arrays(shift):
    vertices, triangles = shapes.room(16)
    vertices = np.append(vertices, vertices[:1], axis=0) + shift  # one vertex that no face uses
    plain = engine.clean(vertices, np.append(triangles, triangles[:1], axis=0))
    options = engine.CleanOptions(fill_holes=9.0, cut_handles=9.0)
    kept = np.array([engine.regions.close_openings(plain, options).openings[0]["center"]])
    for keep in (None, kept):
        whole = engine.clean(vertices, np.append(triangles, triangles[:1], axis=0), options, keep=keep)
        closed = engine.regions.close_openings(plain, options, keep=keep)
        for name in ("vertices", "triangles", "source_face", "source_vertex"):
            assert np.array_equal(getattr(closed, name), getattr(whole, name))
        assert (closed.report, closed.report["repairs"]["duplicate_faces"]) == (whole.report, 1)
        assert [o["kept"] for o in closed.openings] == [o["kept"] for o in whole.openings]
        assert any(o["kept"] for o in closed.openings) == (keep is not None)
    assert plain.report["euler"] == -32, "the mesh that was given stays"
    with pytest.raises(engine.InvalidInput, match="fill_holes must be a length, at least 0"):
        engine.regions.close_openings(plain, engine.CleanOptions(fill_holes=-1.0))
    with pytest.raises(engine.InvalidInput, match="not finite"):
        engine.regions.close_openings(plain, options, keep=np.full((1, 3), np.nan))


def test_covers_belong_to_the_adjacent_face():
    scan = scan_of(*shapes.room(4))
    mesh = engine.clean(scan.vertices, scan.triangles, engine.CleanOptions(cut_handles=5.0))
    covers = np.flatnonzero(mesh.source_face < 0)
    assert len(covers) > 0
    faces = engine.repairs.Repaired(scan.source, engine.repairs.Repair(), mesh).faces
    for cover, face in zip(covers, faces.mesh_face[covers], strict=True):
        near = np.isin(scan.triangles, mesh.source_vertex[mesh.triangles[cover]]).any(axis=1)
        assert near[face]
    assert (faces.face_triangle[faces.mesh_face[covers]] < covers.min()).all(), "a face stands for itself"


def test_a_plate_of_many_holes_is_exact_in_few_regions():
    """The walls of the holes are in the regions of the plate's sides. They become polygons, four a hole."""
    mesh = engine.clean(*shapes.voxels(shapes.plate(6, 6, 1, size=1, gap=2)))
    poly = engine.polygonize(mesh, engine.partition(mesh, engine.PartitionOptions(proxies=6)))
    assert poly.report["imperfect"] == []
    assert poly.report["euler"] == mesh.report["euler"] == 2 - 2 * 36
    assert poly.report["planarity_max"] == 0
    assert poly.report["polygons"] <= 5 * 36
