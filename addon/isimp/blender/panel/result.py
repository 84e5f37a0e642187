"""What is drawn over the scan, the settings of the polygons, and all numbers."""

import bpy

from ... import recipe as rcp
from .. import display, settings, store, targets, text, translations
from .common import SubPanel


class ISIMP_PT_view(SubPanel, bpy.types.Panel):
    bl_label = "Show"
    bl_order = 0

    def draw(self, context):
        layout, panel = self.prepare(context), context.window_manager.isimp
        layout.use_property_split = False
        grid = layout.grid_flow(row_major=True, columns=2, align=True, even_columns=True)
        shown = display.is_shown(context)
        grid.operator("isimp.show_regions", text="Regions", icon="HIDE_OFF" if shown else "HIDE_ON", depress=shown)
        grid.prop(panel, "overlay", text="Lines", text_ctxt=translations.CONTEXT, icon="MESH_GRID", toggle=True)
        grid.prop(panel, "outline", text="Polygons", icon="MESH_ICOSPHERE", toggle=True)
        grid.prop(panel, "summary", text="Summary", text_ctxt=translations.CONTEXT, icon="INFO", toggle=True)
        grid.prop(panel, "heat", text="Flatness", icon="COLOR", toggle=True)
        grid.prop(panel, "away", text="Distance", icon="DRIVER_DISTANCE", toggle=True)
        grid.prop(panel, "directions", text="Directions", icon="ORIENTATION_NORMAL", toggle=True)


class ISIMP_PT_result(SubPanel, bpy.types.Panel):
    bl_label = "Polygon Options"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 3

    def draw(self, context):
        layout, meshing = self.prepare(context), context.window_manager.isimp.mesh
        for name in ("chord_tolerance", "join_junctions", "flatten"):
            settings.draw(layout, rcp.Mesh, meshing, name)
        ticks = layout.column(align=True)
        ticks.use_property_split = False  # its name needs the whole width
        ticks.prop(meshing, "planar")
        most = layout.column()
        most.active = meshing.planar
        settings.draw(most, rcp.Mesh, meshing, "planar_most")


class ISIMP_PT_numbers(SubPanel, bpy.types.Panel):
    bl_label = "Numbers"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 5

    def draw(self, context):
        scan, _ = targets.seen(context)
        column = self.layout.column(align=True)
        unit = context.scene.unit_settings
        for name, value in text.number_rows(store.numbers(scan), unit.system, unit.scale_length):
            row = column.split(factor=0.4)
            row.label(text=name)
            row.label(text=value)


CLASSES = (ISIMP_PT_view, ISIMP_PT_result, ISIMP_PT_numbers)
