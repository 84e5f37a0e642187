"""Values of a glTF file's JSON, each of the kind that it must be, or an error that names their place."""

import math
import reprlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import FileError

_LARGEST = 1 << 53  # whole numbers that all programs write alike


class Item:
    """An object of the JSON. place: the file and where in it, for messages."""

    def __init__(self, value: Any, place: str) -> None:
        if not isinstance(value, dict):
            raise FileError(f"{place} must be an object, got {reprlib.repr(value)}")
        self._value: dict[str, Any] = value
        self.place = place

    def __contains__(self, name: str) -> bool:
        return name in self._value

    def whole(self, name: str, default: int | None = None) -> int:
        """A whole number, at least 0."""
        value = self._get(name, default)
        if isinstance(value, float) and value.is_integer():
            value = int(value)
        if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < _LARGEST:
            raise self._wrong(name, "a whole number, at least 0", value)
        return value

    def number(self, name: str, default: float | None = None) -> float:
        value = self._get(name, default)
        if not _is_finite(value):
            raise self._wrong(name, "a finite number", value)
        return float(value)

    def numbers(self, name: str, count: int, default: Any = None) -> NDArray[np.float64]:
        """Returns `count` numbers, the default where they are absent."""
        value = self._get(name, default)
        if not isinstance(value, (list, tuple)) or len(value) != count or not all(map(_is_finite, value)):
            raise self._wrong(name, f"{count} finite numbers", value)
        return np.array(value, dtype=np.float64)

    def text(self, name: str, default: str | None = None) -> str:
        value = self._get(name, default)
        if not isinstance(value, str):
            raise self._wrong(name, "a text", value)
        return value

    def flag(self, name: str) -> bool:
        """True or false; false where it is not given."""
        value = self._value.get(name, False)
        if not isinstance(value, bool):
            raise self._wrong(name, "true or false", value)
        return value

    def rows(self, name: str) -> list[Any]:
        """A list; empty where it is not given."""
        value = self._value.get(name, [])
        if not isinstance(value, list):
            raise self._wrong(name, "a list", value)
        return value

    def indices(self, name: str) -> list[int]:
        """A list of whole numbers, at least 0."""
        found = self.rows(name)
        for value in found:
            if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < _LARGEST:
                raise self._wrong(name, "a list of whole numbers, at least 0", found)
        return found

    def item(self, name: str) -> "Item":
        """An object; empty where it is not given."""
        return Item(self._value.get(name, {}), f"{self.place}: {name}")

    def items(self, name: str) -> "list[Item]":
        """A list of objects."""
        return [Item(value, f"{self.place}: {name} {k}") for k, value in enumerate(self.rows(name))]

    def extension(self, name: str) -> "Item":
        return self.item("extensions").item(name)

    def _get(self, name: str, default: Any) -> Any:
        if name not in self._value and default is None:
            raise FileError(f"{self.place} lacks {name}")
        return self._value.get(name, default)

    def _wrong(self, name: str, wanted: str, value: Any) -> FileError:
        return FileError(f"{self.place}: {name} must be {wanted}, got {reprlib.repr(value)}")


def _is_finite(value: Any) -> bool:
    """Whether a value is a number that double precision can hold."""
    try:
        return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
    except OverflowError:
        return False
