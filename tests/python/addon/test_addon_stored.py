"""The data stored with a scan give a recipe, or the text of its steps and one line why they can't be read."""

import json
import re

import pytest

from isimp import stored
from isimp.recipe import AddProxy, Partition, Recipe

FIRST, SECOND = json.dumps({"step": "partition", "proxies": 8}), json.dumps({"step": "add_proxy", "face": 20})
DEEP = "[" * 200_000


def chain(*texts):
    """{id: node} of steps that follow each other; ids from 1."""
    return {number: (number - 1, text, "") for number, text in enumerate(texts, 1)}


def test_a_sound_chain_is_read():
    nodes = chain(FIRST, SECOND)
    nodes[2] = (*nodes[2][:2], '{"regions": 9, "error": 0.5}')
    read = stored.read(2, nodes.get)
    assert (read.recipe, read.problem) == (Recipe((Partition(proxies=8, adaptivity=0.0), AddProxy(face=20))), "")
    assert read.numbers == {"regions": 9, "error": 0.5}
    assert stored.read(0, nodes.get) == stored.Stored(Recipe())


@pytest.mark.parametrize(
    ("nodes", "why"),
    [
        ({}, "The steps of these regions are unknown"),
        ({2: (1, SECOND, "")}, "The steps of these regions are unknown: a step before the last 1 is missing"),
        ({2: (-7, SECOND, "")}, "a step before the last 1 is missing"),
        ({1: (2, FIRST, ""), 2: (1, SECOND, "")}, "there are more than 20,000"),
        (chain(FIRST, '{"step": "future_step", "strength": 2}'), "step 2: 'future_step' is not a step of this version"),
        (chain(FIRST, '{"step": "add_proxy", "face": 1, "how": 2}'), "step 2: add_proxy has no setting 'how'"),
        (chain("{", SECOND), "step 1 is not a step: it is not JSON"),
        (chain(FIRST, ""), "step 2 is not a step: it is not JSON"),
        (chain(FIRST, DEEP), "step 2 is not a step: its brackets are nested too deeply"),
        (chain(FIRST, "3"), "step 2: not a step: 3"),
        (chain(FIRST, "null"), "step 2: not a step: None"),
        (chain(FIRST, '{"step": ["add_proxy"]}'), r"step 2: \['add_proxy'\] is not a step"),
        (chain(FIRST, '{"step": "add_proxy", "face": 1e400}'), "face of add_proxy must be a whole number, got inf"),
        (chain(FIRST, '{"step": "add_proxy", "face": 99999999999}'), "face of add_proxy must be at most 2147483647"),
        (chain(FIRST, '{"step": "paint", "faces": [1' + "0" * 5000 + "]}"), "step 2 is not a step: it is not JSON"),
        (chain('{"step": "partition", "detail": NaN}'), r"step 1: detail must be in \(0, 1\], got nan"),
        (chain('{"step": "partition", "tolerance": 1' + "0" * 400 + "}"), "tolerance of partition must be at most"),
        (
            chain('{"step": "partition", "weights": "\\ud800"}'),
            "weights of partition contains characters that are not valid in a name",
        ),
        (
            chain('{"step": "partition", "borders": "a\\u0000b"}'),
            "borders of partition contains characters that are not valid in a name",
        ),
        (chain(FIRST, json.dumps({"step": "x" * 10**6})), "step 2: 'xxx.*is not a step of this version"),
        (chain(FIRST, json.dumps({"step": {"line\nbreak": "\t"}})), "step 2: .* is not a step of this version"),
    ],
)
def test_what_cannot_be_read_is_said_in_one_line(nodes, why):
    read = stored.read(len(nodes) if 1 in nodes else 2, nodes.get)
    assert (read.recipe, read.numbers) == (None, {})
    assert re.search(why, read.problem)
    assert read.problem.isprintable()
    assert len(read.problem) <= 300
    found = [nodes[at][1] for at in (1, 2) if at in nodes and (at == 2 or 1 in nodes)]
    assert all(text in read.text for text in found), "what is there is kept"


def test_a_chain_may_be_long_and_not_without_end():
    longest = chain(*[SECOND] * stored.MOST_STEPS)
    assert len(stored.read(len(longest), longest.get).recipe.steps) == stored.MOST_STEPS
    longer = chain(*[SECOND] * (stored.MOST_STEPS + 1))
    assert "more than 20,000" in stored.read(len(longer), longer.get).problem


@pytest.mark.parametrize(
    ("text", "numbers"),
    [
        ("", {}),
        ("{", {}),
        pytest.param(DEEP, {}, id="deep"),
        ("[1]", {}),
        ('{"failed": 1}', {}),
        ('{"components": 3, "closed": true, "faces": 12}', {"closed": True, "faces": 12}),
        ('{"scan_distance": 1.5}', {}),
        (
            '{"flaws": {"bent": [1]}, "repairs": {"cut_edges": 2}}',
            {"flaws": {"bent": [1]}, "repairs": {"cut_edges": 2}},
        ),
    ],
)
def test_numbers_are_read_as_far_as_those_shown_together_are_there(text, numbers):
    assert stored.numbers_from(text) == numbers
