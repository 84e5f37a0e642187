"""The results of a run: writes the polygons and the labels to their final places."""

import shutil
from pathlib import Path
from typing import Any

import numpy as np

from ..batch.table import sync_folder
from ..drafts import save_array, whole
from ..reading import inner
from .plan import Plan
from .store import load, of_tile, values_of


def write_labels(plan: Plan, folder: Path) -> int:
    """Write the labels of each file's faces; returns the number of files."""
    if plan.is_single:
        faces = values_of(of_tile(plan.work, "split", 0))["faces"]
        label = np.full(faces, -1, np.int32)
        for part in sorted((plan.work / "thin").iterdir()):
            label[load(part, "face")] = load(part, "region")
        _save_label(folder, plan.inputs[0][0], label, plan)
        return 1
    for tile, (name, _) in enumerate(plan.inputs):
        label = np.full(values_of(of_tile(plan.work, "prepare", tile))["file_faces"], -1, np.int32)
        thin = of_tile(plan.work, "thin", tile)
        if thin.exists():
            label[load(thin, "face")] = load(thin, "region")
        _save_label(folder, name, label, plan)
    return len(plan.inputs)


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
