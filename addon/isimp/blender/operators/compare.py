"""Operator that moves the line between the scan and its result with the mouse."""

import bpy

from ... import messages
from ...language import said
from ..scene import mesh_io, runtime, targets
from ..view import comparison, overlay

_NAVIGATION = ("MIDDLE", "WHEEL", "TRACKPAD", "NDOF", "NUMPAD_", "TIMER", "WINDOW", "MOUSEROTATE", "MOUSEZOOM")


class ISIMP_OT_compare(bpy.types.Operator):
    """Drag a line over the view: the scan is at its left, the result at its right. Esc ends it"""

    bl_idname = "isimp.compare"
    bl_label = "Compare with Scan"

    _drags = False

    @classmethod
    def poll(cls, context):
        if runtime.get().comparison is not None:
            cls.poll_message_set(said("Scan and result are being compared: press Esc to end it"))
            return False
        if bpy.app.background or context.area is None or context.area.type != "VIEW_3D":
            cls.poll_message_set(said("This needs a 3D view"))
            return False
        return targets.allows_with_result(cls, context)

    def invoke(self, context, event):
        scan, result, _ = targets.find_result(context)
        self._regions = list(context.area.regions)
        self._region = next(region for region in self._regions if region.type == "WINDOW")
        try:
            self._made = comparison.start(context, scan, result)
        except mesh_io.Unusable as problem:
            self.report({"ERROR"}, str(problem))
            return {"CANCELLED"}
        context.window_manager.modal_handler_add(self)
        self._tell(context)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if runtime.get() is None or runtime.get().comparison is not self._made or not self._made.stands():
            return self._end(context)
        inside = self._is_inside(event)
        if event.type in {"ESC", "RIGHTMOUSE", "RET", "NUMPAD_ENTER"} and event.value == "PRESS":
            return self._end(context)
        if event.type == "LEFTMOUSE" and event.value in {"PRESS", "DOUBLE_CLICK"} and not inside:
            self._end(context)
            return {"FINISHED", "PASS_THROUGH"}
        if event.type == "LEFTMOUSE":
            self._drags = event.value != "RELEASE"
        if event.type in {"LEFTMOUSE", "MOUSEMOVE"} and self._drags:
            wide = max(1, self._region.width)
            self._made.share = min(1.0, max(0.0, (event.mouse_x - self._region.x) / wide))
            overlay.redraw()
            return {"RUNNING_MODAL"}
        if event.type == "C" and event.value == "PRESS":
            looks = self._made.looks
            self._made.look = looks[(looks.index(self._made.look) + 1) % len(looks)]
            overlay.redraw()
        free = event.type == "MOUSEMOVE" or event.type.startswith(_NAVIGATION)
        return {"PASS_THROUGH"} if free else {"RUNNING_MODAL"}

    def cancel(self, context):
        """Ends the comparison. Blender calls this if the window or the file is closed."""
        self._end(context)

    def _is_inside(self, event) -> bool:
        """Return whether the mouse is over the viewport, and not over a sidebar or header that covers it."""
        over = [region for region in self._regions if region.width > 1 and _holds(region, event)]
        return [region.type for region in over] == ["WINDOW"]

    def _tell(self, context) -> None:
        if context.workspace is not None:
            context.workspace.status_text_set(said(messages.COMPARE_KEYS))

    def _end(self, context):
        if runtime.get() is not None and runtime.get().comparison is self._made:
            comparison.stop()
        if context.workspace is not None:
            context.workspace.status_text_set(None)
        return {"FINISHED"}


def _holds(region, event) -> bool:
    return 0 <= event.mouse_x - region.x < region.width and 0 <= event.mouse_y - region.y < region.height


CLASSES = (ISIMP_OT_compare,)
