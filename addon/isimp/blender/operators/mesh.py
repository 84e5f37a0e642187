import bpy

from ... import recipe as rcp
from .. import pending, settings, targets
from ..modal import RecipeOperator
from ..show import show_polygons


class ISIMP_OT_mesh(RecipeOperator, settings.MeshSettings, bpy.types.Operator):
    """Turn the regions into polygons, as a new object at the same place. The scan is hidden"""

    bl_idname = "isimp.mesh"
    bl_label = "Mesh"

    @classmethod
    def problem(cls, context, scan):
        return targets.needs_regions(scan)

    def wanted(self, context, scan):
        return pending.recipe_of(context, scan).then(settings.to_step(rcp.Mesh, self))

    show = staticmethod(show_polygons)

    def told(self, before, numbers):
        closed = "closed" if numbers["closed"] else "open"
        return f"{numbers['triangles']:,} triangles -> {numbers['polygons']:,} polygons, {closed}"


CLASSES = (ISIMP_OT_mesh,)
