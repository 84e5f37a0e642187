"""Applies changed settings of the panel that have no undo step yet. Code that changes a recipe must include them."""

import bpy

from ..controls import settings
from ..scene import runtime, store, targets
from . import scene_outcome

LABEL = "Change Settings"  #: name of the undo step


def recipe_of(context, scan):
    """Return the recipe of a scan with the panel's changes that have not been applied."""
    recipe = store.load(scan)
    live = runtime.get().live
    is_live = live.pending and context.window_manager.isimp.live and live.scan == scan.name
    if not (is_live and recipe and recipe.steps):
        return recipe
    return settings.from_panel(context, recipe)


def interrupt(context) -> None:
    """Stops running previews. A finished preview without an undo step is written and gets one."""
    runtime.get().stop_sketching()
    live = runtime.get().live
    live.tried, live.held = None, False  # ends the preview of an interrupted tool
    if live.work is not None:
        live.work.abandon()
        live.work = None
    if live.shown is not None and write_shown(context):
        bpy.ops.ed.undo_push(message=LABEL)


def push(context) -> None:
    """Makes an undo step of the present settings, even if their result is not ready."""
    scan, _ = targets.find(context)
    is_shown = runtime.get().live.shown is not None
    changed = is_shown or recipe_of(context, scan) != store.load(scan)
    interrupt(context)
    if changed and not is_shown:
        bpy.ops.ed.undo_push(message=LABEL)


def write_shown(context) -> bool:
    """Writes the preview on its scan. Returns False if the scan was deleted or changed."""
    live = runtime.get().live
    work, live.shown = live.shown.work, None
    scan, error = work.target(), work.task.error
    if scan is None:
        return False
    if error is not None:
        scene_outcome.show_failed(context, scan, work, error)
    else:
        scene_outcome.show_regions(context, scan, work, work.task.result)
    return True


def follow(context) -> None:
    """Shows the settings of the active scan's recipe in the panel, or its chosen settings if it has no regions."""
    live, before = runtime.get().live, runtime.get().live.scan
    scan, problem = targets.find(context)
    live.scan, live.pending = (scan.name if scan is not None else before), False
    recipe = None if problem else store.load(scan)
    if recipe is not None and recipe.steps:
        settings.to_panel(context, recipe)
    elif scan is not None:
        if before and before != scan.name and before in bpy.data.objects:  # false if the scan was renamed
            live.settings[before] = settings.shown(context)
            settings.show(context, live.settings.get(scan.name))
        settings.forget_foreign(context, scan)


def go_on() -> None:
    """Continues the work that `interrupt` stopped."""
    live = runtime.get().live
    if live.pending and live.wake is not None:
        live.wake()
