from functools import partial

import bpy

from .. import mesh_io, pending, result, show, store, targets, texture
from ..modal import RecipeOperator


class ISIMP_OT_texture(RecipeOperator, bpy.types.Operator):
    """Put the texture of the scan on the result: a UV map, and a material with colours and normals"""

    bl_idname = "isimp.texture"
    bl_label = "Keep Texture"

    size: bpy.props.IntProperty(
        name="Size",
        description="Width and height of the image in pixels; 0: as dense as the scan's images",
        default=0,
        min=0,
        max=16384,
    )

    @classmethod
    def problem(cls, context, scan):
        return "" if targets.result_of(context.scene, scan) else targets.NO_RESULT

    def wanted(self, context, scan):
        return store.load(scan)

    def begun(self, context, scan, work):
        self._baking = texture.Baking(scan, self.size or None)
        work.after = partial(self._baking.make, work.scan)

    def _finish(self, context, work, outcome):
        """The recipe stays as it is, and the scan's colours do; only the result changes."""
        pending.go_on()
        if context.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        scan = self._target(work)
        made = targets.result_of(context.scene, scan) if scan is not None else None
        if made is None:
            return {"CANCELLED"}
        baking, self._baking = self._baking, None
        try:
            was_edited = result.is_edited(made)
            report = baking.put(made, outcome)
        except mesh_io.Unusable as problem:
            self.report({"ERROR"}, str(problem))
            return {"CANCELLED"}
        if not was_edited:
            result.sign(made)
        show.bring_to_front(context, made, scan)
        self.report({"INFO"}, f"Texture of {report['size']:,} x {report['size']:,} pixels, {report['charts']:,} charts")
        return {"FINISHED"}


CLASSES = (ISIMP_OT_texture,)
