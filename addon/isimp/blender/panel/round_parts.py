"""Panel of round parts: one line each, with the number of segments and a button that explodes the part."""

import bpy

from ...language import own, said
from ..scene import store, targets
from ..texts import text
from .common import SubPanel

_KINDS = {
    "cylinder": own("Cylinder, radius {radius}"),
    "cone": own("Cone, radius {radius}"),
    "sphere": own("Sphere, radius {radius}"),
    "revolution": own("Revolution, radius {radius}"),
    "extrusion": own("Extrusion, largest radius {radius}"),
}
_MOST_LINES = 12  # the largest parts are listed


class ISIMP_PT_round_parts(SubPanel, bpy.types.Panel):
    bl_label = "Round Parts"
    bl_parent_id = "ISIMP_PT_planes"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        """Return whether the scan has round parts, or is in Edit Mode, where faces can be made round."""
        return super().poll(context) and (bool(_parts(context)) or context.mode == "EDIT_MESH")

    def draw(self, context):
        layout = self.prepare(context)
        layout.operator("isimp.make_round", icon="MESH_CYLINDER")
        for part, (kind, radius, segments, _, face, *_) in enumerate(_parts(context)[:_MOST_LINES]):
            column = layout.column(align=True)
            told = said(_KINDS[kind], radius=text.in_scene(radius))
            column.operator("isimp.select_region", text=told, icon="RESTRICT_SELECT_OFF", emboss=False).part = part
            row = column.row(align=True)
            for change, icon in ((-1, "REMOVE"), (1, "ADD")):
                button = row.operator("isimp.round_segments", text="", icon=icon)
                button.face, button.segments = face, max(1, segments + change)
                if change < 0:
                    row.label(text=said("{number} segments", number=segments))
            row.operator("isimp.explode_round", icon="MOD_EXPLODE").face = face


def _parts(context) -> list:
    return store.numbers(targets.seen(context)[0]).get("round", [])


CLASSES = (ISIMP_PT_round_parts,)
