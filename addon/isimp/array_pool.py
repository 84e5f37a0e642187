"""Reuses large arrays, since new memory can cost far more time than filling it. numpy only."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import DTypeLike

_BLOCK = 1 << 15


def blocks(count: int) -> Iterator[slice]:
    """Return slices of `count` values that fit into the processor's cache."""
    return (slice(begin, min(begin + _BLOCK, count)) for begin in range(0, count, _BLOCK))


def taken(values: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Return values[at] without numpy's copy of `at` as 64-bit integers."""
    found = np.empty(len(at), values.dtype)
    for block in blocks(len(at)):
        np.take(values, at[block], out=found[block], mode="wrap")
    return found


class ArrayPool:
    """A pool with one unused array of each type. Thread-safe."""

    def __init__(self) -> None:
        self._arrays: dict[np.dtype[Any], np.ndarray] = {}

    def take(self, shape: tuple[int, ...], dtype: DTypeLike) -> np.ndarray:
        """Return an array with arbitrary values."""
        array = self._arrays.pop(np.dtype(dtype), None)
        return array if array is not None and array.shape == shape else np.empty(shape, dtype)

    def give(self, array: np.ndarray) -> None:
        """Returns an array to the pool. The caller must not use it afterwards."""
        self._arrays[array.dtype] = array
