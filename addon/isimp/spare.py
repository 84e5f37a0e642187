"""Reuse of large arrays: new memory costs more, at times far more, than to fill it. numpy only."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import DTypeLike

_BLOCK = 1 << 15


def blocks(count: int) -> Iterator[slice]:
    """Slices of `count` values, small enough for the processor's cache."""
    return (slice(begin, min(begin + _BLOCK, count)) for begin in range(0, count, _BLOCK))


def taken(values: np.ndarray, at: np.ndarray) -> np.ndarray:
    """values[at], of which numpy would first copy `at` in numbers of 64 bits."""
    found = np.empty(len(at), values.dtype)
    for block in blocks(len(at)):
        np.take(values, at[block], out=found[block], mode="wrap")
    return found


class Spare:
    """A pool of unused arrays, one of a type; usable from any thread."""

    def __init__(self) -> None:
        self._arrays: dict[np.dtype[Any], np.ndarray] = {}

    def take(self, shape: tuple[int, ...], dtype: DTypeLike) -> np.ndarray:
        """An array with anything in it."""
        array = self._arrays.pop(np.dtype(dtype), None)
        return array if array is not None and array.shape == shape else np.empty(shape, dtype)

    def give(self, array: np.ndarray) -> None:
        """Nobody else may use the array from now on."""
        self._arrays[array.dtype] = array
