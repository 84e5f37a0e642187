"""Settings changed in the panel that are no step to undo yet, as all that works on a recipe must respect them."""

import bpy

from . import runtime, settings, store, targets

LABEL = "Change Settings"  #: of the step to undo


def recipe_of(context, scan):
    """The recipe of a scan, with what was changed in the panel and is not done yet."""
    recipe = store.load(scan)
    live = runtime.get().live
    is_live = live.pending and context.window_manager.isimp.live and live.scan == scan.name
    if not (is_live and recipe and recipe.steps):
        return recipe
    return settings.from_panel(context, recipe)


def interrupt() -> None:
    """Stops what is under way. What is shown and no step to undo yet becomes one."""
    runtime.get().stop_sketching()
    live = runtime.get().live
    if live.work is not None:
        live.work.abandon()
        live.work = None
    if live.before is not None:
        live.before = None
        bpy.ops.ed.undo_push(message=LABEL)


def follow(context) -> None:
    """Lets the settings follow the recipe of the active scan."""
    live = runtime.get().live
    scan, problem = targets.find(context)
    live.scan, live.pending = (scan.name if scan is not None else ""), False
    recipe = None if problem else store.load(scan)
    if recipe:
        settings.to_panel(context, recipe)


def go_on() -> None:
    """Takes up again what `interrupt` stopped."""
    live = runtime.get().live
    if live.pending and live.wake is not None:
        live.wake()
