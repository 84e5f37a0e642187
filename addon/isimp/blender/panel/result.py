"""Panels and menus of the result: colours over the scan, texture, export."""

import dataclasses

import bpy

from ... import recipe as rcp
from ..controls import settings
from ..scene import store, targets
from ..texturing import texture
from ..view import display
from .common import Popover, SubPanel, ready
from .main import give_mesh


class ISIMP_MT_colour(bpy.types.Menu):
    """The drawing over the scan, and the meaning of its colours"""

    bl_label = "Colour"

    def draw(self, context):
        layout, panel = self.layout, context.window_manager.isimp
        shown = display.is_shown(context)
        layout.operator("isimp.show_regions", text="Colours", icon="HIDE_OFF" if shown else "HIDE_ON", depress=shown)
        layout.prop(panel, "colour", expand=True)
        layout.separator()
        for name in ("overlay", "outline", "summary"):
            layout.prop(panel, name)


class ISIMP_PT_texture(SubPanel, bpy.types.Panel):
    bl_label = "Texture"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 3

    @classmethod
    def poll(cls, context):
        return ready(context) and texture.is_textured(targets.seen(context)[0])

    def draw(self, context):
        layout, panel = self.prepare(context), context.window_manager.isimp
        scan, _ = targets.seen(context)
        column = layout.column(align=True)
        column.use_property_split = False
        column.prop(panel, "keep_texture")
        if targets.result_of(context.scene, scan) is not None:
            column.menu("ISIMP_MT_texture", text="Make Texture Again", icon="TEXTURE")


class ISIMP_MT_texture(bpy.types.Menu):
    """Make the texture again: with the same settings, or with one changed"""

    bl_label = "Make Texture Again"

    def draw(self, context):
        scan, problem = targets.seen(context)
        made = None if problem else targets.result_of(context.scene, scan)
        if made is None:
            return
        layout, recipe = self.layout, store.load(scan)
        step = (recipe and recipe.texture()) or rcp.Texture()

        def button(label: str, icon: str = "NONE", pressed: bool = False, **changed) -> None:
            made = layout.operator("isimp.texture", text=label, icon=icon, depress=pressed)
            settings.give(rcp.Texture, dataclasses.replace(step, **changed), made)

        def turned(label: str, name: str) -> None:
            on = getattr(step, name)
            button(label, "CHECKBOX_HLT" if on else "CHECKBOX_DEHLT", **{name: not on})

        button("Make Texture Again", "TEXTURE")
        width = texture.image_width(made)
        if width:
            smaller, larger = max(width // 2, 16), min(2 * width, 16384)
            button(f"{smaller:,} px", size=smaller, tiles=0)
            button("Like the Scan", pressed=not step.size, size=0, tiles=0)
            button(f"{larger:,} px", size=larger, tiles=0)
        layout.separator()
        turned("Ambient Occlusion", "occlusion")
        if len(scan.material_slots) > 1:
            turned("Keep Materials Apart", "materials")


class ISIMP_PT_lods(Popover, bpy.types.Panel):
    """Make all levels of detail of the scan, and write them to files"""

    bl_label = "LODs"

    def draw(self, context):
        layout, panel = self.prepare(context), context.window_manager.isimp
        layout.prop(panel, "lods")
        layout.prop(panel, "lod_colliders")
        button = layout.operator("isimp.make_lods", icon="MOD_DECIM")
        give_mesh(panel, button)
        button.counts, button.colliders = panel.lods, panel.lod_colliders
        layout.operator("isimp.export_lods", icon="EXPORT")


class ISIMP_MT_export(bpy.types.Menu):
    """Files of the result: buildings, solids, levels of detail, a report"""

    bl_label = "Export"

    def draw(self, context):
        layout = self.layout
        layout.operator("isimp.export_building", icon="HOME")
        layout.operator("isimp.export_step", icon="MESH_CYLINDER")
        if "install_step" in dir(bpy.ops.isimp) and bpy.ops.isimp.install_step.poll():
            layout.operator("isimp.install_step", icon="IMPORT")
        layout.operator("isimp.export_lods", icon="MOD_DECIM")
        layout.operator("isimp.write_report", icon="TEXT")


CLASSES = (ISIMP_MT_colour, ISIMP_PT_texture, ISIMP_MT_texture, ISIMP_PT_lods, ISIMP_MT_export)
