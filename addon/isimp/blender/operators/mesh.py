import bpy

from ... import recipe as rcp
from .. import mesh_io, pending, settings, targets, texture
from ..modal import RecipeOperator
from ..show import show_polygons


class ISIMP_OT_mesh(RecipeOperator, settings.MeshSettings, bpy.types.Operator):
    """Turn the regions into polygons, as a new object at the same place. The scan is hidden"""

    bl_idname = "isimp.mesh"
    bl_label = "Mesh"

    keep_texture: bpy.props.BoolProperty(
        name="Keep Texture", description="Put the images of the scan's materials on the result", default=True
    )

    @classmethod
    def problem(cls, context, scan):
        return targets.needs_regions(scan)

    def wanted(self, context, scan):
        return pending.recipe_of(context, scan).then(settings.to_step(rcp.Mesh, self))

    def show(self, context, scan, work, outcome):
        show_polygons(context, scan, work, outcome)
        if not self.keep_texture or not texture.is_textured(scan):
            return
        try:
            texture.keep(scan, targets.result_of(context.scene, scan), work.scan, outcome)
        except (mesh_io.Unusable, ValueError) as error:
            self.report({"WARNING"}, f"The result has no texture: {error}")

    def told(self, before, numbers):
        closed = "closed" if numbers["closed"] else "open"
        return f"{numbers['triangles']:,} triangles -> {numbers['polygons']:,} polygons, {closed}"


CLASSES = (ISIMP_OT_mesh,)
