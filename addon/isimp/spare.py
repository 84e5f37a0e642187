"""Reuse of large arrays: new memory costs more, at times far more, than to fill it. numpy only."""

from __future__ import annotations

import numpy as np

_BLOCK = 1 << 15


def blocks(count: int):
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

    def __init__(self):
        self._arrays = {}

    def take(self, shape: tuple, dtype) -> np.ndarray:
        """An array with anything in it."""
        array = self._arrays.pop(np.dtype(dtype), None)
        return array if array is not None and array.shape == shape else np.empty(shape, dtype)

    def give(self, array: np.ndarray) -> None:
        """Nobody else may use the array from now on."""
        self._arrays[array.dtype] = array
