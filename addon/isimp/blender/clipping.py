"""The nearest and the farthest distance that a view shows, where a scan is too large or too small for them."""

import bpy

from . import targets

_ROOM = 2.5  # sizes of the scan that a view of all of it is deep
_NEAR = 0.002  # of the size: the nearest that a view of it needs to show


def hides(space, scan) -> bool:
    """Whether a 3D view that shows all of a scan would clip it."""
    size = scan.dimensions.length
    return space is not None and size > 0 and (_ROOM * size > space.clip_end or size < space.clip_start)


class ISIMP_OT_show_all(bpy.types.Operator):
    """Let the view show all of the scan, and look at it"""

    bl_idname = "isimp.show_all"
    bl_label = "Show All of the Scan"

    @classmethod
    def poll(cls, context):
        return targets.allows(cls, context) and context.area is not None and context.area.type == "VIEW_3D"

    def execute(self, context):
        scan, _ = targets.find(context)
        space, size = context.space_data, scan.dimensions.length
        if _ROOM * size > space.clip_end:
            space.clip_end = 4 * _ROOM * size
            space.clip_start = max(space.clip_start, _NEAR * size)
        elif size < space.clip_start:
            space.clip_start = _NEAR * size
        region = next((region for region in context.area.regions if region.type == "WINDOW"), None)
        if region is not None and not bpy.app.background and scan.visible_get():
            with context.temp_override(region=region):
                bpy.ops.view3d.view_selected()
        return {"FINISHED"}


CLASSES = (ISIMP_OT_show_all,)
