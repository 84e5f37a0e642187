"""Operator that shows the furniture of a room in red; the wheel changes the size, a click leaves it out."""

import bpy
import numpy as np

from ... import messages, pick
from ...language import said
from ..operators.clean_up import furniture_of
from ..scene import runtime, store, targets
from ..view import overlay
from . import under
from .point import ModalTool, do

_RED = (1.0, 0.15, 0.1, 0.55)
_FACTOR = 1.25  # a notch of the wheel
_LEAST, _MOST, _FIRST = 0.05, 50.0, 1.0  # percent of the area


class ISIMP_OT_show_furniture(ModalTool, bpy.types.Operator):
    """Show the furniture of a room in red: all but walls, floor and ceiling. Then a click leaves it out"""

    bl_idname = "isimp.show_furniture"
    bl_label = "Leave Out Furniture..."

    @classmethod
    def poll(cls, context):
        return targets.allows(cls, context, targets.needs_regions)

    def start(self, context, event):
        self._scan, _ = targets.find(context)
        if context.view_layer.objects.active != self._scan:
            bpy.ops.isimp.swap("INVOKE_DEFAULT", True)
        self._region = next((region for region in context.area.regions if region.type == "WINDOW"), None)
        if self._region is None:
            return {"CANCELLED"}
        self._size, self._recipe = _FIRST, store.load(self._scan).without_mesh()
        self.show(context)
        keys = said("Wheel: smallest wall · Click or Enter: leave the red out · Esc: cancel")
        context.workspace.status_text_set(keys)  # `overlay.tell` is for tools of the toolbar
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def heard(self, context, event):
        if event.type in {"WHEELUPMOUSE", "WHEELDOWNMOUSE"} and event.value == "PRESS":
            factor = _FACTOR if event.type == "WHEELUPMOUSE" else 1 / _FACTOR
            self._size = min(_MOST, max(_LEAST, self._size * factor))
            self.show(context)
            return {"RUNNING_MODAL"}
        if event.type in {"LEFTMOUSE", "RET", "NUMPAD_ENTER"} and event.value == "PRESS":
            self.end(context)
            do("isimp.leave_out_furniture", smallest=self._size)
            return {"FINISHED"}
        return {"PASS_THROUGH" if event.type.startswith(("MIDDLE", "NUMPAD_", "TIMER")) else "RUNNING_MODAL"}

    def end(self, context, redraws: bool = True) -> None:
        context.workspace.status_text_set(None)
        super().end(context, redraws)

    def show(self, context) -> None:
        arrays, label, found = furniture_of(context, self._scan, self._recipe, 0.01 * self._size)
        red = np.append(found, False)[label[arrays.triangle_face]]
        triangles = arrays.triangles[red]
        share = pick.area(arrays.vertices, triangles) / max(pick.area(arrays.vertices, arrays.triangles), 1e-300)
        text = said(
            "{regions}, {share} of the area · smallest wall {size} %",
            regions=messages.count(int(found.sum()), "region"),
            share=f"{share:.0%}",
            size=f"{self._size:.2g}",
        )
        at = (self._region.width // 2, self._region.height // 4)
        hover = under.Hover(self._scan.name, -1, at=at, text=text)
        hover.fills.append((arrays.vertices[triangles.ravel()].astype(np.float32), _RED))
        runtime.get().hover = hover
        overlay.redraw()


CLASSES = (ISIMP_OT_show_furniture,)
