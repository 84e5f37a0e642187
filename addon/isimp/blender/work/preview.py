"""Previews regions while a setting is dragged: they are drawn over the scan and not written on it.

Writing the layers of a million faces, and Blender's update of a changed mesh, are too slow for that. Uploading one
colour for each corner is fast enough, in Edit Mode too, where layers can only be written face by face.
"""

import numpy as np
from gpu_extras.batch import batch_for_shader

from ... import sketch, view
from ...array_pool import taken
from ...task import Task
from ..drawing import shaders
from ..scene import runtime
from . import modal


class Work(modal.Work):
    """A replayed recipe for a preview, which is written only after a pause."""

    color = points = None  #: by corner; both None after a failed step, points None if the previous ones are valid
    _painting = None  #: the Task that computes the colours to write on the mesh

    def __init__(self, context, obj, recipe, before=None, again=False):
        """before: the previous Preview, if there is one. again: see modal.Work."""
        super().__init__(context, obj, recipe, again)
        self.before = before

    def run(self, watch=None):
        outcome = self.replay(watch)
        face_color = taken(outcome.face_color, self.scan.triangle_face)
        self.color = view.corner_colors(view.PACKED, face_color, 3, runtime.get().pool)
        self.borders = sketch.borders(self.scan.source, outcome.border)
        if self.before is None or self.before.lit is None or self.before.work.scan.digest != self.scan.digest:
            self.points = self.scan.vertices[self.scan.triangles.ravel()].astype(np.float32, copy=False)
        return outcome

    def is_ready(self) -> bool:
        """Return whether all data to write are ready; starts the computation of missing colours."""
        if self.task.error is not None or self.corner_color is not None:
            return True
        if self._painting is None:
            self._painting = Task(lambda watch: self.paint(self.task.result))
        return False


class Preview:
    """The drawing of a finished `Work`. The corners of a scan are uploaded to the graphics card only once."""

    def __init__(self, work):
        self.work = work
        self.name = work.name
        self.lit = self._lines = None
        if work.color is not None:
            corners = work.before.lit.corners if work.points is None else shaders.Corners(work.points)
            self.lit = shaders.Lit(corners, work.color)
        work.points = work.before = work.color = None

    def draw_borders(self, shader) -> None:
        if self._lines is None:
            self._lines = batch_for_shader(shader, "LINES", {"pos": self.work.borders})
        shaders.draw(self._lines, shader)

    def draw(self) -> None:
        color = self.lit.color
        self.lit.draw()
        if color is not None:
            runtime.get().pool.give(color)
