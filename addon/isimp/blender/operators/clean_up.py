"""Operators that mirror all regions or merge slivers."""

import dataclasses

import bpy
import numpy as np
from bpy.props import EnumProperty, FloatProperty

from ... import recipe as rcp
from ... import slivers
from ...engine import engine
from ...language import said
from .. import reading
from ..controls.properties import PartitionSettings
from ..scene import mesh_io, runtime, targets
from ..work.modal import RecipeOperator

_AXES = PartitionSettings.__annotations__["symmetry"].keywords["items"]


class ISIMP_OT_symmetrise(RecipeOperator, bpy.types.Operator):
    """Mirror the regions across the scan's X axis, as far as the scan is symmetric. Edits run again"""

    bl_idname = "isimp.symmetrise"
    bl_label = "Symmetrise"
    adjusted = ("axis",)

    axis: EnumProperty(name="Axis", description="The axis across which regions mirror", items=_AXES, default="x")

    @classmethod
    def problem(cls, context, scan):
        return targets.needs_steps(scan)

    def wanted(self, context, target):
        recipe = target.recipe.without_mesh()
        index, step = recipe.whole()
        if step is None:
            raise mesh_io.Unusable(said("No step is a partition of the whole scan: press Partition first."))
        return recipe.replaced(index, dataclasses.replace(step, symmetry=self.axis))


class ISIMP_OT_merge_slivers(RecipeOperator, bpy.types.Operator):
    """Merge each small region with the neighbour whose plane is most like its own. Locked regions stay"""

    bl_idname = "isimp.merge_slivers"
    bl_label = "Merge Slivers"
    adjusted = ("share",)

    share: FloatProperty(
        name="Below",
        description="Regions below this share of the mean area are merged",
        default=10.0,
        min=0.0,
        max=100.0,
        precision=0,
        subtype="PERCENTAGE",
    )

    def wanted(self, context, target):
        before = target.recipe.without_mesh()
        recipe, count = without_slivers(context, target.scan, before, 0.01 * self.share)
        if not count:
            raise mesh_io.Unusable(said("No region is that small."))
        return recipe


def without_slivers(context, scan, recipe, share: float) -> tuple:
    """Return (the recipe with small regions merged, their number); see slivers.py."""
    arrays = reading.read(context, scan, recipe.layers())
    label = reading.regions(scan, arrays, recipe)
    area, normal = engine.regions.region_sides(
        arrays.vertices, arrays.triangles, label[arrays.triangle_face], int(label.max(initial=-1)) + 1
    )
    locked = runtime.get().session.locked_regions(arrays, recipe)
    found = slivers.merges(label, arrays.face_edges[0], area, normal, locked, share)
    first = np.full(len(area), -1)
    faces = np.flatnonzero(label >= 0)[::-1]
    first[label[faces]] = faces
    for onto, region in found:
        recipe = recipe.then(rcp.MergeRegions(face=int(first[onto]), other=int(first[region])))
    return recipe, len(found)


CLASSES = (ISIMP_OT_symmetrise, ISIMP_OT_merge_slivers)
