"""Files of a run: arrays in folders, which appear complete or not at all."""

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import InvalidInput
from ..batch.table import sync_folder
from ..drafts import save_array
from ..file_errors import reader
from ..folders import discard

VALUES = "values.json"
DAMAGED = "is damaged; the next run begins with an empty work folder"
MADE = "made"  #: in the folder of a child: the files of its step


def save(folder: Path, **arrays: NDArray[Any]) -> None:
    """Write arrays to a folder, each as NAME.npy."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, array in arrays.items():
        save_array(folder / f"{name}.npy", array, synced=True)


def load(folder: Path, name: str, mapped: bool = False) -> NDArray[Any]:
    """Load an array. mapped: map the file, to read parts of a large array. Raises FileError."""
    path = folder / f"{name}.npy"
    with _ours(path):
        if mapped:
            return np.lib.format.open_memmap(path, mode="r")
        with path.open("rb") as file:
            array: NDArray[Any] = np.lib.format.read_array(file, allow_pickle=False)
            return array
    raise AssertionError


@contextmanager
def _ours(path: Path) -> Iterator[None]:
    """Raise FileError if a file of the work folder is missing or can't be read."""
    with reader(path, DAMAGED):
        try:
            yield
        except FileNotFoundError:
            raise EOFError("it was removed") from None


def save_values(folder: Path, values: dict[str, Any]) -> None:
    """Write the values of a step. Raises InvalidInput for numbers that are not finite."""
    try:
        text = json.dumps(values, allow_nan=False)
    except ValueError:
        raise InvalidInput(
            "its numbers are not finite, since coordinates or a length that was given are huge"
        ) from None
    with (folder / VALUES).open("w", encoding="utf-8") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())


def values_of(folder: Path) -> dict[str, Any]:
    """Load the values of a step. Raises FileError."""
    path = folder / VALUES
    with _ours(path):
        values: dict[str, Any] = json.loads(path.read_bytes())
        return values
    raise AssertionError


def publish(made: Path, place: Path) -> None:
    """Rename a folder to its final name. Its step counts as done if this name exists."""
    place.parent.mkdir(parents=True, exist_ok=True)
    if place.exists():  # left by an interrupted run, which has not used it
        discard(place)
    made.replace(place)
    sync_folder(place.parent)


def tile_name(tile: int) -> str:
    return f"{tile:06d}"


def of_tile(work: Path, step: str, tile: int) -> Path:
    """Return the folder of a step of a tile. Steps of all tiles together use tile 0."""
    return work / step / tile_name(tile)
