"""Panels and menus with edits: of all regions, and at chosen regions or selected faces."""

import bpy

from ... import messages
from ... import recipe as rcp
from ...language import said
from ..controls import settings
from ..scene import pointed, store, targets
from .common import SubPanel, side_by_side


class ISIMP_PT_clean_up(SubPanel, bpy.types.Panel):
    bl_label = "Clean Up"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 0

    def draw(self, context):
        layout, panel = self.prepare(context), context.window_manager.isimp
        column = layout.column(align=True)
        column.operator("isimp.even_borders", text="Even Borders", icon="MOD_SMOOTH")
        settings.give(rcp.Regularise, panel.regularise, column.operator("isimp.regularise", icon="SNAP_ON"))
        column.operator("isimp.merge_slivers", icon="AUTOMERGE_ON")
        column.operator("isimp.show_furniture", icon="GHOST_DISABLED")


class ISIMP_PT_regions(SubPanel, bpy.types.Panel):
    bl_label = "Regions"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 1

    def draw(self, context):
        layout, scan = self.prepare(context), targets.seen(context)[0]
        layout.label(text=_chosen(scan), icon="RESTRICT_SELECT_OFF")
        column = layout.column(align=True)
        _row(context, column, ("isimp.add_proxy", "Add", "ADD"), ("isimp.delete_proxy", "Delete", "REMOVE"))
        _row(context, column, ("isimp.split", "Split", "MOD_BOOLEAN"), ("isimp.merge", "Merge", "AUTOMERGE_ON"))
        sizes = _row(
            context, column, ("isimp.grow", "Grow", "FULLSCREEN_ENTER"), ("isimp.grow", "Shrink", "FULLSCREEN_EXIT")
        )
        sizes[1].shrink = True
        locks = _row(context, column, ("isimp.lock", "Lock", "LOCKED"), ("isimp.lock", "Unlock", "UNLOCKED"))
        locks[1].unlock = True
        column.operator("isimp.leave_out", text="Leave Out", icon="GHOST_DISABLED")
        column.menu("ISIMP_MT_select", text="Select")
        last = (store.load(scan) or rcp.Recipe()).whole()[1]
        if last is not None and last.more:
            row = layout.row(align=True)
            row.label(
                text=said("More regions in {parts}", parts=messages.count(len(last.more), "part")), icon="ZOOM_IN"
            )
            button = row.operator("isimp.more_here", text="", icon="X")
            button.place, button.size = last.more[-1][:3], 0.0
        locked = store.numbers(scan).get("locked", 0)
        if locked:
            layout.label(text=messages.locked({"locked": locked}), icon="LOCKED")
        away = store.numbers(scan).get("regions_left_out", 0)
        if away:
            layout.label(text=messages.left_out({"regions_left_out": away}), icon="GHOST_DISABLED")


def _chosen(scan) -> str:
    """Return the text that names the target of the buttons."""
    if scan.mode == "EDIT":
        return said("{faces} selected", faces=messages.count(scan.data.total_face_sel, "face"))
    number, count = pointed.region(scan), len(pointed.faces(scan))
    if count > 1:
        return said("{regions} chosen", regions=messages.count(count, "region"))
    if number < 0:
        return said("Shift-click a region")
    return said("Region {number}, clicked last", number=number)


def _row(context, column, *buttons) -> list:
    row = side_by_side(context, column, *(name for _, name, _ in buttons))
    return [row.operator(operator, text=name, icon=icon) for operator, name, icon in buttons]


_SELECT_BY = (
    ("SIZE", "Select Small"),
    ("FLATNESS", "Select Bent"),
    ("DIRECTION", "Select Level"),
    ("CLUTTER", "Select Clutter"),
)


class ISIMP_MT_select(bpy.types.Menu):
    """Select regions by size, flatness, direction or number of polygons, or make one of the selected faces"""

    bl_label = "Select"

    def draw(self, context):
        self.layout.operator("isimp.select_region", icon="RESTRICT_SELECT_OFF")
        for by, name in _SELECT_BY:
            self.layout.operator("isimp.select_by", text=name).by = by
        self.layout.separator()
        self.layout.operator("isimp.paint_faces", text="From Selection", icon="BRUSH_DATA")


CLASSES = (ISIMP_PT_clean_up, ISIMP_PT_regions, ISIMP_MT_select)
