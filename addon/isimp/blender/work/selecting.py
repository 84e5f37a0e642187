"""Base of operators that select many faces, in pieces in Edit Mode, which has no bulk access."""

import time
from contextlib import suppress

import bpy

from .. import reading
from ..scene import selection
from . import modal

_TICK = 0.01


class SelectOperator:
    """Mixin. A subclass defines the faces to select (`wanted`) and the end (`conclude`)."""

    bl_options = {"REGISTER", "UNDO"}

    def wanted(self, context):
        """Return (object, (faces,) bool) to select; None after a report if there is nothing to select."""
        raise NotImplementedError

    def conclude(self, context, obj) -> None:
        """Ends the operator after all faces are selected."""

    def execute(self, context):
        if not self._begin(context):
            return {"CANCELLED"}
        for _ in self._steps:
            pass
        return self._end(context)

    def invoke(self, context, event):
        if bpy.app.background:
            return self.execute(context)
        if not self._begin(context):
            return {"CANCELLED"}
        if self._is_done():
            return self._end(context)
        self._timer = context.window_manager.event_timer_add(_TICK, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type != "TIMER":  # the mesh must not change between two pieces
            return {"PASS_THROUGH" if event.type.startswith(modal.NAVIGATION) else "RUNNING_MODAL"}
        if not self._is_done():
            return {"RUNNING_MODAL"}
        context.window_manager.event_timer_remove(self._timer)
        return self._end(context)

    def cancel(self, context):
        """Removes the timer. Blender calls this if the window or the file is closed."""
        context.window_manager.event_timer_remove(self._timer)

    def _begin(self, context) -> bool:
        try:
            wanted = self.wanted(context)
        except modal.PROBLEMS as problem:
            self.report({"ERROR"}, modal.why(problem))
            return False
        if wanted is None:
            return False
        obj, faces = wanted
        self._name, self._steps = obj.name, selection.selecting(obj, faces, reading.known_corners(obj))
        return True

    def _is_done(self) -> bool:
        """Selects faces for at most `reading.SPAN` seconds. Returns whether all are selected."""
        end = time.monotonic() + reading.SPAN
        with suppress(ReferenceError):  # a script has left Edit Mode
            for _ in self._steps:
                if time.monotonic() > end:
                    return False
        return True

    def _end(self, context):
        obj = bpy.data.objects.get(self._name)
        if obj is None:
            return {"CANCELLED"}
        self.conclude(context, obj)
        return {"FINISHED"}
