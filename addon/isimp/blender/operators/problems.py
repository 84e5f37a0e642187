import bpy
import numpy as np

from .. import display, mesh_io, show, targets


class ISIMP_OT_show_problems(bpy.types.Operator):
    """Select the defective polygons in Edit Mode of the result"""

    bl_idname = "isimp.show_problems"
    bl_label = "Select Defective Polygons"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        _, _, problem = targets.find_result(context)
        if problem:
            cls.poll_message_set(problem)
        return not problem

    def execute(self, context):
        scan, result, _ = targets.find_result(context)
        if context.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        defective = mesh_io.read_layer(result.data, mesh_io.FLAW) > 0
        show.bring_to_front(context, result, scan)
        display.give_back(context)
        mesh_io.select_polygons(result, defective)
        if not defective.any():
            self.report({"INFO"}, "No polygon has a defect.")
            return {"FINISHED"}
        bpy.ops.object.mode_set(mode="EDIT")
        context.tool_settings.mesh_select_mode = (False, False, True)
        self.report(
            {"INFO"}, f"{np.count_nonzero(defective)} defective polygons selected: View > Frame Selected zooms to them."
        )
        return {"FINISHED"}


CLASSES = (ISIMP_OT_show_problems,)
