"""Openings that scanning left: closed by default in the command, where the regions can't show them."""

import json

import numpy as np
import pytest

import isimp_engine as engine
import meshfiles
import shapes
from isimp_engine import batch
from test_cli import isimp

REGIONS = 30


def simplified(tmp_path, mesh, *options):
    meshfiles.ply_binary(tmp_path / "scan.ply", mesh[0], mesh[1].tolist())
    done = isimp("simplify", tmp_path / "scan.ply", tmp_path / "o.ply", "--report=-", *options)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout), done.stderr


def test_tunnels_that_the_regions_cannot_show_are_closed_and_named(tmp_path):
    report, said = simplified(tmp_path, shapes.room(16), f"--proxies={REGIONS}")
    assert report["closed_below"] > 4.5
    assert report["repair"]["cut_handles"] == 16
    assert len(report["repaired_at"]["cut_handles"]) > 0
    assert "openings up to" in said
    assert "--keep-openings" in said
    assert report["output"]["closed"]
    assert report["mesh"]["euler"] == 0, "the door and the window make one real handle"
    whole, _ = simplified(tmp_path, shapes.room(0), f"--proxies={REGIONS}")
    kept, _ = simplified(tmp_path, shapes.room(16), f"--proxies={REGIONS}", "--keep-openings")
    assert report["output"]["polygons"] <= 1.1 * whole["output"]["polygons"], "tunnels leave no dents"
    assert kept["output"]["polygons"] > 1.15 * report["output"]["polygons"]


@pytest.mark.parametrize("options", [["--keep-openings"], ["--cut-handles=0.1"], ["--bound=3"]])
def test_all_openings_are_kept_on_request(tmp_path, options):
    asked = [] if options[0].startswith("--bound") else [f"--proxies={REGIONS}"]
    report, said = simplified(tmp_path, shapes.room(16), *asked, *options)
    assert report["closed_below"] is None
    assert report["repair"]["cut_handles"] == 0
    assert report["mesh"]["euler"] == -32
    assert "openings up to" not in said


def test_a_recipe_means_the_same_as_in_the_add_on_which_closes_nothing(tmp_path):
    recipe = {"isimp_recipe": 1, "steps": [{"step": "partition", "proxies": REGIONS}]}
    (tmp_path / "r.json").write_text(json.dumps(recipe))
    report, _ = simplified(tmp_path, shapes.room(16), "--recipe", tmp_path / "r.json")
    assert report["closed_below"] is None
    assert report["mesh"]["euler"] == -32


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


def test_more_regions_show_more_openings(tmp_path):
    few, _ = simplified(tmp_path, shapes.room(16), "--proxies=30")
    many, _ = simplified(tmp_path, shapes.room(16), "--proxies=2000")
    assert few["repair"]["cut_handles"] == 16
    assert many["repair"]["cut_handles"] == 0


def test_with_a_detail_the_regions_found_tell_what_is_closed(tmp_path):
    report, _ = simplified(tmp_path, shapes.room(16), "--detail=0.3")
    area = report["mesh"]["area"]
    assert report["repair"]["cut_handles"] == 16
    assert report["closed_below"] <= 0.5 * np.sqrt(area / 6)


def test_the_length_needs_a_region():
    mesh = engine.clean(*shapes.room(0))
    with pytest.raises(engine.InvalidInput, match="regions must be at least 1, got 0"):
        engine.opening_length(mesh, 0)
    assert engine.opening_length(mesh, 30) > engine.opening_length(mesh, 3000) > 0
