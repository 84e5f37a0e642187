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
        shown = display.is_shown(context)
        layout.operator("isimp.show_regions", text="Colours", icon="HIDE_OFF" if shown else "HIDE_ON", depress=shown)


CLASSES = (ISIMP_PT_regions,)
