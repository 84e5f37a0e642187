import bpy
import numpy as np
from bpy.props import BoolProperty, IntProperty

from ... import messages
from ...language import said
from ..scene import mesh_io, pointed, runtime, selection, store, targets
from ..view import display
from ..work import scene_outcome
from ..work.selecting import SelectOperator


class ISIMP_OT_show_regions(bpy.types.Operator):
    """Show or hide the colours of the regions in the viewports"""

    bl_idname = "isimp.show_regions"
    bl_label = "Show Regions"

    def execute(self, context):
        if display.is_shown(context):
            display.give_back(context)
        else:
            display.show(context)
        return {"FINISHED"}


class ISIMP_OT_swap(bpy.types.Operator):
    """Switch between the scan and its result"""

    bl_idname = "isimp.swap"
    bl_label = "Swap Scan and Result"
    bl_options = {"UNDO"}

    @classmethod
    def poll(cls, context):
        return targets.allows_with_result(cls, context)

    def execute(self, context):
        scan, result, _ = targets.find_result(context)
        if context.view_layer.objects.active == scan:
            scene_outcome.bring_to_front(context, result, scan)
            display.show_result(context, result)
        else:
            scene_outcome.bring_to_front(context, scan, result)
            if mesh_io.state_of(scan):
                mesh_io.show_color(scan.data)
                display.show(context)
        return {"FINISHED"}


class ISIMP_OT_select_region(SelectOperator, bpy.types.Operator):
    """Select all faces of the regions that have a selected face"""

    bl_idname = "isimp.select_region"
    bl_label = "Select Region"

    face: IntProperty(
        name="Face",
        description="Number of a face of the region; -1: the selected faces",
        default=-1,
        min=-1,
        options={"SKIP_SAVE"},
    )
    part: IntProperty(
        name="Round Part",
        description="Number of a round part, the largest first, whose regions are selected; -1: none",
        default=-1,
        min=-1,
        options={"SKIP_SAVE"},
    )
    size: IntProperty(
        name="Size",
        description="Number of a line of Sizes, whose regions are selected; -1: none",
        default=-1,
        min=-1,
        options={"SKIP_SAVE"},
    )
    extend: BoolProperty(name="Extend", description="Keep the present selection", options={"SKIP_SAVE"})

    _chosen = ()  #: a face of each chosen region, if a button was pressed in Object Mode

    @classmethod
    def poll(cls, context):
        return targets.allows(cls, context, targets.needs_regions)

    def invoke(self, context, event):
        scan, problem = targets.find(context)
        if (
            max(self.face, self.part, self.size) < 0
            and not problem
            and scan.mode == "OBJECT"
            and not bpy.app.background
        ):
            self._chosen = pointed.faces(scan)
            self.face = pointed.face(scan)
            if self.face < 0:
                self.report({"ERROR"}, f"{said(pointed.NONE)}.")
                return {"CANCELLED"}
        return super().invoke(context, event)

    def wanted(self, context):
        scan, _ = targets.find(context)
        selected, regions = selection.selected_faces(scan), mesh_io.read_regions(scan)
        parts, sizes = (store.numbers(scan).get(name, []) for name in ("round", "sizes"))
        if 0 <= self.part < len(parts):
            faces = np.flatnonzero(np.isin(regions, parts[self.part][5:]))
        elif 0 <= self.size < len(sizes):
            faces = np.flatnonzero(np.isin(regions, sizes[self.size][-1]))
        else:
            faces = selected if self.face < 0 else np.array(self._chosen or [self.face])
        if len(faces) == 0 or faces.max() >= len(regions):
            self.report({"ERROR"}, said(messages.NO_FACE))
            return None
        chosen = np.isin(regions, np.unique(regions[faces]))
        if self.extend:
            chosen[selected] = True
        self._count = int(chosen.sum())
        return scan, chosen

    def conclude(self, context, obj):
        self.report({"INFO"}, said("{faces} selected", faces=messages.count(self._count, "face")))


class ISIMP_OT_stop(bpy.types.Operator):
    """Stop the current work and restore the previous state"""

    bl_idname = "isimp.stop"
    bl_label = "Stop"

    @classmethod
    def poll(cls, context):
        return runtime.get().running is not None

    def execute(self, context):
        runtime.get().running.task.watch.cancel()
        return {"FINISHED"}


CLASSES = (ISIMP_OT_show_regions, ISIMP_OT_swap, ISIMP_OT_select_region, ISIMP_OT_stop)
