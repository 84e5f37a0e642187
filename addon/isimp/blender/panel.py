"""The sidebar: what the add-on sees, the steps in the order they are done, what the last one did."""

import bpy

from .. import recipe as rcp
from . import display, runtime, settings, store, targets, text


class _Panel:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "iSimp"

    def prepare(self):
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        return self.layout


class ISIMP_PT_main(_Panel, bpy.types.Panel):
    bl_label = "iSimp"

    def draw(self, context):
        layout = self.prepare()
        running = runtime.get().running
        if running is not None:
            _draw_progress(layout, running)
            return
        scan, problem = targets.find(context)
        if problem:
            _draw_lines(layout, problem, icon="INFO")
            return
        box = layout.column(align=True)
        box.label(text=scan.name, icon="MESH_DATA")
        for line in text.scan_lines(scan.data, store.numbers(scan)):
            box.label(text=line)
        panel = context.window_manager.isimp
        layout.prop(panel.partition, "proxies")
        button = layout.column()
        button.scale_y = 1.4
        operator = button.operator("isimp.partition", icon="MOD_EXPLODE")
        settings.copy(rcp.Partition, panel.partition, operator)


class ISIMP_PT_options(_Panel, bpy.types.Panel):
    bl_label = "Options"
    bl_parent_id = "ISIMP_PT_main"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return not targets.find(context)[1]

    def draw(self, context):
        layout, partition = self.prepare(), context.window_manager.isimp.partition
        layout.prop(partition, "method")
        column = layout.column()
        column.active = partition.method != "hierarchy"  # which starts from no faces
        for name in ("seeding", "seed", "iterations"):
            column.prop(partition, name)
        layout.prop(partition, "leave_out")


class ISIMP_PT_regions(_Panel, bpy.types.Panel):
    bl_label = "Edit Regions"
    bl_parent_id = "ISIMP_PT_main"

    @classmethod
    def poll(cls, context):
        return _ready(context)

    def draw(self, context):
        layout = self.prepare()
        row = layout.row(align=True)
        row.operator("isimp.add_proxy", text="Add", icon="ADD")
        row.operator("isimp.delete_proxy", text="Delete", icon="REMOVE")
        shown = display.is_shown(context)
        layout.operator("isimp.show_regions", text="Colours", icon="HIDE_OFF" if shown else "HIDE_ON", depress=shown)


class ISIMP_PT_result(_Panel, bpy.types.Panel):
    bl_label = "Result"
    bl_parent_id = "ISIMP_PT_main"

    @classmethod
    def poll(cls, context):
        return _ready(context)

    def draw(self, context):
        layout = self.prepare()
        meshing = context.window_manager.isimp.meshing
        layout.prop(meshing, "chord_tolerance")
        layout.prop(meshing, "flatten")
        button = layout.column()
        button.scale_y = 1.4
        operator = button.operator("isimp.mesh", icon="MESH_ICOSPHERE")
        settings.copy(rcp.Mesh, meshing, operator)
        scan, _ = targets.find(context)
        if targets.result_of(context.scene, scan) is not None:
            layout.operator("isimp.swap", icon="ARROW_LEFTRIGHT")


class ISIMP_PT_numbers(_Panel, bpy.types.Panel):
    bl_label = "Last Step"
    bl_parent_id = "ISIMP_PT_main"

    @classmethod
    def poll(cls, context):
        return _ready(context)

    def draw(self, context):
        scan, _ = targets.find(context)
        column = self.layout.column(align=True)
        unit = context.scene.unit_settings
        for name, value in text.number_rows(store.numbers(scan), unit.system, unit.scale_length):
            row = column.split(factor=0.4)
            row.label(text=name)
            row.label(text=value)


def _ready(context) -> bool:
    scan, problem = targets.find(context)
    return not problem and targets.has_regions(scan)


def _draw_lines(layout, message: str, icon: str) -> None:
    """A message in as many lines as a narrow sidebar needs."""
    column = layout.column(align=True)
    for number, line in enumerate(text.wrapped(message)):
        column.label(text=line, icon=icon if number == 0 else "BLANK1")


def _draw_progress(layout, running) -> None:
    column = layout.column()
    column.label(text=running.name, icon="SORTTIME")
    task = running.task
    if hasattr(column, "progress"):
        column.progress(factor=task.watch.progress, text=task.describe())
    else:
        column.label(text=task.describe())
        split = column.split(factor=max(0.02, min(1.0, task.watch.progress)))
        split.operator("isimp.stop", text=" ", depress=True)
    column.operator("isimp.stop", text="Stop (Esc)", icon="CANCEL")


CLASSES = (ISIMP_PT_main, ISIMP_PT_options, ISIMP_PT_regions, ISIMP_PT_result, ISIMP_PT_numbers)
