"""The Openings tool: shows closed openings; a click keeps an opening open, another click closes it again."""

import bpy
import numpy as np
from bpy.props import StringProperty

from ... import openings
from ...language import said
from .. import reading
from ..scene import mesh_io, runtime, store, targets
from ..texts import text
from ..view import overlay
from . import point, under

_COVER = 0.45  # opacity of the preview of a closed opening
_CLOSED, _KEPT = (1.0, 0.45, 0.1, 1.0), (0.2, 0.85, 0.35, 1.0)


def found(context, scan, wait: bool = False) -> list | None:
    """Return the openings of the visible regions; None while they are not cached.

    wait: computes them if needed. Raises Unusable, StepFailed or ValueError.
    """
    current, key = runtime.get(), (scan.name, mesh_io.state_of(scan))
    if current.openings is not None and current.openings[0] == key:
        return current.openings[1]
    recipe = store.load(scan)
    if current.running is not None or not recipe:
        return None
    recipe = recipe.without_mesh()
    if not (wait or mesh_io.has_shape(scan)):
        return None
    arrays = reading.read(context, scan, recipe.layers(), again=not wait)
    outcome = current.session.known(arrays, recipe)
    if outcome is None and wait:
        current.stop_sketching()
        outcome = current.session.replay(arrays, recipe)
    if outcome is None:
        return None
    current.openings = (key, current.session.openings(arrays, outcome))
    return current.openings[1]


def under_mouse(context, scan, all_found, at) -> int | None:
    """Return the index of the opening under a point of the viewport, or None."""
    region = context.region
    to_view = np.array(context.region_data.perspective_matrix) @ mesh_io.place_matrix(scan)
    return openings.nearest(all_found, to_view, (region.width, region.height), at)


def show(context, scan, all_found, chosen, at) -> None:
    """Draws all openings, and highlights and describes the one under the mouse."""
    current = runtime.get()
    hover = current.hover = under.Hover(scan.name, -1, at=at, through=True)
    for kept, color in ((False, _CLOSED), (True, _KEPT)):
        some = [opening for opening in all_found if opening["kept"] == kept]
        hover.lines.append((openings.lines(some), color, 2.0))
    if chosen is not None:
        opening = all_found[chosen]
        hover.lines.append((openings.lines([opening]), _KEPT if opening["kept"] else _CLOSED, 6.0))
        if opening["kept"]:  # previews the effect of a click
            hover.fills.append((openings.cover(opening), (*_CLOSED[:3], _COVER)))
        unit = context.scene.unit_settings
        hover.text = openings.told(opening, text.length(opening["length"], unit.system, unit.scale_length))
    overlay.redraw()


def _scan(context):
    """Return the active scan with regions, if the mouse is in the viewport; else None."""
    if not point.in_viewport(context):
        return None
    scan, problem = targets.find(context)
    seen = not problem and context.view_layer.objects.active == scan and not targets.needs_regions(scan)
    return scan if seen else None


class ISIMP_OT_hover_opening(bpy.types.Operator):
    """Show the openings that Partition closed, and describe the one under the mouse"""

    bl_idname = "isimp.hover_opening"
    bl_label = "Highlight Opening"
    bl_options = {"INTERNAL"}

    keys: StringProperty(name="Keys", description="Text of the status bar", options={"SKIP_SAVE"})

    def invoke(self, context, event):
        scan = _scan(context)
        if scan is None:
            return {"PASS_THROUGH"}
        all_found = found(context, scan)
        if all_found is None:
            overlay.tell(context, said("Click: find the closed openings"))
            return {"PASS_THROUGH"}
        at = (event.mouse_region_x, event.mouse_region_y)
        show(context, scan, all_found, under_mouse(context, scan, all_found, at), at)
        overlay.tell(context, self.keys if all_found else said("Nothing was closed"))
        return {"PASS_THROUGH"}


class ISIMP_OT_toggle_opening(point.ModalTool, bpy.types.Operator):
    """Keep the opening under the mouse open, or close it again"""

    bl_idname = "isimp.toggle_opening"
    bl_label = "Keep or Close Opening"

    def start(self, context, event):
        scan = _scan(context)
        if scan is None:
            self.report({"INFO"}, point.nothing_here())
            return {"CANCELLED"}
        all_found = found(context, scan, wait=True) or []
        chosen = under_mouse(context, scan, all_found, (event.mouse_region_x, event.mouse_region_y))
        if chosen is None:
            return point.miss()
        opening = all_found[chosen]
        point.do("isimp.keep_opening", place=opening["center"], close=opening["kept"])
        return {"FINISHED"}


CLASSES = (ISIMP_OT_hover_opening, ISIMP_OT_toggle_opening)
