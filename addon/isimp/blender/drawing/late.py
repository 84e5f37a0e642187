"""Draws changed colours of few faces over the scan, so that Blender need not upload the mesh at once.

If a mesh is reported as changed, Blender copies all of it to the graphics card: a quarter of a second for a million
faces. A click changes few faces. The new layers are written at once, so undo, files and renders have them. The change
is reported to Blender together with the next polygons, or after a pause. Later versions of Blender detect each write,
so nothing is delayed there.
"""

import time

import bpy
import numpy as np

from ... import view
from ...array_pool import ArrayPool
from ..scene import mesh_io, runtime
from . import shaders

#: Whether Blender does not detect a written layer. True for 3.4, false for 4.5; other versions were not tried.
IS_QUIET = bpy.app.version < (3, 5, 0) and not bpy.app.background
_MOST = 0.25  # largest share of the faces in a patch; a larger patch is no faster than Blender
_REST = 0.6  # seconds


class Written:
    """The last written colours of a mesh, and the colours that Blender shows."""

    def __init__(self, obj, state: int, color: np.ndarray):
        """color: (faces,) rows of view.COLORS, written on the mesh and shown."""
        self.name, self.mesh, self.state = obj.name, obj.data.name, state
        self.color = self.shown = color
        self.patch, self.touched = None, 0.0


class Patch:
    """Triangles of the faces whose new colours are not reported to Blender yet."""

    def __init__(self, scan, before: np.ndarray, faces: np.ndarray, color: np.ndarray):
        inside = np.zeros(scan.face_count, bool)
        inside[faces] = True
        some = np.flatnonzero(inside[scan.triangle_face])
        points = scan.vertices[scan.triangles[some].ravel()].astype(np.float32, copy=False)
        colors = view.corner_colors(view.PACKED, color[scan.triangle_face[some]], 3, ArrayPool())
        self.before = before
        self.count, self._lit = len(some), shaders.Lit(shaders.Corners(points), colors)

    def draw(self) -> None:
        if self.count:
            self._lit.draw()


def shown(obj) -> np.ndarray | None:
    """Return (faces,) the colours that Blender shows of an object in Object Mode; None if unknown."""
    known = runtime.get().late
    if not IS_QUIET or known is None or obj.mode != "OBJECT":
        return None
    same = (known.name, known.mesh) == (obj.name, obj.data.name) and known.state == mesh_io.state_of(obj)
    return known.shown if same else None


def patch_of(scan, before: np.ndarray | None, after: np.ndarray) -> Patch | None:
    """Return the patch between shown and new colours; None if `before` is unknown or too many faces differ."""
    if before is None or len(before) != len(after):
        return None
    faces = np.flatnonzero(before != after)
    return Patch(scan, before, faces, after) if len(faces) <= _MOST * len(after) else None


def fits(obj, patch: Patch | None) -> bool:
    """Return whether a patch starts from the colours that Blender shows of an object."""
    return patch is not None and patch.before is shown(obj)


def note(obj, state: int, color: np.ndarray, patch: Patch | None) -> None:
    """Records colours written on an object in Object Mode. patch: the unreported faces; None after a report."""
    current = runtime.get()
    if patch is None:
        if current.late is not None and current.late.mesh != obj.data.name:
            settle()
        current.late = Written(obj, state, color)
        return
    known = current.late
    known.state, known.color, known.patch, known.touched = state, color, patch, time.monotonic()


def draw(scan) -> None:
    """Draws the patch of a scan, if there is one."""
    known = runtime.get().late
    is_late = known is not None and known.patch is not None and known.name == scan.name
    if is_late and known.state == mesh_io.state_of(scan):
        known.patch.draw()


def is_due() -> bool | None:
    """Return whether the delay of the last write has passed; None if there is no write to report."""
    known = runtime.get().late
    return None if known is None or known.patch is None else time.monotonic() - known.touched > _REST


def settle() -> None:
    """Reports the delayed colours to Blender."""
    known = runtime.get().late
    if known is None or known.patch is None:
        return
    mesh, is_new = bpy.data.meshes.get(known.mesh), known.patch.count > 0
    known.shown, known.patch = known.color, None
    if mesh is not None and is_new and not mesh.is_editmode:
        mesh_io.tell(mesh)


def forget(mesh_name: str | None = None) -> None:
    """Drops the known colours of a mesh, or of all meshes, after Blender detected a change."""
    known = runtime.get().late
    if known is not None and mesh_name in (None, known.mesh):
        runtime.get().late = None
