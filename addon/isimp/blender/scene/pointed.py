"""The regions that were clicked last: in Object Mode the buttons act on them, since a selection is not seen there.

A click chooses one, a shift-click one more. Each is kept as a face of it, since edits change the numbers of regions.
"""

import numpy as np

from ... import sketch
from ...language import own
from . import mesh_io, runtime, store

NONE = own("No region is chosen: alt-click one with the Region tool (T), or select faces in Edit Mode (Tab, then 3)")


def note(scan, face: int) -> None:
    """A face of the scan was clicked; -1: the click was beside it."""
    runtime.get().pointed = (scan.name, (face,)) if face >= 0 else None


def collect(scan, face: int) -> None:
    """Chooses the region of a face beside those chosen before, or no longer."""
    regions = mesh_io.read_regions(scan)
    kept = [other for other in faces(scan) if regions[other] != regions[face]]
    added = [face] if len(kept) == len(faces(scan)) else []
    runtime.get().pointed = (scan.name, (*kept, *added)) if kept or added else None


def faces(scan) -> tuple:
    """A face of each region that is chosen, the one chosen last at the end."""
    name, found = runtime.get().pointed or ("", ())
    return tuple(face for face in found if face < len(scan.data.polygons)) if name == scan.name else ()


def face(scan) -> int:
    """The face of a scan that was clicked last; -1 if there is none."""
    return next(reversed(faces(scan)), -1)


def region(scan) -> int:
    """The region that it is in now; -1 if there is none. Cost: none to speak of."""
    found = face(scan)
    return mesh_io.region_of(scan, found) if found >= 0 else -1


def outline(scan) -> np.ndarray:
    """(2 B, 3) float32: the border edges of the chosen regions; empty if the search would be slow."""
    current, found = runtime.get(), faces(scan)
    key = (scan.name, mesh_io.state_of(scan), found)
    if current.marked[0] != key:
        known, recipe = current.scans.get(scan.name), store.load(scan)
        outcome = None
        if found and known is not None and not recipe.layers() and current.session.is_prepared(known.scan):
            outcome = current.session.known(known.scan, recipe.without_mesh())
        if outcome is None:
            return np.empty((0, 3), np.float32)
        arrays, numbers = current.session.prepare(known.scan).scan, outcome.face_region[list(found)]
        current.marked = key, sketch.borders_of(arrays, outcome.border, outcome.face_region, numbers)
    return current.marked[1]
