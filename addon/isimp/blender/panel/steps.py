"""Popover of the recipe: one row for each step, and the settings of the open step."""

import bpy

from ... import messages
from ...language import said
from ..controls import settings
from ..scene import store, targets
from .common import Popover, draw_lines, ready

_ROWS = 16  # the last steps, unless "All Steps" is on


class ISIMP_PT_steps(Popover, bpy.types.Panel):
    """The steps of the recipe, each with its settings"""

    bl_label = "Steps"

    @classmethod
    def poll(cls, context):
        return ready(context)

    def draw(self, context):
        layout, panel = self.prepare(context), context.window_manager.isimp
        scan, _ = targets.seen(context)
        recipe, numbers = store.load(scan), store.numbers(scan)
        if recipe is None:
            draw_lines(context, layout, targets.needs_steps(scan), icon="INFO")
            return
        failed = numbers.get("failed", len(recipe.steps))
        column = layout.column(align=True)
        hidden = 0 if panel.all_steps else max(0, len(recipe.steps) - _ROWS)
        if len(recipe.steps) > _ROWS:
            column.prop(panel, "all_steps", text=said("All {number} steps", number=len(recipe.steps)), toggle=True)
        for index, step in enumerate(recipe.steps):
            is_open = panel.open_step == index
            if index < hidden and not is_open and index != failed:
                continue
            _draw_row(column, index, step, is_open, index - failed, len(recipe.steps))
            if index == failed:
                draw_lines(context, column, numbers["reason"], icon="BLANK1", alert=True)
            if is_open:
                _draw_settings(context, column.box(), index, step, recipe)
        layout.menu("ISIMP_MT_recipe", icon="FILE_TEXT")


class ISIMP_MT_recipe(bpy.types.Menu):
    """Carry the steps to other scans"""

    bl_label = "Recipe"

    def draw(self, context):
        self.layout.operator("isimp.recipe_copy", text="Copy", icon="COPYDOWN")
        self.layout.operator("isimp.recipe_paste", text="Paste", icon="PASTEDOWN")
        self.layout.operator("isimp.recipe_export", text="Export Recipe", icon="EXPORT")
        self.layout.operator("isimp.recipe_import", text="Import Recipe", icon="IMPORT")


def _draw_row(column, index, step, is_open, past_failed, count) -> None:
    row = column.row(align=True)
    eye = "HIDE_OFF" if step.enabled else "HIDE_ON"
    row.operator("isimp.step_switch", text="", icon=eye, emboss=False).step = index
    name = row.row(align=True)
    name.alignment = "LEFT"
    name.alert = past_failed == 0
    name.active = step.enabled and past_failed <= 0
    icon = "ERROR" if past_failed == 0 else "DOWNARROW_HLT" if is_open else "RIGHTARROW"
    name.operator("isimp.step_open", text=f"{index + 1}  {messages.line(step)}", icon=icon, emboss=False).step = index
    if not is_open:
        return
    tools = row.row(align=True)
    tools.alignment = "RIGHT"
    for later, arrow in ((False, "TRIA_UP"), (True, "TRIA_DOWN")):
        place = tools.row(align=True)
        place.enabled = index < count - 1 if later else index > 0
        move = place.operator("isimp.step_move", text="", icon=arrow)
        move.step, move.later = index, later
    tools.operator("isimp.step_delete", text="", icon="X").step = index


def _draw_settings(context, box, index, step, recipe) -> None:
    names = settings.names(type(step))
    if not names:
        box.label(text="No settings")
    if settings.shown_step(recipe, type(step))[0] == index:
        group = settings.group(context, type(step))
        for name in names:
            settings.draw(box, type(step), group, name)


CLASSES = (ISIMP_PT_steps, ISIMP_MT_recipe)
