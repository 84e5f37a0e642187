"""Files of a run: arrays in folders that appear whole or not at all."""

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import InvalidInput
from ..batch.table import sync_folder
from ..drafts import save_array
from ..folders import discard
from ..reading import reader

VALUES = "values.json"
DAMAGED = "is damaged; the next run begins with an empty work folder"
MADE = "made"  #: in the folder of a child: what its step made


def save(folder: Path, **arrays: NDArray[Any]) -> None:
    """Write arrays to a folder, each as NAME.npy."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, array in arrays.items():
        save_array(folder / f"{name}.npy", array, synced=True)


def load(folder: Path, name: str, mapped: bool = False) -> NDArray[Any]:
    """An array; mapped: of a large file, to read parts of it. Raises FileError."""
    path = folder / f"{name}.npy"
    with reader(path, DAMAGED):
        array: NDArray[Any] = np.load(path, mmap_mode="r" if mapped else None)
        if not isinstance(array, np.ndarray):
            raise TypeError("it is an archive")
        return array
    raise AssertionError


def save_values(folder: Path, values: dict[str, Any]) -> None:
    """Raises InvalidInput for numbers that are not finite."""
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
    """Raises FileError."""
    path = folder / VALUES
    with reader(path, DAMAGED):
        values: dict[str, Any] = json.loads(path.read_bytes())
        return values
    raise AssertionError


def publish(made: Path, place: Path) -> None:
    """Give a folder its final name; from then on its step is done."""
    place.parent.mkdir(parents=True, exist_ok=True)
    if place.exists():  # of a run that was ended before it could use it
        discard(place)
    made.replace(place)
    sync_folder(place.parent)


def tile_name(tile: int) -> str:
    return f"{tile:06d}"


def of_tile(work: Path, step: str, tile: int) -> Path:
    """The folder of a step of a tile; steps of all tiles together are of tile 0."""
    return work / step / tile_name(tile)
