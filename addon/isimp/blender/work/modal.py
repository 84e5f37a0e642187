"""Base of all operators that replay a recipe: long work on a thread, so that the window responds.

`execute` blocks until the end, for scripts and `blender -b`. `invoke` starts a thread and a timer, which shows the
progress and applies the result. Esc cancels without a change.
"""

import logging
import math
import threading
import time
from contextlib import suppress

import bpy

from ... import messages, view
from ... import recipe as rcp
from ...language import own, said
from ...session import StepFailed
from ...task import Status, Stopped, Task, Watch
from .. import preferences, reading
from ..drawing import late
from ..scene import mesh_io, runtime, store, targets
from ..texts import text
from ..texturing import texture
from ..view import overlay
from . import panel_changes, scene_outcome
from .target import Target

log = logging.getLogger("isimp")
_AT_ONCE = 0.08  # seconds that the window waits for short work, which needs no progress bar
_TICK = 0.05
_BEFORE = 0.6  # share of the progress for the steps before a texture
DISCARDED = own("'{name}' was changed or removed meanwhile: the result was discarded.")
#: Raised where a scan can't be used or a step fails; `why` has the report
PROBLEMS = (mesh_io.Unusable, StepFailed, ValueError)
#: Prefixes of events that are allowed while a mesh in Edit Mode is written, since other events could change the mesh
NAVIGATION = ("MOUSE", "MIDDLE", "WHEEL", "TRACKPAD", "NDOF", "NUMPAD_", "TIMER", "WINDOW")


class Work:
    """A running recipe on an object: the main thread reads the scan, a thread replays, the operator writes."""

    end = None  #: see Aside

    def __init__(self, context, obj, recipe, again=False):
        """again: the scan has not changed since it was read last."""
        preferences.obey(context, runtime.get().session)
        self.name, self.recipe = obj.name, recipe
        self.states = {mesh_io.state_of(obj)}  #: states of the scan that this work starts from or has written
        self._layers, self._is_read, self._problem = recipe.layers(), threading.Event(), None
        if reading.ready(context, obj, self._layers, 0.0):
            self.scan = reading.read(context, obj, self._layers, again)
            self._is_read.set()
        else:
            self.scan = reading.read(context, obj, again=again)
        self.corners = mesh_io.corner_totals(obj.data)
        self.face_color = self.corner_color = None
        self._shown_color = late.shown(obj)
        self.patch = None  #: faces whose colours differ from Blender's, if they are few; see late.py
        self.task = None
        self.baking = None  #: the texture.Baking of a recipe that ends in Texture
        self.untextured = ""  #: why there is no texture
        self.shown = None  #: written share of the outcome; None before writing begins; see scene_outcome.writing

    def progress(self) -> tuple:
        """Return (share, text) of the progress."""
        if self.shown is not None:
            return self.shown, said("Showing {share}", share=f"{self.shown:.0%}")
        return self.task.watch.progress, self.task.describe()

    def read_on(self, context, seconds: float = math.inf) -> None:
        """Continues reading the weights for `seconds`. Called by the main thread while the work waits for it."""
        obj = self.target()
        if self._is_read.is_set() or (obj is not None and not reading.ready(context, obj, self._layers, seconds)):
            return
        try:
            if obj is not None:  # else the result will be discarded
                self.scan = reading.read(context, obj, self._layers, again=True)
        except mesh_io.Unusable as problem:
            self._problem = ValueError(str(problem))
        self._is_read.set()

    def read_texture(self, obj) -> None:
        """Reads the images of the scan's materials, if the recipe ends in a texture."""
        step = self.recipe.texture()
        if step is None:
            return
        try:
            self.baking = texture.Baking(obj, step)
        except mesh_io.Unusable as problem:
            self.untextured = str(problem)

    def run(self, watch=None):
        """Return the outcome, and compute its texture and the colours of corners; on any thread."""
        watch = watch or Watch()
        with watch.share(0.0, 1.0 if self.baking is None else _BEFORE):
            outcome = self.replay(watch)
        self.paint(outcome)
        if self.baking is not None:
            with watch.share(_BEFORE, 1.0):
                self._bake(outcome, watch)
        return outcome

    def _bake(self, outcome, watch) -> None:
        """Bakes the texture. An error is stored, since the polygons are useful without a texture."""
        try:
            self.baking.make(self.scan, outcome, watch)
        except ValueError as problem:
            self.baking, self.untextured = None, str(problem)

    def replay(self, watch):
        """Return the outcome. Waits until all data are read."""
        while not self._is_read.wait(_TICK):
            watch.poll()
        if self._problem is not None:
            raise self._problem
        return runtime.get().session.replay(self.scan, self.recipe, watch)

    def paint(self, outcome) -> None:
        """Computes the colours of the corners for the mesh; on any thread."""
        self.face_color = outcome.face_color
        self.patch = late.patch_of(self.scan, self._shown_color, self.face_color)
        self.corner_color = view.corner_colors(view.COLORS, self.face_color, self.corners, runtime.get().pool)

    def start(self) -> None:
        self.task = Task(self.run)

    def abandon(self) -> None:
        """Stops the thread and waits for its end."""
        if self.task is not None:
            self.task.watch.cancel()
            self.task.wait()

    def target(self):
        """Return the object if it exists and has not changed since the work began; else None."""
        obj = bpy.data.objects.get(self.name)
        if obj is None or obj.type != "MESH" or obj.mode not in {"OBJECT", "EDIT"}:
            return None
        same = mesh_io.counts(obj)[1] == self.scan.face_count and mesh_io.state_of(obj) in self.states
        return obj if same else None


class Aside(Work):
    """Work that leaves the regions alone, such as cutting a result into convex parts."""

    def __init__(self, scan, compute, end):
        """compute(watch) returns an outcome, on any thread. end(context, outcome) shows it; returns Blender's state."""
        self.name, self.recipe, self.end, self._compute = scan.name, store.load(scan) or rcp.Recipe(), end, compute
        self.task = self.shown = None

    def read_on(self, context, seconds: float = math.inf) -> None:
        """Does nothing: all data were read before."""

    def run(self, watch=None):
        return self._compute(watch or Watch())

    def target(self):
        return bpy.data.objects.get(self.name)


class RecipeOperator:
    """Mixin of operators that change the recipe of a scan and show its outcome.

    A subclass defines the new recipe (`wanted`), and how it differs from an edit of regions.
    """

    bl_options = {"REGISTER", "UNDO"}

    #: Whether the recipe is kept if one of its steps fails: the step is marked, and the previous result stays visible
    keeps_failed = False

    #: Whether messages name the failed step, because the user works with the list of steps
    names_steps = False

    #: Whether the operator runs on all selected scans, one after the other
    does_all = False

    _waiting = ()  #: names of the remaining selected scans
    _skipped = ()  #: names of the selected scans without regions
    _done = ()  #: names of the shown objects of finished scans
    _writing = None  #: the write in progress in Edit Mode: see scene_outcome.writing
    _before = None  #: the numbers of the former regions
    _is_modal = False

    #: The most important settings, in the panel of the last operation (F9)
    adjusted: tuple = ()

    @classmethod
    def poll(cls, context):
        return targets.allows(cls, context, lambda scan: cls.problem(context, scan))

    def draw(self, context):
        self.layout.use_property_split = True
        for name in self.adjusted:
            self.layout.prop(self, name)

    @classmethod
    def problem(cls, context, scan) -> str:
        """Return why this operator cannot run; empty if it can."""
        return targets.needs_regions(scan)

    #: Shows an outcome on the scan, and returns the kept results
    show = staticmethod(scene_outcome.show_outcome)

    def told(self, before: dict, numbers: dict) -> str:
        """Return the report. before, numbers: of the former and of the present regions."""
        return messages.changed(before, numbers)

    def warnings(self, context, scan, before: dict) -> list:
        """Return warnings about the scan. before: the numbers of the former regions."""
        return []

    def execute(self, context):
        target, state = self._gather(context, Target(context)), set()
        while target is not None:
            state |= self._execute_one(context, target)
            target = self._next_target(context)
        return self._conclude(context, state)

    def _execute_one(self, context, target):
        work = self._begin(context, target)
        if work is None:
            return {"CANCELLED"}
        work.read_on(context)
        try:
            outcome = work.run()
        except Exception as error:  # noqa: BLE001  (no step may show its user a traceback)
            return self._refuse(context, work, error)
        return self._finish(context, work, outcome)

    def invoke(self, context, event):
        if bpy.app.background:
            return self.execute(context)
        target, self._state = self._gather(context, Target(context)), set()
        self.press(target)
        return self._invoke_one(context, target)

    def press(self, target) -> None:
        """Takes what is chosen when a button is pressed."""

    def _invoke_one(self, context, target):
        self._work, self._writing, self._before = self._begin(context, target), None, None
        if self._work is None:
            return self._next(context, {"CANCELLED"})
        self._work.start()
        return self.go_on(context)

    def _next(self, context, state):
        """Continues with the next scan, or ends."""
        self._state = getattr(self, "_state", set()) | state
        task = self._work.task if self._work is not None else None
        stopped = task is not None and isinstance(task.error, Stopped)
        if not stopped and (target := self._next_target(context)) is not None:
            return self._invoke_one(context, target)
        return self._conclude(context, self._state)

    def _gather(self, context, first):
        """Collects the selected scans to run on after the first target, which is returned."""
        others = targets.selected(context) if self.does_all and context.mode == "OBJECT" else []
        others = [obj for obj in others if obj != first.scan and first.scan is not None]
        self._waiting = [obj.name for obj in others if not self.problem(context, obj)]
        self._skipped = [obj.name for obj in others if obj.name not in self._waiting]
        self._done = []
        return first

    def _next_target(self, context):
        """Makes the next waiting scan the active object, and returns it; None if none is left."""
        while self._waiting:
            scan = bpy.data.objects.get(self._waiting.pop(0))
            if scan is not None and scan.name in context.view_layer.objects:
                scene_outcome.bring_to_front(context, scan, None)
                return Target(context)
        return None

    def _conclude(self, context, state):
        """Selects all shown objects if there are several, and ends."""
        shown = [bpy.data.objects[name] for name in self._done if name in context.view_layer.objects]
        if len(shown) > 1:
            for obj in shown:
                obj.select_set(True)
            self.report({"INFO"}, messages.several(len(shown)))
        if self._skipped and shown:
            self.report({"WARNING"}, messages.skipped(self._skipped))
        return {"FINISHED"} if "FINISHED" in state else {"CANCELLED"}

    def go_on(self, context):
        """Applies the result of short work, or starts a timer that waits for it."""
        end = time.monotonic() + _AT_ONCE
        self._work.read_on(context, 0.5 * _AT_ONCE)
        status = self._work.task.wait(max(0.0, end - time.monotonic()))
        if status is not Status.RUNNING and self._written(end - time.monotonic()):
            return self._next(context, self._settle(context))
        runtime.get().running = self._work
        self._timer = context.window_manager.event_timer_add(_TICK, window=context.window)
        if not self._is_modal:
            context.window_manager.modal_handler_add(self)
            self._is_modal = True
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        task = self._work.task
        if event.type == "ESC" and event.value == "PRESS" and self._writing is None:
            task.watch.cancel()
            return {"RUNNING_MODAL"}
        if event.type != "TIMER":
            free = self._writing is None or event.type.startswith(NAVIGATION)
            return {"PASS_THROUGH" if free else "RUNNING_MODAL"}
        if task.status is Status.RUNNING:
            self._work.read_on(context, reading.SPAN)
            _show_progress(
                context,
                said("{name}: {progress} - Esc stops it", name=self._work.name, progress=self._work.progress()[1]),
            )
            return {"PASS_THROUGH"}
        if not self._written(reading.SPAN):
            _show_progress(context, f"{self._work.name}: {self._work.progress()[1]}")
            return {"PASS_THROUGH"}
        self._end_modal(context)
        return self._next(context, self._settle(context))

    def _written(self, seconds: float) -> bool:
        """Continues writing face by face for `seconds`. Returns whether it is complete."""
        work, end = self._work, time.monotonic() + seconds
        scan = work.target()
        if scan is None or work.task.error is not None or work.end is not None:
            return True
        if self._writing is None:
            self._before = store.numbers(scan)
            self._writing = scene_outcome.writing(scan, work, work.task.result)
        with suppress(ReferenceError):  # a script has left Edit Mode
            for work.shown in self._writing:
                if time.monotonic() > end:
                    return False
        return True

    def cancel(self, context):
        """Stops the work. Blender calls this if the window or the file is closed."""
        self._work.abandon()
        with suppress(ReferenceError):
            for _ in self._writing or ():  # a half-written mesh would belong to no state
                pass
        self._end_modal(context)

    def _end_modal(self, context) -> None:
        context.window_manager.event_timer_remove(self._timer)
        if runtime.get() is not None:
            runtime.get().running = None
        _show_progress(context, None)

    def _begin(self, context, target):
        if target.problem:
            self.report({"ERROR"}, target.problem)
            return None
        panel_changes.interrupt(context)
        try:
            work = self._read(context, target.scan, self.wanted(context, target))
        except (mesh_io.Unusable, ValueError) as problem:
            self.report({"ERROR"}, str(problem))
            return None
        return work

    def _read(self, context, scan, recipe) -> Work:
        """Return the work of a recipe on a scan, which is read."""
        work = Work(context, scan, recipe)
        work.read_texture(scan)
        return work

    def _settle(self, context):
        """Applies the result or the error of the ended thread."""
        task = self._work.task
        if task.error is not None:
            return self._refuse(context, self._work, task.error)
        return self._finish(context, self._work, task.result)

    def _refuse(self, context, work, error: Exception):
        panel_changes.go_on()
        overlay.redraw()  # a tool may have left its highlight
        if isinstance(error, StepFailed) and self.keeps_failed:
            return self._keep(context, work, error)
        if isinstance(error, Stopped):
            self.report({"INFO"}, messages.unchanged(said("Stopped")))
        elif isinstance(error, (StepFailed, ValueError)):
            why = (
                self._reason(work, error)
                if isinstance(error, StepFailed)
                else messages.reason(str(error), text.in_scene)
            )
            self.report({"ERROR"}, messages.unchanged(why))
        else:
            note_internal(error)
            internal = said("Internal error in iSimp: {error}", error=f"{type(error).__name__}: {error}")
            self.report({"ERROR"}, messages.unchanged(internal))
        return {"CANCELLED"}

    def _keep(self, context, work, error: StepFailed):
        obj = self._target(work)
        if obj is None:
            return {"CANCELLED"}
        scene_outcome.show_failed(context, obj, work, error)
        panel_changes.follow(context)
        self.report(
            {"WARNING"},
            said("{why}. The previous result stays.", why=messages.failed(error, self.names_steps, text.in_scene)),
        )
        return {"FINISHED"}

    def _reason(self, work, error: StepFailed) -> str:
        """Return the reason. It names the step unless the user has just added it."""
        scan = work.target()
        before = store.load(scan) if scan is not None else None
        known = before.steps if before is not None else ()
        old = error.index < len(known) and work.recipe.steps[: error.index + 1] == known[: error.index + 1]
        return messages.failed(error, self.names_steps or old, text.in_scene)

    def _finish(self, context, work, outcome):
        obj = self._target(work)
        if obj is None:
            return {"CANCELLED"}
        if work.end is not None:
            return work.end(context, outcome)
        before = store.numbers(obj) if self._before is None else self._before
        kept = self.show(context, obj, work, outcome) or []
        panel_changes.follow(context)
        shown = context.view_layer.objects.active
        self._done = [*self._done, shown.name]
        self.report({"INFO"}, self.told(before, outcome.numbers))
        for warning in (*_warnings(shown, before, work, outcome, kept), *self.warnings(context, obj, before)):
            self.report({"WARNING"}, warning)
        return {"FINISHED"}

    def _target(self, work):
        obj = work.target()
        if obj is None:
            self.report({"WARNING"}, said(DISCARDED, name=work.name))
        return obj


def note_internal(error: Exception | None) -> None:
    """Writes the traceback of an internal error to the console, where users find it for a report."""
    if error is not None and not isinstance(error, (StepFailed, Stopped, ValueError)):
        log.error("unexpected", exc_info=error)


def why(problem: Exception) -> str:
    """Return the report of one of PROBLEMS in a sentence."""
    if isinstance(problem, StepFailed):
        return f"{messages.failed(problem, True, text.in_scene)}."
    return str(problem)


def _warnings(shown, before: dict, work, outcome, kept: list):
    """Yields warnings about a finished work. shown: the active object. kept: (name, reason) of kept results."""
    if not shown.visible_get():
        yield messages.hidden(shown.name)
    if _was_edited(before, work, outcome):
        yield said(messages.SCAN_EDITED)
    if work.untextured:
        yield said("The result has no texture: {why}", why=work.untextured)
    for name, why in kept:
        yield messages.kept(name, why, bpy.data.objects[name].hide_get(), shown.name)


def _was_edited(before: dict, work, outcome) -> bool:
    """Return whether the scan changed after its regions were found, so that steps before the last one ran again."""
    changed = before.get("scan", "") not in {"", outcome.numbers["scan"]}
    return changed and len(work.recipe.steps) > 1


def _show_progress(context, text) -> None:
    if context.workspace is not None:
        context.workspace.status_text_set(text)
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                for region in area.regions:
                    if region.type == "UI" or text is None:  # the progress bar needs no redraw of the scan
                        region.tag_redraw()
