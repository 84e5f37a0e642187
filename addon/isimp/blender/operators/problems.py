import bpy
import numpy as np

from ... import handover, messages
from ...language import own, said
from ...outcome import EXACT
from ..scene import mesh_io, pointed, selection, store, targets
from ..texts import text
from ..view import display, overlay
from ..work import scene_outcome

_TOOLTIPS = {
    "DEFECTIVE": own("Select the defective polygons in Edit Mode of the result"),
    "BENT": own("Select the polygons that are not exactly flat, in Edit Mode of the result"),
    "DIVIDED": own("Select the polygons of regions that became more than one polygon, in Edit Mode of the result"),
}
_NONE = {
    "DEFECTIVE": own("No polygon has a defect."),
    "BENT": own("Each polygon is exactly flat."),
    "DIVIDED": own("Each region is one polygon."),
}


class ISIMP_OT_show_problems(bpy.types.Operator):
    """Select polygons in Edit Mode of the result: defective or bent ones, or the polygons of divided regions"""

    bl_idname = "isimp.show_problems"
    bl_label = "Select Defective Polygons"
    bl_options = {"REGISTER", "UNDO"}

    kind: bpy.props.EnumProperty(
        name="Polygons",
        items=(
            ("DEFECTIVE", "Defective", "Polygons that are bent, flipped, crossing or intersecting"),
            ("BENT", "Bent", "Polygons that are not exactly flat"),
            ("DIVIDED", "Of Divided Regions", "Polygons of regions that became more than one polygon"),
        ),
        options={"SKIP_SAVE"},
    )

    @classmethod
    def description(cls, context, properties):
        return said(_TOOLTIPS[properties.kind])

    @classmethod
    def poll(cls, context):
        _, _, problem = targets.find_result(context)
        if problem:
            cls.poll_message_set(problem)
        return not problem

    def execute(self, context):
        scan, result, _ = targets.find_result(context)
        selection.leave_modes(context, result)
        chosen = _chosen(result.data, self.kind)
        scene_outcome.bring_to_front(context, result, scan)
        display.show_result(context, result)
        selection.select_polygons(result, chosen)
        if not chosen.any():
            self.report({"INFO"}, said(_NONE[self.kind]))
            return {"FINISHED"}
        # Before the mode, which in other modes of selection also selects polygons whose corners are all selected.
        context.tool_settings.mesh_select_mode = (False, False, True)
        bpy.ops.object.mode_set(mode="EDIT")
        found = messages.count(int(np.count_nonzero(chosen)), "polygon")
        self.report({"INFO"}, said("{polygons} selected: View > Frame Selected zooms to them.", polygons=found))
        return {"FINISHED"}


class _Choose:
    """Mixin of operators that choose regions, which are then outlined, and buttons act on them."""

    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context):
        scan, problem = targets.find(context)
        return not problem and bool(cls.faces(context, scan))

    def execute(self, context):
        scan, _ = targets.find(context)
        pointed.choose(scan, tuple(self.faces(context, scan)))
        overlay.redraw()
        return {"FINISHED"}


class ISIMP_OT_choose_problems(_Choose, bpy.types.Operator):
    """Choose the regions whose polygons would have defects, drawn in magenta over the scan"""

    bl_idname = "isimp.choose_problems"
    bl_label = "Choose Regions in Magenta"
    faces = staticmethod(overlay.problem_faces)


class ISIMP_OT_choose_moved(_Choose, bpy.types.Operator):
    """Choose and outline the regions of edits whose size has changed by more than half since another number"""

    bl_idname = "isimp.choose_moved"
    bl_label = "Choose Regions of Edits"

    @staticmethod
    def faces(context, scan) -> list:
        return store.numbers(scan).get("moved", [])


class ISIMP_OT_report(bpy.types.Operator):
    """The whole report. A click selects the polygons of divided regions, or shows the report in the Info editor"""

    bl_idname = "isimp.report"
    bl_label = "Report"
    bl_options = {"INTERNAL"}

    @classmethod
    def description(cls, context, properties):
        return "\n".join(_report(context)) or said(cls.__doc__)

    def execute(self, context):
        if bpy.ops.isimp.show_problems.poll():
            return bpy.ops.isimp.show_problems(kind="DIVIDED")
        self.report({"INFO"}, " · ".join(_report(context)))
        return {"FINISHED"}


def _report(context) -> list:
    """Return all lines of the scan's report."""
    scan, problem = targets.seen(context)
    numbers = {} if problem else store.numbers(scan)
    if "regions" not in numbers:
        return []
    unit, made = context.scene.unit_settings, overlay.previewed(context, scan)
    rows = text.number_rows(numbers)
    lines = [line for line, _ in text.report_lines(numbers, unit.system, unit.scale_length, made)]
    return [*lines, *(f"{name}: {value}" for name, value in rows)]


def _chosen(mesh, kind: str) -> np.ndarray:
    """Return (polygons,) bool: the polygons to select."""
    if kind == "DEFECTIVE":
        return mesh_io.read_layer(mesh, mesh_io.DEFECT) > 0
    if kind == "BENT":
        vertices = mesh_io.points(mesh).reshape(-1, 3).astype(np.float64)
        size = np.linalg.norm(np.ptp(vertices, axis=0)) if len(vertices) else 0.0
        return handover.planarity(vertices, *mesh_io.polygons(mesh)) > EXACT * size
    region = np.maximum(mesh_io.read_layer(mesh, mesh_io.REGION), 0)
    _, of, count = np.unique(region, return_inverse=True, return_counts=True)  # the numbers may be huge
    return count[of] > 1


CLASSES = (ISIMP_OT_show_problems, ISIMP_OT_choose_problems, ISIMP_OT_choose_moved, ISIMP_OT_report)
