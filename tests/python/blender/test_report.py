"""The report in the panel: its rows before and after an edit, their room, notes, and polygons that it shows."""

import bpy
import pytest
import scans
from drawing import Recorder

from isimp import blender
from isimp.blender import panel
from isimp.blender.panel import main
from isimp.blender.scene import store, targets
from isimp.blender.texts import text


def test_the_report_fits_the_default_width():
    scan = scans.dimple(scans.cube())
    bpy.ops.isimp.partition(proxies=12)
    bpy.ops.isimp.mesh()
    numbers = store.numbers(scan)
    lines = [line for line, _ in text.report_lines(numbers, "METRIC", 1.0)]
    assert lines[0] == "12 polygons · closed"
    assert any(line.endswith(numbers_away(numbers)) for line in lines)
    for line in (*lines, *text.scan_lines(scan.data, numbers)):
        assert all(len(part) <= 22 for part in text.wrapped(line, 22))


def numbers_away(numbers):
    assert 0 < numbers["away_mean"] < numbers["away_max"] < 0.5
    return f"{text.amount(numbers, 'away_max', 'METRIC', 1.0)} at most"


def drawn_rows(scan, numbers=None, made=None, room=25):
    """The texts that the report draws, from top to bottom."""
    drawn = []
    with pytest.MonkeyPatch.context() as patch:
        for place in (main, panel.common):
            patch.setattr(place, "letters", lambda context: room)
        patch.setattr(main.overlay, "previewed", lambda context, scan: made)
        main._draw_report(bpy.context, Recorder(drawn), scan, numbers or store.numbers(scan))
    return [text for _, text in drawn]


def test_notes_are_one_line_that_opens():
    scan = scans.cube()
    bpy.ops.isimp.partition(proxies=6)
    bpy.ops.isimp.mesh()
    assert "notes" not in drawn_rows(scan, room=80), "a cube has no notes"
    bpy.ops.isimp.swap()
    scan.data.vertices[0].co.x += 1e-4  # a result that is older than its scan
    numbers = store.numbers(scan) | {"left_out": 3, "repairs": {"duplicate_faces": 2, "filled_holes": 1}}
    closed = drawn_rows(scan, numbers, room=80)
    assert "notes" in closed
    assert not any("ignored" in each or each == "Choose Openings" for each in closed)
    bpy.context.window_manager.isimp.notes = True
    opened = " ".join(drawn_rows(scan, numbers, room=80))
    bpy.context.window_manager.isimp.notes = False
    for part in ("3 faces ignored", "2 duplicate faces", "1 hole"):
        assert part in opened.replace("\N{NO-BREAK SPACE}", " "), part


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


def test_divided_regions_are_selected():
    scan = scans.tube()
    assert bpy.ops.isimp.partition(proxies=1, snap=False) == {"FINISHED"}
    assert bpy.ops.isimp.mesh() == {"FINISHED"}
    numbers, result = store.numbers(scan), bpy.context.object
    assert numbers["polygons"] > numbers["regions"]
    lines = text.report_lines(numbers, "METRIC", 1.0)
    assert "more than regions" in lines[1][0]
    assert ("Open, like the scan", False) in lines
    assert bpy.ops.isimp.show_problems(kind="DIVIDED") == {"FINISHED"}
    result.update_from_editmode()
    chosen = {polygon.index for polygon in result.data.polygons if polygon.select}
    scans.mode("OBJECT")
    regions = scans.regions(result).tolist()
    assert chosen == {index for index, region in enumerate(regions) if regions.count(region) > 1} != set()
    assert targets.result_of(bpy.context.scene, scan) == result
