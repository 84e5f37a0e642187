from functools import partial

import bpy

from ... import messages
from ... import recipe as rcp
from .. import mesh_io, pending, result, settings, targets, texture
from ..modal import RecipeOperator
from ..show import show_polygons


class ISIMP_OT_mesh(RecipeOperator, settings.MeshSettings, bpy.types.Operator):
    """Turn the regions into polygons, as a new object at the same place. The scan is hidden"""

    bl_idname = "isimp.mesh"
    bl_label = "Mesh"
    does_all = True

    keep_texture: bpy.props.BoolProperty(
        name="Keep Texture", description="Put the images of the scan's materials on the result", default=True
    )

    @classmethod
    def problem(cls, context, scan):
        return targets.needs_regions(scan)

    def wanted(self, context, scan):
        return pending.recipe_of(context, scan).then(settings.to_step(rcp.Mesh, self))

    def begun(self, context, scan, work):
        self._baking, self._untextured = None, ""
        if not self.keep_texture or not texture.is_textured(scan):
            return
        try:
            self._baking = texture.Baking(scan)
            work.after = partial(self._bake, work)
        except mesh_io.Unusable as problem:
            self._untextured = str(problem)

    def _bake(self, work, outcome, watch):
        """On a thread. Without a texture the polygons are of use still."""
        try:
            self._baking.make(work.scan, outcome, watch)
        except ValueError as problem:
            self._baking, self._untextured = None, str(problem)

    def show(self, context, scan, work, outcome):
        self._kept = show_polygons(context, scan, work, outcome)
        if self._baking is not None:
            made = targets.result_of(context.scene, scan)
            try:
                self._baking.put(made, outcome)
                result.sign(made)
            except mesh_io.Unusable as problem:
                self._untextured = str(problem)
        self._baking = None  # its images are large
        if self._untextured:
            self.report({"WARNING"}, f"The result has no texture: {self._untextured}")

    def told(self, before, numbers):
        return messages.meshed(numbers)

    def warnings(self, context, scan, before):
        lines = []
        if self._kept is not None:
            made = targets.result_of(context.scene, scan)
            lines.append(messages.kept(self._kept.name, made.name))
        return lines


CLASSES = (ISIMP_OT_mesh,)
