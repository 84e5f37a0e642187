"""Operators that change steps of the recipe; all steps after a changed one run again."""

import dataclasses

import bpy
from bpy.props import BoolProperty, IntProperty

from ... import messages
from ...language import own, said
from ...recipe import Recipe
from ..controls import settings
from ..scene import mesh_io, store, targets
from ..view import display
from ..work import scene_outcome
from ..work.modal import RecipeOperator


class _AtStep(RecipeOperator):
    """Mixin of operators that change one step of the recipe."""

    keeps_failed = names_steps = True
    step: IntProperty(name="Step", description="Number of the step, from 0", default=0, min=0, options={"SKIP_SAVE"})

    @classmethod
    def problem(cls, context, scan):
        return targets.needs_steps(scan)

    def wanted(self, context, target):
        steps = list(target.recipe.steps)
        if self.step >= len(steps):
            raise ValueError(messages.no_step(self.step, len(steps)))
        return Recipe(tuple(self.changed(steps)))


class ISIMP_OT_step_switch(_AtStep, bpy.types.Operator):
    """Switch this step on or off"""

    bl_idname = "isimp.step_switch"
    bl_label = "Switch Step"

    def changed(self, steps):
        steps[self.step] = dataclasses.replace(steps[self.step], enabled=not steps[self.step].enabled)
        return steps


class ISIMP_OT_step_move(_AtStep, bpy.types.Operator):
    """Move this step up or down the list"""

    bl_idname = "isimp.step_move"
    bl_label = "Move Step"

    later: BoolProperty(name="Later", description="Move down", options={"SKIP_SAVE"})

    def changed(self, steps):
        to = self.step + (1 if self.later else -1)
        if not 0 <= to < len(steps):
            text = (
                own("Step {number} is the last already.") if self.later else own("Step {number} is the first already.")
            )
            raise ValueError(said(text, number=self.step + 1))
        steps.insert(to, steps.pop(self.step))
        return steps


class ISIMP_OT_step_delete(_AtStep, bpy.types.Operator):
    """Delete this step from the recipe. Without steps the scan is in its original state"""

    bl_idname = "isimp.step_delete"
    bl_label = "Delete Step"

    def changed(self, steps):
        del steps[self.step]
        return steps

    def execute(self, context):
        return self._cleared(context) or super().execute(context)

    def invoke(self, context, event):
        return self._cleared(context) or super().invoke(context, event)

    def _cleared(self, context):
        scan, problem = targets.find(context)
        if problem or targets.needs_steps(scan) or len(store.load(scan).steps) != 1 or self.step != 0:
            return None
        mesh_io.clear_regions(scan)
        scene_outcome.bring_to_front(context, scan, None)
        display.give_back(context)
        self.report({"INFO"}, said("No step is left: the scan is in its original state."))
        return {"FINISHED"}


class ISIMP_OT_step_open(bpy.types.Operator):
    """Show the settings of this step. A changed setting runs this step and all later ones again"""

    bl_idname = "isimp.step_open"
    bl_label = "Edit Step"

    step: IntProperty(name="Step", description="Number of the step, from 0", default=0, min=0, options={"SKIP_SAVE"})

    @classmethod
    def poll(cls, context):
        scan, problem = targets.find(context)
        return not (problem or targets.needs_steps(scan))

    def execute(self, context):
        panel = context.window_manager.isimp
        panel.open_step = -1 if panel.open_step == self.step else self.step
        settings.to_panel(context, store.load(targets.find(context)[0]))
        return {"FINISHED"}


CLASSES = (ISIMP_OT_step_switch, ISIMP_OT_step_move, ISIMP_OT_step_delete, ISIMP_OT_step_open)
