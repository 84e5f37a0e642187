"""Checks of the values of steps. Standard library only."""

from __future__ import annotations

import math
import operator
import reprlib
from collections.abc import Iterable, Sequence
from typing import Any, SupportsIndex

from .option import Option


class RecipeError(ValueError):
    """A recipe can't be used; the message says which step and why."""


def check(wrong: bool, message: str) -> None:
    """Raises RecipeError if something is wrong."""
    if wrong:
        raise RecipeError(message)


def check_options(settings: dict[str, Any], table: dict[str, Option]) -> None:
    """Refuses settings that the engine would refuse."""
    for name, value in settings.items():
        option = table[name]
        if option.choices:
            known = ", ".join(option.choices)
            check(value not in option.choices, f"{name} must be one of {known}, got {short(value)}")
        elif option.kind in {"int", "float"}:
            check(not option.holds(value), f"{name} must be {option.words}, got {value}")


def indices(faces: Sequence[SupportsIndex]) -> tuple[int, ...]:
    """Faces as plain integers; any sequence of integers will do, numpy's too."""
    try:
        plain = tuple(operator.index(face) for face in faces if not isinstance(face, bool))
    except TypeError:
        plain = ()
    check(len(plain) == 0 or len(plain) != len(faces), f"faces must be a list of faces, got {short(faces)}")
    check(min(plain) < 0, f"faces must be at least 0, got {short(min(plain))}")
    return plain


def numbers(values: Iterable[Any], name: str) -> tuple[float, ...]:
    """Values as plain, finite numbers."""
    try:
        plain = tuple(float(value) for value in values)
    except (TypeError, ValueError, OverflowError):
        raise RecipeError(f"{name} must be a list of numbers, got {short(values)}") from None
    check(not all(map(math.isfinite, plain)), f"{name} must be finite, got {short(values)}")
    return plain


_SHORT = reprlib.Repr()  # with limits of depth and length
_SHORT.maxlevel, _SHORT.maxstring, _SHORT.maxlist, _SHORT.maxtuple = 3, 50, 10, 10


def short(value: object) -> str:
    """A value that may be anything, as it is put into a message."""
    text = _SHORT.repr(value)
    return text if len(text) < 60 else text[:57] + "..."
