"""The language of the add-on's messages. Standard library only.

A message is an English text with places for its values, as in "{regions} locked". In Blender the add-on puts in
Blender's translation (`speak`). Everywhere else messages are English.
"""

from __future__ import annotations

from collections.abc import Callable

_translate: Callable[[str], str] = str


def speak(translate: Callable[[str], str]) -> None:
    """Translates all messages from now on. `str` restores English."""
    global _translate  # noqa: PLW0603  (the one place that decides on the language)
    _translate = translate


def said(text: str, /, **values: object) -> str:
    """A text in the language of the interface, with its values."""
    own = _translate(text)
    return own.format(**values) if values else own


def own(text: str) -> str:
    """Marks a text that is translated where it is used."""
    return text


def noun(one: str) -> str:
    """Marks a noun that is counted later."""
    return one


def plural(one: str) -> str:
    return f"{one[:-2]}ices" if one.endswith("vertex") else f"{one}s"


def count(number: int, one: str) -> str:
    """A number with its noun: "1 region", "1,280 regions"."""
    return said(f"{{number}} {one if number == 1 else plural(one)}", number=f"{number:,}")
