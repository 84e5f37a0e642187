"""docs/constants.md has the tuned constants with the values that the sources have."""

from pathlib import Path

import pytest

from bench.quality import constants, curved_constants

ROOT = Path(__file__).resolve().parents[3]
ROWS = (ROOT / "docs/constants.md").read_text().splitlines()


@pytest.mark.parametrize("tuned", constants.TUNED, ids=lambda tuned: f"{Path(tuned.path).name}:{tuned.name}")
def test_the_table_has_each_with_its_value(tuned):
    mine = [row for row in ROWS if row.startswith(f"| {tuned.place} |")]
    assert len(mine) == 1
    assert mine[0].split("|")[2].strip() == tuned.value()


@pytest.mark.parametrize("tuned", constants.TUNED, ids=lambda tuned: f"{Path(tuned.path).name}:{tuned.name}")
def test_half_and_twice_are_others(tuned):
    below, above = map(float, tuned.variants())
    assert below < float(tuned.value()) < above


def test_the_table_has_no_other():
    named = [row for row in ROWS if row.startswith("| `")]
    assert len(named) == len(constants.TUNED) + len(curved_constants.constants())


def test_the_table_of_round_parts_has_each_with_its_value_and_meaning():
    for constant in curved_constants.constants():
        start = f"| {constant.place} | {constant.text} | {constant.meaning} |"
        assert sum(row.startswith(start) for row in ROWS) == 1, start


def test_constants_are_found_with_several_in_a_line_and_a_meaning_of_two_lines():
    text = """constexpr double kOne = 0.5, kTwo = 2;  ///< first
                                              ///< second
constexpr std::array kThree = {1, 2};
const double kFour = std::cos(1.0);
  constexpr int kInner = 3;
"""
    found = [(c.name, c.text, c.meaning) for c in curved_constants.constants_in("file.cpp", text)]
    assert found == [("kOne", "0.5", "first second"), ("kTwo", "2", "first second"), ("kFour", "std::cos(1.0)", "")]


@pytest.mark.parametrize(
    ("value", "kind", "others"),
    [
        (0.3, "double", [0.15, 0.6]),
        (0.8, "double", [0.6, 0.9]),
        (1.2, "double", [1.1, 1.4]),
        (6, "int", [3, 12]),
        (1, "int", [2]),
    ],
)
def test_other_values(value, kind, others):
    assert curved_constants.other_values(value, kind) == pytest.approx(others)


def test_a_changed_value_is_found_and_a_missing_name_is_refused(tmp_path):
    tuned = next(t for t in constants.TUNED if t.name == "kNu")
    file = tmp_path / tuned.path
    file.parent.mkdir(parents=True)
    file.write_text("constexpr double kNu = 0.25;  // kNu of a turn\n")
    assert tuned.value(tmp_path) == "0.25"
    file.write_text("constexpr double kOther = 0.25;\n")
    with pytest.raises(SystemExit, match="kNu occurs 0 times"):
        tuned.value(tmp_path)
