"""The top of the sidebar: the scan, the number of regions, the button Partition."""

import bpy

from ... import recipe as rcp
from .. import presets, runtime, settings, store, targets, text
from .common import Panel, draw_lines, is_narrow


class ISIMP_PT_main(Panel, bpy.types.Panel):
    bl_label = "iSimp"

    def draw(self, context):
        layout = self.prepare(context)
        running = runtime.get().running
        if running is not None:
            _draw_progress(context, layout, running)
            return
        scan, problem = targets.find(context)
        if problem:
            draw_lines(context, layout, problem, icon="INFO")
            return
        numbers, panel = store.numbers(scan), context.window_manager.isimp
        column = layout.column(align=True)
        column.label(text=scan.name, icon="MESH_DATA")
        draw_lines(context, column, text.scan_line(scan.data, numbers), icon="BLANK1")
        lost = text.lost_detail(scan, context.scene.unit_settings)
        for warning in (*lost, *text.warnings(scan.data, numbers)):
            draw_lines(context, layout, warning, icon="ERROR")
        for note in targets.notes(scan):
            draw_lines(context, layout, note, icon="INFO")
        if store.kept(scan) is not None:
            layout.operator("isimp.take_back", icon="LOOP_BACK")
        presets.draw(context, layout)
        partition = panel.partition
        ways = layout.grid_flow(row_major=True, columns=1 if is_narrow(context) else 2, align=True)
        ways.use_property_split = False
        for name in rcp.COUNTS:
            ways.prop_enum(partition, "count_by", name)
        row = layout.row(align=True)
        row.prop(partition, partition.count_by or "detail")  # which a file of another version may not say
        row.prop(panel, "live", text="", icon="PLAY")
        if partition.count_by != "proxies" and "regions" in numbers:
            layout.label(text=f"{numbers['regions']:,} regions", icon="FORWARD")
        button = layout.column()
        button.scale_y = 1.4
        operator = button.operator("isimp.partition", icon="MOD_EXPLODE")
        settings.give(rcp.Partition, panel.partition, operator)


class ISIMP_PT_options(Panel, bpy.types.Panel):
    bl_label = "Options"
    bl_parent_id = "ISIMP_PT_main"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return not targets.find(context)[1]

    def draw(self, context):
        layout, partition = self.prepare(context), context.window_manager.isimp.partition
        if partition.count_by != "proxies":
            layout.prop(partition, "noise")
            layout.prop(partition, "snap")
        layout.prop(partition, "method")
        column = layout.column()
        column.active = partition.method != "hierarchy"  # which starts from no faces
        for name in ("seeding", "seed", "iterations"):
            column.prop(partition, name)
        layout.prop(partition, "leave_out", text="Leave Out")
        layout.prop(partition, "close_openings")
        layout.prop(partition, "adaptivity", slider=True)
        layout.prop(partition, "smooth", slider=True)
        layout.prop(partition, "weights", icon="GROUP_VERTEX")
        if partition.weights:
            layout.prop(partition, "influence", slider=True)


class ISIMP_PT_borders(Panel, bpy.types.Panel):
    bl_label = "Barriers"
    bl_parent_id = "ISIMP_PT_options"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, partition = self.prepare(context), context.window_manager.isimp.partition
        column = layout.column(heading="Marked", align=True)
        column.prop(partition, "seams")
        column.prop(partition, "sharp")
        column.prop(partition, "materials")
        if bpy.app.version >= (3, 6, 0):  # before, nothing tells of them
            column.prop(partition, "face_sets")
        layout.prop(partition, "angle")
        layout.prop(partition, "borders", icon="SPREADSHEET")


def _draw_progress(context, layout, running) -> None:
    column = layout.column()
    column.label(text=running.name, icon="SORTTIME")
    share, said = running.progress()
    draw_lines(context, column, said, icon="BLANK1")  # the time left is to be read at any width
    if hasattr(column, "progress"):
        column.progress(factor=share, text=f"{share:.0%}")
    else:
        split = column.split(factor=max(0.02, min(1.0, share)))
        split.operator("isimp.stop", text=" ", depress=True)
    if running.shown is None:  # writing takes a moment, and must not be stopped half way
        column.operator("isimp.stop", text="Stop (Esc)", icon="CANCEL")


CLASSES = (ISIMP_PT_main, ISIMP_PT_options, ISIMP_PT_borders)
