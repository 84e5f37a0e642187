"""The data stored with a scan: any content of a file gives a recipe, or one line with the reason why there is none."""

import json
import random
import re

import pytest

from isimp import stored
from isimp.recipe import MOST_ROUNDS, AddProxy, Partition, Recipe, RecipeError, SmoothFaces, step_from_dict

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
        ({2: (2, SECOND, "")}, "form a circle"),
        ({1: (2, FIRST, ""), 2: (1, SECOND, "")}, "form a circle"),
        (
            chain(FIRST, '{"step": "future_step", "strength": 2}'),
            "step 2: 'future_step' is not a step of this version",
        ),
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


def test_a_chain_may_be_long_and_not_without_end():
    longest = chain(*[SECOND] * stored.MOST_STEPS)
    assert len(stored.read(len(longest), longest.get).recipe.steps) == stored.MOST_STEPS
    longer = chain(*[SECOND] * (stored.MOST_STEPS + 1))
    assert "more than 20,000" in stored.read(len(longer), longer.get).problem


@pytest.mark.parametrize(
    "values",
    [
        {"parent": "1", "step": FIRST},
        {"parent": 1.5},
        {"step": 7},
        {"numbers": [1]},
        {"parent": True},
        {"step": b"\xff"},
    ],
)
def test_a_node_of_other_types_is_none(values):
    assert stored.node_from(values) is None
    assert stored.node_from({"parent": 3, "step": FIRST, "more": 1}) == (3, FIRST, "")
    assert stored.node_from({}) == (0, "", "")


@pytest.mark.parametrize(
    ("text", "numbers"),
    [
        ("", {}),
        ("{", {}),
        pytest.param(DEEP, {}, id="deep"),
        ("[1]", {}),
        ('{"regions": "many", "error": null, "seconds": true, "locked": 1e999}', {}),
        ('{"regions": 9, "later": {"a": 1}}', {"regions": 9}),
        ('{"failed": 1}', {}),
        ('{"failed": 1, "reason": "two\\nlines \\ud800"}', {"failed": 1, "reason": "two lines  "}),
        ('{"components": 3, "closed": true, "faces": 12}', {"closed": True, "faces": 12}),
        ('{"scan_distance": 1.5}', {}),
        ('{"flaws": {"bent": [1, "x"]}, "repairs": {"cut_edges": "x"}}', {}),
        (
            '{"flaws": {"bent": [1]}, "repairs": {"cut_edges": 2}}',
            {"flaws": {"bent": [1]}, "repairs": {"cut_edges": 2}},
        ),
        ('{"regions": 1' + "0" * 30 + "}", {}),
    ],
)
def test_numbers_are_read_as_far_as_they_can_be_shown(text, numbers):
    assert stored.numbers_from(text) == numbers


def test_which_states_can_be_read():
    nodes = chain(FIRST, SECOND, '{"step": "future_step"}', SECOND)
    nodes |= {10: (11, FIRST, ""), 11: (10, FIRST, ""), 12: (10, SECOND, ""), 13: (99, SECOND, ""), 14: (1, SECOND, "")}
    assert stored.readable(nodes, nodes.get) == {1, 2, 14}
    assert stored.readable(reversed(nodes), nodes.get) == {1, 2, 14}
    assert stored.readable([0, 99], nodes.get) == {0}


def anything(draw, depth=0):
    """A value of any kind that JSON can hold."""
    kinds = [
        None,
        True,
        -1,
        0,
        7,
        10**12,
        10**40,
        0.5,
        -1e300,
        float("nan"),
        float("inf"),
        "",
        "add_proxy",
        "\ud800",
        "é",
    ]
    if depth < 3 and draw.random() < 0.3:
        if draw.random() < 0.5:
            return [anything(draw, depth + 1) for _ in range(draw.randrange(4))]
        return {draw.choice(["step", "face", "x", ""]): anything(draw, depth + 1) for _ in range(draw.randrange(4))}
    return draw.choice(kinds)


def a_step(draw):
    """The text of a step: sound, with wrong values, cut off, or nothing of the kind."""
    values = {
        "partition": ("proxies", "detail", "tolerance", "weights", "seed", "method", "count_by", "faces", "seams"),
        "smooth": ("faces", "rounds"),
        "cut_region": ("face", "line", "direction"),
        "paint": ("faces", "onto", "lock"),
        "mesh": ("flatten", "chord_tolerance"),
        "grow": ("face", "rings"),
        "future_step": ("face",),
        "add_proxy": ("face", "later"),
    }
    kind = draw.choice(list(values))
    step = {"step": kind, **{name: anything(draw) for name in values[kind] if draw.random() < 0.3}}
    text = json.dumps(draw.choice([step, step, step, anything(draw)]))
    return draw.choice([FIRST, SECOND, SECOND, text, text, text[: draw.randrange(len(text))], "[" * 5000])


def test_a_thousand_stored_recipes_of_all_kinds():
    """Every one is read or refused in a line; none raises, and none runs forever."""
    draw, read, refused = random.Random(18), 0, set()
    for _ in range(1000):
        ids = range(1, draw.randrange(2, 8))
        nodes = {at: stored.node_from({"parent": at - 1, "step": a_step(draw)}) for at in ids}
        for at in nodes:
            if draw.random() < 0.1:
                nodes[at] = (draw.choice([0, at, draw.randrange(9), -1, 2**31 - 1]), *nodes[at][1:])
            values = draw.choice([anything(draw), {"regions": anything(draw), "failed": 1}])
            numbers = draw.choice(["", json.dumps(values)])
            nodes[at] = (*nodes[at][:2], numbers)
        found = stored.read(draw.choice([*ids, 8]), nodes.get)
        json.dumps(found.numbers)
        if found.recipe is None:
            assert found.problem.isprintable()
            refused.add(found.problem)
        else:
            assert found.problem == ""
            assert Recipe.from_json(found.recipe.to_json()) == found.recipe
            read += 1
    assert read > 100
    for kind in ("form a circle", "is missing", "of this version", "has no setting", "not JSON", "must be"):
        assert any(kind in problem for problem in refused), kind


@pytest.mark.parametrize("rounds", [0, MOST_ROUNDS + 1, 10**6])
def test_smoothing_has_a_limit(rounds):
    with pytest.raises(RecipeError, match=rf"rounds must be in \[1, 1,000\], got {rounds}"):
        step_from_dict({"step": "smooth", "faces": [1], "rounds": rounds})
    assert SmoothFaces(faces=(1,), rounds=MOST_ROUNDS).rounds == 1000
