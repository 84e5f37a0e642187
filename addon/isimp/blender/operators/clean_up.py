"""Operators that merge slivers and leave out furniture."""

import bpy
import numpy as np
from bpy.props import FloatProperty

from ... import furniture, messages, slivers
from ... import recipe as rcp
from ...engine import engine
from ...language import said
from .. import reading
from ..controls import up_direction
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


class ISIMP_OT_leave_out_furniture(RecipeOperator, bpy.types.Operator):
    """Make no polygons of regions that are neither walls, floor and ceiling of a room nor pieces of these"""

    bl_idname = "isimp.leave_out_furniture"
    bl_label = "Leave Out Furniture"
    adjusted = ("smallest",)

    smallest: FloatProperty(
        name="Smallest Wall",
        description="Share of the area that a wall, a floor or a ceiling has at least",
        default=1.0,
        min=0.01,
        max=50.0,
        soft_max=10.0,
        precision=2,
        subtype="PERCENTAGE",
    )

    def wanted(self, context, target):
        _, label, found = furniture_of(context, target.scan, target.recipe.without_mesh(), 0.01 * self.smallest)
        regions, first = np.unique(label, return_index=True)
        faces = first[np.append(found, False)[regions]]
        if not len(faces):
            raise mesh_io.Unusable(said("No furniture was found: all regions are walls, floor or ceiling."))
        return target.recipe.then(rcp.LeaveOutRegions(faces=tuple(faces.tolist())))

    def told(self, before, numbers):
        return messages.left_out(numbers)


def furniture_of(context, scan, recipe, smallest: float) -> tuple:
    """Return (arrays, the region of each face, (R,) bool: the regions that are furniture)."""
    arrays = reading.read(context, scan, recipe.layers())
    label = reading.regions(scan, arrays, recipe)
    up = up_direction.direction(scan) or (0.0, 0.0, 1.0)
    found = furniture.furniture(arrays.vertices, arrays.triangles, label[arrays.triangle_face], up, smallest)
    return arrays, label, found


def without_slivers(context, scan, recipe, share: float) -> tuple:
    """Return (the recipe with small regions merged, their number); see slivers.py."""
    arrays = reading.read(context, scan, recipe.layers())
    label = reading.regions(scan, arrays, recipe)
    area, normal = engine.regions.region_sides(
        arrays.vertices, arrays.triangles, label[arrays.triangle_face], int(label.max(initial=-1)) + 1
    )
    session = runtime.get().session
    pairs, locked = session.neighbours(arrays, recipe), session.locked_regions(arrays, recipe)
    found = slivers.merges(label, pairs, area, normal, locked, share)
    first = np.full(len(area), -1)
    faces = np.flatnonzero(label >= 0)[::-1]
    first[label[faces]] = faces
    merges = (rcp.MergeRegions(face=int(first[onto]), other=int(first[region])) for onto, region in found)
    return recipe.then(*merges), len(found)


CLASSES = (ISIMP_OT_merge_slivers, ISIMP_OT_leave_out_furniture)
