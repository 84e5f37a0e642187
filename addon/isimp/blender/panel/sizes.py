"""Popover of sizes: a line for each, whose click selects its regions, and a known length that scales the scan."""

import bpy

from ..scene import store, targets
from ..texts import text
from .common import Popover

_MOST_LINES = 16


class ISIMP_PT_sizes(Popover, bpy.types.Panel):
    """Distances of parallel planes, diameters and angles of the result; a known length sets the scale"""

    bl_label = "Sizes"
    bl_ui_units_x = 16

    def draw(self, context):
        layout, sizes = self.prepare(context), sizes_of(context)
        column = layout.column(align=True)
        for number, size in enumerate(sizes[:_MOST_LINES]):
            icon = "CHECKMARK" if size[5] == "yes" else "RESTRICT_SELECT_OFF"
            column.operator("isimp.select_region", text=text.size(size), icon=icon, emboss=False).size = number
        if len(sizes) > _MOST_LINES:
            column.label(text=text.more_sizes(len(sizes) - _MOST_LINES))
        row = layout.row(align=True)
        row.prop(context.window_manager.isimp, "known_length", text="")
        row.operator("isimp.set_length").length = context.window_manager.isimp.known_length


def sizes_of(context) -> list:
    """Return the sizes of the polygons; empty before Mesh."""
    scan, problem = targets.seen(context)
    return [] if problem else store.numbers(scan).get("sizes", [])


CLASSES = (ISIMP_PT_sizes,)
