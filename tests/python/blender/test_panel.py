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
from isimp.blender.scene import measure, runtime, store, targets
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


@pytest.mark.parametrize("letters", [22])
def test_the_report_fits_the_default_width(letters):
    scan = scans.dimple(scans.cube())
    bpy.ops.isimp.partition(proxies=12)
    bpy.ops.isimp.mesh()
    numbers = store.numbers(scan)
    lines = [line for line, _ in text.report_lines(numbers, "METRIC", 1.0)]
    assert lines[0] == "12 polygons · closed"
    assert any(line.endswith(numbers_away(numbers)) for line in lines)
    for line in (*lines, *text.scan_lines(scan.data, numbers)):
        assert all(len(part) <= letters for part in text.wrapped(line, letters))


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


def test_notes_are_one_line_that_opens():
    scan = scans.cube()
    bpy.ops.isimp.partition(proxies=6)
    bpy.ops.isimp.mesh()
    assert "notes" not in drawn_props(scan), "a cube has no notes"
    bpy.ops.isimp.swap()
    scan.data.vertices[0].co.x += 1e-4  # a result that is older than its scan
    numbers = store.numbers(scan) | {"left_out": 3, "repairs": {"duplicate_faces": 2, "filled_holes": 1}}
    closed = drawn_props(scan, numbers)
    assert "notes" in closed
    assert not any("ignored" in each or each == "Choose Openings" for each in closed)
    bpy.context.window_manager.isimp.notes = True
    opened = " ".join(drawn_props(scan, numbers))
    bpy.context.window_manager.isimp.notes = False
    for part in ("3 faces ignored", "2 duplicate faces", "1 hole"):
        assert part in opened.replace("\N{NO-BREAK SPACE}", " "), part


def drawn_props(scan, numbers=None):
    """All that the report draws, in wide rows."""
    drawn = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(main, "letters", lambda context: 80)
        patch.setattr(panel.common, "letters", lambda context: 80)
        main._draw_report(bpy.context, Recorder(drawn), scan, store.numbers(scan) if numbers is None else numbers)
    return [text for _, text in drawn]


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


def test_the_size_is_that_of_the_engine():
    scan = scans.dimple(scans.cube())
    scan.scale = (1, 2, 0.5)
    bpy.context.view_layer.update()
    bpy.ops.isimp.partition()
    arrays = reading.read(bpy.context, scan)
    outcome = runtime.get().session.replay(arrays, store.load(scan))
    assert measure.size(scan) * 0.005 == pytest.approx(outcome.partition.report["tolerance"], rel=1e-5)


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


def test_the_report_has_the_same_rows_before_an_edit_after_it_and_after_mesh():
    scan = scans.dimple(scans.cube())
    rows = drawn_rows(scan)
    assert not rows, "nothing to report before Partition"
    seen = {}
    bpy.ops.isimp.partition(proxies=12)
    seen["fresh"] = drawn_rows(scan)
    assert seen["fresh"][0].startswith("About ")
    bpy.ops.isimp.add_proxy(face=3)
    seen["edited"] = drawn_rows(scan)
    numbers = store.numbers(scan) | {"regions_before": 13, "polygons": 20, "split": {"split_for_holes": 4}}
    seen["previewed"] = drawn_rows(scan, made=numbers)
    assert seen["previewed"][0] == "20 polygons"
    bpy.ops.isimp.mesh()
    seen["made"] = drawn_rows(scan)
    triangles = sum(len(polygon.vertices) - 2 for polygon in targets.result_of(bpy.context.scene, scan).data.polygons)
    told = " ".join(seen["made"][:2]).replace("\N{NO-BREAK SPACE}", " ")
    assert told.startswith(f"13 polygons · {triangles} triangles · ")
    assert told.endswith(" off")
    bpy.ops.isimp.add_proxy(face=300)
    seen["edited again"] = drawn_rows(scan)
    assert {state: len(rows) for state, rows in seen.items()} == dict.fromkeys(seen, len(seen["fresh"]))


def drawn_rows(scan, made=None):
    """The texts of all that the report draws, from above."""
    drawn = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(main, "letters", lambda context: 25)
        patch.setattr(main.overlay, "previewed", lambda context, scan: made)
        main._draw_report(bpy.context, Recorder(drawn), scan, store.numbers(scan))
    return [text for _, text in drawn]


def test_the_report_begins_with_round_parts_if_they_were_asked_for():
    scan = scans.dimple(scans.cube(cells=10))
    told = "No round part found: "
    bpy.ops.isimp.partition(proxies=12)
    assert told not in " ".join(drawn_rows(scan))
    bpy.ops.isimp.partition(proxies=12, curved=True)
    assert " ".join(drawn_rows(scan)).startswith(told)
    bpy.context.window_manager.isimp.regularise_first = True
    assert told not in " ".join(drawn_rows(scan)), "a building"
    bpy.context.window_manager.isimp.regularise_first = False


def test_polygons_left_bent_are_shown_and_made_flat():
    scan = scans.dimple(scans.cube(cells=10), 0.8)
    bpy.ops.isimp.partition(proxies=30)
    bpy.ops.isimp.mesh(planar=True, planar_most=0.0)
    made, numbers = bpy.context.object, store.numbers(scan)
    line = f"{numbers['not_flat']} of {numbers['polygons']} not exactly flat"
    rows = [row.replace("\N{NO-BREAK SPACE}", " ") for row in drawn_rows(scan)]
    assert [line, "isimp.flatten", "Show"] == rows[rows.index(line) :][:3]
    assert bpy.ops.isimp.show_problems(kind="BENT") == {"FINISHED"}
    made.update_from_editmode()
    assert sum(polygon.select for polygon in made.data.polygons) == numbers["not_flat"] > 0
    bpy.ops.object.mode_set(mode="OBJECT")
    assert bpy.ops.isimp.flatten() == {"FINISHED"}
    assert not any("exactly flat" in row for row in drawn_rows(scan))
    assert store.load(scan).steps[-1].planar_most == 1.0
    assert bpy.context.window_manager.isimp.mesh.planar_most == 1.0
    assert bpy.ops.isimp.show_problems(kind="BENT") == {"FINISHED"}
    assert bpy.context.mode == "OBJECT", "there is nothing to show"


@pytest.mark.parametrize("width", [12, 22, 25, 40, 80])
@pytest.mark.parametrize("polygons", [None, 1_325, 12_417])
def test_the_report_is_short_and_its_tooltip_has_the_reasons(width, polygons):
    causes = ("holes", "handles", "pinches", "closed", "unconnected")
    split = {f"split_for_{cause}": 11 * number for number, cause in enumerate(causes, 1)}
    numbers = {"regions": 325, "diagonal": 1.0, "expected": {"regions": 325, "polygons": 1_325} | split}
    empty = len(text.report_rows({"regions": 325}, "METRIC", 1.0, None, width))
    if polygons:
        away = {"away_mean": 0.0123, "away_max": 0.2345, "planarity_mean": 0.0123, "planarity_max": 0.2345}
        numbers |= away | {"polygons": polygons, "closed": True, "manifold": True, "split": split}
    rows = text.report_rows(numbers, "METRIC", 1.0, None, width)
    assert width < 22 or len(rows) == empty  # 25: as Blender opens the sidebar
    assert not any(alert for _, _, alert in rows)
    assert "325 polygons" in " ".join(row for row, _, _ in rows) or polygons == 12_417
    told = " ".join(line for line, _ in text.report_lines(numbers, "METRIC", 1.0))
    assert "more than regions" in told
    assert "split because they bend" in told
    assert "not held" in text.planes_let_go(numbers | {"let_go": 3, "held": 4}), "a note: the program chose it"


def test_the_tooltip_of_the_report_has_the_distance_and_the_flatness():
    scans.dimple(scans.cube())
    bpy.ops.isimp.partition(proxies=12)
    bpy.ops.isimp.mesh()
    told = blender.operators.problems.ISIMP_OT_report.description(bpy.context, None)
    assert "from the scan on average" in told
    assert "Flat within" in told, "the sides of a cube with a dimple bend"


def numbers_away(numbers):
    assert 0 < numbers["away_mean"] < numbers["away_max"] < 0.5
    return f"{text.amount(numbers, 'away_max', 'METRIC', 1.0)} at most"


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


def test_divided_regions_are_selected():
    scan = tube()
    assert bpy.ops.isimp.partition(proxies=1, snap=False) == {"FINISHED"}
    assert bpy.ops.isimp.mesh() == {"FINISHED"}
    numbers, result = store.numbers(scan), bpy.context.object
    assert numbers["polygons"] > numbers["regions"]
    assert "more than regions" in text.report_lines(numbers, "METRIC", 1.0)[1][0]
    assert bpy.ops.isimp.show_problems(kind="DIVIDED") == {"FINISHED"}
    result.update_from_editmode()
    chosen = {polygon.index for polygon in result.data.polygons if polygon.select}
    scans.mode("OBJECT")
    regions = scans.regions(result).tolist()
    assert chosen == {index for index, region in enumerate(regions) if regions.count(region) > 1} != set()
    assert targets.result_of(bpy.context.scene, scan) == result


def tube():
    """A square plate with a square hole: a flat region that is no disc."""
    points = [(x, y, 0) for y in range(7) for x in range(7)]
    faces = []
    for y in range(6):
        for x in range(6):
            if not (2 <= x < 4 and 2 <= y < 4):
                a = 7 * y + x
                faces += [(a, a + 1, a + 8), (a, a + 8, a + 7)]
    return scans.add("Scan", points, faces)


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
