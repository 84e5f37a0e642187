"""The results of a run: writes the polygons and the labels to their final places."""

import shutil
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
    parts, at = [], 0
    for thin in sorted((plan.work / "thin").iterdir()):
        if count := values_of(thin)["thinned_faces"]:
            parts.append((int(thin.name), _labels(thin, region[at : at + count])))
            at += count
    if plan.is_single:
        whole = np.full(values_of(of_tile(plan.work, "split", 0))["faces"], -1, np.int32)
        for _, (face, label) in parts:
            whole[face] = label
        _save_label(folder, plan.inputs[0][0], whole, plan)
        return 1
    of = dict(parts)
    for tile, (name, _) in enumerate(plan.inputs):
        label = np.full(values_of(of_tile(plan.work, "prepare", tile))["file_faces"], -1, np.int32)
        if tile in of:
            label[of[tile][0]] = of[tile][1]
        _save_label(folder, name, label, plan)
    return len(plan.inputs)


def _labels(thin: Path, region: NDArray[np.int32]) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Return the faces of a tile's file that are left, rising, and for each the region with most of its area.

    region: the region of each thinned face of the tile.
    """
    of, polygon, area = region[load(thin, "to")], load(thin, "polygon"), load(thin, "area")
    kept = of >= 0
    faces, at = np.unique(polygon, return_inverse=True)
    result = np.full(len(faces), -1, np.int32)
    result[at[kept]] = of[kept]
    shared = np.bincount(at[kept][result[at[kept]] != of[kept]], minlength=len(faces)) > 0
    several = kept & shared[at]
    if several.any():
        place, largest = largest_shares(at[several].astype(np.int32), of[several], area[several])
        result[place] = largest
    return faces, result


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
