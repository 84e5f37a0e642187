"""docs/constants.md has the tuned constants with the values that the sources have."""

from pathlib import Path

import pytest

from bench.quality import constants

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
    assert len(named) == len(constants.TUNED)


def test_a_changed_value_is_found_and_a_missing_name_is_refused(tmp_path):
    tuned = next(t for t in constants.TUNED if t.name == "kNu")
    file = tmp_path / tuned.path
    file.parent.mkdir(parents=True)
    file.write_text("constexpr double kNu = 0.25;  // kNu of a turn\n")
    assert tuned.value(tmp_path) == "0.25"
    file.write_text("constexpr double kOther = 0.25;\n")
    with pytest.raises(SystemExit, match="kNu occurs 0 times"):
        tuned.value(tmp_path)
