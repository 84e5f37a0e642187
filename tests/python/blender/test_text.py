"""Texts and their room."""

import pytest

from isimp.blender.texts import text

SAID = "Region 3 · 12.3% of the area · flat to 2 mm"  # 43 letters


@pytest.mark.parametrize(
    ("wanted", "right", "lines", "at"),
    [
        (20, 500, [SAID], 20),
        (300, 500, [SAID], 70),  # moved to the left, so that it ends at the border
        (300, 440, [SAID], 10),
        (300, 439, ["Region 3 · 12.3% of the area", "flat to 2 mm"], 159),
        (0, 500, [SAID], 10),
        (50, 200, ["Region 3", "12.3% of the area", "flat to 2 mm"], 30),
        (50, 60, ["Region 3", "12.3% of the area", "flat to 2 mm"], 10),  # no room at all
    ],
)
def test_text_next_to_the_mouse_stays_visible(wanted, right, lines, at):
    assert text.beside(SAID, lambda words: 10 * len(words), wanted, right, 10) == (lines, at)


@pytest.mark.parametrize(
    ("room", "lines"),
    [
        (400, ["200 regions -> 201 polygons, 1.4 cm off"]),
        (280, ["200 regions -> 201 polygons,", "1.4 cm off"]),
        (150, ["200 regions ->", "201 polygons,", "1.4 cm off"]),
        (-50, ["200", "regions", "->", "201", "polygons,", "1.4", "cm", "off"]),  # no room at all
    ],
)
def test_the_summary_takes_the_lines_that_it_needs(room, lines):
    assert text.fitted("200 regions -> 201 polygons, 1.4 cm off", lambda words: 10 * len(words), room) == lines


def test_progress_fits_the_sidebar():
    assert text.short_progress("Reading the mesh 15%, 10 s left") == "15%, 10 s left"
    assert text.short_progress("Starting") == "Starting"


def test_a_number_keeps_its_unit():
    assert text.wrapped("1.4 cm off the scan, at most 5.1 cm", 32)[-1] == "5.1\N{NO-BREAK SPACE}cm"
    assert text.wrapped("26 regions at most", 9) == ["26", "regions", "at most"]


def test_a_number_is_parted_from_its_word_only_where_it_must_be():
    line = "5,120\N{NO-BREAK SPACE}triangles · 1\N{NO-BREAK SPACE}part"
    assert text.wrapped(line, 20) == ["5,120\N{NO-BREAK SPACE}triangles ·", "1\N{NO-BREAK SPACE}part"]
    assert text.wrapped(line, 10) == ["5,120", "triangles", "· 1\N{NO-BREAK SPACE}part"]


def test_planes_that_are_not_held_are_in_the_report():
    away = {"away_mean": 0.01, "away_max": 0.02, "planarity_mean": 0.0, "planarity_max": 0.0}
    numbers = away | {"regions": 4, "polygons": 4, "closed": True, "manifold": True, "diagonal": 1.0, "let_go": 3}
    line = ("3 planes not held, for better polygons", False)
    assert line in text.report_lines(numbers | {"held": 4}, "METRIC", 1.0)
    assert line in text.report_lines(numbers | {"planes": 4}, "METRIC", 1.0)
    assert line not in text.report_lines(numbers, "METRIC", 1.0), "nobody asked for planes"
    assert text.planes_let_go(numbers | {"held": 4}) == line[0]
    assert text.planes_let_go(numbers) == ""
    assert len(text.report_lines(numbers | {"let_go": 0}, "METRIC", 1.0)) == 3


def test_polygons_left_bent_are_counted_before_the_planes():
    away = {"away_mean": 0.01, "away_max": 0.02, "planarity_mean": 0.01, "planarity_max": 0.1}
    numbers = away | {"regions": 4, "polygons": 307, "closed": True, "manifold": True, "diagonal": 1.0}
    numbers |= {"let_go": 3, "held": 4, "cut_if_planar": 0.5, "not_flat": 136}
    lines = [line for line, _ in text.report_lines(numbers, "METRIC", 1.0)]
    assert lines.index("136 of 307 not exactly flat") < lines.index("3 planes not held, for better polygons")
    assert not any("not held" in row for row, _, _ in text.report_rows(numbers, "METRIC", 1.0, None, 60))
    assert text.not_flat(numbers) == "136 of 307 not exactly flat"
    assert text.not_flat(numbers | {"not_flat": 0}) == ""


@pytest.mark.parametrize(
    ("parts", "told"),
    [
        ([["cylinder", 0.04985, 28, 1, 7, [0, 1]]], "1 cylinder Ø 9.97 cm, 28 segments; 6 planes"),
        ([["cone", 0.04985, 28, 1, 7, [0, 1, 2, 3, 4, 5, 6]]], "1 cone, 28 segments; 1 plane"),
        ([[kind, 1.0, 8, 1, 7, [4]] for kind in ("cylinder", "cone", "cylinder")], "2 cylinders, 1 cone; 5 planes"),
        (
            [["revolution", 1.0, 8, 1, 7, [3, 4]], ["sphere", 1.0, 8, 1, 7, [0, 1, 2, 5, 6, 7]]],
            "1 sphere, 1 turned part",
        ),
    ],
)
def test_round_parts_are_told(parts, told):
    assert text.round_parts({"round": parts, "regions": 8}, False) == told


def test_round_parts_that_were_asked_for_and_not_found_are_told():
    assert text.round_parts({}, False) == ""
    assert text.round_parts({}, True) == "No round part found: try a larger Smallest Feature"
    assert text.round_parts({"not_round": "flat"}, True) == "No round part found: no surface bends"
