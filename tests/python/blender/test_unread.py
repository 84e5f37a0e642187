"""Steps that can't be read and foreign layers: each file opens, reports its fault, keeps them, and Partition works."""

import bpy
import numpy as np
import pytest
import scans
from drawing import controls

from isimp.blender import panel
from isimp.blender.scene import mesh_io, store, targets, unread_layers
from isimp.recipe import AddProxy, Partition, Recipe

STEPS = (Partition(count_by="proxies", proxies=8), AddProxy(face=20))
LATER = '{"step": "future_step", "face": 20}'


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


def texts() -> list:
    return [text.as_string() for text in bpy.data.texts]


def last(scan):
    return scan.data.isimp.nodes[str(mesh_io.state_of(scan))]


def with_last(name, value):
    return lambda scan: setattr(last(scan), name, value)


def circle(scan):
    scan.data.isimp.nodes[str(last(scan).parent)].parent = int(last(scan).name)


def write(layer, value):
    layer.data.foreach_set("value", np.full(len(layer.data), value))


def of_kind(name, kind, domain):
    """Puts a layer of another kind in the place of one of the add-on's."""

    def change(scan):
        scan.data.attributes.remove(scan.data.attributes[name])
        made = scan.data.attributes.new(name, kind, domain)
        if kind in {"FLOAT", "INT"}:
            write(made, 7)

    return change


def with_value(name, value):
    return lambda scan: write(scan.data.attributes[name], value)


#: {name: (change, the line of text, part of the kept text)}; with any of these the steps can't be read
UNREADABLE = {
    "a step of a later version": (with_last("step", LATER), "'future_step' is not a step of this version", LATER),
    "broken JSON": (with_last("step", '{"step": "add_pro'), "step 2 is not a step: it is not JSON", "add_pro"),
    "a circle": (circle, "more than 20,000", "add_proxy"),
    "a missing parent": (with_last("parent", 77), "a step before the last 1 is missing", "add_proxy"),
    "no nodes": (lambda scan: scan.data.isimp.nodes.clear(), "The steps of these regions are unknown", None),
    "an unknown state": (with_value(".isimp_state", -5), "The steps of these regions are unknown", None),
    "a state of points": (of_kind(".isimp_state", "INT", "POINT"), "'.isimp_state' is no layer of iSimp's", None),
}
#: with these the steps are read; the other fault does no harm
READABLE = {
    "numbers that are none": with_last("numbers", "[" * 100_000),
    "regions of fractions": of_kind("isimp_region", "FLOAT", "FACE"),
    "regions of points": of_kind("isimp_region", "INT", "POINT"),
    "regions that are huge": with_value("isimp_region", 2**31 - 1),
    "regions below none": with_value("isimp_region", -(2**31)),
    "colours of points": of_kind("isimp_color", "BYTE_COLOR", "POINT"),
    "no colours": lambda scan: scan.data.attributes.remove(scan.data.attributes["isimp_color"]),
}


@pytest.mark.parametrize("what", UNREADABLE)
def test_steps_that_cannot_be_read_are_kept_as_text_and_partition_starts_over(what, tmp_path, silent):
    change, why, kept = UNREADABLE[what]
    scan = made()
    change(scan)
    regions, state = layer(scan, "isimp_region"), layer(scan, ".isimp_state")
    scan = reopened(tmp_path / "later.blend")
    controls(*panel.CLASSES)
    told = " ".join(targets.notes(scan))
    assert why in told
    assert ("'Scan.steps'" in told) == (kept is not None)
    assert "'isimp_region.kept'" in told or "no layer" in why
    assert not bpy.ops.isimp.add_proxy.poll()
    assert (layer(scan, "isimp_region"), layer(scan, ".isimp_state")) == (regions, state)
    assert texts() == [], "looking at it changes nothing"
    for _ in range(2):
        assert bpy.ops.isimp.partition(proxies=6) == {"FINISHED"}
        assert store.load(scan) == Recipe((Partition(count_by="proxies", proxies=6),))
        assert np.unique(scans.regions(scan)).tolist() == list(range(6))
        scan = reopened(tmp_path / "anew.blend")
        assert len(texts()) == (kept is not None)
        assert kept is None or kept in bpy.data.texts["Scan.steps"].as_string()
    assert (layer(scan, "isimp_region.kept"), layer(scan, ".isimp_state.kept")) == (regions, state)
    assert targets.notes(scan) == []
    assert targets.needs_regions(scan) == ""
    assert bpy.ops.isimp.mesh() == {"FINISHED"}


def test_a_version_that_knows_the_step_replays_the_kept_text(silent):
    scan = made()
    regions = scans.regions(scan).tolist()
    last(scan).step = LATER
    store.forget_file()
    bpy.ops.isimp.partition(proxies=6)
    text = bpy.data.texts["Scan.steps"].as_string().replace("future_step", "add_proxy")
    assert bpy.ops.isimp.replay(recipe=text) == {"FINISHED"}
    assert (store.load(scan), scans.regions(scan).tolist()) == (Recipe(STEPS), regions)


@pytest.mark.parametrize("what", [None, "a step of a later version", "a state of points"])
def test_a_file_saved_in_edit_mode_is_opened(what, tmp_path, silent):
    scan = made()
    if what is not None:
        UNREADABLE[what][0](scan)
    scans.mode("EDIT")
    scan = reopened(tmp_path / "edited.blend")
    assert scan.mode == "EDIT"
    controls(*panel.CLASSES)
    assert bpy.ops.isimp.partition(proxies=6) == {"FINISHED"}
    assert ("isimp_region.kept" in scan.data.attributes) == (what is not None)
    assert len(texts()) == (what == "a step of a later version")


@pytest.mark.parametrize("what", READABLE)
def test_foreign_values_next_to_the_steps_do_no_harm(what, tmp_path, silent):
    scan = made()
    READABLE[what](scan)
    scan = reopened(tmp_path / "foreign.blend")
    assert store.load(scan) == Recipe(STEPS)
    controls(*panel.CLASSES)
    assert mesh_io.read_regions(scan).max() < 20
    assert bpy.ops.isimp.delete_proxy.poll()
    bpy.ops.isimp.show_regions()
    bpy.ops.isimp.select_region(face=3)
    kept = {found.name: layer(scan, found.name) for found in unread_layers.foreign_layers(scan.data)}
    assert all(f"'{name}' is no layer of iSimp's" in " ".join(targets.notes(scan)) for name in kept)
    assert bpy.ops.isimp.delete_proxy(face=20) == {"FINISHED"}
    assert len(store.load(scan).steps) == 3
    assert {name: layer(scan, f"{name}.kept") for name in kept} == kept
    assert bpy.ops.isimp.mesh() == {"FINISHED"}


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
@pytest.mark.parametrize("what", ["a step of a later version", "a state of points"])
def test_starting_over_is_undone_and_redone(what, mode, tmp_path, silent):
    scan = made()
    UNREADABLE[what][0](scan)
    scan = reopened(tmp_path / "later.blend")
    scans.activate(scan)
    scans.mode(mode)
    scans.push("opened")

    def seen():
        obj = bpy.data.objects["Scan"]
        names = sorted(layer.name for layer in obj.data.attributes if "isimp" in layer.name)
        return names, store.read(obj).recipe, "Nothing is lost" in " ".join(targets.notes(obj))

    before = seen()
    bpy.ops.isimp.partition("EXEC_DEFAULT", True, proxies=6)
    after = seen()
    assert after[1] == Recipe((Partition(count_by="proxies", proxies=6),))
    assert "isimp_region.kept" in after[0]
    bpy.ops.ed.undo()
    assert seen() == before
    bpy.ops.ed.redo()
    assert seen() == after
    assert bool(texts()) == (what == "a step of a later version")


def test_a_recipe_that_fails_at_once_keeps_unreadable_steps(silent):
    scan = made()
    last(scan).step = LATER
    store.forget_file()
    bpy.ops.isimp.replay(recipe=Recipe((AddProxy(face=1),)).to_json())
    assert store.numbers(scan)["failed"] == 0
    assert "isimp_region.kept" in scan.data.attributes
    assert LATER in texts()[0]


def test_only_nodes_that_led_to_other_regions_are_forgotten(monkeypatch, silent):
    monkeypatch.setattr(store, "MOST_NODES", 5)
    scan = made()
    for face in range(30, 42):
        bpy.ops.isimp.partition(proxies=6)
        bpy.ops.isimp.add_proxy(face=face)
    assert len(scan.data.isimp.nodes) <= 10
    store.forget_file()
    assert store.load(scan) == Recipe((Partition(count_by="proxies", proxies=6), AddProxy(face=41)))


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


def test_regions_of_which_no_state_is_known_are_kept():
    scan = scans.cube(cells=3)
    write(scan.data.attributes.new("isimp_region", "INT", "FACE"), 42)
    before = layer(scan, "isimp_region")
    assert bpy.ops.isimp.partition(proxies=6) == {"FINISHED"}
    assert layer(scan, "isimp_region.kept") == before


def test_what_is_kept_a_second_time_gets_a_name_of_its_own():
    scan = made()
    for number in ("", ".001"):
        last(scan).step = LATER
        store.forget_file()
        assert bpy.ops.isimp.partition(proxies=6) == {"FINISHED"}
        assert f".isimp_state.kept{number}" in scan.data.attributes
        assert f"Scan.steps{number}" in bpy.data.texts


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


def test_a_stored_colour_type_of_another_version_is_left_alone(silent):
    screens = {window.screen for window in bpy.context.window_manager.windows}
    shadings = [area.spaces.active.shading for screen in screens for area in screen.areas if area.type == "VIEW_3D"]
    for screen in screens:
        screen["isimp_color_type"] = {"0": "NO_SUCH_TYPE", "1": 7}
    scans.cube()
    bpy.ops.isimp.partition(proxies=6)
    bpy.ops.isimp.mesh()
    bpy.ops.isimp.swap()
    assert {shading.color_type for shading in shadings} == {"VERTEX"}
    for shading in shadings:
        shading.color_type = "MATERIAL"
    for screen in screens:
        screen.pop("isimp_color_type", None)


def test_a_setting_beyond_the_limits_of_the_panel_is_kept_in_the_steps(silent):
    scan = scans.cube(cells=4)
    step = Partition(count_by="proxies", proxies=6, seed=2**40, tolerance=1e300, bound=1e-9)
    bpy.ops.isimp.replay(recipe=Recipe((step,)).to_json())
    bpy.context.window_manager.isimp.partition.proxies = 7
    from isimp.blender.controls import settings

    recipe = settings.from_panel(bpy.context, store.load(scan))
    assert (recipe.steps[0].proxies, recipe.steps[0].seed, recipe.steps[0].tolerance) == (7, 2**40, 1e300)
    assert recipe.steps[0].bound == 1e-9
