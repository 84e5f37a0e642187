"""Finds edits that act on other regions since the number of regions has changed. numpy only."""

from __future__ import annotations

import json
from zlib import crc32

import numpy as np

from . import recipe as rcp

_CHANGE = 2.0  # factor of a region's size from which an edit acts on another region


def compared(recipe: rcp.Recipe, face_region: np.ndarray, before: dict) -> dict:
    """Return the numbers "edits" and "moved" of a partition and its edits.

    "edits" has, for each edit, the Partition step that it was made after, and the share of faces of its region then.
    "moved" has a face of each edit whose region has another size now, by more than half. before: the numbers before.
    """
    known, edits, moved = before.get("edits", {}), {}, []
    index, step = recipe.whole()
    if step is None:
        return {"edits": {}, "moved": []}
    base, count = _key(step), np.bincount(face_region[face_region >= 0], minlength=1)
    for edit in (edit for number, edit in recipe.active() if number > index):
        face = _face_of(edit)
        region = int(face_region[face]) if 0 <= face < len(face_region) else -1
        if region < 0:
            continue
        share, key = float(count[region] / len(face_region)), _key(edit)
        was = known.get(key, [base, share])
        edits[key] = [base, share] if was[0] == base else was
        if was[0] != base and not 1 / _CHANGE <= share / was[1] <= _CHANGE:
            moved.append(face)
    return {"edits": edits, "moved": moved}


def _face_of(step: rcp.Step) -> int:
    """Return a face of the region that a step changes; -1 for steps without faces."""
    onto, faces = getattr(step, "onto", -1), getattr(step, "faces", ())
    found: int = onto if onto >= 0 else faces[0] if len(faces) else getattr(step, "face", -1)
    return found


def _key(step: rcp.Step) -> str:
    return f"{crc32(json.dumps(step.to_dict(), sort_keys=True).encode()):08x}"
