"""The promise of CONTRIBUTING.md for a step of recipes: features that follow from its class and its row of `EDITS`."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

import shapes
from isimp import applying, messages
from isimp import recipe as rcp
from isimp.session import Session, StepFailed, engine
from isimp_engine import recipe as command_steps
from session_scans import scan_of

ROOT = Path(__file__).resolve().parents[3]
SOURCES = [path for folder in ("addon/isimp", "python/isimp_engine") for path in (ROOT / folder).rglob("*.py")]
#: files that may name a step, except operators: its class, its names, its application, its time and its label
NAMED_IN = r"python/isimp_engine/(recipe/\w+|recipes|replay/edits)|addon/isimp/(applying|messages|session)"
IN_BLENDER = r"addon/isimp/blender/(operators/\w+|controls/settings)"
#: steps with settings in the panel, presets or the view, which name them; and Blender's or the engine's own words
SETTINGS = {"Partition", "Regularise", "AlignPlanes", "Mesh", "Texture"}


@dataclass(frozen=True)
class Whet(rcp.Step):
    """Split the region at a face, which is enough to see that the step was applied."""

    face: int = 0
    times: int = 1

    def __post_init__(self) -> None:
        if not 1 <= self.times <= 9:
            raise rcp.RecipeError(f"times must be in [1, 9], got {self.times}")

    def describe(self) -> str:
        return f"Whet face {self.face}"


@pytest.fixture
def whet(monkeypatch):
    def edit(step, faces, part, job):
        return engine.split_region(faces.mesh, part, faces.triangle_at(step.face), job=job)

    monkeypatch.setitem(rcp.KINDS, Whet, "whet")
    monkeypatch.setitem(command_steps.KINDS, Whet, "whet")
    monkeypatch.setitem(applying.STAGES, "whet", "whetting")
    monkeypatch.setitem(engine.replay.EDITS, "whet", edit)
    return Whet


@pytest.fixture(scope="module")
def scan():
    return scan_of(*shapes.cube(6))


def test_a_class_and_its_name_are_saved_read_and_checked(whet):
    text = rcp.Recipe((whet(face=3, times=2),)).to_json()
    assert json.loads(text)["steps"] == [{"step": "whet", "face": 3, "times": 2}]
    assert rcp.Recipe.from_json(text).steps == (whet(face=3, times=2),)
    for values, words in [
        ({"times": 10}, r"times must be in \[1, 9\], got 10"),
        ({"face": "a"}, "face of whet must be a whole number"),
        ({"edge": 1}, "whet has no setting 'edge'"),
    ]:
        with pytest.raises(rcp.RecipeError, match=words):
            rcp.Recipe.from_json(json.dumps({"isimp_recipe": 1, "steps": [{"step": "whet", **values}]}))


def test_a_row_applies_it_with_cache_and_progress(whet, scan):
    session = Session()
    recipe = rcp.Recipe((rcp.Partition(proxies=6), whet(face=3)))
    outcome = session.replay(scan, recipe)
    assert (outcome.partition.region_count, outcome.numbers["step"]) == (7, "whet")
    assert session.replay(scan, recipe) is outcome, "known outcomes are not computed again"
    longer = recipe.then(whet(face=3, enabled=False)).then(whet(face=90))
    assert session.replay(scan, longer).partition.region_count == 8
    assert len(np.unique(session.replay(scan, longer).face_region)) == 8
    with pytest.raises(StepFailed) as caught:
        session.replay(scan, recipe.then(whet(face=10**6)))
    assert caught.value.index == 2
    assert messages.line(whet(face=3)) == "Whet face 3"


def test_the_command_does_it(whet):
    values = {"isimp_recipe": 1, "steps": [{"step": "partition", "proxies": 6}, {"step": "whet", "face": 3}]}
    assert engine.simplify(shapes.cube(6), recipe=values).partition.region_count == 7


@pytest.mark.parametrize("step", [cls for cls in rcp.KINDS if cls.__name__ not in SETTINGS], ids=rcp.KINDS.get)
def test_few_files_name_a_step(step):
    name = re.compile(rf"\b{step.__name__}\b")
    files = [path.relative_to(ROOT).with_suffix("").as_posix() for path in SOURCES if name.search(path.read_text())]
    others = [file for file in files if not re.fullmatch(f"{NAMED_IN}|{IN_BLENDER}", file)]
    assert others == []
    assert len(files) <= 8
    assert any(file.startswith("addon/isimp/blender/operators/") for file in files), "no operator adds it"
