"""The quick start: three lines of help in the 3D view until the first Partition, or a click in the view."""

import bpy

from ...language import said
from .. import preferences
from ..scene import runtime, targets
from ..texts import viewport_text
from . import overlay

LINES = (
    "Quick start with iSimp (a click hides this)",
    "1. Select the scan, and open the sidebar (N), tab iSimp",
    "2. Press Partition: the scan is split into regions, shown in colours",
    "3. Press Mesh: each region becomes a polygon of a new object",
)


def is_shown(context) -> bool:
    """Return whether to show the lines: the preference is on, and the scan has no regions."""
    if not preferences.get(context).quick_start or runtime.get().comparison is not None:
        return False
    scan, problem = targets.seen(context)
    return bool(problem) or not targets.has_regions(scan)


def _draw() -> None:
    context = bpy.context
    if runtime.get() is not None and is_shown(context):
        viewport_text.draw_low(context, [said(line) for line in LINES])


def end(context) -> None:
    """Switches the preference off. Blender saves it with its other preferences."""
    wish = preferences.get(context)
    if wish.quick_start:
        wish.quick_start = False
        overlay.redraw()


class ISIMP_OT_quick_start_end(bpy.types.Operator):
    """Hide the quick start"""

    bl_idname = "isimp.quick_start_end"
    bl_label = "Hide Quick Start"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context):
        return runtime.get() is not None and is_shown(context)

    def invoke(self, context, event):
        return self.execute(context) | {"PASS_THROUGH"}  # Blender handles the click too

    def execute(self, context):
        end(context)
        return {"FINISHED"}


CLASSES = (ISIMP_OT_quick_start_end,)


def register() -> None:
    keys = bpy.context.window_manager.keyconfigs.addon
    if bpy.app.background or keys is None:
        return
    runtime.get().start = bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_PIXEL")
    keymap = keys.keymaps.new("3D View", space_type="VIEW_3D")
    item = keymap.keymap_items.new("isimp.quick_start_end", "LEFTMOUSE", "PRESS", any=True, head=True)
    runtime.get().keys.append((keymap, item))


def unregister() -> None:
    if runtime.get().start is not None:
        bpy.types.SpaceView3D.draw_handler_remove(runtime.get().start, "WINDOW")
    for keymap, item in runtime.get().keys:
        keymap.keymap_items.remove(item)
    runtime.get().keys.clear()
