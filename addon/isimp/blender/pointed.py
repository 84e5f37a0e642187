"""The region that was clicked last: in Object Mode the buttons act on it, as a selection of faces is not seen there."""

import numpy as np

from .. import sketch
from ..language import own
from . import mesh_io, runtime, store

NONE = own("No region is chosen: alt-click one with the Region tool (T), or select faces in Edit Mode (Tab, then 3)")


def note(scan, face: int) -> None:
    """A face of the scan was clicked; -1: the click was beside it."""
    runtime.get().pointed = (scan.name, face) if face >= 0 else None


def face(scan) -> int:
    """The face of a scan that was clicked last; -1 if there is none."""
    name, found = runtime.get().pointed or ("", -1)
    return found if name == scan.name and found < len(scan.data.polygons) else -1


def region(scan) -> int:
    """The region that it is in now; -1 if there is none. Cost: none to speak of."""
    found = face(scan)
    return mesh_io.region_of(scan, found) if found >= 0 else -1


def outline(scan) -> np.ndarray:
    """(2 B, 3) float32: the border edges of that region; empty if the search would be slow."""
    current, found = runtime.get(), face(scan)
    key = (scan.name, mesh_io.state_of(scan), found)
    if current.marked[0] != key:
        known, recipe = current.scans.get(scan.name), store.load(scan)
        outcome = None
        if found >= 0 and known is not None and not recipe.layers() and current.session.is_prepared(known.scan):
            outcome = current.session.known(known.scan, recipe.without_mesh())
        if outcome is None:
            return np.empty((0, 3), np.float32)
        arrays, number = current.session.prepare(known.scan).scan, outcome.face_region[found]
        current.marked = key, sketch.borders_of(arrays, outcome.border, outcome.face_region, number)
    return current.marked[1]
