"""Reads the data stored with a scan: a recipe, or the reason why it can't be read.

A file may be damaged, or written by a later version or another program. Standard library only.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from . import recipe as rcp
from .language import own, said

MOST_STEPS = 20_000  #: largest number of steps of a recipe
_LONGEST_REASON = 300  # letters; the panel wraps them
_LARGEST = 1 << 63  # counts must be below it

NodeOf = Callable[[int], "tuple[int, str, str] | None"]  #: returns a node by its id; None if there is no such node

UNKNOWN = own("The steps of these regions are unknown")


@dataclass(frozen=True)
class Stored:
    """The stored data of the regions on a scan."""

    recipe: rcp.Recipe | None  #: empty if there are no regions, None if the steps that led to them can't be read
    numbers: dict[str, Any] = field(default_factory=dict)  #: numbers of the last step
    problem: str = ""  #: why the steps can't be read, as a line without a full stop


def node_from(values: Mapping[str, Any]) -> tuple[int, str, str] | None:
    """Return (parent, step, numbers) of a stored node; None if the values are not a node."""
    node = values.get("parent", 0), values.get("step", ""), values.get("numbers", "")
    return node if (type(node[0]), type(node[1]), type(node[2])) == (int, str, str) else None


def read(state: int, node_of: NodeOf, recipe: rcp.Recipe | None = None) -> Stored:
    """Return the recipe of a state and the numbers of its last step. recipe: used instead of reading the steps.

    Never raises. Cost: linear in the steps of the recipe.
    """
    if not state:
        return Stored(rcp.Recipe())
    if recipe is None:
        texts, problem = _texts(state, node_of)
        if problem:
            return Stored(None, problem=problem)
        try:
            recipe = rcp.Recipe(tuple(_step(number, text) for number, text in enumerate(texts, 1)))
        except rcp.RecipeError as error:
            return Stored(None, problem=line(said("The steps can't be read: {error}", error=error)))
    last = node_of(state)
    return Stored(recipe, numbers_from(last[2]) if last is not None else {})


def _texts(state: int, node_of: NodeOf) -> tuple[list[str], str]:
    """Return (texts of the steps of a state, ""), or ([], reason)."""
    texts: list[str] = []
    seen: set[int] = set()
    at = state
    while at:
        if at in seen:
            return [], said("The steps can't be read: they form a circle")
        if len(texts) == MOST_STEPS:
            return [], said("The steps can't be read: there are more than {most}", most=f"{MOST_STEPS:,}")
        node = node_of(at)
        if node is None:
            text = own("The steps of these regions are unknown: a step before the last {number} is missing")
            return [], said(text, number=len(texts)) if texts else said(UNKNOWN)
        seen.add(at)
        texts.append(node[1])
        at = node[0]
    return texts[::-1], ""


def _step(number: int, text: str) -> rcp.Step:
    return rcp.numbered_step(number, rcp.parsed(text, said("step {number} is not a step", number=number)))


def readable(states: Iterable[int], node_of: NodeOf) -> set[int]:
    """Return the states whose steps can all be read. Cost: linear in all steps."""
    good, states = {0: True}, set(states)
    for state in states:
        way, at = [], state
        while at not in good:
            good[at] = False  # ends the search in a circle of parents
            way.append(at)
            node = node_of(at)
            if node is None or not _is_step(node[1]):
                break
            at = node[0]
        else:
            good.update(dict.fromkeys(way, good[at]))
    return {state for state in states if good[state]}


def _is_step(text: str) -> bool:
    try:
        _step(1, text)
    except rcp.RecipeError:
        return False
    return True


def numbers_from(text: str) -> dict[str, Any]:
    """Return the numbers of a step from JSON text. Values of a type that the panel can't show are dropped."""
    try:
        found = json.loads(text) if text else {}
    except (ValueError, RecursionError):
        return {}
    if not isinstance(found, dict):
        return {}
    numbers = {name: value for name, value in found.items() if name in _FITS and _FITS[name](value)}
    for name, needed in _TOGETHER.items():
        if name in numbers and not all(other in numbers for other in needed):
            del numbers[name]
    if "reason" in numbers:
        numbers["reason"] = line(numbers["reason"])
    return numbers


def _is_count(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and -_LARGEST < value < _LARGEST


def _is_number(value: object) -> bool:
    return isinstance(value, float) or _is_count(value)


def _is_flag(value: object) -> bool:
    return isinstance(value, bool)


def _is_text(value: object) -> bool:
    return isinstance(value, str)


def _are_counts(value: object) -> bool:
    return isinstance(value, dict) and all(map(_is_count, value.values()))


def _are_polygons(value: object) -> bool:
    if not isinstance(value, dict) or not all(isinstance(found, list) for found in value.values()):
        return False
    return all(_is_count(polygon) for found in value.values() for polygon in found)


def _are_round(value: object) -> bool:
    """Return whether the value is a list of round parts, as `applying` makes it."""

    def fits(part: object) -> bool:
        if not isinstance(part, list) or len(part) != 5:
            return False
        kind, radius, *counts = part
        return (
            kind in ("cylinder", "cone", "sphere", "revolution", "extrusion")
            and _is_number(radius)
            and all(map(_is_count, counts))
        )

    return isinstance(value, list) and all(map(fits, value))


_COUNTS = (
    *(
        "regions",
        "regions_before",
        "asked",
        "left_out",
        "regions_left_out",
        "locked",
        "barriers",
        "barriers_inside",
        "failed",
    ),
    *("polygons", "corners", "vertices", "triangles", "faces", "components", "border_loops", "kept_open"),
    *("cluttered", "clutter_polygons", "nearer_regions"),
    *("held", "planes", "directions", "let_go", "not_flat", "mirrored_regions", "mirrored_corners"),
)
_NUMBERS = (
    *("error", "seconds", "diagonal", "planarity_max", "planarity_mean"),
    *("scan_distance", "scan_distance_allowed", "away_mean", "away_max", "closed_below", "planes_add", "cut_if_planar"),
    *("nearer_bound", "nearer_times"),
)
_FITS = {
    **dict.fromkeys(_COUNTS, _is_count),
    **dict.fromkeys(_NUMBERS, _is_number),
    **dict.fromkeys(("closed", "manifold"), _is_flag),
    "repairs": _are_counts,
    "split": _are_counts,
    "expected": _are_counts,
    "scan": _is_text,
    "symmetry": lambda value: value in ("X", "Y", "Z", "oblique", "none"),
    "flaws": _are_polygons,
    "round": _are_round,
    "reason": _is_text,
}
#: numbers that are dropped if one of these others is missing, since they are shown together
_TOGETHER = {
    "components": ("border_loops", "closed", "triangles", "faces"),
    "polygons": ("corners", "vertices", "planarity_mean", "planarity_max", "closed", "manifold", "regions"),
    "scan_distance": ("scan_distance_allowed",),
    "planes": ("directions", "planes_add", "regions"),
    "nearer_bound": ("nearer_regions", "nearer_times"),
    "away_max": ("away_mean",),
    "away_mean": ("away_max",),
    "mirrored_regions": ("regions",),
    "not_flat": ("cut_if_planar", "polygons"),
    "failed": ("reason",),
}


def line(text: str) -> str:
    """Return any text as one printable line of limited length."""
    shown = "".join(letter if letter.isprintable() else " " for letter in text[: 2 * _LONGEST_REASON])
    return shown if len(shown) <= _LONGEST_REASON else shown[: _LONGEST_REASON - 3] + "..."
