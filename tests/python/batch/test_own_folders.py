"""isimp removes only files that it made and marked, and a run that was ended anywhere can be repeated."""

import json
import os
import shutil
from pathlib import Path

import pytest

import shapes
import tilesets
from batches import ODD
from isimp_engine import batch, folders, tiles
from isimp_engine.batch import page, table
from isimp_engine.batch.run import Outcome
from isimp_engine.cli import batch as command
from isimp_engine.folders import MARK, NotOwn, Own

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="batches and tiles need fork")


@pytest.fixture
def tile(tmp_path):
    return tilesets.write(tmp_path / "in", tilesets.cut(*shapes.cube(1), 1))


@pytest.mark.parametrize("plan", ['{"version": 4}', '{"key": "0", "isimp": "1"}', "[]", ""])
def test_a_folder_of_the_users_with_a_plan_does_not_change(tmp_path, tile, plan):
    project = tmp_path / "project"
    (project / "sub").mkdir(parents=True)
    (project / "plan.json").write_text(plan)
    (project / "thesis.txt").write_text("precious")
    with pytest.raises(tiles.TilesError, match="is not empty and no work folder of isimp tiles"):
        tiles.run(tile, tmp_path / "o.obj", proxies=6, work=project)
    assert sorted(os.listdir(project)) == ["plan.json", "sub", "thesis.txt"]
    assert (project / "plan.json").read_text() == plan


def test_a_work_folder_in_which_the_user_put_something_is_refused(tmp_path, tile):
    work = tmp_path / "work"
    tiles.run(tile, tmp_path / "o.obj", proxies=6, work=work)
    (work / "thesis.txt").write_text("precious")
    with pytest.raises(tiles.TilesError, match=r"work: holds thesis\.txt, which isimp did not put there"):
        tiles.run(tile, tmp_path / "o.obj", proxies=5, work=work)
    assert (work / "thesis.txt").exists()
    assert (work / "prepare").exists()


def ended(state, work: Path):
    """A work folder as a run leaves it that is ended while it makes or removes the folder."""
    work.mkdir()
    if state != "unmarked":
        (work / MARK).touch()
    if state == "part":
        (work / "plan.json.part").write_text('{"key"')
    else:
        (work / "prepare" / "000000").mkdir(parents=True)
        (work / "prepare" / "000000" / "values.json").write_text("{}")
        (work / "parts" / "tmp1").mkdir(parents=True)
    if state == "power":
        (work / "plan.json").write_bytes(bytes(100))


@pytest.mark.parametrize("state", ["part", "removing", "unmarked", "power"])
def test_the_folder_of_a_run_that_was_ended_is_no_dead_end(tmp_path, tile, state):
    ended(state, tmp_path / ".o.obj.tiles")
    assert tiles.run(tile, tmp_path / "o.obj", proxies=6).report["regions"] == 6
    assert sorted(os.listdir(tmp_path)) == ["in", "o.obj"]


def test_the_content_of_a_folder_is_removed_first_and_its_mark_last(tmp_path, monkeypatch):
    own = Own(tmp_path / "own", "plan|step")
    own.take(unmarked=False)
    (own.path / "plan").touch()
    (own.path / "step").mkdir()
    with monkeypatch.context() as patch:
        patch.setattr(shutil, "rmtree", lambda path: (_ for _ in ()).throw(PermissionError(13, "no", str(path))))
        own.remove("plan")
    assert sorted(os.listdir(own.path)) == [MARK, "step"]
    own.take(unmarked=False)
    own.remove("plan")
    assert not own.path.exists()


def test_nothing_outside_such_a_folder_is_removed(tmp_path):
    (tmp_path / "step").mkdir()
    with pytest.raises(NotOwn, match="is in no folder of isimp's own"):
        folders.discard(tmp_path / "step")
    assert (tmp_path / "step").exists()
    (tmp_path / "own").symlink_to(tmp_path / "step")
    with pytest.raises(NotOwn, match="is a link"):
        Own(tmp_path / "own", ".*").take(unmarked=True)
    own = Own(tmp_path / "other", ".*")
    own.take(unmarked=False)
    (own.path / "parts").symlink_to(tmp_path / "step")
    with pytest.raises(NotOwn, match="parts: is a link"):
        own.take(unmarked=False)


@pytest.mark.parametrize("name", [".isimp-batch", ".isimp-batch/parts", ".isimp-batch/lock", "results.jsonl"])
def test_links_do_not_lead_a_batch_out_of_its_folder(scans, tmp_path, name):
    victim, link = tmp_path / "victim", tmp_path / "out" / name
    link.parent.mkdir(parents=True)
    if "." in link.name or link.name == "parts":
        (victim / "parts").mkdir(parents=True)
        (victim / "parts" / "precious").write_text("precious")
    if name in ("results.jsonl", ".isimp-batch/lock"):
        shutil.rmtree(victim, ignore_errors=True)
        victim.write_text("precious")
    link.symlink_to(victim)
    with pytest.raises(batch.BatchError, match="is a link"):
        batch.run(scans, tmp_path / "out", work=ODD)
    assert "precious" in ((victim / "parts" / "precious") if victim.is_dir() else victim).read_text()


def test_a_key_of_a_row_names_no_file_but_a_picture(scans, tmp_path):
    out, photo = tmp_path / "out", tmp_path / "victim" / "photo.png"
    photo.parent.mkdir()
    photo.write_text("precious")
    out.mkdir()
    row = {"name": "a.ply", "status": "ok", "key": "../../../victim/photo", "seconds": 1, "peak_mb": 1}
    (out / "results.jsonl").write_text(json.dumps(row) + "\n")
    assert len(batch.run(scans, out, work=ODD).rows) == 3
    assert photo.exists()


GOOD = {"name": "a.ply", "status": "ok", "key": "0" * 32, "seconds": 1.5, "peak_mb": 30, "faces": 12, "polygons": 6}
ODD_VALUES = [None, True, "<b>", "\ud800", [1], {}, -1, 10**400, 1e308, float("nan"), float("inf"), ["<b>", 5], "a\0b"]


@pytest.mark.parametrize("status", ["ok", "failed"])
def test_rows_may_hold_anything(tmp_path, status):
    names = [*GOOD, "why", "output", "regions", "warnings", "planarity_mean", "diagonal", "scan_distance", "manifold"]
    names.append("files")
    rows = [GOOD | {"status": status, "name": f"{name}{k}"} for name in names for k in range(len(ODD_VALUES))]
    for k, name in enumerate(names):
        for n, value in enumerate(ODD_VALUES):
            rows[k * len(ODD_VALUES) + n][name] = value
    lines = [json.dumps(row) for row in rows] + ["[" * 100_000 + "]" * 100_000, '{"name": "z", "status": "ok"}']
    (tmp_path / "results.jsonl").write_text("\n".join(lines) + "\n")
    (tmp_path / ".isimp-batch").mkdir()
    found = batch.table.read_rows(tmp_path)
    assert len(found) > 0.8 * len(rows)
    assert found[-1]["name"] == "z"
    page.write(tmp_path, found, tmp_path)
    assert "<b>" not in (tmp_path / "results.html").read_text()
    outcome = Outcome(found, len(found), 0, cut_short=False)
    said = "\n".join(command.summary(outcome, tmp_path, False))
    os.fsencode(said)
    assert all(table._is_key(row["key"]) or row["key"] == "" for row in found)
