"""Re-runs the recipe while a setting is dragged, so that its effect is visible like that of a modifier.

The settings are on the window manager, which undo does not change. After a change, a timer starts a thread that replays
the recipe with the new value, and draws the outcome over the scan (preview.py). After a pause, one operator writes the
outcome on the scan as an undo step. An undo before that makes the undo step first, so it reverts only the changed
settings. After undo and redo the settings follow the recipe.
"""

import logging
import time

import bpy

from ...session import StepFailed
from ...task import Status
from .. import reading
from ..drawing import late
from ..scene import result, runtime, store, targets
from ..view import overlay
from . import modal, panel_changes, preview
from .target import Target

log = logging.getLogger("isimp")
_SETTLED = 0.3  # seconds without a change
_TICK = 0.02


def _find(context):
    """Return the scan whose settings are shown, if they can be changed live; else None."""
    live = runtime.get().live
    if not (context.window_manager.isimp.live and live.pending) or runtime.get().running is not None:
        return None
    scan, problem = targets.find(context)
    if problem or scan.name != live.scan or targets.needs_regions(scan) or result.why_kept_here(context, scan):
        return None
    return scan


def _tick():
    """Shows and writes changed settings step by step. A timer calls it while settings change."""
    if runtime.get() is None:
        return None
    live, context = runtime.get().live, bpy.context
    if live.held:
        return _TICK
    scan = _find(context)
    if scan is None:
        panel_changes.interrupt(context)
        return None
    if live.work is not None and live.work.task.status is Status.RUNNING:
        live.work.read_on(context, _TICK)
        return _TICK
    if live.work is not None:
        work, live.work = live.work, None
        if not _take_up(context, work) or runtime.get().running is not None:  # an operator bakes a texture
            return None
    try:
        kept, changed = store.load(scan), panel_changes.recipe_of(context, scan)
    except ValueError as error:  # settings that contradict each other
        log.info("%s", error)
        live.pending = False
        return None
    return _show(context, scan, kept, changed)


def _show(context, scan, kept, changed):
    """Starts the preview of changed settings, or writes it after a pause. kept: the stored recipe."""
    live = runtime.get().live
    if changed == kept and live.shown is not None:  # the setting has its former value again
        live.shown = None
        overlay.redraw()
    wanted = visible(context, scan, changed)
    rested = time.monotonic() - live.touched > _SETTLED
    if changed == kept or (live.shown is not None and live.shown.work.recipe == wanted):
        return _rest(live) if rested else _TICK
    if rested or not wanted.ends_in_mesh():
        runtime.get().stop_sketching()
        live.work = preview.Work(context, scan, wanted, live.shown, again=live.shown is not None)
        live.work.start()
    return _TICK


def _rest(live):
    """Writes the preview, if there is one and its data are ready, and ends."""
    if live.shown is not None and not live.shown.work.is_ready():
        return _TICK
    live.pending = False
    if live.shown is not None:
        settle()
    return None


def visible(context, scan, recipe):
    """Return the recipe, without Mesh if the scan is the active object and not its result."""
    return recipe.without_mesh() if context.view_layer.objects.active == scan else recipe


def _take_up(context, work) -> bool:
    """Shows the result. Returns False if there is none."""
    live, scan, error = runtime.get().live, work.target(), work.task.error
    modal.note_internal(error)
    if scan is None or (error is not None and not isinstance(error, StepFailed)):
        live.pending = False
        return False
    if work.recipe.ends_in_mesh():
        settle()
    else:
        live.shown = preview.Preview(work)
        overlay.redraw()
    return True


def settle() -> None:
    """Makes an undo step of the changes."""
    window = bpy.context.window_manager.windows[0]  # the context of a timer has no window
    with bpy.context.temp_override(window=window):
        bpy.ops.isimp.settle("INVOKE_DEFAULT", True)


class ISIMP_OT_settle(modal.RecipeOperator, bpy.types.Operator):
    """Make one undo step of changed settings"""

    bl_idname = "isimp.settle"
    bl_label = panel_changes.LABEL
    bl_options = {"UNDO", "INTERNAL"}

    keeps_failed = names_steps = True

    @classmethod
    def problem(cls, context, scan):
        return ""

    def wanted(self, context, target):
        return visible(context, target.scan, target.recipe)

    def invoke(self, context, event):
        if runtime.get().live.shown is None:
            target = Target(context)
            recipe = None if target.problem else self.wanted(context, target)
            has_texture = recipe is not None and recipe.texture() is not None
            return super().invoke(context, event) if has_texture else self.execute(context)
        self._work = runtime.get().live.shown.work
        runtime.get().live.held = True
        return self.go_on(context)

    def cancel(self, context):
        super().cancel(context)
        runtime.get().live.held = False

    def execute(self, context):
        if runtime.get().live.shown is None:
            return super().execute(context)
        return self._settle(context)

    def _settle(self, context):
        """Writes the preview on the scan. In Edit Mode it is written already; textured results have no preview."""
        runtime.get().live.held = False
        if runtime.get().live.shown is None:
            return super()._settle(context)
        return {"FINISHED"} if panel_changes.write_shown(context) else {"CANCELLED"}

    def _refuse(self, context, work, error):
        """Restores the settings of the recipe, because the timer would repeat the refused ones."""
        if not isinstance(error, StepFailed):
            panel_changes.follow(context)
        return super()._refuse(context, work, error)


@bpy.app.handlers.persistent
def _before_undo(*_):
    """Makes an undo step of the changes, so that the undo reverts them and nothing before them."""
    if _find(bpy.context) is not None:
        panel_changes.push(bpy.context)
    runtime.get().live.pending = False


@bpy.app.handlers.persistent
def _drop_changes(*_):
    """Drops changes without an undo step. Called before a file is loaded or a step is redone."""
    live = runtime.get().live
    if live.work is not None:
        live.work.abandon()
    live.work = live.shown = live.tried = None
    live.pending = False


@bpy.app.handlers.persistent
def _before_load(*_):
    _drop_changes()
    late.forget()
    store.forget_file()


@bpy.app.handlers.persistent
def _after_undo(*_):
    late.settle()  # reports delayed colours, as undo may not have changed the mesh
    late.forget()
    store.forget()
    reading.forget()
    panel_changes.follow(bpy.context)


@bpy.app.handlers.persistent
def _after_update(scene, depsgraph):
    """Drops cached arrays of changed objects, and shows the settings of the active scan."""
    reading.forget_changed(depsgraph)
    active = bpy.context.view_layer.objects.active if bpy.context.view_layer else None
    scan = targets.scan_of(active) or active
    live = runtime.get().live
    if live.work is None and not live.pending and (scan.name if scan else "") != live.scan:
        panel_changes.follow(bpy.context)


_HANDLERS = (
    ("undo_pre", _before_undo),
    ("redo_pre", _drop_changes),
    ("undo_post", _after_undo),
    ("redo_post", _after_undo),
    ("load_pre", _before_load),
    ("load_post", _after_undo),
    ("depsgraph_update_post", _after_update),
)
CLASSES = (ISIMP_OT_settle,)


def _wake() -> None:
    if not bpy.app.timers.is_registered(_tick):
        bpy.app.timers.register(_tick, first_interval=0.0)


def register() -> None:
    if not bpy.app.background:  # timers do not run in the background
        runtime.get().live.wake = _wake
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)


def unregister() -> None:
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).remove(handler)
    if bpy.app.timers.is_registered(_tick):
        bpy.app.timers.unregister(_tick)
