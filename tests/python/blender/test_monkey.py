"""Every operator pressed at random, with random settings: a short run of bench/monkeys/addon_monkey.py."""

import importlib.util
import sys
from pathlib import Path

import pytest

BENCH = Path(__file__).parents[3] / "bench" / "monkeys"


@pytest.fixture
def monkey(monkeypatch):
    monkeypatch.setattr(sys, "path", list(sys.path))
    spec = importlib.util.spec_from_file_location("addon_monkey", BENCH / "addon_monkey.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_random_actions_break_nothing(monkey, tmp_path):
    one = monkey.Monkey(7, tmp_path / "log")
    assert one.run(250) == []
    assert one.refused < 190, "most presses do something"
    noted = (tmp_path / "log").read_text().splitlines()
    assert len(noted) == sum(one.done.values()) > 220, "few actions find nothing to do"


def test_a_changed_scan_and_a_traceback_are_found(monkey, tmp_path, monkeypatch):
    one = monkey.Monkey(7, tmp_path / "log")
    one.begin()
    one.check()
    mesh = next(obj.data for obj in monkey.bpy.data.objects if obj.type == "MESH")
    mesh.vertices[0].co.x += 1
    with pytest.raises(monkey.Broken, match="has changed"):
        one.check()
    one.begin()
    one.errors.write("Traceback (most recent call last)")
    with pytest.raises(monkey.Broken, match="Traceback"):
        one.check()
    assert "ZeroDivisionError" in one._tried(lambda: 1 / 0)
