"""Operator that keeps single openings open which Partition closes."""

import bpy
from bpy.props import BoolProperty, FloatVectorProperty

from ... import messages
from ...language import said
from ..scene import mesh_io
from ..work.modal import RecipeOperator


class ISIMP_OT_keep_opening(RecipeOperator, bpy.types.Operator):
    """Keep an opening open that Partition closes, and run Partition and all later edits again"""

    bl_idname = "isimp.keep_opening"
    bl_label = "Keep Opening"

    place: FloatVectorProperty(
        name="Place", description="A place in the opening, in the scan's coordinates", size=3, options={"SKIP_SAVE"}
    )
    close: BoolProperty(name="Close", description="Close the kept opening again", options={"SKIP_SAVE"})

    @classmethod
    def description(cls, context, properties):
        again = said("Close an opening again that was kept open")
        return again if properties.close else said(cls.__doc__)

    def wanted(self, context, target):
        recipe = target.recipe.without_mesh()
        index, step = recipe.whole()
        if step is None or not step.close_openings:
            raise mesh_io.Unusable(said("No opening was closed: switch Close Openings on and press Partition."))
        return recipe.replaced(index, step.keeping(self.place, keep=not self.close))

    def told(self, before, numbers):
        return messages.kept_open(numbers)


CLASSES = (ISIMP_OT_keep_opening,)
