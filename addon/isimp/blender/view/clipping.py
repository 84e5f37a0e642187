"""Detects a view whose clipping distances hide a part of the scan, and widens them."""

import bpy
from mathutils import Vector

from ...language import own, said
from ..scene import targets
from ..texts.text import in_scene

_ROOM = 2.5  # depth of a view of the whole scan, in sizes of the scan
_NEAR = 0.002  # start of clipping, as a share of the scan's size


_TEXTS = {"clip_end": own("Clips at {length}: show all"), "clip_start": own("Clips below {length}: show all")}


def hides(space, scan) -> str:
    """Return the limit that clips the scan in a 3D view: "clip_end" or "clip_start"; empty if none does."""
    size = scan.dimensions.length
    if space is None or size <= 0:
        return ""
    if _ROOM * size > space.clip_end:
        return "clip_end"
    return "clip_start" if size < space.clip_start else ""


def told(space, scan) -> str:
    """Return the text of the button that widens the limit, with the limit in the scene's units."""
    limit = hides(space, scan)
    return said(_TEXTS[limit], length=in_scene(getattr(space, limit)))


class ISIMP_OT_show_all(bpy.types.Operator):
    """Widen the clipping distances of the view, and frame the scan"""

    bl_idname = "isimp.show_all"
    bl_label = "Show All of the Scan"

    @classmethod
    def poll(cls, context):
        return targets.allows(cls, context) and context.area is not None and context.area.type == "VIEW_3D"

    def execute(self, context):
        scan, _ = targets.find(context)
        space, size = context.space_data, scan.dimensions.length
        limit = hides(space, scan)
        if limit == "clip_end":
            space.clip_end = 4 * _ROOM * size
            space.clip_start = max(space.clip_start, _NEAR * size)
        elif limit == "clip_start":
            space.clip_start = _NEAR * size
        if scan.visible_get():
            frame(context, context.area)
        return {"FINISHED"}


def frame(context, area) -> None:
    """Frames the selected objects in a 3D view, as Numpad . does, but with their corners inside of the view."""
    region = next((region for region in area.regions if region.type == "WINDOW"), None)
    if region is None or bpy.app.background:
        return
    preferences = context.preferences.view
    smooth, preferences.smooth_view = preferences.smooth_view, 0  # else the view goes on to its old distance
    try:
        with context.temp_override(area=area, region=region):
            bpy.ops.view3d.view_selected()
    finally:
        preferences.smooth_view = smooth
    corners = [obj.matrix_world @ Vector(corner) for obj in context.selected_objects for corner in obj.bound_box]
    if corners:
        sides = Vector(max(each) - min(each) for each in zip(*corners, strict=True))
        area.spaces.active.region_3d.view_distance *= sides.length / max(*sides, 1e-30)


CLASSES = (ISIMP_OT_show_all,)
