"""Presets in the panel: the add-on's own, and users', which Blender keeps as files."""

import bpy
import numpy as np
import pytest
import scans

from isimp import presets as given
from isimp import recipe as rcp
from isimp.blender.controls import presets, settings

pytestmark = pytest.mark.usefixtures("scene")


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
    group = settings.group(bpy.context, rcp.Partition)
    group.proxies, group.weights = 123, "Density"
    bpy.ops.isimp.preset(name=preset.name)
    step = shown(rcp.Partition)
    assert (step.proxies, step.weights) == (123, "Density")
    assert (step.noise, step.leave_out) == (preset.partition.noise, preset.partition.leave_out)
    assert step.detail == pytest.approx(preset.partition.detail)
    assert shown(rcp.Mesh) == preset.mesh
    assert presets.title(bpy.context) == preset.label
    group.seed += 1
    assert presets.title(bpy.context) == "Presets"


@pytest.mark.parametrize("way", ["proxies", "triangles", "tolerance"])
def test_a_preset_keeps_the_way_to_count_and_stays_lit(way):
    group = settings.group(bpy.context, rcp.Partition)
    group.count_by = way
    bpy.ops.isimp.preset(name="figure")
    assert group.count_by == way
    assert presets.title(bpy.context) == "Figure"
    group.count_by = "detail"
    assert presets.title(bpy.context) == "Figure"


def test_no_preset_is_named_before_one_is_chosen():
    for cls in (rcp.Partition, rcp.Mesh):
        settings.copy(cls, cls(), settings.group(bpy.context, cls))
    assert presets.title(bpy.context) == "No preset (defaults)"
    bpy.ops.isimp.preset(name="figure")
    assert presets.title(bpy.context) == "Figure"


def test_a_preset_equals_partition_with_its_settings():
    scans.cube(cells=10)
    bpy.ops.isimp.preset(name="cad")
    panel = settings.group(bpy.context, rcp.Partition)
    bpy.ops.isimp.partition(**{name: getattr(panel, name) for name in settings.names(rcp.Partition)})
    assert len(set(scans.regions(bpy.context.object))) == 6


def test_a_scan_with_noise_has_larger_features_and_the_same_card(capfd):
    drawn = scans.dimple(scans.cube(cells=12), 0.1)
    bpy.ops.isimp.preset(name="cad")
    assert shown(rcp.Partition).detail == pytest.approx(0.00125)
    assert "noise" not in capfd.readouterr().out
    points = scans.coordinates(drawn.data) + np.random.default_rng(1).normal(0, 0.003, (len(drawn.data.vertices), 3))
    drawn.data.vertices.foreach_set("co", points.astype(np.float32).ravel())
    bpy.ops.isimp.preset(name="cad")
    assert shown(rcp.Partition).detail == pytest.approx(0.005)
    assert presets.title(bpy.context) == "CAD"
    assert "CAD: the scan has noise, features below 1" in capfd.readouterr().out
    bpy.ops.object.select_all(action="DESELECT")
    bpy.context.view_layer.objects.active = None
    bpy.ops.isimp.preset(name="cad")
    assert shown(rcp.Partition).detail == pytest.approx(0.00125)


def test_users_keep_presets_of_their_own(tmp_path, monkeypatch):
    monkeypatch.setenv("BLENDER_USER_SCRIPTS", str(tmp_path))
    group, meshing = (settings.group(bpy.context, cls) for cls in (rcp.Partition, rcp.Mesh))
    bpy.ops.isimp.preset(name="building")
    group.seed, group.detail, meshing.flatten = 77, 0.0123, 11
    bpy.ops.isimp.preset_add(name="My Walls")
    (file,) = (tmp_path / "presets" / "isimp").iterdir()
    assert presets.title(bpy.context) == bpy.path.display_name(file.name)
    bpy.ops.isimp.preset(name="figure")
    assert (group.seed, presets.title(bpy.context)) == (1, "Figure")
    bpy.ops.script.execute_preset(filepath=str(file), menu_idname="ISIMP_MT_presets")
    assert (group.seed, meshing.flatten) == (77, 11)
    assert group.detail == pytest.approx(0.0123)
    bpy.ops.isimp.preset_add(remove_active=True)
    assert not file.exists()


@pytest.mark.parametrize("chosen", ["", "figure", "building", "cad"])
def test_the_card_of_a_preset_is_lit_once_it_was_chosen(chosen):
    for cls in (rcp.Partition, rcp.Mesh):
        settings.copy(cls, cls(), settings.group(bpy.context, cls))
    if chosen:
        bpy.ops.isimp.preset(name=chosen)
    cards = {}

    class Layout:
        def grid_flow(self, **_):
            return self

        def operator(self, name, text, depress, icon_value):
            cards[text] = depress
            return type("Button", (), {})()

    presets.draw(bpy.context, Layout())
    assert list(cards) == ["Figure", "Building", "City Tile", "CAD", "Generated Mesh"]
    assert [name for name, lit in cards.items() if lit] == ([given.BY_NAME[chosen].label] if chosen else [])


@pytest.mark.parametrize("preset", given.PRESETS, ids=lambda preset: preset.name)
def test_each_preset_has_a_small_picture(preset):
    path = presets._PICTURES / f"{preset.name}.png"
    image = bpy.data.images.load(str(path))
    assert tuple(image.size) == (64, 64)
    assert path.stat().st_size < 10_000
    bpy.data.images.remove(image)
