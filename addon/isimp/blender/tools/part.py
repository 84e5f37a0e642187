"""Operator that finds the part of the scan under the mouse, and gives it more regions."""

import math

import bpy

from ...engine import engine
from ...language import own, said
from ..scene import runtime
from ..view import overlay
from . import under
from .point import ModalTool, do, miss

_LIT = (0.3, 1.0, 0.5, 0.5)
_DOUBLE, _NOTCH = 150.0, 1.15  # pixels of a drag that double the size; its factor for a notch of the wheel


class ISIMP_OT_find_part(ModalTool, bpy.types.Operator):
    """Press: show the part under the mouse, up to its neck. Drag or wheel: grow or shrink it. Release: more regions"""

    bl_idname = "isimp.find_part"
    bl_label = "Find Part"

    def start(self, context, event):
        if not self.begin(context, event):
            return {"CANCELLED"}
        self._hit = self._ground.hit(self.ray(event))
        if self._hit is None:
            return miss()
        self._mesh = self._ground.mesh()  # as Partition: openings are closed and no vertex is NaN
        self._found = engine.parts.Distances(*self._mesh, self._hit.place)
        self._from, self._wheel, self._shown = self.place(event), 1.0, None
        self.show(event)
        return self.go(
            context, own("Right, wheel up: larger · Left, wheel down: smaller · Release: apply · Esc: cancel")
        )

    def heard(self, context, event):
        if event.type in {"WHEELUPMOUSE", "WHEELDOWNMOUSE"} and event.value == "PRESS":
            self._wheel *= _NOTCH if event.type == "WHEELUPMOUSE" else 1 / _NOTCH
        if event.type == "LEFTMOUSE" and event.value == "RELEASE":
            self.end(context)
            do("isimp.more_here", place=self._hit.place, size=self.size(event))
            return {"FINISHED"}
        self.show(event)
        return {"RUNNING_MODAL"}

    def size(self, event) -> float:
        size = self._wheel * 2 ** ((self.place(event)[0] - self._from[0]) / _DOUBLE)
        return min(20.0, max(0.05, math.floor(20 * size + 0.5) / 20))

    def show(self, event) -> None:
        size = self.size(event)
        if size == self._shown:
            return
        self._shown = size
        inside = self._found.inside(size).nonzero()[0]
        hover = under.Hover(self._ground.name, -1, at=self.place(event))
        hover.fills.append((under.corners(*self._mesh, inside), _LIT))
        up_to = said("up to the neck") if size == 1 and self._found.has_neck else said("size {size}", size=f"{size:g}")
        share = f"{len(inside) / max(1, len(self._mesh[1])):.0%}"
        hover.text = said("More regions in {share} of the faces, {up_to}", share=share, up_to=up_to)
        runtime.get().hover = hover
        overlay.redraw()


CLASSES = (ISIMP_OT_find_part,)
