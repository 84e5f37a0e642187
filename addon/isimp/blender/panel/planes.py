"""Panel of planes: buttons that align the selected regions, and the settings of Regularise."""

import bpy

from ... import recipe as rcp
from ..controls import settings
from ..scene import store, targets
from ..texts import text
from . import sizes
from .common import Popover, SubPanel, draw_lines, side_by_side

_ROWS = (("level", "upright"), ("parallel", "perpendicular"), ("coplanar", "free"))


class ISIMP_PT_planes(SubPanel, bpy.types.Panel):
    bl_label = "Planes and Round Parts"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 2

    def draw(self, context):
        layout, panel = self.prepare(context), context.window_manager.isimp
        numbers, unit = store.numbers(targets.seen(context)[0]), context.scene.unit_settings
        column = layout.column(align=True)
        column.label(text="Planes of the chosen regions:")
        for names in _ROWS:
            row = side_by_side(context, column, *(name.title() for name in names), icons=False)
            for name in names:
                align(row, name).length = panel.align.length
        ticks = layout.column(align=True)
        ticks.use_property_split = False  # their names need the whole width
        ticks.prop(panel, "regularise_first")
        ticks.popover("ISIMP_PT_regularise", text="Regularise", icon="SNAP_ON")
        if sizes.sizes_of(context):
            ticks.popover("ISIMP_PT_sizes", text="Sizes", icon="DRIVER_DISTANCE")
        # Below the buttons, since the number of lines varies.
        draw_lines(context, layout, text.planes_line(numbers, unit.system, unit.scale_length), icon="FORWARD")


class ISIMP_PT_regularise(Popover, bpy.types.Panel):
    """How planes are snapped"""

    bl_label = "Regularise"

    def draw(self, context):
        layout, panel = self.prepare(context), context.window_manager.isimp
        _draw_limit(layout, panel.regularise)
        for name in ("angle", "up", "snap_sizes"):
            settings.draw(layout, rcp.Regularise, panel.regularise, name)
        layout.label(text="Planes set by hand:")
        _draw_limit(layout, panel.align)


def _draw_limit(layout, group) -> None:
    place = layout.column(align=True)
    place.use_property_split = False
    place.prop(group, "length_automatic")
    if not group.length_automatic:
        layout.prop(group, "length")


def align(layout, to: str):
    """Draws and returns a button that aligns planes."""
    items = bpy.ops.isimp.align.get_rna_type().properties["to"].enum_items
    button = layout.operator("isimp.align", text=items[to].name)
    button.to = to
    return button


CLASSES = (ISIMP_PT_planes, ISIMP_PT_regularise)
