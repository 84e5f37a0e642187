import bpy

from ...session import StepFailed
from .. import mesh_io, reading, result, runtime, show, store, targets, texture


class ISIMP_OT_texture(bpy.types.Operator):
    """Put the texture of the scan on the result: a UV map, and a material with colours and normals"""

    bl_idname = "isimp.texture"
    bl_label = "Keep Texture"
    bl_options = {"REGISTER", "UNDO"}

    size: bpy.props.IntProperty(
        name="Size",
        description="Width and height of the image in pixels; 0: as dense as the scan's images",
        default=0,
        min=0,
        max=16384,
    )

    @classmethod
    def poll(cls, context):
        _, _, problem = targets.find_result(context)
        if problem:
            cls.poll_message_set(problem)
        return not problem

    def execute(self, context):
        scan, made, _ = targets.find_result(context)
        if context.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        try:
            recipe = store.load(scan)
            arrays = reading.read(context, scan, recipe.layers())
            outcome = runtime.get().session.replay(arrays, recipe)
            was_edited = result.is_edited(made)
            report = texture.keep(scan, made, arrays, outcome, self.size or None)
        except (mesh_io.Unusable, StepFailed, ValueError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        if not was_edited:
            result.sign(made)
        show.bring_to_front(context, made, scan)
        self.report({"INFO"}, f"Texture of {report['size']:,} x {report['size']:,} pixels, {report['charts']:,} charts")
        return {"FINISHED"}


CLASSES = (ISIMP_OT_texture,)
