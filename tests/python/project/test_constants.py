"""Each number of native says its kind, and docs/constants.md has a row for each tuned one."""

import re

import pytest

from bench.quality import constants

PAGE = constants.PAGE.read_text()
ROWS = [row for row in PAGE.splitlines() if re.match(r"\| `\w+`, `", row)]
ALL = constants.constants()
TUNED = constants.tuned()


def test_each_constant_says_its_kind():
    assert [c.key for c in ALL if c.kind not in constants.KINDS] == []


def test_a_tuned_constant_names_known_data_and_its_meaning():
    known = set(re.findall(r"^\| `(\w+)` \|", PAGE, re.M))
    assert [c.key for c in TUNED if c.data not in known or not c.meaning] == []
    assert known - constants.KINDS.keys() == {c.data for c in TUNED} | {d for d, _ in constants.OPTIONS.values()}


def test_the_table_has_a_row_for_each_tuned_constant_and_no_other():
    heads = [constants.head_of(c) for c in TUNED + constants.options()]
    assert [row for row in ROWS if not row.startswith(tuple(heads))] == []
    assert [head for head in heads if sum(row.startswith(head) for row in ROWS) != 1] == []


def test_kinds_are_found_behind_above_and_for_several_in_a_line():
    text = """// work: one
constexpr int kZero = 0;
constexpr int kLost = 0;  // of no kind
// tuned houses
constexpr double kOne = 0.5, kTwo = 2;  ///< first
                                        ///< second
constexpr std::array kThree = {1, 2};  // a list
constexpr std::array<double, 2> kLong{0.5,
                                      1e-3};
constexpr double kPlain[] = {1, 2};
constexpr std::array kNames = {"a", "b"};
/// rounding: a share
static constexpr float kFour{1e-6F};

  const int kFive = 3;  // and more
// tuned walls
constexpr int kSix = 6;  // mark
"""
    found = [(c.name, c.value, c.kind, c.data, c.meaning) for _, some in constants.declared("f.h", text) for c in some]
    assert found == [
        ("kZero", "0", "work", "", "one"),
        ("kLost", "0", "", "", "of no kind"),
        ("kOne", "0.5", "tuned", "houses", "first second"),
        ("kTwo", "2", "tuned", "houses", "first second"),
        ("kThree", "1, 2", "tuned", "houses", "a list"),
        ("kLong", "0.5, 1e-3", "tuned", "houses", ""),
        ("kPlain", "1, 2", "tuned", "houses", ""),
        ("kFour", "1e-6F", "rounding", "", "a share"),
        ("kFive", "3", "tuned", "houses", "and more"),
        ("kSix", "6", "mark", "", ""),
    ]


def test_a_comment_above_is_of_the_constant_below():
    text = """// tuned houses
/// The first.
constexpr double kOne = 1;
/// rounding: the second,
/// of two lines.
constexpr double kTwo = 2;
struct Any {
  static constexpr int kThree = 3;  ///< work: the third,
                                    ///< of two lines
  /// limit: the fourth
  static constexpr int kFour = 4;
};
"""
    found = [(c.name, c.kind, c.meaning) for _, some in constants.declared("f.h", text) for c in some]
    assert found == [
        ("kOne", "tuned", "The first."),
        ("kTwo", "rounding", "the second, of two lines."),
        ("kThree", "work", "the third, of two lines"),
        ("kFour", "limit", "the fourth"),
    ]


def test_constants_become_functions_where_they_are_declared_and_included():
    texts = {
        "src/flat/flat.h": "#pragma once\nconstexpr double kHigh = 2;  // tuned houses: x\n",
        "src/flat/regions.cpp": """#include "flat/flat.h"
constexpr int kLow = 3;  // work
constexpr std::array kSteps = {1, 2};  // tuned houses: y
double f() { return kHigh * kLow; }
""",
    }
    changed = constants.looked_up(texts, {"src/flat/flat.h:kHigh": 7})
    assert "constexpr double kHigh() ISIMP_LOOKUP(double, 7, (2))" in changed["src/flat/flat.h"]
    assert "constexpr std::array kSteps = {1, 2};" in changed["src/flat/regions.cpp"]
    assert "return kHigh() * kLow;" in changed["src/flat/regions.cpp"]


@pytest.mark.parametrize(
    ("value", "kind", "others"),
    [
        (0.3, "double", [0.15, 0.6]),
        (0.8, "double", [0.6, 0.9]),
        (1.2, "double", [1.1, 1.4]),
        (6, "int", [3, 12]),
        (1, "int", [0, 2]),
    ],
)
def test_other_values(value, kind, others):
    assert constants.other_values(value, kind) == pytest.approx(others)
