"""Checks of the settings of steps. Each message names the setting, the rule and the value."""

from __future__ import annotations

import math
import operator
import reprlib
from collections.abc import Iterable, Sequence
from typing import Any, SupportsIndex

from .language import own, said
from .options import Option


class RecipeError(ValueError):
    """A recipe can't be used; the message names the step and the reason."""


def check(wrong: bool, message: str) -> None:
    """Raises RecipeError if something is wrong."""
    if wrong:
        raise RecipeError(message)


def must(right: bool, name: str, words: str, value: object) -> None:
    """Raises RecipeError if a setting has a wrong value. words: the rule."""
    check(not right, said("{name} must be {words}, got {value}", name=name, words=said(words), value=short(value)))


def check_choice(wrong: bool, name: str, known: str, value: object) -> None:
    check(wrong, said("{name} must be one of {known}, got {value}", name=name, known=known, value=short(value)))


def check_options(step: object, table: dict[str, Option]) -> None:
    """Refuses settings of a step that the engine would refuse."""
    for name, option in table.items():
        value = getattr(step, name, None)
        if value is None:
            continue
        if option.choices:
            check_choice(value not in option.choices, name, ", ".join(option.choices), value)
        elif option.is_below_zero:
            must(option.accepts(value), name, own("a length, or below 0"), value)
        elif option.kind in {"int", "float"}:
            words = said("0, or {words}", words=said(option.words)) if option.is_optional else option.words
            must(option.accepts(value), name, words, value)


def check_face(face: int) -> None:
    must(face >= 0, "face", own("at least 0"), face)


def indices(faces: Sequence[SupportsIndex]) -> tuple[int, ...]:
    """Faces as plain integers; any sequence of integers will do, numpy's too."""
    try:
        plain = () if bool in set(map(type, faces)) else tuple(map(operator.index, faces))
    except TypeError:
        plain = ()
    must(len(plain) > 0 and len(plain) == len(faces), "faces", own("a list of faces"), faces)
    must(min(plain) >= 0, "faces", own("at least 0"), min(plain))
    return plain


def numbers(values: Iterable[Any], name: str) -> tuple[float, ...]:
    plain: tuple[float, ...] = ()
    try:
        plain, are_numbers = tuple(float(value) for value in values), True
    except (TypeError, ValueError, OverflowError):
        are_numbers = False
    must(are_numbers, name, own("a list of numbers"), values)
    must(all(map(math.isfinite, plain)), name, own("finite"), values)
    return plain


_SHORT = reprlib.Repr()  # with limits of depth and length
_SHORT.maxlevel, _SHORT.maxstring, _SHORT.maxlist, _SHORT.maxtuple = 3, 50, 10, 10


def short(value: object) -> str:
    """The text of any value for a message, shortened."""
    text = _SHORT.repr(value)
    return text if len(text) < 60 else text[:57] + "..."
