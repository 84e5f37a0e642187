"""The main panel: scan, kinds of scans, number of regions, Partition, Mesh and the report.

The rows above a button are drawn before and after the button is pressed, so that it does not move under the mouse. The
report has a fixed height too, since buttons of edits are below it. Each group of the panel is one function.
"""

import bpy

from ... import messages
from ... import recipe as rcp
from ...language import said
from .. import translations
from ..controls import presets, settings
from ..scene import result, runtime, store, targets
from ..texts import text
from ..view import clipping, overlay
from .common import Panel, draw_lines, letters, side_by_side


class ISIMP_PT_main(Panel, bpy.types.Panel):
    bl_label = "iSimp"

    def draw(self, context):
        layout = self.prepare(context)
        scan, problem = targets.seen(context)
        broken = targets.install_problem()
        if broken:
            draw_lines(context, layout, broken, icon="ERROR")
        if problem:
            if problem != broken:
                draw_lines(context, layout, problem, icon="INFO")
            return
        numbers, panel = store.numbers(scan), context.window_manager.isimp
        _draw_head(context, layout, scan, numbers)
        presets.draw(context, layout)
        _draw_count(layout, panel.partition)
        _draw_partition(context, layout, scan, numbers, panel)
        _draw_mesh(context, layout, numbers, panel)
        _draw_report(context, layout, scan, numbers)


def _draw_head(context, layout, scan, numbers) -> None:
    """Draws the name of the active object and the scan's size: two lines before and after Partition."""
    column = layout.column(align=True)
    active = context.view_layer.objects.active
    is_scan = active == scan or active is None
    name = text.shortened((scan if is_scan else active).name, letters(context) - 3)
    column.label(text=name, icon="MESH_DATA" if is_scan else "MESH_ICOSPHERE")
    column.label(text=text.scan_lines(scan.data, numbers)[0], icon="BLANK1")
    if clipping.hides(context.space_data, scan):
        column.operator("isimp.show_all", text=clipping.told(context.space_data, scan), icon="ERROR")


def _draw_count(layout, partition) -> None:
    """Draws the way to choose the number of regions, and its field: two rows for each way."""
    column = layout.column(align=True)
    column.use_property_split = False
    ways = column.row(align=True)
    for way in partition.bl_rna.properties["way"].enum_items:
        ways.prop_enum(partition, "way", way.identifier, text=way.name, text_ctxt=translations.CONTEXT)
    field = column.row(align=True)
    if partition.count_by in ("proxies", "triangles"):
        field.prop(partition, partition.count_by, text="")
        return
    field.prop(partition, "feature", text="")
    field.prop(partition, "coarseness", text="", slider=True)


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
        text="Start Over" if edits else "Partition",
        icon="MOD_EXPLODE",
        depress="regions" not in numbers,  # highlights the next thing to do
    )
    settings.give(rcp.Partition, panel.partition, operator)
    line = place.row(align=True)
    line.label(text=_regions_line(numbers, edits), icon="FORWARD" if "regions" in numbers else "BLANK1")
    if "regions" in numbers:
        line.popover("ISIMP_PT_steps", text="", icon="PRESET")


def _regions_line(numbers, edits: int) -> str:
    if "regions" not in numbers:
        return said("No regions yet")
    more = f" · {messages.count(edits, 'edit')}" if edits else ""
    return messages.count(numbers["regions"], "region") + more


def _draw_mesh(context, layout, numbers, panel) -> None:
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
    give_mesh(panel, operator)
    button.menu("ISIMP_MT_mesh", text="", icon="DOWNARROW_HLT")
    if "regions" in numbers:
        row = place.row(align=True)
        row.operator("isimp.swap", text="Swap", icon="ARROW_LEFTRIGHT")
        row.operator("isimp.compare", text="Compare", icon="IMAGE_ALPHA")
        if panel.kind == "room":
            place.operator("isimp.show_furniture", icon="GHOST_DISABLED")
        row = place.row(align=True)
        row.popover("ISIMP_PT_lods", text="LODs...", icon="MOD_DECIM")
        row.menu("ISIMP_MT_export", text="Export...")
        row.menu("ISIMP_MT_colour", text="", icon="COLOR")


def give_mesh(panel, operator) -> None:
    """Sets the panel's settings on a button that makes polygons."""
    settings.give(rcp.Mesh, panel.mesh, operator)
    operator.keep_texture, operator.regularise = panel.keep_texture, panel.regularise_first


class ISIMP_MT_mesh(bpy.types.Menu):
    """Further actions for the regions, the result and flat faces"""

    bl_label = "Mesh"

    def draw(self, context):
        layout, panel = self.layout, context.window_manager.isimp
        give_mesh(panel, layout.operator("isimp.make_editable", icon="EDITMODE_HLT"))
        layout.operator("isimp.keep_lod", icon="MOD_DECIM")
        layout.operator("isimp.colliders", icon="MESH_ICOSPHERE")
        layout.separator()
        layout.operator("isimp.merge_flat", icon="MESH_PLANE")


def _draw_progress(place, running) -> None:
    """Draws the progress bar, as high as the button and the line that it replaces."""
    share, said = running.progress()
    row = place.split(factor=0.5, align=True)
    row.scale_y = 1.4
    if hasattr(row, "progress"):
        row.progress(factor=share, text=f"{share:.0%}")
    else:
        row.split(factor=max(0.02, min(1.0, share))).operator("isimp.stop", text=" ", depress=True)
    if running.shown is None:  # a write must not be stopped half-way
        row.operator("isimp.stop", text="Stop (Esc)", icon="CANCEL")
    place.label(text=text.short_progress(said), icon="SORTTIME")


def _draw_report(context, layout, scan, numbers) -> None:
    """Draws the report of Mesh, repairs, notes and warnings, below the buttons because the number of lines varies."""
    if "regions" in numbers:
        parts = text.round_parts(numbers, _asks_for_round_parts(context, scan))
        draw_lines(context, layout, parts, icon="MESH_CYLINDER")
    _draw_counts(context, layout, scan, numbers)
    _draw_not_flat(context, layout, numbers)
    defects = text.problems(numbers)
    if moved := messages.moved(numbers):
        layout.operator("isimp.choose_moved", text=moved, icon="INFO")
    magenta = messages.magenta(len(overlay.problem_faces(context, scan)))
    if defects:
        layout.operator("isimp.show_problems", text=defects, icon="ERROR").kind = "DEFECTIVE"
    elif magenta:
        layout.operator("isimp.choose_problems", text=magenta, icon="ERROR")
    _draw_notes(context, layout, scan, numbers)


def _draw_notes(context, layout, scan, numbers) -> None:
    """Draws one line with the number of notes, which opens, and the notes below it."""
    found = _notes(context, scan, numbers)
    if not found:
        return
    panel = context.window_manager.isimp
    row = layout.row(align=True)
    row.use_property_split, row.alignment = False, "LEFT"
    icon = "ERROR" if any(icon == "ERROR" for _, icon in found) else "INFO"
    row.prop(panel, "notes", text=messages.count(len(found), "note"), icon=icon, emboss=False, toggle=True)
    if not panel.notes:
        return
    for line, icon in found:
        draw_lines(context, layout, line, icon=icon)
    if text.has_openings(numbers) and text.describes(scan.data, numbers):
        choose = layout.operator("wm.tool_set_by_id", text="Choose Openings", icon="MESH_CIRCLE")
        choose.name = f"isimp.opening_tool.{context.mode.lower()}"


def _notes(context, scan, numbers) -> list:
    """Return (line, icon) of repairs, closed openings, ignored faces, released planes, and lost detail."""
    unit = context.scene.unit_settings
    why = "" if runtime.get().running is not None else result.why_kept_here(context, scan)
    lines = [messages.is_kept(why)] if why else []
    if text.describes(scan.data, numbers):
        shape = text.scan_lines(scan.data, numbers)[1] if numbers["components"] > 1 or not numbers["closed"] else ""
        lines += [shape, text.planes_let_go(numbers), text.left_out(numbers)]
        lines += text.repair_lines(numbers, unit.system, unit.scale_length)
    found = [(line, "INFO") for line in (*lines, *targets.notes(scan)) if line]
    return found + [(warning, "ERROR") for warning in text.lost_detail(scan, unit)]


def _asks_for_round_parts(context, scan) -> bool:
    """Return whether the user expects round parts. Buildings, whose planes become regular, seldom have any."""
    recipe = store.load(scan)
    steps = [step for _, step in recipe.active()] if recipe is not None else []
    if context.window_manager.isimp.regularise_first or any(isinstance(step, rcp.Regularise) for step in steps):
        return False
    found = [step for step in steps if isinstance(step, rcp.Partition)]
    return bool(found) and found[-1].curved


def _draw_not_flat(context, layout, numbers) -> None:
    """Draws how many polygons Mesh left bent in spite of Exactly Flat Faces, with a button that makes them flat."""
    told = text.not_flat(numbers)
    if not told:
        return
    draw_lines(context, layout, told, icon="INFO")
    row = side_by_side(context, layout, "Flatten Anyway", "Show")
    give_mesh(context.window_manager.isimp, row.operator("isimp.flatten", icon="MESH_PLANE"))
    row.operator("isimp.show_problems", text="Show", icon="RESTRICT_SELECT_OFF").kind = "BENT"


def _draw_counts(context, layout, scan, numbers) -> None:
    """Draws the expected or present polygons, in the same number of rows before an edit, after it, and after Mesh."""
    if "regions" not in numbers:
        return
    unit, width = context.scene.unit_settings, letters(context)
    column = layout.column(align=True)
    made, is_new = overlay.reported(context, scan)
    if not is_new and ("polygons" in numbers or "expected" in numbers):
        made, is_new = {}, True
    column.active = is_new
    panel = context.window_manager.isimp
    snaps = panel.mesh.planar or panel.mesh.convex or panel.regularise_first
    first, *rows = text.report_rows(numbers, unit.system, unit.scale_length, made, width, snaps)
    # A button without a frame, since labels have no tooltip.
    told = column.row(align=True)
    told.alignment = "LEFT"
    told.operator("isimp.report", text=first[0], icon=first[1], emboss=False)
    for line, icon, alert in rows:
        row = column.row(align=True)
        row.alert = alert
        row.label(text=line, icon=icon)


CLASSES = (ISIMP_PT_main, ISIMP_MT_mesh)
