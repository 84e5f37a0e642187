"""The results of a run: writes the polygons and the labels to their final places."""

import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..batch.table import sync_folder
from ..drafts import save_array, whole
from ..file_faces import largest_shares
from ..reading import inner
from .plan import Plan
from .store import load, of_tile, values_of


def write_labels(plan: Plan, folder: Path) -> int:
    """Write the labels of each file's faces; returns the number of files."""
    region = load(of_tile(plan.work, "mesh", 0), "region")
    tiles: dict[int, _Tile] = {}
    at = 0
    for thin in sorted((plan.work / "thin").iterdir()):
        if count := values_of(thin)["thinned_faces"]:
            tiles[int(thin.name)] = _Tile(thin, region[at : at + count])
            at += count
    if plan.is_single:
        count = values_of(of_tile(plan.work, "split", 0))["faces"]
        _save_label(folder, plan.inputs[0][0], _labels(list(tiles.values()), count), plan)
        return 1
    for tile, (name, _) in enumerate(plan.inputs):
        count = values_of(of_tile(plan.work, "prepare", tile))["file_faces"]
        _save_label(folder, name, _labels([tiles[tile]] if tile in tiles else [], count), plan)
    return len(plan.inputs)


@dataclass(frozen=True)
class _Tile:
    """A tile with faces: its folder, and the region of each thinned face."""

    thin: Path
    region: NDArray[np.int32]

    def faces(self) -> tuple[NDArray[np.bool_], NDArray[np.int32], NDArray[np.int32]]:
        """Whether each triangle has a region; where it has one, the face of the file and the region."""
        region = self.region[load(self.thin, "to")]
        kept = region >= 0
        return kept, load(self.thin, "polygon")[kept], region[kept]


def _labels(tiles: list[_Tile], count: int) -> NDArray[np.int32]:
    """Return for each of `count` faces of a file the region with most of its area; -1: no region has any.

    A face may have triangles in several tiles, so these are loaded one at a time, as often as needed.
    """
    label, divided = np.full(count, -1, np.int32), np.zeros(count, bool)
    for tile in tiles:
        _, face, region = tile.faces()
        label[face] = region
    for tile in tiles:
        _, face, region = tile.faces()
        divided[face[label[face] != region]] = True
    if divided.any():
        shares = []
        for tile in tiles:
            kept, face, region = tile.faces()
            shared = divided[face]
            shares.append((face[shared], region[shared], load(tile.thin, "area")[kept][shared]))
        place, largest = largest_shares(*map(np.concatenate, zip(*shares, strict=True)))
        label[place] = largest
    return label


def _save_label(folder: Path, name: str, label: Any, plan: Plan) -> None:
    """Write labels as NAME.npy, or as NAME.SUFFIX.npy if two tiles differ only in their suffix."""
    stems = [str(inner(other).with_suffix("")) for other, _ in plan.inputs]
    own = str(inner(name).with_suffix(""))
    path = folder / f"{name if stems.count(own) > 1 else own}.npy"
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole(path) as draft:
        save_array(draft, label)


def deliver(plan: Plan) -> None:
    """Copy the result to its place. It replaces an older one."""
    made = of_tile(plan.work, "mesh", 0) / f"result{plan.output.suffix.lower()}"
    with whole(plan.output) as draft:
        shutil.copyfile(made, draft)
    sync_folder(plan.output.parent)
