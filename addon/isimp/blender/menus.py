"""Menus: Object > iSimp, whose entries the search (F3) finds too, and pie menus for the user's own keys."""

import bpy

from .. import recipe as rcp
from .controls import settings
from .panel.main import give_mesh
from .panel.planes import align
from .scene import pointed

_SELECT = (
    ("SIZE", "Select Small Regions"),
    ("FLATNESS", "Select Bent Regions"),
    ("DIRECTION", "Select Regions Facing Up"),
    ("CLUTTER", "Select Clutter"),
)


class ISIMP_MT_object(bpy.types.Menu):
    """Turn scans into clean, editable polygons"""

    bl_label = "iSimp"

    def draw(self, context):
        layout, panel = self.layout, context.window_manager.isimp
        settings.give(rcp.Partition, panel.partition, layout.operator("isimp.partition", icon="MOD_EXPLODE"))
        give_mesh(panel, layout.operator("isimp.mesh", icon="MESH_ICOSPHERE"))
        layout.operator("isimp.swap", icon="ARROW_LEFTRIGHT")
        layout.operator("isimp.compare", icon="IMAGE_ALPHA")
        layout.separator()
        for by, name in _SELECT:
            layout.operator("isimp.select_by", text=name).by = by
        layout.separator()
        for name in ("add_worst", "delete_least", "merge_cheapest", "improve", "even_borders"):
            layout.operator(f"isimp.{name}")
        again = layout.operator("isimp.partition", text="Repartition", icon="MOD_EXPLODE")
        settings.give(rcp.Partition, panel.partition, again)
        again.part = True
        layout.separator()
        settings.give(rcp.Regularise, panel.regularise, layout.operator("isimp.regularise", icon="SNAP_ON"))
        layout.menu("ISIMP_MT_planes")
        layout.separator()
        layout.operator("isimp.merge_flat", icon="MESH_PLANE")
        layout.separator()
        layout.operator("isimp.recipe_export", icon="EXPORT")
        layout.operator("isimp.recipe_import", icon="IMPORT")
        layout.separator()
        layout.operator("isimp.workspace", icon="WORKSPACE")


class ISIMP_MT_planes(bpy.types.Menu):
    """Set the planes of the regions of the selected faces"""

    bl_label = "Align Planes"

    def draw(self, context):
        for name in rcp.ALIGNMENTS:
            align(self.layout, name).length = context.window_manager.isimp.align.length


class ISIMP_MT_planes_pie(bpy.types.Menu):
    """Regularise, and planes set by hand, around the mouse"""

    bl_label = "Planes"

    def draw(self, context):
        pie, panel = self.layout.menu_pie(), context.window_manager.isimp
        for name in ("upright", "perpendicular", "level", "coplanar", "parallel", "free"):
            align(pie, name).length = panel.align.length
        settings.give(rcp.Regularise, panel.regularise, pie.operator("isimp.regularise", icon="SNAP_ON"))
        pie.operator("isimp.select_region", icon="RESTRICT_SELECT_OFF")


class ISIMP_MT_pie(bpy.types.Menu):
    """The most frequent operators, around the mouse"""

    bl_label = "iSimp"

    def draw(self, context):
        pie, panel = self.layout.menu_pie(), context.window_manager.isimp
        pie.operator("isimp.add_proxy", icon="ADD")  # left, right, below, above; then the corners
        pie.operator("isimp.delete_proxy", icon="REMOVE")
        give_mesh(panel, pie.operator("isimp.mesh", icon="MESH_ICOSPHERE"))
        settings.give(rcp.Partition, panel.partition, pie.operator("isimp.partition", icon="MOD_EXPLODE"))
        pie.operator("isimp.merge", icon="AUTOMERGE_ON")
        pie.operator("isimp.split", icon="MOD_BOOLEAN")
        pie.operator("isimp.swap", icon="ARROW_LEFTRIGHT")
        pie.operator("isimp.select_region", icon="RESTRICT_SELECT_OFF")


class ISIMP_MT_chosen_pie(bpy.types.Menu):
    """Actions for the regions chosen by shift-clicks, around the mouse"""

    bl_label = "Chosen Regions"

    def draw(self, context):
        pie, panel = self.layout.menu_pie(), context.window_manager.isimp
        scan = context.view_layer.objects.active
        faces = pointed.faces(scan) if scan else ()
        if not faces:  # a script may open the pie while no region is chosen
            return
        buttons = []
        for name in ("upright", "parallel", "level", "coplanar"):
            button = align(pie, name)
            button.length = panel.align.length
            buttons.append(button)
        buttons.append(pie.operator("isimp.merge", icon="AUTOMERGE_ON"))
        buttons.append(pie.operator("isimp.lock", icon="LOCKED"))
        buttons.append(pie.operator("isimp.leave_out", icon="GHOST_DISABLED"))
        for button in buttons:  # in Edit Mode they would act on the selected faces
            button.face, button.chosen = faces[-1], ",".join(map(str, faces)) if len(faces) > 1 else ""


def _draw_entry(menu, context) -> None:
    menu.layout.separator()
    menu.layout.menu("ISIMP_MT_object", icon="MOD_REMESH")


def _draw_import(menu, context) -> None:
    menu.layout.operator("isimp.import_scan", text="Scan (iSimp)")


def _draw_export(menu, context) -> None:
    menu.layout.operator("isimp.export_building", text="Building (.ifc, .dxf, .city.json)")
    menu.layout.operator("isimp.export_step", text="Solid (.step)")
    menu.layout.operator("isimp.export_lods", text="LODs (.glb, .obj, .ifc)")


CLASSES = (ISIMP_MT_object, ISIMP_MT_planes, ISIMP_MT_planes_pie, ISIMP_MT_chosen_pie, ISIMP_MT_pie)
_HOMES = (
    ("VIEW3D_MT_object", _draw_entry),
    ("VIEW3D_MT_edit_mesh", _draw_entry),
    ("TOPBAR_MT_file_import", _draw_import),
    ("TOPBAR_MT_file_export", _draw_export),
)


def register() -> None:
    for name, draw in _HOMES:
        getattr(bpy.types, name).append(draw)


def unregister() -> None:
    for name, draw in _HOMES:
        getattr(bpy.types, name).remove(draw)
