"""Changes to the regions at the selected faces."""

import bpy

from .. import display
from .common import SubPanel


class ISIMP_PT_regions(SubPanel, bpy.types.Panel):
    bl_label = "Edit Regions"

    def draw(self, context):
        layout = self.prepare()
        row = layout.row(align=True)
        row.operator("isimp.add_proxy", text="Add", icon="ADD")
        row.operator("isimp.delete_proxy", text="Delete", icon="REMOVE")
        layout.operator("isimp.select_region", icon="RESTRICT_SELECT_OFF")
        shown = display.is_shown(context)
        row = layout.row(align=True)
        row.use_property_split = False
        row.operator("isimp.show_regions", text="Colours", icon="HIDE_OFF" if shown else "HIDE_ON", depress=shown)
        row.prop(context.window_manager.isimp, "overlay", text="Lines", icon="MESH_GRID", toggle=True)


CLASSES = (ISIMP_PT_regions,)
