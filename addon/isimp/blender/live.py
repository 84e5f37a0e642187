"""Settings that show what they give while they are dragged, as those of a modifier do.

The settings live on the window manager, which undo leaves alone. When one is changed, a timer has the recipe with the
new value replayed on a thread and shows the outcome on the scan; once the settings have rested for a moment, one
operator makes a step to undo of it. Until then `before` knows what to give back, as an undo in between must find what
the last step left. After undo and redo the settings follow the recipe.
"""

import logging
import time

import bpy

from ..session import StepFailed
from ..task import Status
from . import mesh_io, modal, pending, reading, runtime, show, store, targets

log = logging.getLogger("isimp")
_SETTLED = 0.3  # seconds without a change
_TICK = 0.02
_EDIT_FACES = 20_000  # in Edit Mode layers are written one by one: with more, nothing is shown before it settles


def _find(context):
    """The scan whose settings are shown, if they can be changed live; else None."""
    live = runtime.get().live
    if not (context.window_manager.isimp.live and live.pending) or runtime.get().running is not None:
        return None
    scan, problem = targets.find(context)
    return None if problem or scan.name != live.scan or targets.needs_regions(scan) else scan


def _tick():
    """Called by a timer while settings change."""
    if runtime.get() is None:
        return None
    live, context = runtime.get().live, bpy.context
    scan = _find(context)
    if scan is None:
        pending.interrupt()
        return None
    if live.work is not None:
        if live.work.task.status is Status.RUNNING:
            return _TICK
        work, live.work = live.work, None
        if not _take_up(context, work):
            return None
    try:
        shown, changed = store.load(scan), pending.recipe_of(context, scan)
    except ValueError as error:  # settings that do not go together
        log.info("%s", error)
        live.pending = False
        return None
    rested = time.monotonic() - live.touched > _SETTLED
    if changed == shown:
        if rested:
            live.pending = False
            if live.before is not None:
                bpy.ops.isimp.settle("EXEC_DEFAULT", True)
        return None if rested else _TICK
    if rested or not _is_slow(scan, changed):
        runtime.get().stop_sketching()
        live.work = modal.Work(context, scan, visible(context, scan, changed))
        live.work.start()
    return _TICK


def visible(context, scan, recipe):
    """The recipe without its polygons where the scan is looked at, not they."""
    return recipe.without_mesh() if context.view_layer.objects.active == scan else recipe


def _is_slow(scan, recipe) -> bool:
    """Whether the outcome is too slow to show for each value on the way."""
    return recipe.ends_in_mesh() or (scan.mode == "EDIT" and len(scan.data.polygons) > _EDIT_FACES)


def _take_up(context, work) -> bool:
    """Shows what was computed; False if there is nothing to show."""
    live, scan, error = runtime.get().live, work.target(), work.task.error
    if scan is None or (error is not None and not isinstance(error, StepFailed)):
        live.pending = False
        return False
    if work.recipe.ends_in_mesh():
        bpy.ops.isimp.settle("EXEC_DEFAULT", True)
        return True
    if live.before is None:
        live.before = mesh_io.Kept(scan)
    if error is not None:
        show.show_failed(context, scan, work, error)
    else:
        show.show_regions(context, scan, work, work.task.result)
    return True


class ISIMP_OT_settle(modal.RecipeOperator, bpy.types.Operator):
    """Make one step to undo of settings that were changed"""

    bl_idname = "isimp.settle"
    bl_label = pending.LABEL
    bl_options = {"UNDO", "INTERNAL"}

    keeps_failed = True

    def wanted(self, context, scan):
        return visible(context, scan, pending.recipe_of(context, scan))

    show = staticmethod(show.show_outcome)

    def told(self, before, numbers):
        return f"{before.get('regions', '?')} -> {numbers['regions']} regions"

    def execute(self, context):
        live = runtime.get().live
        if live.before is None:
            return super().execute(context)
        live.before = None
        return {"FINISHED"}


@bpy.app.handlers.persistent
def _before_undo(*_):
    """Gives back what the last step left, as undo compares with that."""
    live = runtime.get().live
    if live.work is not None:
        live.work.abandon()
        live.work = None
    if live.before is not None:
        live.before.give_back()
        live.before = None
    live.pending = False


@bpy.app.handlers.persistent
def _after_undo(*_):
    reading.forget()
    pending.follow(bpy.context)


@bpy.app.handlers.persistent
def _before_load(*_):
    live = runtime.get().live
    if live.work is not None:
        live.work.abandon()
    live.work = live.before = None
    live.pending = False


@bpy.app.handlers.persistent
def _after_update(scene, depsgraph):
    """Geometry may have changed, or another object have become active."""
    reading.forget_changed(depsgraph)
    active = bpy.context.view_layer.objects.active if bpy.context.view_layer else None
    scan = targets.scan_of(active) or active
    live = runtime.get().live
    if live.work is None and not live.pending and (scan.name if scan else "") != live.scan:
        pending.follow(bpy.context)


_HANDLERS = (
    ("undo_pre", _before_undo),
    ("redo_pre", _before_undo),
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
    if not bpy.app.background:  # where timers never fire
        runtime.get().live.wake = _wake
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)


def unregister() -> None:
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).remove(handler)
    if bpy.app.timers.is_registered(_tick):
        bpy.app.timers.unregister(_tick)
