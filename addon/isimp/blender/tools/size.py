"""Operators that grow and shrink the region under the mouse, by a drag with a preview or by the wheel."""

import bpy
from bpy.props import BoolProperty

from ... import messages
from ...gestures import Sizing, rings_in
from ...language import own, said
from ...session import StepFailed
from ...task import Status
from ..operators.edits import ISIMP_OT_grow
from ..scene import runtime, targets
from ..view import overlay
from ..work import panel_changes, preview
from . import under
from .point import ModalTool, do, miss

_TICK = 0.02
_NOTCH = 8.0  # pixels by which the wheel moves a border


class ISIMP_OT_size(ModalTool, bpy.types.Operator):
    """Drag right: grow the region. Drag left: shrink it. Click: grow by one ring of faces. Ctrl-click: shrink by one"""

    bl_idname = "isimp.size"
    bl_label = "Grow or Shrink Region"

    def start(self, context, event):
        panel_changes.interrupt(context)
        if not self.begin(context, event):
            return {"CANCELLED"}
        hit = self._ground.hit(self.ray(event))
        if hit is None:
            return miss()
        self._gesture = Sizing(self._ground.ring(self._region, self._view, self.place(event), hit))
        self._gesture.press(hit, self.place(event), ctrl=event.ctrl)
        self._scan, _ = targets.find(context)
        self._recipe = panel_changes.recipe_of(context, self._scan)
        self._work = self._tried = None  # the running computation, and its wish
        self._said = ""
        runtime.get().live.held = True
        self._timer = context.window_manager.event_timer_add(_TICK, window=context.window)
        return self.go(context, own("Right: grow · Left: shrink · Release: apply · Esc: cancel"))

    def heard(self, context, event):
        if event.type == "MOUSEMOVE":
            self._gesture.move(self.place(event))
            self.tell(self.place(event))
        elif event.type == "TIMER":
            self.follow(context)
        elif event.type == "LEFTMOUSE" and event.value == "RELEASE":
            self._gesture.move(self.place(event))
            wish = self._gesture.wish
            self.end(context)
            if wish is not None:
                do("isimp.grow", face=wish.faces[0], rings=wish.rings, shrink=wish.verb == "shrink")
            return {"FINISHED"}
        return {"RUNNING_MODAL"}

    def tell(self, at) -> None:
        """Shows the effect of a release next to the mouse."""
        wish = self._gesture.wish
        what = said("No change")
        if wish is not None:
            text = own("Shrink by {rings}") if wish.verb == "shrink" else own("Grow by {rings}")
            what = said(text, rings=messages.count(wish.rings, "ring"))
        runtime.get().hover = under.Hover(self._ground.name, -1, at=at, text=self._said or what)
        overlay.redraw()

    def follow(self, context) -> None:
        """Shows a finished result, and starts the computation of the present wish."""
        live, work, wish = runtime.get().live, self._work, self._gesture.wish
        if work is not None:
            if work.task.status is Status.RUNNING:
                work.read_on(context, _TICK)
                return
            self._work, error = None, work.task.error
            self._said = messages.failed(error, False) if isinstance(error, StepFailed) else ""
            live.tried = preview.Preview(work) if error is None else live.tried
            overlay.redraw()
        if wish == self._tried:
            return
        self._tried = wish
        if wish is None:
            live.tried, self._said = None, ""
            overlay.redraw()
            return
        runtime.get().stop_sketching()
        step = ISIMP_OT_grow.step(wish.faces[0], wish.rings, wish.verb == "shrink")
        self._work = preview.Work(context, self._scan, self._recipe.then(step), live.tried, again=True)
        self._work.start()

    def end(self, context) -> None:
        live = runtime.get().live
        if self._work is not None:
            self._work.abandon()
        context.window_manager.event_timer_remove(self._timer)
        live.tried, live.held = None, False
        super().end(context)


class ISIMP_OT_size_here(ModalTool, bpy.types.Operator):
    """Grow or shrink the region under the mouse a little"""

    bl_idname = "isimp.size_here"
    bl_label = "Grow or Shrink Region a Little"

    shrink: BoolProperty(name="Shrink", description="Shrink the region", options={"SKIP_SAVE"})

    def start(self, context, event):
        hit = self._ground.hit(self.ray(event)) if self.begin(context, event) else None
        if hit is None:
            return {"CANCELLED"}
        ring = self._ground.ring(self._region, self._view, self.place(event), hit)
        do("isimp.grow", face=hit.face, rings=rings_in(_NOTCH, ring), shrink=self.shrink)
        return {"FINISHED"}


CLASSES = (ISIMP_OT_size, ISIMP_OT_size_here)
