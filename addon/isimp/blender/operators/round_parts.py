"""Operators for round parts: cylinders, cones, spheres and surfaces of revolution as rings of equal segments."""

import bpy
from bpy.props import EnumProperty, IntProperty

from ... import recipe as rcp
from .edits import _Edit


class ISIMP_OT_make_round(_Edit, bpy.types.Operator):
    """Make the regions of the selected faces one round part with the same number of equal cells"""

    bl_idname = "isimp.make_round"
    bl_label = "Make Round"

    may_be_all = True

    kind: EnumProperty(
        name="Kind",
        description="Kind of surface",
        items=(
            ("fit", "Automatic", "The simplest that fits"),
            ("cylinder", "Cylinder", "A cylinder"),
            ("cone", "Cone", "A cone"),
            ("sphere", "Sphere", "A sphere"),
            ("revolution", "Revolution", "A surface of revolution"),
            ("extrusion", "Extrusion", "A profile moved along a line"),
        ),
        default="fit",
    )

    def wanted(self, context, target):
        kind = "" if self.kind == "fit" else self.kind
        step = rcp.RoundRegions(faces=tuple(self.each(target.scan)), kind=kind)
        return target.recipe.then(step)


class ISIMP_OT_round_segments(_Edit, bpy.types.Operator):
    """Cut the round part of the selected face into this number of segments"""

    bl_idname = "isimp.round_segments"
    bl_label = "Segments"

    segments: IntProperty(
        name="Segments", description="Number of segments around the axis", default=12, min=1, max=256, soft_max=64
    )
    rings: IntProperty(
        name="Rings",
        description="Number of rings along the axis. 0: about the same number of cells as before",
        default=0,
        min=0,
        max=64,
        soft_max=16,
    )

    def wanted(self, context, target):
        step = rcp.RoundSegments(face=self.faces(target.scan)[0], segments=self.segments, rings=self.rings)
        return target.recipe.then(step)


class ISIMP_OT_explode_round(_Edit, bpy.types.Operator):
    """Make the cells of the round part of the selected face ordinary regions"""

    bl_idname = "isimp.explode_round"
    bl_label = "Explode"

    def wanted(self, context, target):
        return target.recipe.then(rcp.ExplodeRound(face=self.faces(target.scan)[0]))


CLASSES = (ISIMP_OT_make_round, ISIMP_OT_round_segments, ISIMP_OT_explode_round)
