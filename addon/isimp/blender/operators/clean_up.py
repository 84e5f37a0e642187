"""The operator that merges slivers."""

import bpy
import numpy as np
from bpy.props import FloatProperty

from ... import recipe as rcp
from ... import slivers
from ...engine import engine
from ...language import said
from .. import reading
from ..scene import mesh_io, runtime
from ..work.modal import RecipeOperator


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


CLASSES = (ISIMP_OT_merge_slivers,)
