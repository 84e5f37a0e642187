"""Presets of the add-on, and presets of the user, which Blender stores as files."""

from pathlib import Path

import bpy
import bpy.utils.previews
from bl_operators.presets import AddPresetBase
from bpy.props import EnumProperty

from ... import presets
from ... import recipe as rcp
from ...language import own, said
from ..scene import mesh_io, runtime, targets
from ..texts.text import in_scene
from . import settings

_FOLDER = "isimp"
_TITLE, _DEFAULTS = "Presets", own("No preset (defaults)")
# Titles of the menu that are not presets of the user.
_OURS = {_TITLE, _DEFAULTS, *(preset.label for preset in presets.PRESETS)}
_PICTURES = Path(__file__).parents[2] / "pictures"
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
        return presets.BY_NAME[properties.name].about

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
        ISIMP_MT_presets.bl_label = preset.label
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
    """Presets for kinds of scans, and your own presets"""

    bl_label = _TITLE
    preset_subdir = _FOLDER
    preset_operator = "script.execute_preset"

    def draw(self, context):
        for preset in presets.PRESETS:
            self.layout.operator("isimp.preset", text=preset.label).name = preset.name
        if bpy.utils.preset_paths(_FOLDER):  # exists once the user has stored a preset
            self.layout.separator()
            self.draw_preset(context)


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
        ]


def title(context) -> str:
    """Return the title of the menu: the add-on's preset with these settings, else the preset chosen last."""
    chosen = ISIMP_MT_presets.bl_label
    for preset in presets.PRESETS:
        snaps = context.window_manager.isimp.regularise_first == (preset.regularise is not None)
        partitions = {preset.partition_for(scanned) for scanned in (False, True)}
        if snaps and any(_is_shown(context, step) for step in partitions) and _is_shown(context, preset.mesh):
            are_defaults = (preset.partition, preset.mesh, preset.regularise) == (rcp.Partition(), rcp.Mesh(), None)
            return _DEFAULTS if are_defaults and chosen != preset.label else preset.label
    return _TITLE if chosen in _OURS else chosen


def _is_shown(context, step) -> bool:
    shown = settings.to_step(type(step), settings.group(context, type(step)))
    return all(getattr(shown, name) == getattr(step, name) for name in _kept(type(step)))


def draw(context, layout, is_narrow: bool = False) -> None:
    """Draws the cards of presets. The card with the present settings is highlighted; for defaults, if it was chosen."""
    grid = layout.grid_flow(row_major=True, columns=1 if is_narrow else 2, even_columns=True, align=True)
    chosen = title(context)
    for preset in filter(lambda each: each.card, presets.PRESETS):
        card = grid.operator(
            "isimp.preset", text=preset.label, icon_value=_picture(preset.name), depress=preset.label == chosen
        )
        card.name = preset.name


def draw_own(context, layout) -> None:
    """Draws the menu of presets and the buttons that store and delete the user's presets."""
    row = layout.row(align=True)
    row.use_property_split = False
    shown = title(context)
    row.menu("ISIMP_MT_presets", text=said(shown) if shown in _OURS else shown)
    row.operator("isimp.preset_add", text="", icon="ADD")
    if shown not in _OURS:
        row.operator("isimp.preset_add", text="", icon="REMOVE").remove_active = True


def _picture(name: str) -> int:
    """Return the icon id of a preset's picture; 0 if no pictures are loaded."""
    found = runtime.get().pictures
    return found[name].icon_id if found is not None and name in found else 0


def register() -> None:
    if bpy.app.background:
        return
    found = runtime.get().pictures = bpy.utils.previews.new()
    for preset in presets.PRESETS:
        found.load(preset.name, str(_PICTURES / f"{preset.name}.png"), "IMAGE")


def unregister() -> None:
    if runtime.get().pictures is not None:
        bpy.utils.previews.remove(runtime.get().pictures)
        runtime.get().pictures = None


CLASSES = (ISIMP_OT_preset, ISIMP_MT_presets, ISIMP_OT_preset_add)
