"""Reads the data stored with a scan: a recipe, or the reason why it can't be read.

A later version may have written the file. Standard library only.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from . import recipe as rcp
from .language import own, said

MOST_STEPS = 20_000  #: largest number of steps of a recipe; it also ends a circle of parents
_LONGEST_REASON = 300  # letters; the panel wraps them

NodeOf = Callable[[int], "tuple[int, str, str] | None"]  #: returns (parent, step, numbers) of a node; None without it


@dataclass(frozen=True)
class Stored:
    """The stored data of the regions on a scan."""

    recipe: rcp.Recipe | None  #: empty if there are no regions, None if the steps that led to them can't be read
    numbers: dict[str, Any] = field(default_factory=dict)  #: numbers of the last step
    problem: str = ""  #: why the steps can't be read, as a line without a full stop
    text: str = ""  #: the steps that can't be read, as far as they are there: a recipe in JSON for another version


def read(state: int, node_of: NodeOf, recipe: rcp.Recipe | None = None) -> Stored:
    """Return the recipe of a state and the numbers of its last step. recipe: used instead of reading the steps.

    Cost: linear in the steps of the recipe.
    """
    if not state:
        return Stored(rcp.Recipe())
    if recipe is None:
        texts, problem = _texts(state, node_of)
        if not problem:
            try:
                values = [_values(number, text) for number, text in enumerate(texts, 1)]
                recipe = rcp.Recipe.from_values(rcp.Recipe().to_values() | {"steps": values})
            except rcp.RecipeError as error:
                problem = line(said("The steps can't be read: {error}", error=error))
        if recipe is None:
            return Stored(None, problem=problem, text=_kept(texts) if texts else "")
    last = node_of(state)
    return Stored(recipe, numbers_from(last[2]) if last is not None else {})


def _texts(state: int, node_of: NodeOf) -> tuple[list[str], str]:
    """Return the texts of the last steps of a state, and why they are not all; the reason is empty if they are."""
    texts: list[str] = []
    while state and len(texts) <= MOST_STEPS:
        node = node_of(state)
        if node is None:
            break
        texts.append(node[1])
        state = node[0]
    problem = ""
    if len(texts) > MOST_STEPS:
        problem = said("The steps can't be read: there are more than {most}", most=f"{MOST_STEPS:,}")
    elif state:
        text = own("The steps of these regions are unknown: a step before the last {number} is missing")
        unknown = own("The steps of these regions are unknown")
        problem = said(text, number=len(texts)) if texts else said(unknown)
    return texts[::-1], problem


def _kept(texts: list[str]) -> str:
    steps = ",\n".join(texts)
    return rcp.Recipe().to_json().replace("[]", f"[\n{steps}\n]") + "\n"


def _values(number: int, text: str) -> Any:
    return rcp.parsed(text, said("step {number} is not a step", number=number))


def numbers_from(text: str) -> dict[str, Any]:
    """Return the numbers of a step from JSON text; none if it can't be read."""
    try:
        numbers = json.loads(text) if text else {}
    except (ValueError, RecursionError):
        return {}
    if not isinstance(numbers, dict):
        return {}
    for name, needed in _TOGETHER.items():
        if name in numbers and not all(other in numbers for other in needed):
            del numbers[name]
    return numbers


#: numbers that are dropped if one of these others is missing, as in files of earlier versions, since they are shown
#: together
_TOGETHER = {
    "components": ("border_loops", "closed", "triangles", "faces"),
    "polygons": ("corners", "vertices", "planarity_mean", "planarity_max", "closed", "manifold", "regions"),
    "scan_distance": ("scan_distance_allowed",),
    "planes": ("directions", "planes_add", "regions"),
    "away_max": ("away_mean",),
    "away_mean": ("away_max",),
    "not_flat": ("cut_if_planar", "polygons"),
    "failed": ("reason",),
}


def line(text: str) -> str:
    """Return any text as one printable line of limited length."""
    shown = "".join(letter if letter.isprintable() else " " for letter in text[: 2 * _LONGEST_REASON])
    return shown if len(shown) <= _LONGEST_REASON else shown[: _LONGEST_REASON - 3] + "..."
