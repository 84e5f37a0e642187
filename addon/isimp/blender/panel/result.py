"""The settings and the report of the polygons."""

import bpy

from ... import recipe as rcp
from .. import settings, store, targets, text, texture
from .common import SubPanel, draw_lines

#: Where the name of a property is too long for the sidebar as it comes
_LABELS = {"chord_tolerance": {"text": "Corners"}}


class ISIMP_PT_result(SubPanel, bpy.types.Panel):
    bl_label = "Result"

    def draw(self, context):
        layout, panel = self.prepare(context), context.window_manager.isimp
        meshing = panel.mesh
        column = layout.column(heading="Preview", align=True)
        column.prop(panel, "outline")
        column.prop(panel, "heat")
        for name in settings.names(rcp.Mesh):
            layout.prop(meshing, name, **_LABELS.get(name, {}))
        button = layout.column()
        button.scale_y = 1.4
        operator = button.operator("isimp.mesh", icon="MESH_ICOSPHERE")
        settings.give(rcp.Mesh, meshing, operator)
        operator.keep_texture = panel.keep_texture
        scan, _ = targets.find(context)
        textured = scan is not None and texture.is_textured(scan)
        if textured:
            layout.prop(panel, "keep_texture")
        unit = context.scene.unit_settings
        for line, alert in text.report_lines(store.numbers(scan), unit.system, unit.scale_length):
            draw_lines(context, layout, line, icon="ERROR" if alert else "CHECKMARK")
        defects = text.problems(store.numbers(scan))
        if defects:
            layout.operator("isimp.show_problems", text=defects, icon="ERROR")
        if targets.result_of(context.scene, scan) is not None:
            if textured:
                layout.operator("isimp.texture", icon="TEXTURE")
            layout.operator("isimp.swap", icon="ARROW_LEFTRIGHT")


class ISIMP_PT_numbers(SubPanel, bpy.types.Panel):
    bl_label = "Numbers"
    bl_parent_id = "ISIMP_PT_result"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        scan, _ = targets.find(context)
        column = self.layout.column(align=True)
        unit = context.scene.unit_settings
        for name, value in text.number_rows(store.numbers(scan), unit.system, unit.scale_length):
            row = column.split(factor=0.4)
            row.label(text=name)
            row.label(text=value)


CLASSES = (ISIMP_PT_result, ISIMP_PT_numbers)
