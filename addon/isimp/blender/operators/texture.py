import bpy

from ... import messages
from ... import recipe as rcp
from ...language import said
from ..controls import settings
from ..scene import mesh_io, selection, store, targets
from ..view import display
from ..work import panel_changes, scene_outcome
from ..work.modal import RecipeOperator


class ISIMP_OT_texture(RecipeOperator, settings.TextureSettings, bpy.types.Operator):
    """Put the texture of the scan on the result: a UV map, and a material with colours and normals"""

    bl_idname = "isimp.texture"
    bl_label = "Keep Texture"
    adjusted = ("size", "tiles", "occlusion")

    @classmethod
    def problem(cls, context, scan):
        return "" if targets.result_of(context.scene, scan) else targets.NO_RESULT

    def wanted(self, context, target):
        recipe = store.load(target.scan)
        if recipe is None or not recipe.ends_in_mesh():
            raise mesh_io.Unusable(said(messages.REGIONS_CHANGED))
        return recipe.then(settings.to_step(rcp.Texture, self))

    def _begin(self, context, target):
        work = super()._begin(context, target)
        if work is not None and work.untextured:
            self.report({"ERROR"}, work.untextured)
            return None
        return work

    def _finish(self, context, work, outcome):
        """Writes the texture only; polygons and the scan's colours do not change."""
        panel_changes.go_on()
        scan = self._target(work)
        made = targets.result_of(context.scene, scan) if scan is not None else None
        selection.leave_modes(context, made)
        if made is None:
            return {"CANCELLED"}
        if work.baking is None:  # too many charts for the size
            self.report({"ERROR"}, work.untextured)
            return {"CANCELLED"}
        try:
            report = scene_outcome.show_texture(scan, work, outcome, made)
        except mesh_io.Unusable as problem:
            self.report({"ERROR"}, str(problem))
            return {"CANCELLED"}
        for note in work.baking.notes:
            self.report({"WARNING"}, note)
        scene_outcome.bring_to_front(context, made, scan)
        display.show_result(context, made)
        self.report({"INFO"}, messages.textured(report))
        return {"FINISHED"}


CLASSES = (ISIMP_OT_texture,)
