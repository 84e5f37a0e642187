"""The panel: settings belong to a scan, have units, and every line and button has its place and its words."""

import re
import types
from pathlib import Path

import bpy
import pytest
import scans
import ui_strings
from drawing import Recorder, controls

from isimp import blender
from isimp import recipe as rcp
from isimp.blender import panel, reading
from isimp.blender.controls import presets, properties, settings
from isimp.blender.panel import main
from isimp.blender.scene import measure, runtime, store
from isimp.blender.scene import result as results
from isimp.blender.texts import text
from isimp.blender.view import clipping
from isimp.blender.work import panel_changes
from isimp.blender.work.modal import RecipeOperator
from test_texture import textured_cube

MANUAL = Path(__file__).parents[3] / "docs" / "manual.md"
#: Bold words of the manual that are no texts of the add-on: keys, signs, and beginnings of paragraphs
NO_TEXT = {"+", "\u2212", "C", "Click", "Ctrl-click", "eye", "name", "red", "Object > iSimp", "iSimp"}
NO_TEXT |= {"LODs", "File > Import > Scan (iSimp)", "File > Export > Building (.ifc, .dxf, .city.json)"}
NO_TEXT |= {"File > Export > Solid (.step)", "File > Export > LODs (.glb, .obj, .ifc)"}
NO_TEXT |= {"The result is yours.", "Rigged figures.", "Further layers."}


def group(cls=rcp.Partition):
    return settings.group(bpy.context, cls)


@pytest.fixture(autouse=True)
def fresh():
    runtime.get().live.scan = ""
    runtime.get().live.settings.clear()
    yield
    settings.show(bpy.context, None)


def look_at(scan):
    scans.activate(scan)
    panel_changes.follow(bpy.context)


def test_a_preset_of_one_scan_is_not_that_of_the_next():
    first, other = scans.cube("First"), scans.cube("Other")
    look_at(first)
    bpy.ops.isimp.preset(name="building")
    look_at(other)
    assert group().detail == pytest.approx(0.005)
    group().detail = 0.02
    look_at(first)
    assert group().detail == pytest.approx(0.0025)
    look_at(other)
    assert group().detail == pytest.approx(0.02)


def test_settings_stay_while_another_object_is_active_or_the_scan_is_renamed():
    scan = scans.cube()
    look_at(scan)
    group().detail = 0.02
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    bpy.context.scene.collection.objects.link(lamp)
    look_at(lamp)
    look_at(scan)
    assert group().detail == pytest.approx(0.02)
    scan.name = "Renamed"
    look_at(scan)
    assert group().detail == pytest.approx(0.02)


def test_a_scan_with_regions_brings_its_own():
    first, other = scans.cube("First"), scans.cube("Other")
    look_at(first)
    bpy.ops.isimp.partition(proxies=17)
    look_at(other)
    assert (group().count_by, group().proxies) == ("detail", 200)
    look_at(first)
    assert (group().count_by, group().proxies) == ("proxies", 17)


@pytest.mark.parametrize(
    ("cls", "name", "other", "value", "seen"),
    [
        (rcp.Partition, "detail", "detail_percent", 0.0025, 0.25),
        (rcp.Partition, "leave_out", "leave_out_percent", 0.001, 0.1),
        (rcp.Partition, "angle", "angle_turn", 90.0, 1.5707964),
        (rcp.Partition, "noise", "noise_length", 0.25, 0.25),
        (rcp.Mesh, "chord_tolerance", "chord_percent", 0.7, 70.0),
        (rcp.Mesh, "join_junctions", "join_percent", 0.5, 50.0),
    ],
)
def test_settings_have_units_and_both_faces_agree(cls, name, other, value, seen):
    setattr(group(cls), name, value)
    assert getattr(group(cls), other) == pytest.approx(seen)
    setattr(group(cls), other, seen / 2)
    assert getattr(group(cls), name) == pytest.approx(value / 2)


def test_noise_is_automatic_without_a_magic_number():
    assert group().noise_automatic
    assert group().noise_length == 0
    group().noise_automatic = False
    assert group().noise == 0
    group().noise_length = 0.5
    assert not group().noise_automatic
    group().noise_automatic = True
    assert settings.to_step(rcp.Partition, group()).noise == -1


def test_the_other_face_of_a_setting_is_followed_live(monkeypatch):
    touched = []
    monkeypatch.setattr(runtime.get().live, "touch", lambda: touched.append(1))
    group().detail_percent = 1.5
    assert touched


def test_no_setting_of_the_panel_shows_minus_one():
    for cls in (rcp.Partition, rcp.Mesh):
        for name in settings.names(cls):
            shown = settings.units.INSTEAD.get((cls, name), name)
            value = getattr(group(cls), shown)
            assert not isinstance(value, (int, float)) or value >= 0, shown


def test_lines_that_change_have_their_place_before_partition():
    scan = scans.cube()
    before = text.scan_lines(scan.data, store.numbers(scan))
    assert before == ("432 triangles", "Not partitioned yet")
    assert main._regions_line({}, 0) == "No regions yet"
    bpy.ops.isimp.partition(proxies=6)
    after = text.scan_lines(scan.data, store.numbers(scan))
    assert after == ("432 triangles", "1 part · closed")
    assert main._regions_line(store.numbers(scan), 0) == "6 regions"
    bpy.ops.isimp.add_proxy(face=3)
    assert main._regions_line(store.numbers(scan), 1) == "7 regions · 1 edit"


def sidebar(opened):
    """The panels that are seen in the sidebar: the main one and open ones, or all."""
    panels = [cls for cls in panel.CLASSES if issubclass(cls, bpy.types.Panel) and cls.bl_region_type == "UI"]
    return [cls for cls in panels if opened or "DEFAULT_CLOSED" not in getattr(cls, "bl_options", ())]


def seen(opened=False):
    """The controls in the sidebar. A row of which one is chosen counts once."""
    return {(kind, "way" if name.startswith("way ") else name) for kind, name in controls(*sidebar(opened))}


@pytest.mark.parametrize("is_textured", [False, True])
def test_the_panel_has_few_controls(is_textured):
    scan = textured_cube() if is_textured else scans.dimple(scans.cube())
    look_at(scan)
    assert len(seen()) <= 8
    assert {name for _, name in seen()} >= {"isimp.preset", "way", "Partition", "isimp.mesh"}
    bpy.ops.isimp.partition(proxies=6 if is_textured else 12)
    assert len(seen()) <= 15
    bpy.ops.isimp.mesh()
    scans.activate(scan)
    assert len(seen()) <= 16
    assert 40 <= len(seen(opened=True)) <= 70, "a lower number is a mistake of the test, or a better limit"


def test_settings_are_found_by_their_names():
    look_at(scans.cube())
    panel_settings = bpy.context.window_manager.isimp
    everything = controls(panel.more.ISIMP_PT_options)
    assert len(everything) > 25
    panel_settings.search = " RIM"
    assert [name for _, name in controls(panel.more.ISIMP_PT_options)] == ["search", "straight_rims_found"]
    panel_settings.search = "seams"
    assert [name for _, name in controls(panel.more.ISIMP_PT_options)] == ["search", "seams"]
    panel_settings.search = ""
    assert controls(panel.more.ISIMP_PT_options) == everything


def test_menus_and_popovers_of_the_panel_draw():
    scan = textured_cube()
    look_at(scan)
    bpy.ops.isimp.partition(proxies=6)
    bpy.ops.isimp.mesh()
    others = [cls for cls in panel.CLASSES if issubclass(cls, bpy.types.Menu) or cls.bl_region_type == "HEADER"]
    assert len(others) >= 8
    for cls in others:
        assert controls(cls), cls


def test_settings_that_are_not_in_the_sidebar_are_one_click_away():
    look_at(scans.cube())
    bpy.ops.isimp.partition(proxies=6)
    drawn = {name for kind, name in controls(*panel.CLASSES) if kind == "prop"}
    for cls in (rcp.Partition, rcp.Mesh, rcp.Regularise):
        shown = {settings.units.INSTEAD.get((cls, name), name) for name in settings.names(cls)}
        found = {"sharp_edges_length", "stitch_length", "grid_length", "straight_rims_length"}
        by_way = {
            "triangles",
            *found,
            "detail_percent",
            "tolerance",
            "bound",
            "influence",
            "length",
            "noise_length",
            "snap",
        }
        methods = {"method", "metric", "seeding", "seed", "iterations", "face_sets"}
        assert shown - by_way - methods - drawn - {"noise"} == set()


@pytest.mark.parametrize("way", ["detail", "tolerance", "bound"])
def test_the_smallest_feature_is_a_length_and_left_is_finer(way):
    scan = scans.cube()
    scan.scale = (3, 3, 3)
    bpy.context.view_layer.update()
    look_at(scan)
    shown = group()
    shown.count_by, shown.detail = way, 0.005
    assert (shown.way, shown.feature) == (
        "SIZE",
        pytest.approx({"detail": 0.005 * measure.size(scan)}.get(way, getattr(shown, way, 0))),
    )
    shown.feature = 0.03
    assert shown.feature == pytest.approx(0.03, rel=1e-5)
    if way == "detail":
        assert shown.detail == pytest.approx(0.03 / measure.size(scan), rel=1e-5)
    shown.coarseness = 0
    finest = shown.feature
    shown.coarseness = 50
    middle = shown.feature
    shown.coarseness = 100
    ratio = shown.feature / middle
    assert middle / finest == pytest.approx(ratio, rel=1e-4), "logarithmic"
    assert finest < middle
    shown.way = "COUNT"
    assert shown.count_by == "proxies"
    shown.way = "TRIANGLES"
    assert (shown.count_by, shown.way) == ("triangles", "TRIANGLES")
    shown.way = "SIZE"
    assert shown.count_by == "detail"


@pytest.mark.parametrize(("place", "near"), [(0.0, 1e-5), (float("nan"), 1e-2)])
def test_the_size_is_that_of_the_engine(place, near):
    scan = scans.dimple(scans.cube())
    scan.data.vertices[0].co.x += place
    scan.scale = (1, 2, 0.5)
    bpy.context.view_layer.update()
    bpy.ops.isimp.partition()
    arrays = reading.read(bpy.context, scan)
    outcome = runtime.get().session.replay(arrays, store.load(scan))
    assert measure.size(scan) * 0.005 == pytest.approx(outcome.partition.report["tolerance"], rel=near)


@pytest.mark.parametrize("language", ["en", "de"])
def test_buttons_next_to_each_other_have_room_for_their_names(language, monkeypatch):
    """At the width at which Blender opens the sidebar: 25 letters of a line with an icon."""
    from isimp import language as speech
    from isimp.blender import translations

    monkeypatch.setattr(panel.common, "letters", lambda context: 25)
    speech.speak(translations.read("de").get if language == "de" else str)
    rows = []

    class Layout:
        def row(self, align):
            return "row"

        def column(self, align):
            return "column"

    try:
        for names in (("Add", "Delete"), ("Lock", "Unlock"), ("Regularise", "Merge Slivers"), ("Grow", "Shrink")):
            place = panel.common.side_by_side(bpy.context, Layout(), *names)
            rows.append(place)
            assert place == "column" or max(len(speech.said(name)) for name in names) <= 8
    finally:
        translations.unregister()
        translations.register()
    assert rows == {"en": ["row", "row", "column", "row"]}.get(language, rows)
    assert "column" in rows


def test_colours_are_one_choice():
    shown = bpy.context.window_manager.isimp
    for value, name in (("HEAT", "heat"), ("AWAY", "away"), ("DIRECTIONS", "directions")):
        shown.colour = value
        assert [n for n in ("heat", "away", "directions") if getattr(shown, n)] == [name]
        assert shown.colour == value
    shown.colour = "NONE"
    assert not any((shown.heat, shown.away, shown.directions))


def test_the_panel_of_the_last_operation_shows_the_main_settings():
    scans.cube()
    bpy.ops.isimp.partition(proxies=6)
    found = {}
    for cls in blender._CLASSES:
        if issubclass(cls, RecipeOperator) and cls.adjusted and not isinstance(cls.adjusted, property):
            names = cls.adjusted
            assert len(names) <= 3
            known = getattr(bpy.ops.isimp, cls.bl_idname.split(".")[1]).get_rna_type().properties
            assert all(name in known for name in names), cls
            found[cls.bl_idname] = names
    assert {"isimp.mesh", "isimp.regularise", "isimp.grow", "isimp.texture"} <= set(found)
    for way, name in (("detail", "detail_percent"), ("proxies", "proxies"), ("tolerance", "tolerance")):
        fake = type("Fake", (), {"count_by": way})()
        assert blender.operators.partition.ISIMP_OT_partition.adjusted.fget(fake)[0] == name


def test_partition_names_the_number_of_edits_that_it_drops_and_the_remedy(capfd):
    scan = scans.dimple(scans.cube())
    bpy.ops.isimp.partition(proxies=12)
    assert "dropped" not in capfd.readouterr().out
    bpy.ops.isimp.add_proxy(face=3)
    bpy.ops.isimp.add_proxy(face=300)
    bpy.ops.isimp.mesh()
    capfd.readouterr()
    bpy.ops.isimp.partition(proxies=12)
    assert "2 edits by hand were dropped: Ctrl-Z brings them back" in capfd.readouterr().out
    assert len(store.load(scan).steps) == 1


def test_settings_leave_a_result_alone_that_was_edited_by_hand():
    scan = scans.dimple(scans.cube())
    bpy.ops.isimp.partition(proxies=12)
    bpy.ops.isimp.mesh()
    result = bpy.context.object
    assert not results.why_kept_here(bpy.context, scan)
    scans.mode("EDIT")
    assert results.why_kept_here(bpy.context, scan)
    scans.mode("OBJECT")
    assert not results.why_kept_here(bpy.context, scan)
    result.data.vertices[0].co.x += 1
    assert results.why_kept_here(bpy.context, scan)
    scans.activate(scan)
    assert not results.why_kept_here(bpy.context, scan)


def test_the_presets_menu_draws_in_a_fresh_configuration(monkeypatch, tmp_path):
    monkeypatch.setenv("BLENDER_USER_SCRIPTS", str(tmp_path))
    drawn = []
    monkeypatch.setattr(
        presets.ISIMP_MT_presets, "draw_preset", lambda menu, context: drawn.append(menu), raising=False
    )

    fields = {"layout": Recorder([]), "bl_label": "Presets", "draw_preset": lambda self, context: drawn.append(self)}
    menu = type("Menu", (), fields)()
    presets.ISIMP_MT_presets.draw(menu, bpy.context)
    assert not drawn, "a menu of no files says * Missing Paths *"
    (tmp_path / "presets" / "isimp").mkdir(parents=True)
    presets.ISIMP_MT_presets.draw(menu, bpy.context)
    assert len(drawn) == 1


def test_every_setting_of_mesh_is_drawn():
    drawn = {"chord_tolerance", "join_junctions", "flatten", "straight_rims", "planar", "planar_most", "convex"}
    assert set(settings.names(rcp.Mesh)) == drawn, "draw a new one in panel/more.py"


def test_the_manual_names_everything_as_the_panel_does():
    bold = {name.strip(",.") for name in re.findall(r"\*\*([^*]+)\*\*", MANUAL.read_text().replace("\n", " "))}
    bold -= {name.strip(",.") for name in NO_TEXT}
    assert len(bold) > 50
    assert bold <= ui_strings.all_strings(), bold - ui_strings.all_strings()


@pytest.mark.parametrize("size", [1.0, 3000.0, 1e-4])
def test_a_view_that_clips_the_scan_can_show_all_of_it(size):
    scan = scans.cube()
    scan.scale = (size,) * 3
    bpy.context.view_layer.update()
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    space = area.spaces.active
    space.clip_start, space.clip_end = 0.01, 1000.0
    told = {1.0: "", 3000.0: "Clips at 1 km: show all", 1e-4: "Clips below 1 cm: show all"}[size]
    assert bool(clipping.hides(space, scan)) == bool(told)
    assert not told or clipping.told(space, scan) == told
    with bpy.context.temp_override(window=window, area=area):
        assert bpy.ops.isimp.show_all() == {"FINISHED"}
    assert not clipping.hides(space, scan)
    assert space.clip_end >= 1000
    assert (space.clip_start == pytest.approx(0.01)) == (size == 1.0)
    assert not clipping.hides(None, scan)


def test_a_row_of_the_table_of_options_makes_a_property():
    """The third of the places of tests/python/project/test_add_option.py that is derived."""
    row = rcp.REGULARISE["angle"]._replace(label="Crisp", tip="How crisp it is", most=2.0)
    step = types.SimpleNamespace(crispness=0.5)

    @properties.with_options(step, {"crispness": row, "hidden": row._replace(label="")})
    class Crisp:
        pass

    assert list(Crisp.__annotations__) == ["crispness"]
    made = Crisp.__annotations__["crispness"]
    texts = {"name": "Crisp", "description": "How crisp it is", "default": 0.5}
    assert (made.function, made.keywords) == (bpy.props.FloatProperty, texts | {"min": 0.0, "max": 2.0})
