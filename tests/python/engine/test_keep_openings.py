"""Openings that stay open one by one: in the module, the command, recipes and the add-on."""

import json
import pickle

import numpy as np
import pytest

import isimp_engine as engine
import shapes
from isimp import messages, openings
from isimp import recipe as rcp
from isimp.session import Session
from isimp_engine import recipes
from session_scans import scan_of
from test_openings import REGIONS, simplified


def spot(report):
    """A place at the fourth opening, beside its middle."""
    opening = report["openings"][3]
    x, y, z = opening["center"]
    return f"{x!r},{y!r},{z + 0.05 * opening['length']!r}"


def test_a_named_tunnel_stays_and_the_others_are_cut(tmp_path):
    before, said = simplified(tmp_path, shapes.room(16), f"--proxies={REGIONS}")
    assert len(before["openings"]) == 16
    assert {opening["kind"] for opening in before["openings"]} == {"handle"}
    lengths = [opening["length"] for opening in before["openings"]]
    assert lengths == sorted(lengths, reverse=True)
    assert "--keep-opening X,Y,Z" in said
    after, said = simplified(tmp_path, shapes.room(16), f"--proxies={REGIONS}", f"--keep-opening={spot(before)}")
    assert after["repair"]["cut_handles"] == 15
    assert after["mesh"]["euler"] == before["mesh"]["euler"] - 2
    assert [opening["center"] for opening in after["openings"] if opening["kept"]] == [before["openings"][3]["center"]]
    assert said.count("kept open: a handle") == 1
    assert "warning" not in said


def test_a_place_without_an_opening_is_warned_of(tmp_path):
    _, said = simplified(tmp_path, shapes.room(16), f"--proxies={REGIONS}", "--keep-opening=900,0,0")
    assert "warning: no opening that would be closed is at 900,0,0" in said


def test_lengths_of_the_user_s_own_keep_them_too(tmp_path):
    before, _ = simplified(tmp_path, shapes.room(16), "--cut-handles=5")
    after, _ = simplified(tmp_path, shapes.room(16), "--cut-handles=5", f"--keep-opening={spot(before)}")
    assert after["repair"]["cut_handles"] == 15


@pytest.mark.parametrize("wrong", ["1,2", "1,2,x", "1,2,nan", ""])
def test_a_place_is_three_numbers(tmp_path, wrong):
    with pytest.raises(AssertionError, match="--keep-opening"):
        simplified(tmp_path, shapes.room(0), f"--keep-opening={wrong}")


def test_a_recipe_keeps_them(tmp_path):
    before, _ = simplified(tmp_path, shapes.room(16), f"--proxies={REGIONS}")
    step = rcp.Partition(proxies=REGIONS).keeping(before["openings"][3]["center"], keep=True)
    (tmp_path / "r.json").write_text(rcp.Recipe((step,)).to_json())
    after, _ = simplified(tmp_path, shapes.room(16), "--recipe", tmp_path / "r.json")
    assert after["repair"]["cut_handles"] == 15


@pytest.mark.parametrize("wrong", [3, [1, 2, 3], [[1, 2]], [[1, 2, "x"]], [[1, 2, float("inf")]], None])
def test_a_recipe_with_wrong_places_is_refused(wrong):
    values = {"isimp_recipe": 1, "steps": [{"step": "partition", "keep_openings": wrong}]}
    with pytest.raises(recipes.RecipeError, match=r"step 1: .*keep_openings"):
        recipes.parsed(values)
    with pytest.raises(rcp.RecipeError, match="keep_openings"):
        rcp.Recipe.from_json(json.dumps(values))


def test_a_step_keeps_and_closes_places():
    step = rcp.Partition(proxies=5)
    assert "keep_openings" not in step.to_dict()
    two = step.keeping((1, 2, 3), keep=True).keeping((4, 5, 6), keep=True).keeping((4, 5, 6), keep=True)
    assert two.keep_openings == ((1, 2, 3), (4, 5, 6))
    assert rcp.step_from_dict(json.loads(json.dumps(two.to_dict()))) == two
    assert two.keeping((4, 5, 7), keep=False).keep_openings == ((1, 2, 3),)
    assert step.keeping((0, 0, 0), keep=False) == step


def test_the_last_partition_of_all_faces_decides_which_openings_stay():
    first, second = rcp.Partition(proxies=5), rcp.Partition(proxies=6)
    part = rcp.Partition(proxies=2, faces=(1, 2))
    assert rcp.Recipe((first, rcp.AddProxy(face=1), part)).whole() == (0, first)
    assert rcp.Recipe((first, rcp.LockRegions(faces=(1,)), second)).whole() == (2, second)
    assert rcp.Recipe().whole() == (-1, None)


def test_the_module_lists_and_keeps_openings_and_copies_have_them():
    vertices, triangles = shapes.room(4)
    options = engine.CleanOptions(cut_handles=5.0)
    mesh = engine.clean(vertices, triangles, options)
    assert len(mesh.openings) == 4
    one = mesh.openings[0]
    assert (one["kind"], one["kept"], len(one["loops"])) == ("handle", False, 2)
    kept = engine.clean(vertices, triangles, options, keep=np.array([one["center"]]))
    assert sum(opening["kept"] for opening in kept.openings) == 1
    again = pickle.loads(pickle.dumps(kept))  # noqa: S301
    for a, b in zip(kept.openings, again.openings, strict=True):
        assert (a["center"], a["length"], a["kept"]) == (b["center"], b["length"], b["kept"])
        assert all(np.array_equal(x, y) for x, y in zip(a["loops"], b["loops"], strict=True))
    assert engine.clean(vertices, triangles).openings == []
    with pytest.raises(engine.InvalidInput, match="keep"):
        engine.clean(vertices, triangles, options, keep=np.zeros((2, 2)))
    with pytest.raises(engine.InvalidInput, match="not finite"):
        engine.clean(vertices, triangles, options, keep=np.array([[0, 0, np.nan]]))


def test_openings_are_where_the_caller_s_coordinates_are():
    vertices, triangles = shapes.room(4)
    far = np.array([448_000.0, 5_411_000.0, 220.0])
    options = engine.CleanOptions(cut_handles=5.0)
    here, there = engine.clean(vertices, triangles, options), engine.clean(vertices + far, triangles, options)
    kept = engine.clean(vertices + far, triangles, options, keep=np.array([there.openings[1]["center"]]))
    assert len(there.openings) == len(here.openings) == 4
    assert np.allclose([o["center"] for o in there.openings], [o["center"] + far for o in here.openings], atol=1e-6)
    assert kept.report["euler"] == there.report["euler"] - 2


def test_the_add_on_keeps_clicked_openings():
    scan, session = scan_of(*shapes.room(16)), Session()
    step = rcp.Partition(proxies=REGIONS)
    outcome = session.replay(scan, rcp.Recipe((step,)))
    found = session.openings(scan, outcome)
    assert len(found) == 16
    face = int(np.flatnonzero(outcome.face_region >= 0)[0])
    edited = rcp.Recipe((step.keeping(found[5]["center"], keep=True), rcp.AddProxy(face=face)))
    kept = session.replay(scan, edited)
    assert (kept.numbers["kept_open"], kept.numbers["repairs"]["cut_handles"]) == (1, 15)
    assert messages.kept_open(kept.numbers) == "1 opening kept open, 15 closed"
    assert sum(opening["kept"] for opening in session.openings(scan, kept)) == 1
    assert session.replay(scan, edited.then(rcp.Mesh())).polygons.report["euler"] == -2
    assert session.replay(scan, rcp.Recipe((step,))).numbers["kept_open"] == 0


def test_the_opening_under_the_mouse():
    def ring(x, kept=False):
        angle = np.linspace(0, 2 * np.pi, 12, endpoint=False)
        loop = np.stack([x + 0.05 * np.cos(angle), 0.05 * np.sin(angle), np.zeros(12)], axis=1)
        return {"kind": "hole", "kept": kept, "center": (x, 0, 0), "length": 0.3, "loops": [loop]}

    some, view = [ring(-0.5), ring(0.5, kept=True)], np.eye(4)
    size = (400, 300)
    assert openings.nearest(some, view, size, (100, 150)) == 0
    assert openings.nearest(some, view, size, (325, 150)) == 1
    assert openings.nearest(some, view, size, (200, 150)) is None
    behind = np.diag([1.0, 1.0, 1.0, -1.0])
    assert openings.nearest(some, behind, size, (100, 150)) is None
    assert openings.lines(some).shape == (48, 3)
    assert np.allclose(openings.lines(some[:1], (-0.5, 0, 0))[0], [0.05, 0, 0])
    assert openings.lines([]).shape == (0, 3)
    assert openings.told(some[0], "3 cm") == "Hole, 3 cm around · closed · click: keep it open"
    assert "close it" in openings.told(some[1], "3 cm")


def test_the_cover_of_an_opening_has_its_area():
    square = {"loops": [[(0, 0, 1), (2, 0, 1), (2, 2, 1), (0, 2, 1)]]}
    a, b, c = openings.cover(square).reshape(-1, 3, 3).transpose(1, 0, 2)
    assert 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() == pytest.approx(4)
    assert openings.cover({"loops": []}).shape == (0, 3)
