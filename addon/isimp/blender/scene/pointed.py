"""Stores the regions clicked last. In Object Mode buttons act on them, since selected faces are not visible there.

A click chooses one region, a shift-click adds one. Each is stored as a face, since edits renumber the regions.
"""

import numpy as np

from ... import sketch
from ...language import own
from . import mesh_io, runtime, store

NONE = own("No region is chosen: shift-click one with the Region tool (T), or select faces in Edit Mode (Tab, then 3)")


def note(scan, face: int) -> None:
    """Stores a clicked face of the scan; -1: the click missed the scan."""
    runtime.get().pointed = (scan.name, (face,)) if face >= 0 else None


def choose(scan, faces: tuple) -> None:
    """Chooses the regions of faces in place of others."""
    runtime.get().pointed = (scan.name, faces) if faces else None


def collect(scan, face: int) -> None:
    """Adds the region of a face to the chosen regions, or removes it."""
    regions = mesh_io.read_regions(scan)
    kept = [other for other in faces(scan) if regions[other] != regions[face]]
    added = [face] if len(kept) == len(faces(scan)) else []
    runtime.get().pointed = (scan.name, (*kept, *added)) if kept or added else None


def faces(scan) -> tuple:
    """Return a face of each chosen region, the last chosen one at the end."""
    name, found = runtime.get().pointed or ("", ())
    return tuple(face for face in found if face < len(scan.data.polygons)) if name == scan.name else ()


def face(scan) -> int:
    """Return the face of a scan that was clicked last; -1 if there is none."""
    return next(reversed(faces(scan)), -1)


def region(scan) -> int:
    """Return the region of the face clicked last; -1 if there is none. Cost: O(1)."""
    found = face(scan)
    return mesh_io.region_of(scan, found) if found >= 0 else -1


def outline(scan) -> np.ndarray:
    """Return (2 B, 3) float32 the border edges of the chosen regions; empty if they are not cached."""
    current, found = runtime.get(), faces(scan)
    key = (scan.name, mesh_io.state_of(scan), found)
    if current.marked[0] != key:
        known, recipe = current.scans.get(scan.name), store.load(scan)
        outcome = None
        if found and known is not None and not recipe.layers():
            outcome = current.session.known(known.scan, recipe.without_mesh())
        if outcome is None or not current.session.is_prepared(known.scan, outcome.repair):
            return np.empty((0, 3), np.float32)
        numbers = outcome.face_region[list(found)]
        current.marked = key, sketch.borders_of(known.scan, outcome.border, outcome.face_region, numbers)
    return current.marked[1]
