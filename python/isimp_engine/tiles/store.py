"""Files of a run: arrays in folders that appear whole or not at all."""

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..batch.table import sync_folder
from ..folders import discard

VALUES = "values.json"
MADE = "made"  #: in the folder of a child: what its step made


def save(folder: Path, **arrays: NDArray[Any]) -> None:
    """Write arrays to a folder, each as NAME.npy."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, array in arrays.items():
        with (folder / f"{name}.npy").open("wb") as file:
            np.save(file, array)
            file.flush()
            os.fsync(file.fileno())


def load(folder: Path, name: str) -> NDArray[Any]:
    array: NDArray[Any] = np.load(folder / f"{name}.npy")
    return array


def save_values(folder: Path, values: dict[str, Any]) -> None:
    with (folder / VALUES).open("w", encoding="utf-8") as file:
        json.dump(values, file, allow_nan=False)
        file.flush()
        os.fsync(file.fileno())


def values_of(folder: Path) -> dict[str, Any]:
    values: dict[str, Any] = json.loads((folder / VALUES).read_bytes())
    return values


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
