"""Files with damaged, foreign or later states: each opens, reports its fault, keeps the data, and Partition works."""

import random

import bpy
import damage
import numpy as np
import pytest
import scans

from isimp.blender.scene import mesh_io, store, targets, unread_layers
from isimp.recipe import AddProxy, Partition, Recipe

pytestmark = pytest.mark.usefixtures("scene")
STEPS = (Partition(count_by="proxies", proxies=8), AddProxy(face=20))


@pytest.fixture
def silent(capfd):
    """Fails if any call from Blender, a handler or a poll, ended in a traceback."""
    yield
    said = "".join(capfd.readouterr())
    assert "Traceback" not in said, said[-3000:]
    assert "Error:" not in said, said[-3000:]


def made():
    scan = scans.dimple(scans.cube(cells=4))
    bpy.ops.isimp.partition(proxies=8)
    bpy.ops.isimp.add_proxy(face=20)
    return scan


def reopened(path):
    """Saves the file, opens another one, and it again."""
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.wm.open_mainfile(filepath=str(path))
    return bpy.data.objects["Scan"]


def layer(scan, name):
    """A layer of any kind, as bytes."""
    found = scan.data.attributes[name]
    key = {"FLOAT_COLOR": "color", "BYTE_COLOR": "color"}.get(found.data_type, "value")
    values = np.empty(len(found.data) * (4 if key == "color" else 1), np.float32 if key == "color" else np.float64)
    found.data.foreach_get(key, values)
    return values.tobytes()


def holds(block, value) -> bool:
    """Return whether a value of the file exists, in its place or moved by the add-on; of a list, every item."""
    now, aside = damage.dump(block), repr(damage.kept(block))
    found = value.get("nodes") if isinstance(value, dict) else value
    if isinstance(found, list) and found and all(isinstance(node, dict) for node in found):
        return set(map(repr, found)) <= set(map(repr, now["nodes"]))
    return found is None or repr(found) in aside


@pytest.mark.parametrize("what", damage.UNREADABLE)
def test_unreadable_steps_are_reported_and_kept_and_partition_starts_over(what, tmp_path, silent):
    hurt, why = damage.UNREADABLE[what]
    scan = made()
    hurt(scan)
    before = damage.dump(scan.data)
    regions, state = layer(scan, "isimp_region"), layer(scan, ".isimp_state")
    scan = reopened(tmp_path / "damaged.blend")
    can = damage.operators()
    said = damage.panels()
    assert why in said
    assert "isimp_" in said.split(why)[1], "where it will be kept"
    assert not can["add_proxy"]
    assert damage.dump(scan.data) == before, "looking at it changes nothing"
    assert (layer(scan, "isimp_region"), layer(scan, ".isimp_state")) == (regions, state)
    for _ in range(2):
        assert bpy.ops.isimp.partition(proxies=6) == {"FINISHED"}
        assert store.load(scan) == Recipe((Partition(count_by="proxies", proxies=6),))
        assert np.unique(scans.regions(scan)).tolist() == list(range(6))
        assert holds(scan.data, before)
        scan = reopened(tmp_path / "anew.blend")
    assert (layer(scan, "isimp_region.kept"), layer(scan, ".isimp_state.kept")) == (regions, state)
    assert "isimp_region.kept.2" not in scan.data.attributes
    assert "Kept, as it could not be read: 'isimp_region.kept'" in damage.panels()
    assert targets.needs_regions(scan) == ""
    assert bpy.ops.isimp.mesh() == {"FINISHED"}


@pytest.mark.parametrize("what", [None, "a step of a later version", "a state of points"])
def test_a_file_saved_in_edit_mode_is_opened(what, tmp_path, silent):
    scan = made()
    if what is not None:
        damage.UNREADABLE[what][0](scan)
    scans.mode("EDIT")
    scan = reopened(tmp_path / "edited.blend")
    assert scan.mode == "EDIT"
    damage.panels()
    damage.operators()
    assert bpy.ops.isimp.partition(proxies=6) == {"FINISHED"}
    assert ("isimp_region.kept" in scan.data.attributes) == (what is not None)


@pytest.mark.parametrize("what", damage.READABLE)
def test_foreign_values_next_to_the_steps_do_no_harm(what, tmp_path, silent):
    scan = made()
    damage.READABLE[what](scan)
    scan = reopened(tmp_path / "damaged.blend")
    assert store.load(scan) == Recipe(STEPS)
    damage.panels()
    assert mesh_io.read_regions(scan).max() < 20
    assert damage.operators()["delete_proxy"]
    bpy.ops.isimp.show_regions()
    bpy.ops.isimp.select_region(face=3)
    kept = {name: layer(scan, name) for name, _ in unread_layers.foreign_layers(scan.data)}
    assert all(f"'{name}' is no layer of iSimp's" in damage.panels() for name in kept)
    assert bpy.ops.isimp.delete_proxy(face=20) == {"FINISHED"}
    assert len(store.load(scan).steps) == 3
    assert {name: layer(scan, f"{name}.kept") for name in kept} == kept
    assert bpy.ops.isimp.mesh() == {"FINISHED"}
    damage.panels()


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
@pytest.mark.parametrize("what", ["a step of a later version", "a state of points", "a number in place of all"])
def test_starting_over_is_undone_and_redone(what, mode, tmp_path, silent):
    scan = made()
    damage.UNREADABLE[what][0](scan)
    scan = reopened(tmp_path / "damaged.blend")
    scans.activate(scan)
    scans.mode(mode)
    scans.push("opened")

    def seen():
        obj = bpy.data.objects["Scan"]
        names = sorted(layer.name for layer in obj.data.attributes if "isimp" in layer.name)
        return names, store.read(obj).recipe, "Nothing is lost" in damage.panels()

    before = seen()
    bpy.ops.isimp.partition("EXEC_DEFAULT", True, proxies=6)
    after = seen()
    assert after[1] == Recipe((Partition(count_by="proxies", proxies=6),))
    assert "isimp_region.kept" in after[0]
    bpy.ops.ed.undo()
    assert seen() == before
    bpy.ops.ed.redo()
    assert seen() == after


def test_a_recipe_that_fails_at_once_leaves_unreadable_steps(silent):
    scan = made()
    damage.UNREADABLE["broken JSON"][0](scan)
    before = damage.dump(scan.data)["nodes"]
    store.forget_file()
    bpy.ops.isimp.replay(recipe=Recipe((AddProxy(face=1),)).to_json())
    assert holds(scan.data, {"nodes": before})
    assert store.numbers(scan)["failed"] == 0
    assert "isimp_region.kept" in scan.data.attributes
    damage.panels()


def test_steps_that_cannot_be_read_are_not_forgotten(monkeypatch, silent):
    monkeypatch.setattr(store, "MOST_NODES", 5)
    scan = made()
    damage.UNREADABLE["a step of a later version"][0](scan)
    before = damage.dump(scan.data)["nodes"]
    store.forget_file()
    for face in range(30, 42):
        bpy.ops.isimp.partition(proxies=6)
        bpy.ops.isimp.add_proxy(face=face)
    assert holds(scan.data, {"nodes": before})
    assert len(scan.data.isimp.nodes) <= 12
    assert store.load(scan).steps[1] == AddProxy(face=41)


def test_steps_that_cannot_be_read_and_led_to_nothing_seen_are_not_forgotten(monkeypatch, silent):
    monkeypatch.setattr(store, "MOST_NODES", 3)
    scan = made()
    damage.UNREADABLE["a step of a later version"][0](scan)
    before = damage.dump(scan.data)["nodes"]
    mesh_io.clear_regions(scan)
    store.forget_file()
    for proxies in range(5, 12):
        bpy.ops.isimp.partition(proxies=proxies)
    assert holds(scan.data, {"nodes": before})
    assert len(scan.data.isimp.nodes) <= 6


def test_steps_of_a_state_that_was_moved_aside_are_not_forgotten(monkeypatch, silent):
    """Even where this version can read them: an earlier one, which could not, moved them aside."""
    monkeypatch.setattr(store, "MOST_NODES", 3)
    scan = made()
    before = damage.dump(scan.data)["nodes"]
    unread_layers.rename(scan, regions_too=True)
    for proxies in range(5, 12):
        bpy.ops.isimp.partition(proxies=proxies)
    assert holds(scan.data, {"nodes": before})
    assert len(scan.data.isimp.nodes) <= 6


def test_undo_restores_the_former_numbers_of_the_same_steps(silent):
    scan = scans.cube(cells=4)
    scans.push("cube")
    recipe = Recipe((Partition(proxies=6, weights="w"),)).to_json()
    bpy.ops.isimp.replay("EXEC_DEFAULT", True, recipe=recipe)
    assert store.numbers(scan)["failed"] == 0
    scan.vertex_groups.new(name="w")
    scans.push("group")
    bpy.ops.isimp.replay("EXEC_DEFAULT", True, recipe=recipe)
    assert "failed" not in store.numbers(scan)
    bpy.ops.ed.undo()
    assert store.numbers(bpy.data.objects["Scan"])["failed"] == 0


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_a_version_that_can_read_the_kept_steps_restores_them(mode, tmp_path, silent):
    scan = made()
    node, regions = damage.last(scan.data), scans.regions(scan).tolist()
    name, text = node["name"], node["step"]
    damage.UNREADABLE["a step of a later version"][0](scan)
    scan = reopened(tmp_path / "later.blend")
    bpy.ops.isimp.partition(proxies=6)
    assert not bpy.ops.isimp.take_back.poll()
    assert store.kept(scan) is None
    damage.put(next(node for node in damage.nodes(scan.data) if node["name"] == name), "step", text)
    scan = reopened(tmp_path / "later.blend")
    scans.activate(scan)
    scans.mode(mode)
    scans.push("opened")
    assert store.kept(scan) == Recipe(STEPS)
    assert bpy.ops.isimp.take_back("EXEC_DEFAULT", True) == {"FINISHED"}
    assert (store.load(scan), scans.regions(scan).tolist()) == (Recipe(STEPS), regions)
    assert not bpy.ops.isimp.take_back.poll()
    bpy.ops.ed.undo()
    assert len(store.load(bpy.data.objects["Scan"]).steps) == 1


def test_regions_of_which_no_state_is_known_are_kept():
    scan = scans.cube(cells=3)
    own = scan.data.attributes.new("isimp_region", "INT", "FACE")
    damage.write(own, 42)
    before = layer(scan, "isimp_region")
    assert bpy.ops.isimp.partition(proxies=6) == {"FINISHED"}
    assert layer(scan, "isimp_region.kept") == before
    assert "'isimp_region.kept'" in damage.panels()


def test_what_is_kept_a_second_time_gets_a_name_of_its_own():
    scan = made()
    for number, proxies in (("", 6), (".2", 7)):
        damage.write(scan.data.attributes[".isimp_state"], -5)
        store.forget_file()
        assert f"keeps this as 'isimp_region.kept{number}'" in damage.panels()
        assert bpy.ops.isimp.partition(proxies=proxies) == {"FINISHED"}
        assert f".isimp_state.kept{number}" in scan.data.attributes


@pytest.mark.parametrize("value", [5, {"key": 5, "scan_key": [1, 2], "scan_name": 2.5}, "x", [1, 2]])
def test_object_properties_of_other_types(value, tmp_path, silent):
    scan = made()
    damage.put(damage.home(scan), "isimp", value)
    before = damage.dump(scan)
    scan = reopened(tmp_path / "damaged.blend")
    damage.panels()
    damage.operators()
    assert damage.dump(scan) == before
    assert bpy.ops.isimp.mesh() == {"FINISHED"}
    wrong = [{name: found} for name, found in value.items()] if isinstance(value, dict) else [value]
    assert damage.kept(scan) == wrong


def test_a_scan_that_is_said_to_be_its_own_result_is_never_filled(tmp_path, silent):
    scan, other = made(), scans.cube("Other", cells=2)
    for one, two in ((scan, scan), (scan, other)):
        one.isimp.key, two.isimp.key = one.name, two.name
        one.isimp.scan_key, one.isimp.scan_name = two.name, two.name
        two.isimp.scan_key, two.isimp.scan_name = one.name, one.name
        geometry = scans.geometry(scan.data), scans.geometry(other.data)
        scans.activate(scan)
        assert targets.scan_of(scan) is None
        assert bpy.ops.isimp.mesh() == {"FINISHED"}
        assert (scans.geometry(scan.data), scans.geometry(other.data)) == geometry
        assert bpy.context.object not in (scan, other)


def test_a_result_that_shares_the_mesh_of_its_scan_is_not_filled():
    scan = made()
    bpy.ops.isimp.mesh()
    bpy.context.object.data = scan.data
    scan.hide_set(False)
    geometry = scans.geometry(scan.data)
    scans.activate(scan)
    assert bpy.ops.isimp.mesh() == {"FINISHED"}
    assert scans.geometry(scan.data) == geometry


@pytest.mark.parametrize("value", [5, "x", {"0": "NO_SUCH_TYPE", "1": 7}])
def test_colours_of_viewports_that_are_none(value, silent):
    screens = {window.screen for window in bpy.context.window_manager.windows}
    shadings = [area.spaces.active.shading for screen in screens for area in screen.areas if area.type == "VIEW_3D"]
    for screen in screens:
        damage.put(screen, "isimp_color_type", value)
    scans.cube()
    bpy.ops.isimp.partition(proxies=6)
    bpy.ops.isimp.mesh()
    bpy.ops.isimp.swap()
    assert {shading.color_type for shading in shadings} == {"VERTEX"}
    assert isinstance(value, dict) or {screen["isimp_color_type"] for screen in screens} == {value}, "it is not ours"
    for shading in shadings:
        shading.color_type = "MATERIAL"
    for screen in screens:
        screen.pop("isimp_color_type", None)


def test_panel_settings_that_are_none(silent):
    made()
    panel = damage.home(bpy.context.window_manager)
    values = {"leave_out": 5.0, "count_by": 99, "noise": float("nan"), "proxies": -7, "weights": 3, "method": 1000}
    damage.put(
        panel,
        "isimp",
        {
            "partition": values,
            "mesh": {"flatten": -3, "chord_tolerance": float("inf")},
            "smooth": {"rounds": 0},
        },
    )
    damage.panels()
    assert damage.operators()["partition"]
    assert bpy.ops.isimp.partition(proxies=6) == {"FINISHED"}
    del panel["isimp"]


def test_a_setting_beyond_the_limits_of_the_panel_is_kept_in_the_steps(silent):
    scan = scans.cube(cells=4)
    step = Partition(count_by="proxies", proxies=6, seed=2**40, tolerance=1e300, bound=1e-9)
    bpy.ops.isimp.replay(recipe=Recipe((step,)).to_json())
    bpy.context.window_manager.isimp.partition.proxies = 7
    from isimp.blender.controls import settings

    recipe = settings.from_panel(bpy.context, store.load(scan))
    assert (recipe.steps[0].proxies, recipe.steps[0].seed, recipe.steps[0].tolerance) == (7, 2**40, 1e300)
    assert recipe.steps[0].bound == 1e-9


def test_a_thousand_meshes_with_nodes_damaged_at_random(tmp_path, silent):
    """All in one file, since opening is slow: each gives steps or a line, and loses nothing."""
    draw, first = random.Random(7), made()
    for proxies in (5, 6, 7):
        bpy.ops.isimp.partition(proxies=proxies)
        bpy.ops.isimp.lock(face=3)
    before = {}
    for number in range(1000):
        twin = bpy.data.objects.new(f"Twin {number}", first.data.copy())
        bpy.context.scene.collection.objects.link(twin)
        damage.at_random(draw, twin.data)
        before[twin.name] = damage.dump(twin.data)
    reopened(tmp_path / "damaged.blend")
    lost = 0
    for number, (name, values) in enumerate(before.items()):
        twin = bpy.data.objects[name]
        scans.activate(twin)
        found = store.read(twin)
        assert (found.recipe is None) == bool(found.problem)
        assert found.problem.isprintable()
        damage.panels()
        assert repr(damage.dump(twin.data)) == repr(values)
        lost += found.recipe is None
        if number % 20 == 0:
            assert bpy.ops.isimp.partition(proxies=6) == {"FINISHED"}
            assert holds(twin.data, values)
    assert 200 < lost < 900
