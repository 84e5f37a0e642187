import bpy

from .. import display, mesh_io, runtime, show, targets


class ISIMP_OT_show_regions(bpy.types.Operator):
    """Show the regions' colours in the viewports, or give the viewports their own shading back"""

    bl_idname = "isimp.show_regions"
    bl_label = "Show Regions"

    def execute(self, context):
        if display.is_shown(context):
            display.give_back(context)
        else:
            display.show(context)
        return {"FINISHED"}


class ISIMP_OT_swap(bpy.types.Operator):
    """Show the scan in place of its result, or the result in place of its scan"""

    bl_idname = "isimp.swap"
    bl_label = "Swap Scan and Result"
    bl_options = {"UNDO"}

    @classmethod
    def poll(cls, context):
        scan, problem = targets.find(context)
        if not problem and targets.result_of(context.scene, scan) is None:
            problem = "There is no result yet: press Mesh first"
        if not problem and context.mode != "OBJECT":
            problem = "Leave Edit Mode first (Tab)"
        if problem:
            cls.poll_message_set(problem)
        return not problem

    def execute(self, context):
        scan, _ = targets.find(context)
        result = targets.result_of(context.scene, scan)
        if context.view_layer.objects.active == scan:
            show.bring_to_front(context, result, scan)
            display.give_back(context)
        else:
            show.bring_to_front(context, scan, result)
            if mesh_io.state_of(scan):
                mesh_io.show_color(scan.data)
                display.show(context)
        return {"FINISHED"}


class ISIMP_OT_stop(bpy.types.Operator):
    """Stop what is being worked on; everything stays as it was before"""

    bl_idname = "isimp.stop"
    bl_label = "Stop"

    @classmethod
    def poll(cls, context):
        return runtime.get().running is not None

    def execute(self, context):
        runtime.get().running.task.watch.cancel()
        return {"FINISHED"}


CLASSES = (ISIMP_OT_show_regions, ISIMP_OT_swap, ISIMP_OT_stop)
