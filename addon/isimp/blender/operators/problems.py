import bpy
import numpy as np

from .. import display, mesh_io, show, targets


class ISIMP_OT_show_problems(bpy.types.Operator):
    """Select the polygons that something is amiss with, in Edit Mode of the result"""

    bl_idname = "isimp.show_problems"
    bl_label = "Show Problem Polygons"
    bl_options = {"REGISTER", "UNDO"}

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
        amiss = mesh_io.read_layer(result.data, mesh_io.FLAW) > 0
        show.bring_to_front(context, result, scan)
        display.give_back(context)
        mesh_io.select_polygons(result, amiss)
        if not amiss.any():
            self.report({"INFO"}, "Nothing is amiss with these polygons.")
            return {"FINISHED"}
        bpy.ops.object.mode_set(mode="EDIT")
        context.tool_settings.mesh_select_mode = (False, False, True)
        self.report({"INFO"}, f"{np.count_nonzero(amiss)} polygons selected: View > Frame Selected goes there.")
        return {"FINISHED"}


CLASSES = (ISIMP_OT_show_problems,)
