"""Edits of regions: at the selected faces, or at places chosen by the error."""

import bpy

from ... import messages
from ... import recipe as rcp
from ...language import said
from .. import pointed, settings, store, targets
from .common import SubPanel, side_by_side


class ISIMP_PT_regions(SubPanel, bpy.types.Panel):
    bl_label = "Edit Regions"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 1

    def draw(self, context):
        layout, panel = self.prepare(context), context.window_manager.isimp
        layout.label(text=_chosen(targets.seen(context)[0]), icon="RESTRICT_SELECT_OFF")
        column = layout.column(align=True)
        _row(context, column, ("isimp.add_proxy", "Add", "ADD"), ("isimp.delete_proxy", "Delete", "REMOVE"))
        _row(context, column, ("isimp.split", "Split", "MOD_BOOLEAN"), ("isimp.merge", "Merge", "AUTOMERGE_ON"))
        sizes = _row(
            context, column, ("isimp.grow", "Grow", "FULLSCREEN_ENTER"), ("isimp.grow", "Shrink", "FULLSCREEN_EXIT")
        )
        sizes[1].shrink = True
        column.operator("isimp.paint_faces", text="From Selection", icon="BRUSH_DATA")
        anew = column.operator("isimp.partition", text="Repartition", icon="MOD_EXPLODE")
        settings.give(rcp.Partition, panel.partition, anew)
        anew.part = True
        column.operator("isimp.even_borders", icon="MOD_SMOOTH")
        column.operator("isimp.select_region", icon="RESTRICT_SELECT_OFF")
        row = column.row(align=True)
        for by, name in (("SIZE", "Small"), ("FLATNESS", "Bent"), ("DIRECTION", "Up")):
            row.operator("isimp.select_by", text=name).by = by
        column = layout.column(align=True)
        locked = store.numbers(targets.seen(context)[0]).get("locked", 0)
        column.label(text=messages.locked({"locked": locked}), icon="LOCKED" if locked else "UNLOCKED")
        locks = _row(context, column, ("isimp.lock", "Lock", "LOCKED"), ("isimp.lock", "Unlock", "UNLOCKED"))
        locks[1].unlock = True


def _chosen(scan) -> str:
    """What the buttons act on."""
    if scan.mode == "EDIT":
        return said("{faces} selected", faces=messages.count(scan.data.total_face_sel, "face"))
    number = pointed.region(scan)
    return said("Region {number}, clicked last", number=number) if number >= 0 else said("Alt-click a region (tool: T)")


class ISIMP_PT_heuristics(SubPanel, bpy.types.Panel):
    bl_label = "By Error"
    bl_parent_id = "ISIMP_PT_regions"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, panel = self.prepare(context), context.window_manager.isimp
        layout.prop(panel, "times")
        column = layout.column(align=True)
        for name in ("add_worst", "delete_least", "merge_cheapest"):
            column.operator(f"isimp.{name}").times = panel.times
        column.operator("isimp.improve")


def _row(context, column, *buttons) -> list:
    row = side_by_side(context, column)
    return [row.operator(operator, text=name, icon=icon) for operator, name, icon in buttons]


CLASSES = (ISIMP_PT_regions, ISIMP_PT_heuristics)
