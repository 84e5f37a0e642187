"""Presets in the panel: the add-on's own, and users', which Blender keeps as files."""

import bpy
import numpy as np
import pytest
import scans
from drawing import Recorder

from isimp import recipe as rcp
from isimp.blender.controls import presets, settings
from isimp.blender.work import panel_changes
from isimp.recipe import presets as given


def shown(cls):
    return settings.to_step(cls, settings.group(bpy.context, cls))


@pytest.fixture(autouse=True)
def fresh():
    """Default settings, restored afterwards."""
    kept = {cls: shown(cls) for cls in (rcp.Partition, rcp.Mesh)}
    yield
    for cls, step in kept.items():
        settings.copy(cls, step, settings.group(bpy.context, cls))
    presets.ISIMP_MT_presets.bl_label = "Presets"


@pytest.mark.parametrize("preset", given.PRESETS, ids=lambda preset: preset.name)
def test_a_preset_sets_the_settings_of_its_kind_of_scan_and_no_more(preset):
    scans.cube()
    panel_changes.follow(bpy.context)
    group = settings.group(bpy.context, rcp.Partition)
    group.proxies, group.weights = 123, "Density"
    bpy.ops.isimp.preset(name=preset.name)
    step = shown(rcp.Partition)
    assert (step.proxies, step.weights) == (123, "Density")
    assert (step.noise, step.leave_out) == (preset.partition.noise, preset.partition.leave_out)
    assert step.detail == pytest.approx(preset.partition.detail)
    assert shown(rcp.Mesh) == preset.mesh
    assert presets.chosen(bpy.context) == (preset, True)
    group.seed += 1
    assert presets.chosen(bpy.context) == (preset, False)


@pytest.mark.parametrize("way", ["proxies", "triangles", "tolerance"])
def test_a_preset_keeps_the_way_to_count_and_stays_lit_with_a_dot(way):
    scan, group = scans.cube(), settings.group(bpy.context, rcp.Partition)
    group.count_by = way
    bpy.ops.isimp.preset(name="figure")
    statue = given.BY_NAME["figure"]
    assert group.count_by == way
    assert presets.chosen(bpy.context) == (statue, True)
    group.count_by = "detail"
    assert presets.chosen(bpy.context) == (statue, True)
    assert row() == ("Statue", ["figure"])
    group.adaptivity = 1.0
    assert presets.chosen(bpy.context) == (statue, False)
    assert row() == ("Statue \N{BULLET}", ["figure"])
    bpy.ops.isimp.partition(proxies=6)
    assert row()[1] == ["figure"], "it stays with the scan"
    scans.activate(scans.cube("Other"))
    assert bpy.context.window_manager.isimp.kind == ""
    scans.activate(scan)
    assert bpy.context.window_manager.isimp.kind == "figure"


def row():
    """The name above the row of kinds, and the kinds that are lit."""
    layout = Recorder([])
    presets.draw(bpy.context, layout)
    buttons = [(button.values["name"], is_lit) for button, is_lit in layout.made]
    assert [name for name, _ in buttons] == [preset.name for preset in given.PRESETS if preset.is_kind]
    (told,) = (text for kind, text in layout.drawn if kind == "label")
    return told, [name for name, is_lit in buttons if is_lit]


def test_no_preset_is_named_before_one_is_chosen():
    scans.cube()
    for cls in (rcp.Partition, rcp.Mesh):
        settings.copy(cls, cls(), settings.group(bpy.context, cls))
    assert row() == ("What is it?", [])


def test_a_scan_with_noise_has_larger_features_and_the_same_card(capfd):
    drawn = scans.dimple(scans.cube(cells=12), 0.1)
    bpy.ops.isimp.preset(name="cad")
    assert shown(rcp.Partition).detail == pytest.approx(0.00125)
    assert "noise" not in capfd.readouterr().out
    points = scans.coordinates(drawn.data) + np.random.default_rng(1).normal(0, 0.003, (len(drawn.data.vertices), 3))
    drawn.data.vertices.foreach_set("co", points.astype(np.float32).ravel())
    bpy.ops.isimp.preset(name="cad")
    assert shown(rcp.Partition).detail == pytest.approx(0.005)
    assert row() == ("Machine Part", ["cad"])
    assert "Machine Part: the scan has noise, features below 1" in capfd.readouterr().out
    bpy.ops.object.select_all(action="DESELECT")
    bpy.context.view_layer.objects.active = None
    bpy.ops.isimp.preset(name="cad")
    assert shown(rcp.Partition).detail == pytest.approx(0.00125)


def test_users_keep_presets_of_their_own(tmp_path, monkeypatch):
    monkeypatch.setenv("BLENDER_USER_SCRIPTS", str(tmp_path))
    scans.cube()
    group, meshing = (settings.group(bpy.context, cls) for cls in (rcp.Partition, rcp.Mesh))
    bpy.ops.isimp.preset(name="building")
    group.seed, group.detail, meshing.flatten = 77, 0.0123, 11
    bpy.ops.isimp.preset_add(name="My Walls")
    (file,) = (tmp_path / "presets" / "isimp").iterdir()
    assert presets.ISIMP_MT_presets.bl_label == bpy.path.display_name(file.name)
    assert row() == ("Building \N{BULLET}", ["building"])
    bpy.ops.isimp.preset(name="figure")
    assert (group.seed, row()) == (1, ("Statue", ["figure"]))
    bpy.ops.script.execute_preset(filepath=str(file), menu_idname="ISIMP_MT_presets")
    assert (group.seed, meshing.flatten) == (77, 11)
    assert group.detail == pytest.approx(0.0123)
    assert row() == ("Building \N{BULLET}", ["building"])
    bpy.ops.isimp.preset_add(remove_active=True)
    assert not file.exists()


@pytest.mark.parametrize("preset", given.PRESETS, ids=lambda preset: preset.name)
def test_each_preset_has_an_icon_of_blender_and_a_tooltip_with_its_name(preset):
    assert preset.icon in bpy.types.UILayout.bl_rna.functions["operator"].parameters["icon"].enum_items
    told = presets.ISIMP_OT_preset.description(bpy.context, type("Properties", (), {"name": preset.name}))
    assert told.startswith(f"{preset.label}: ")
