"""The main panel: the scan, the settings of the count, Partition, Mesh and the report.

The rows above a button are drawn before and after the button is pressed, so that it does not move under the mouse. The
report holds its room too, as buttons of edits stand below it.
"""

import dataclasses

import bpy

from ... import messages
from ... import recipe as rcp
from ...language import said
from .. import clipping, overlay, presets, result, runtime, settings, store, targets, text, texture, translations
from .common import Panel, draw_lines, is_narrow, letters


class ISIMP_PT_main(Panel, bpy.types.Panel):
    bl_label = "iSimp"

    def draw(self, context):
        layout = self.prepare(context)
        scan, problem = targets.seen(context)
        if problem:
            draw_lines(context, layout, problem, icon="INFO")
            return
        numbers, panel = store.numbers(scan), context.window_manager.isimp
        _draw_head(context, layout, scan, numbers)
        presets.draw(context, layout)
        _draw_count(context, layout, panel)
        _draw_partition(context, layout, scan, numbers, panel)
        _draw_mesh(context, layout, scan, numbers, panel)
        _draw_report(context, layout, scan, numbers)


def _draw_head(context, layout, scan, numbers) -> None:
    """Draws the scan's name and size: three lines, before and after Partition."""
    column = layout.column(align=True)
    active = context.view_layer.objects.active
    column.label(text=scan.name if active == scan else said("{name} (its result)", name=scan.name), icon="MESH_DATA")
    for line in text.scan_lines(scan.data, numbers):
        column.label(text=line, icon="BLANK1")
    if clipping.hides(context.space_data, scan):
        column.operator("isimp.show_all", text=clipping.told(context.space_data, scan), icon="ERROR")


def _draw_count(context, layout, panel) -> None:
    partition = panel.partition
    ways = layout.grid_flow(row_major=True, columns=1 if is_narrow(context) else 2, align=True)
    ways.use_property_split = False
    items = partition.bl_rna.properties["count_by"].enum_items
    for name in rcp.COUNTS:  # Blender translates some of the words otherwise
        ways.prop_enum(partition, "count_by", name, text=items[name].name, text_ctxt=translations.CONTEXT)
    row = layout.row(align=True)
    settings.draw(row, rcp.Partition, partition, partition.count_by or "detail")  # which another version may not say
    row.prop(panel, "live", text="", icon="PLAY")


def _draw_partition(context, layout, scan, numbers, panel) -> None:
    running = runtime.get().running
    place = layout.column(align=True)
    if running is not None and not running.recipe.ends_in_mesh():
        _draw_progress(place, running)
        return
    edits = messages.hand_edits(store.load(scan), panel.regularise_first)
    button = place.row(align=True)
    button.scale_y = 1.4
    operator = button.operator(
        "isimp.partition",
        text="Partition Anew" if edits else "Partition",
        icon="MOD_EXPLODE",
        depress="regions" not in numbers,  # what to do next has the accent
    )
    settings.give(rcp.Partition, panel.partition, operator)
    place.label(text=_regions_line(numbers, edits), icon="FORWARD" if "regions" in numbers else "BLANK1")


def _regions_line(numbers, edits: int) -> str:
    if "regions" not in numbers:
        return said("No regions yet")
    more = f" · {messages.count(edits, 'edit')}" if edits else ""
    return messages.count(numbers["regions"], "region") + more


def _draw_mesh(context, layout, scan, numbers, panel) -> None:
    running = runtime.get().running
    place = layout.column(align=True)
    if running is not None and running.recipe.ends_in_mesh():
        _draw_progress(place, running)
        return
    button = place.row(align=True)
    button.scale_y = 1.4
    operator = button.operator(
        "isimp.mesh", icon="MESH_ICOSPHERE", depress="regions" in numbers and "polygons" not in numbers
    )
    settings.give(rcp.Mesh, panel.mesh, operator)
    operator.keep_texture, operator.regularise = panel.keep_texture, panel.regularise_first
    row = place.row(align=True)
    row.use_property_split = False
    row.operator("isimp.swap", text="Swap", icon="ARROW_LEFTRIGHT")
    row.operator("isimp.compare", text="Compare", icon="IMAGE_ALPHA")
    if texture.is_textured(scan):
        row = place.row(align=True)
        row.use_property_split = False
        row.prop(panel, "keep_texture", icon="TEXTURE", toggle=True)


def _draw_progress(place, running) -> None:
    """Draws the progress bar, as high as the button and the line that it replaces."""
    share, said = running.progress()
    row = place.split(factor=0.5, align=True)
    row.scale_y = 1.4
    if hasattr(row, "progress"):
        row.progress(factor=share, text=f"{share:.0%}")
    else:
        row.split(factor=max(0.02, min(1.0, share))).operator("isimp.stop", text=" ", depress=True)
    if running.shown is None:  # writing takes a moment, and must not be stopped half way
        row.operator("isimp.stop", text="Stop (Esc)", icon="CANCEL")
    place.label(text=text.short_progress(said), icon="SORTTIME")


def _draw_report(context, layout, scan, numbers) -> None:
    """Draws the report of Mesh, repairs, notes and warnings; below the buttons, because their number changes."""
    unit = context.scene.unit_settings
    _draw_counts(context, layout, scan, numbers)
    defects = text.problems(numbers)
    if defects:
        layout.operator("isimp.show_problems", text=defects, icon="ERROR").kind = "DEFECTIVE"
    why = "" if runtime.get().running is not None else result.why_kept_here(context, scan)
    if why:
        draw_lines(context, layout, messages.is_kept(why), icon="INFO")
    if not text.describes(scan.data, numbers):
        numbers = {}
    for line in text.repair_lines(numbers, unit.system, unit.scale_length):
        draw_lines(context, layout, line, icon="CHECKMARK")
    if text.has_openings(numbers):
        choose = layout.operator("wm.tool_set_by_id", text="Choose Openings", icon="MESH_CIRCLE")
        choose.name = f"isimp.opening_tool.{context.mode.lower()}"
    left_out = text.left_out(numbers)
    for line in (*([left_out] if left_out else ()), *targets.notes(scan)):
        draw_lines(context, layout, line, icon="INFO")
    for warning in text.lost_detail(scan, unit):
        draw_lines(context, layout, warning, icon="ERROR")
    if store.kept(scan) is not None:
        layout.operator("isimp.take_back", icon="LOOP_BACK")
    made = targets.result_of(context.scene, scan) if texture.is_textured(scan) else None
    if made is not None:
        _draw_texture(layout.column(), scan, made)


def _draw_counts(context, layout, scan, numbers) -> None:
    """Draws what Mesh will make, or has made: as many rows before an edit, after it, and after Mesh."""
    if "regions" not in numbers:
        return
    unit, width = context.scene.unit_settings, letters(context)
    column = layout.column(align=True)
    made, is_new = overlay.reported(context, scan)
    if not is_new and ("polygons" in numbers or "expected" in numbers):
        made, is_new = {}, True
    column.active = is_new
    panel = context.window_manager.isimp
    snaps = panel.mesh.planar or panel.regularise_first
    for line, icon, alert in text.report_rows(numbers, unit.system, unit.scale_length, made, width, snaps):
        row = column.row(align=True)
        row.alert = alert
        row.label(text=line, icon=icon)
    place = column.row(align=True)
    place.enabled = numbers.get("polygons", 0) > numbers["regions"]
    divided = place.operator("isimp.show_problems", text="Select Divided Regions", icon="RESTRICT_SELECT_OFF")
    divided.kind = "DIVIDED"


def _draw_texture(layout, scan, shown_on) -> None:
    """Draws the buttons that make the texture again: with the same settings, or with one changed."""
    recipe = store.load(scan)
    step = (recipe and recipe.texture()) or rcp.Texture()

    def button(place, label: str, icon: str = "NONE", pressed: bool = False, **changed) -> None:
        made = place.operator("isimp.texture", text=label, icon=icon, depress=pressed)
        settings.give(rcp.Texture, dataclasses.replace(step, **changed), made)

    def turned(place, label: str, name: str) -> None:
        on = getattr(step, name)
        button(place, label, "CHECKBOX_HLT" if on else "CHECKBOX_DEHLT", **{name: not on})

    button(layout, "Make Texture Again", "TEXTURE")
    width = texture.image_width(shown_on) if shown_on is not None else 0
    if width:
        row = layout.row(align=True)
        smaller, larger = max(width // 2, 16), min(2 * width, 16384)
        button(row, f"{smaller:,} px", size=smaller, tiles=0)
        button(row, "Like the Scan", pressed=not step.size, size=0, tiles=0)
        button(row, f"{larger:,} px", size=larger, tiles=0)
    row = layout.row(align=True)
    turned(row, "Ambient Occlusion", "occlusion")
    turned(row, "Height Map", "height")
    if len(scan.material_slots) > 1:
        turned(layout, "Keep Materials Apart", "materials")


class ISIMP_PT_options(Panel, bpy.types.Panel):
    bl_label = "Partition Options"
    bl_parent_id = "ISIMP_PT_main"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 2

    @classmethod
    def poll(cls, context):
        return not targets.seen(context)[1]

    def draw(self, context):
        layout, partition = self.prepare(context), context.window_manager.isimp.partition
        for name in ("adaptivity", "smooth"):
            layout.prop(partition, name, slider=True)
        layout.prop(partition, "symmetry")
        settings.draw(layout, rcp.Partition, partition, "leave_out")
        ticks = layout.column(align=True)
        ticks.use_property_split = False  # their names need the whole width
        ticks.prop(partition, "close_openings")
        if partition.count_by != "proxies":
            ticks.prop(partition, "snap")
            ticks.prop(partition, "noise_automatic", text="Automatic Noise")
            if not partition.noise_automatic:
                layout.prop(partition, "noise_length")
        layout.prop(partition, "weights", icon="GROUP_VERTEX")
        if partition.weights:
            layout.prop(partition, "influence", slider=True)
        layout.prop(partition, "method")
        if partition.method != "hierarchy":  # which starts from no faces
            for name in ("seeding", "seed", "iterations"):
                layout.prop(partition, name)


class ISIMP_PT_borders(Panel, bpy.types.Panel):
    bl_label = "Barriers"
    bl_parent_id = "ISIMP_PT_options"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, partition = self.prepare(context), context.window_manager.isimp.partition
        column = layout.column(heading="Marked", align=True)
        column.prop(partition, "seams")
        column.prop(partition, "sharp")
        column.prop(partition, "materials")
        if bpy.app.version >= (3, 6, 0):  # before, nothing tells of them
            column.prop(partition, "face_sets")
        settings.draw(layout, rcp.Partition, partition, "angle")
        layout.prop(partition, "borders", icon="SPREADSHEET")


CLASSES = (ISIMP_PT_main, ISIMP_PT_options, ISIMP_PT_borders)
