"""Checks that docs/benchmarks.md has the tasks of bench/public.py, and that a loss is found."""

import importlib.util
import json
import re
from pathlib import Path

from bench import public

ROOT = Path(__file__).resolve().parents[3]
BEFORE = {"quality": {"a": 1.0, "b": 0.0}, "operations": {"meshing": 100.0}}


def test_every_task_is_a_program_with_a_table():
    page = (ROOT / "docs" / "benchmarks.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`(\w+)[^`]*`", page))
    for task, (module, _, about) in public.TASKS.items():
        assert importlib.util.find_spec(module), task
        assert about
        assert task in named
    headings = re.findall(r"^## `(\w+)`", page, re.MULTILINE)
    assert set(headings) <= public.TASKS.keys() | {"small"}


def test_a_loss_is_found_and_a_gain_is_not():
    assert public.worse(BEFORE, BEFORE) == []
    better = {"quality": {"a": 0.5, "b": 0.0}, "operations": {"meshing": 50.0}}
    assert public.worse(better, BEFORE) == []
    within = {"quality": {"a": 1.04, "b": 0.009}, "operations": {"meshing": 114.0}}
    assert public.worse(within, BEFORE) == []
    for kind, name, value in (("quality", "a", 1.06), ("quality", "b", 0.02), ("operations", "meshing", 116.0)):
        (line,) = public.worse(BEFORE | {kind: BEFORE[kind] | {name: value}}, BEFORE)
        assert line.startswith(f"{kind}: {name} ")


def test_a_figure_that_only_one_side_has_is_a_loss():
    (line,) = public.worse({"quality": {"a": 1.0}}, BEFORE)
    assert line.startswith("quality: b 0.0 -> None")


def test_the_kept_figures_are_those_that_are_measured():
    kept = json.loads((ROOT / "bench" / "public.json").read_text(encoding="utf-8"))
    assert kept["operations"].keys() == set(public.STAGES)
    solids = {f"solids {name}": value for name, value in public.solids().items()}
    assert public.worse({"quality": kept["quality"] | solids}, kept) == []
