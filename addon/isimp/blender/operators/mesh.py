import bpy

from ... import messages
from ... import recipe as rcp
from ..controls import settings, up_direction
from ..scene import store, targets
from ..texturing import texture
from ..work.modal import RecipeOperator
from ..work.scene_outcome import show_polygons


class Meshing(RecipeOperator, settings.MeshSettings):
    """Mixin of operators that turn the regions into polygons."""

    adjusted = ("chord_tolerance", "planar", "regularise")

    keep_texture: bpy.props.BoolProperty(
        name="Keep Texture", description="Put the images of the scan's materials on the result", default=True
    )

    regularise: bpy.props.BoolProperty(
        name="Regularise First",
        description="Regularise the planes first, with the settings of the panel",
        default=False,
    )

    def wanted(self, context, target):
        before = target.recipe
        if not before.steps:  # Mesh pressed at once
            before = before.then(settings.to_step(rcp.Partition, settings.group(context, rcp.Partition)))
        first = up_direction.first(context, target.scan) if self.regularise else None
        recipe = (before if first is None else before.regularised(first)).then(settings.to_step(rcp.Mesh, self))
        if self.keep_texture and texture.is_textured(target.scan):
            last = texture.last_step(targets.result_of(context.scene, target.scan))
            recipe = recipe.then(before.texture() or last or rcp.Texture())
        return recipe

    def show(self, context, scan, work, outcome):
        self._notes = [] if work.baking is None else work.baking.notes
        kept = show_polygons(context, scan, work, outcome)
        self._width = texture.image_width(targets.result_of(context.scene, scan)) if work.baking is not None else 0
        return kept

    def told(self, before, numbers):
        return messages.meshed(numbers, self._width)

    def warnings(self, context, scan, before):
        return list(self._notes)


class ISIMP_OT_mesh(Meshing, bpy.types.Operator):
    """Turn the regions into polygons, as a new object at the same place; first find them, if there are none"""

    bl_idname = "isimp.mesh"
    bl_label = "Mesh"
    does_all = True

    @classmethod
    def problem(cls, context, scan):
        stored = store.read(scan).recipe
        return "" if stored is not None and not stored.steps else super().problem(context, scan)


class ISIMP_OT_flatten(Meshing, bpy.types.Operator):
    """Mesh again with every polygon exactly flat, even if many are cut for it"""

    bl_idname = "isimp.flatten"
    bl_label = "Flatten Anyway"
    adjusted = ("chord_tolerance", "regularise")

    def wanted(self, context, target):
        self.planar, self.planar_most = True, 1.0
        return super().wanted(context, target)


CLASSES = (ISIMP_OT_mesh, ISIMP_OT_flatten)
