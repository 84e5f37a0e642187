"""Regions shown before they are written on the scan, as a setting is dragged: drawn over it by the graphics card.

Writing the layers of a million faces, and all that Blender does when a mesh has changed, takes longer than a hand
waits for; handing one colour a corner to the graphics card does not. It works in Edit Mode just as well, where layers
can only be written face by face.
"""

import gpu
import numpy as np

from .. import sketch, view
from . import modal, runtime, shaders


class Work(modal.Work):
    """A recipe replayed to be seen, and written only if it settles."""

    def run(self, watch=None):
        session = runtime.get().session
        outcome = session.replay(self.scan, self.recipe, watch)
        colors = view.packed_colors(outcome.face_region, outcome.region_color)
        self.color = np.repeat(colors[self.scan.triangle_face], 3).view(np.uint8).reshape(-1, 4)
        self.borders = sketch.borders(session.prepare(self.scan).scan, outcome.face_region)
        return outcome


class Preview:
    """What is seen of a `Work` that has ended. The corners of a scan are handed to the graphics card only once."""

    def __init__(self, work, before=None):
        self.work = work
        self.name = work.name
        self._scan = work.scan
        self._corners = before._corners if before is not None and before._scan is work.scan else None
        self._batch = None

    @property
    def borders(self):
        return self.work.borders

    def draw(self) -> None:
        if self._corners is None:
            points = self._scan.vertices[self._scan.triangles.ravel()].astype(np.float32, copy=False)
            self._corners = _buffer("pos", "F32", 3, "FLOAT", points)
        if self._batch is None:
            self._batch = gpu.types.GPUBatch(type="TRIS", buf=self._corners)
            self._batch.vertbuf_add(_buffer("color", "U8", 4, "INT_TO_FLOAT_UNIT", self.work.color))
        shader = shaders.lit()
        shader.bind()
        gpu.state.depth_mask_set(True)  # its own far side is not to be seen
        self._batch.draw(shader)
        gpu.state.depth_mask_set(False)


def _buffer(name, kind, count, fetch, values):
    layout = gpu.types.GPUVertFormat()
    layout.attr_add(id=name, comp_type=kind, len=count, fetch_mode=fetch)
    buffer = gpu.types.GPUVertBuf(layout, len(values))
    buffer.attr_fill(name, values)
    return buffer
