"""Presets of the add-on, and presets of the user, which Blender stores as files."""

import bpy
from bl_operators.presets import AddPresetBase
from bpy.props import EnumProperty

from ... import recipe as rcp
from ...language import said
from ...recipe import presets
from ..scene import mesh_io, runtime, targets
from ..texts.text import in_scene
from . import settings

_FOLDER = "isimp"
_TITLE = "Presets"
# Settings that belong to one scan, not to a kind of scans: lengths, counts and their choice, weights.
_COUNTS = {"count_by", "proxies", "triangles", "tolerance", "bound"}
_LEFT = frozenset(_COUNTS | {"weights", "influence", "borders", "length"})


def _kept(cls) -> list:
    return [name for name in settings.names(cls) if name not in _LEFT]


class ISIMP_OT_preset(bpy.types.Operator):
    """Use the settings for a kind of scan"""

    bl_idname = "isimp.preset"
    bl_label = "Preset"

    name: EnumProperty(name="Preset", items=[(preset.name, preset.label, preset.about) for preset in presets.PRESETS])

    @classmethod
    def description(cls, context, properties):
        preset = presets.BY_NAME[properties.name]
        return f"{said(preset.label)}: {said(preset.about)}"

    def execute(self, context):
        preset = presets.BY_NAME[self.name]
        scanned = bool(preset.scanned_detail) and _is_scanned(context)
        partition = preset.partition_for(scanned)
        for step in (partition, preset.mesh, *([preset.regularise] if preset.regularise else [])):
            group = settings.group(context, type(step))
            for name in _kept(type(step)):
                if getattr(group, name) != getattr(step, name):
                    setattr(group, name, getattr(step, name))
        context.window_manager.isimp.regularise_first = preset.regularise is not None
        context.window_manager.isimp.kind = preset.name
        ISIMP_MT_presets.bl_label = _TITLE
        if scanned:
            feature = in_scene(settings.group(context, rcp.Partition).feature)
            self.report(
                {"INFO"},
                said(
                    "{preset}: the scan has noise, features below {length} are ignored",
                    preset=said(preset.label),
                    length=feature,
                ),
            )
        return {"FINISHED"}


def _is_scanned(context) -> bool:
    """Return whether the active scan has noise; False without a usable scan."""
    scan, problem = targets.find(context)
    if problem:
        return False
    try:
        return runtime.get().session.is_scanned(mesh_io.read(context, scan))
    except (ValueError, mesh_io.Unusable):
        return False


class ISIMP_MT_presets(bpy.types.Menu):
    """A style, and your own presets: store the settings as one"""

    bl_label = _TITLE
    preset_subdir = _FOLDER
    preset_operator = "script.execute_preset"

    def draw(self, context):
        for preset in presets.PRESETS:
            if not preset.is_kind:
                self.layout.operator("isimp.preset", text=preset.label, icon=preset.icon).name = preset.name
        if bpy.utils.preset_paths(_FOLDER):  # exists once the user has stored a preset
            self.layout.separator()
            self.draw_preset(context)
        self.layout.separator()
        self.layout.operator("isimp.preset_add", icon="ADD")
        chosen = ISIMP_MT_presets.bl_label
        if chosen != _TITLE:
            text = said("Remove {preset}", preset=chosen)
            self.layout.operator("isimp.preset_add", text=text, icon="REMOVE").remove_active = True


class ISIMP_OT_preset_add(AddPresetBase, bpy.types.Operator):
    """Store the settings as a preset of your own, or delete it"""

    bl_idname = "isimp.preset_add"
    bl_label = "Add Preset"
    preset_menu = "ISIMP_MT_presets"
    preset_subdir = _FOLDER
    preset_defines = ("shown = bpy.context.window_manager.isimp",)

    @property
    def preset_values(self):
        steps = (rcp.Partition, rcp.Mesh, rcp.Regularise)
        return [
            *(f"shown.{rcp.KINDS[cls]}.{name}" for cls in steps for name in _kept(cls)),
            "shown.regularise_first",
            "shown.kind",
        ]


def chosen(context) -> tuple:
    """Return (preset, whether all its settings are shown): the kind of the scan, else a preset with these settings.

    (None, False) if no preset was chosen and the settings belong to none, or are the defaults.
    """
    found = presets.BY_NAME.get(context.window_manager.isimp.kind)
    if found is not None:
        return found, _has(context, found)
    given = {preset: _has(context, preset) for preset in presets.PRESETS}
    found = next((preset for preset, has in given.items() if has and not _is_default(preset)), None)
    return found, found is not None


def _is_default(preset) -> bool:
    return (preset.partition, preset.mesh, preset.regularise) == (rcp.Partition(), rcp.Mesh(), None)


def _has(context, preset) -> bool:
    """Return whether the panel shows a preset's settings."""
    snaps = context.window_manager.isimp.regularise_first == (preset.regularise is not None)
    partitions = {preset.partition_for(scanned) for scanned in (False, True)}
    return snaps and any(_is_shown(context, step) for step in partitions) and _is_shown(context, preset.mesh)


def _is_shown(context, step) -> bool:
    shown = settings.to_step(type(step), settings.group(context, type(step)))
    return all(getattr(shown, name) == getattr(step, name) for name in _kept(type(step)))


def draw(context, layout) -> None:
    """Draws the row of kinds of scans. The chosen one is lit; a dot at its name stands for another setting."""
    found, is_pure = chosen(context)
    column = layout.column(align=True)
    head = column.row(align=True)
    name = said("What is it?") if found is None else said(found.label)
    head.label(text=name if found is None or is_pure else f"{name} \N{BULLET}")
    head.menu("ISIMP_MT_presets", text="", icon="DOWNARROW_HLT")
    kinds = [preset for preset in presets.PRESETS if preset.is_kind]
    row = column.grid_flow(row_major=True, columns=len(kinds), even_columns=True, align=True)
    for preset in kinds:
        row.operator("isimp.preset", text="", icon=preset.icon, depress=preset == found).name = preset.name


CLASSES = (ISIMP_OT_preset, ISIMP_MT_presets, ISIMP_OT_preset_add)
