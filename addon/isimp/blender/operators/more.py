"""Operator that gives a part of the scan, such as a head, more regions."""

import dataclasses

import bpy
from bpy.props import FloatProperty, FloatVectorProperty

from ...language import said
from ..scene import mesh_io
from ..work.modal import RecipeOperator


class ISIMP_OT_more_here(RecipeOperator, bpy.types.Operator):
    """Make regions of a part smaller, such as a head up to its neck; Partition and all later edits run again"""

    bl_idname = "isimp.more_here"
    bl_label = "More Here"
    adjusted = ("size",)

    place: FloatVectorProperty(
        name="Place", description="A place in the part, in the scan's coordinates", size=3, options={"SKIP_SAVE"}
    )
    size: FloatProperty(
        name="Size",
        description="Size of the part: 1 is up to its neck. 0: no part near the place has smaller regions any more",
        default=1.0,
        min=0.0,
        max=20.0,
        soft_max=4.0,
        options={"SKIP_SAVE"},
    )

    def wanted(self, context, target):
        recipe = target.recipe.without_mesh()
        index, step = recipe.whole()
        if step is None:
            raise mesh_io.Unusable(said("There is no Partition step of the whole scan: press Partition first."))
        place = tuple(float(x) for x in self.place)
        more = (*step.more, (*place, round(self.size, 4))) if self.size > 0 else step.without_nearest(place)
        return recipe.replaced(index, dataclasses.replace(step, more=more))


CLASSES = (ISIMP_OT_more_here,)
