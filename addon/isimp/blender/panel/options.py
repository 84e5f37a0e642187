"""Panel with all further settings of Partition and Mesh. Each group is one function or one panel."""

import bpy

from ... import recipe as rcp
from .. import preferences
from ..controls import presets, settings
from ..scene import targets
from .common import Panel, Popover


class ISIMP_PT_options(Panel, bpy.types.Panel):
    bl_label = "More Settings"
    bl_parent_id = "ISIMP_PT_main"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 5

    @classmethod
    def poll(cls, context):
        return not targets.seen(context)[1]

    def draw(self, context):
        layout, panel = self.prepare(context), context.window_manager.isimp
        presets.draw_own(context, layout)
        _draw_regions(context, layout, panel)
        _draw_polygons(layout, panel.mesh)


def _draw_regions(context, layout, panel) -> None:
    """Draws the settings of regions, of round parts too."""
    partition = panel.partition
    layout.prop(partition, "count_by")
    for name in ("adaptivity", "smooth"):
        layout.prop(partition, name, slider=True)
    layout.prop(partition, "weights", icon="GROUP_VERTEX")
    if partition.weights:
        layout.prop(partition, "influence", slider=True)
    row = layout.row(align=True)
    row.use_property_split = False
    row.popover("ISIMP_PT_scan", text="Scan", icon="MESH_DATA")
    row.popover("ISIMP_PT_borders", text="Barriers", icon="MOD_EDGESPLIT")
    ticks = layout.column(align=True)
    ticks.use_property_split = False  # their names need the whole width
    ticks.prop(panel, "live")
    if preferences.get(context).experimental:
        layout.prop(partition, "method")
        # The hierarchy has no seeds, the others have no metric.
        for name in ("metric",) if partition.method == "hierarchy" else ("seeding", "seed", "iterations"):
            layout.prop(partition, name)


def _draw_polygons(layout, meshing) -> None:
    """Draws the settings of polygons."""
    ticks = layout.column(align=True)
    ticks.use_property_split = False
    ticks.prop(meshing, "planar")
    ticks.prop(meshing, "convex")
    ticks.popover("ISIMP_PT_polygons", text="Polygons", icon="MESH_ICOSPHERE")


class ISIMP_PT_scan(Popover, bpy.types.Panel):
    """Size, noise and repair of the scan before the partition"""

    bl_label = "Scan"

    def draw(self, context):
        layout, partition = self.prepare(context), context.window_manager.isimp.partition
        layout.prop(partition, "curved")
        settings.draw(layout, rcp.Partition, partition, "leave_out")
        _draw_mended(layout, partition)
        if partition.count_by in ("proxies", "triangles"):
            return
        ticks = layout.column(align=True)
        ticks.use_property_split = False
        ticks.prop(partition, "snap")
        ticks.prop(partition, "noise_automatic", text="Automatic Noise")
        if not partition.noise_automatic:
            layout.prop(partition, "noise_length")


def _draw_mended(layout, partition) -> None:
    """Draws the settings of the repair."""
    ticks = layout.column(align=True)
    ticks.use_property_split = False
    ticks.prop(partition, "close_openings")
    ticks.prop(partition, "sharpens")
    if partition.sharpens:
        layout.prop(partition, "sharp_edges_length")
    for name in ("stitch", "grid"):
        draw_found(layout, partition, name)


def draw_found(layout, group, name: str) -> None:
    """Draws the two properties of a length: the tick for automatic, and the length if it is off."""
    place = layout.column(align=True)
    place.use_property_split = False
    place.prop(group, f"{name}_found")
    if not getattr(group, f"{name}_found"):
        layout.prop(group, f"{name}_length")


class ISIMP_PT_borders(Popover, bpy.types.Panel):
    """Edges that no region crosses"""

    bl_label = "Barriers"

    def draw(self, context):
        layout, partition = self.prepare(context), context.window_manager.isimp.partition
        column = layout.column(heading="Marked", align=True)
        column.prop(partition, "seams")
        column.prop(partition, "sharp")
        column.prop(partition, "materials")
        if bpy.app.version >= (3, 6, 0):  # earlier versions have no attribute of face sets
            column.prop(partition, "face_sets")
        settings.draw(layout, rcp.Partition, partition, "angle")
        layout.prop(partition, "borders", icon="SPREADSHEET")


class ISIMP_PT_polygons(Popover, bpy.types.Panel):
    """How corners are made, joined and moved"""

    bl_label = "Polygons"

    def draw(self, context):
        layout, meshing = self.prepare(context), context.window_manager.isimp.mesh
        for name in ("chord_tolerance", "join_junctions", "flatten"):
            settings.draw(layout, rcp.Mesh, meshing, name)
        draw_found(layout, meshing, "straight_rims")
        most = layout.column()
        most.active = meshing.planar
        settings.draw(most, rcp.Mesh, meshing, "planar_most")


CLASSES = (ISIMP_PT_options, ISIMP_PT_scan, ISIMP_PT_borders, ISIMP_PT_polygons)
