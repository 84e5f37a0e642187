"""The recipe in the panel: steps switched, moved, deleted, edited, copied, read and written."""

import json

import bmesh
import bpy
import pytest
import scans

from isimp.blender.scene import store
from isimp.recipe import AddProxy, DeleteProxy, Mesh, Partition, Recipe
from test_edits import count, scan, steps


@pytest.fixture
def edited():
    """A rounded cube in 8 regions, then one added at 70 and the one at 10 deleted."""
    scans.dimple(scans.cube(cells=5))
    scans.push("cube")
    bpy.ops.isimp.partition("EXEC_DEFAULT", True, proxies=8)
    bpy.ops.isimp.add_proxy("EXEC_DEFAULT", True, face=70)
    bpy.ops.isimp.delete_proxy("EXEC_DEFAULT", True, face=10)
    return scan()


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_a_step_switched_off_and_on_again(edited, mode):
    before = scans.regions(edited).tolist()
    scans.mode(mode)
    scans.push("mode")
    bpy.ops.isimp.step_switch("EXEC_DEFAULT", True, step=2)
    assert (count(), steps()[2].enabled) == (9, False)
    bpy.ops.isimp.step_switch("EXEC_DEFAULT", True, step=2)
    assert scans.regions(edited).tolist() == before
    bpy.ops.ed.undo()
    assert (count(), steps()[2].enabled) == (9, False)
    bpy.ops.ed.redo()
    assert (count(), steps()[2].enabled) == (8, True)


def test_a_step_moved_and_deleted(edited):
    bpy.ops.isimp.step_move(step=2, later=False)
    assert steps()[1:] == (DeleteProxy(face=10), AddProxy(face=70))
    assert count() == 8
    bpy.ops.isimp.step_delete(step=1)
    assert (steps()[1:], count()) == ((AddProxy(face=70),), 9)


def test_deleting_the_last_step_restores_the_scan(edited):
    geometry = scans.geometry(edited.data)
    for _ in range(2):
        bpy.ops.isimp.step_delete("EXEC_DEFAULT", True, step=1)
    bpy.ops.isimp.step_delete("EXEC_DEFAULT", True, step=0)
    names = {"isimp_region", "isimp_color", ".isimp_state"}
    assert not names & set(edited.data.attributes.keys())
    assert (store.load(edited).steps, scans.geometry(edited.data)) == ((), geometry)
    bpy.ops.ed.undo()
    assert count() == 8


def test_a_step_that_cannot_be_done_is_marked_and_the_last_good_result_stays(edited):
    before = scans.regions(edited).tolist()
    bpy.ops.isimp.step_switch("EXEC_DEFAULT", True, step=0)
    numbers = store.numbers(edited)
    assert (numbers["failed"], "Partition step must come first" in numbers["reason"]) == (1, True)
    assert scans.regions(edited).tolist() == before
    assert not steps()[0].enabled
    bpy.ops.isimp.step_switch("EXEC_DEFAULT", True, step=0)
    assert "failed" not in store.numbers(edited)
    assert scans.regions(edited).tolist() == before


def test_the_settings_shown_follow_the_recipe(edited):
    panel = bpy.context.window_manager.isimp
    bpy.ops.isimp.partition("EXEC_DEFAULT", True, proxies=17)
    assert panel.partition.proxies == 17
    bpy.ops.ed.undo()
    assert panel.partition.proxies == 8
    bpy.ops.ed.redo()
    assert panel.partition.proxies == 17
    bpy.ops.ed.undo()
    bpy.ops.isimp.step_open(step=1)
    assert (panel.open_step, panel.add_proxy.face) == (1, 70)
    bpy.ops.isimp.step_open(step=1)
    assert panel.open_step == -1


def test_two_scans_keep_their_own(edited):
    other = scans.cube("Other", cells=4)
    bpy.ops.isimp.partition(proxies=6)
    panel = bpy.context.window_manager.isimp
    assert panel.partition.proxies == 6
    scans.activate(edited)
    bpy.context.view_layer.update()
    assert panel.partition.proxies == 8
    scans.activate(other)
    bpy.context.view_layer.update()
    assert panel.partition.proxies == 6
    assert len(store.load(other).steps) == 1
    assert len(store.load(edited).steps) == 3


def test_the_file_of_a_recipe_has_the_name_that_was_entered(edited, tmp_path):
    foreign = tmp_path / "house.json"
    foreign.write_text("{}")
    for name, written in (("house.v2", "house.v2.json"), ("Barn.JSON", "Barn.JSON")):
        bpy.ops.isimp.recipe_export(filepath=str(tmp_path / name))
        assert Recipe.from_json((tmp_path / written).read_text()) == store.load(edited)
    assert foreign.read_text() == "{}"
    assert len(list(tmp_path.iterdir())) == 3


def test_a_recipe_that_can_not_be_written_leaves_the_old_file(edited, tmp_path, monkeypatch):
    path = tmp_path / "house.json"
    path.write_text("{}")

    def full(self, text, **more):
        with self.open("w") as file:
            file.write(text[:10])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(type(path), "write_text", full)
    with pytest.raises(RuntimeError, match=r"house\.json' can't be written: No space"):
        bpy.ops.isimp.recipe_export(filepath=str(path))
    assert path.read_text() == "{}"
    assert list(tmp_path.iterdir()) == [path]


def test_a_recipe_with_polygons_is_replayed_to_polygons():
    scans.cube(cells=4)
    bpy.ops.isimp.replay(recipe=Recipe((Partition(proxies=6), Mesh())).to_json())
    assert bpy.context.object.name == "Scan.simplified"
    assert len(bpy.context.object.data.polygons) == 6


def test_a_recipe_with_a_failed_step_shows_the_steps_before_it():
    scans.cube(cells=4)
    recipe = Recipe((Partition(proxies=6), AddProxy(face=99999), Mesh()))
    bpy.ops.isimp.replay(recipe=recipe.to_json())
    assert (count(), store.numbers(scan())["failed"], store.load(scan())) == (6, 1, recipe)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("not a recipe", "it is not JSON"),
        ("{}", "no 'isimp_recipe'"),
        (Recipe().to_json(), "no active step"),
        pytest.param("[" * 200_000, "its brackets are nested too deeply", id="deep"),
        ('{"isimp_recipe": 1, "steps": [{"step": "lock", "faces": "\\ud800"}]}', "faces of lock must be a list"),
        ('{"isimp_recipe": 1, "steps": []}\0', "it is not JSON|not text|no active step"),
    ],
)
def test_what_is_no_recipe_is_refused(edited, text, said, tmp_path):
    before = scans.regions(edited).tolist()
    (tmp_path / "bad.json").write_text(text, encoding="utf-8")
    for call, settings in (("replay", {"recipe": text}), ("recipe_import", {"filepath": str(tmp_path / "bad.json")})):
        with pytest.raises(RuntimeError, match=said):
            getattr(bpy.ops.isimp, call)(**settings)
    assert scans.regions(edited).tolist() == before


def test_an_exported_recipe_acts_on_another_version_of_the_scan(edited, tmp_path):
    bpy.ops.isimp.recipe_export(filepath=str(tmp_path / "r.json"))
    values = json.loads((tmp_path / "r.json").read_text())
    assert [step["step"] for step in values["steps"]] == ["partition", "add_proxy", "delete_proxy"]
    assert values["places"]["faces"] == [10, 70]
    middle = list(edited.data.polygons[70].center)
    assert values["places"]["points"][1] == pytest.approx(middle, abs=1e-5)
    other = edited.copy()
    other.data = edited.data.copy()
    bpy.context.collection.objects.link(other)
    bm = bmesh.new()
    bm.from_mesh(other.data)
    bmesh.ops.subdivide_edges(bm, edges=bm.edges, cuts=1, use_grid_fill=True)
    bm.to_mesh(other.data)
    bm.free()
    scans.activate(other)
    (tmp_path / "r.json").write_text(json.dumps(values), encoding="utf-8-sig")  # as an editor may
    assert bpy.ops.isimp.recipe_import(filepath=str(tmp_path / "r.json")) == {"FINISHED"}
    done = store.load(other).steps
    assert [type(step) for step in done] == [Partition, AddProxy, DeleteProxy]
    assert (other.data.polygons[done[1].face].center - edited.data.polygons[70].center).length < 0.1
    values["places"]["points"][1] = [9, 9, 9]
    for strict in (True, False):
        assert bpy.ops.isimp.replay(recipe=json.dumps(values), strict=strict) == {"FINISHED"}
        assert [step.enabled for step in store.load(other).steps] == [True, False, True]
