"""Planes that belong together: Regularise with its settings, and planes set by hand at the selected faces."""

import bpy

from ... import recipe as rcp
from ...language import own
from .. import settings, store, targets, text
from .common import SubPanel, draw_lines, side_by_side

_ROWS = (("level", "upright"), ("parallel", "perpendicular"), ("coplanar", "free"))


class ISIMP_PT_regularity(SubPanel, bpy.types.Panel):
    bl_label = "Regularity"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 2

    def draw(self, context):
        layout, panel = self.prepare(context), context.window_manager.isimp
        numbers, unit = store.numbers(targets.seen(context)[0]), context.scene.unit_settings
        button = layout.row()
        button.scale_y = 1.2
        settings.give(rcp.Regularise, panel.regularise, button.operator("isimp.regularise", icon="SNAP_ON"))
        draw_lines(context, layout, text.planes_line(numbers, unit.system, unit.scale_length), icon="FORWARD")
        _draw_limit(layout, panel.regularise)
        for name in ("angle", "up", "merge_islands"):
            settings.draw(layout, rcp.Regularise, panel.regularise, name)
        ticks = layout.column(align=True)
        ticks.use_property_split = False  # their names need the whole width
        ticks.prop(panel.regularise, "even_spacing")
        ticks.prop(panel, "regularise_first")
        ticks.prop(panel, "directions", text="Colour by Direction")
        column = layout.column(align=True)
        column.label(text="Planes of the selected faces:")
        for names in _ROWS:
            row = side_by_side(context, column)
            for name in names:
                align(row, name).length = panel.align.length
        _draw_limit(layout, panel.align)
        if not panel.mesh.planar:
            draw_lines(
                context, layout, own("For exactly planar polygons: Planar Exactly in Polygon Options"), icon="INFO"
            )


def _draw_limit(layout, group) -> None:
    place = layout.column(align=True)
    place.use_property_split = False
    place.prop(group, "length_automatic")
    if not group.length_automatic:
        layout.prop(group, "length")


def align(layout, to: str):
    """Draws the button that makes planes so."""
    items = bpy.ops.isimp.align.get_rna_type().properties["to"].enum_items
    button = layout.operator("isimp.align", text=items[to].name)
    button.to = to
    return button


CLASSES = (ISIMP_PT_regularity,)
