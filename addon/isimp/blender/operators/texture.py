import bpy
import numpy as np

from ...session import StepFailed
from .. import mesh_io, reading, runtime, show, store, targets, texture


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
        scan, problem = targets.find(context)
        if not problem and targets.result_of(context.scene, scan) is None:
            problem = "There is no result yet: press Mesh first"
        if problem:
            cls.poll_message_set(problem)
        return not problem

    def execute(self, context):
        scan, _ = targets.find(context)
        result = targets.result_of(context.scene, scan)
        if context.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        try:
            shown = texture.read(scan)
            recipe, session = store.load(scan), runtime.get().session
            arrays = reading.read(context, scan, recipe.layers())
            outcome = session.replay(arrays, recipe)
            order = corners(result, outcome)
            made = session.texture(arrays, outcome, shown, self.size or None)
        except (mesh_io.Unusable, StepFailed, ValueError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        name = next(layer.name for layer in scan.data.uv_layers if layer.active_render)
        texture.write(result, made.uv[order], made, name)
        show.bring_to_front(context, result, scan)
        size, charts = made.report["size"], made.report["charts"]
        self.report({"INFO"}, f"Texture of {size:,} x {size:,} pixels, {charts:,} charts")
        return {"FINISHED"}


def corners(result, outcome) -> np.ndarray:
    """Which corner of the outcome's polygons each corner of the result is. Raises Unusable if it was edited."""
    if outcome.polygons is None:
        raise mesh_io.Unusable("The regions have changed since Mesh: press Mesh again, then Keep Texture.")
    wanted, start = np.array(outcome.polygons.loops), np.array(outcome.polygons.loop_start)
    loops = np.empty(len(result.data.loops), np.int32)
    result.data.loops.foreach_get("vertex_index", loops)
    each = np.arange(len(wanted))
    for order in (each, show.turned(each, start)):
        if np.array_equal(wanted[order], loops):
            return order
    raise mesh_io.Unusable(f"'{result.name}' has changed since Mesh: press Mesh again, then Keep Texture.")


CLASSES = (ISIMP_OT_texture,)
