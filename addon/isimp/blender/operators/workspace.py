import bpy

from ...language import said

_NAME = "iSimp"


class ISIMP_OT_workspace(bpy.types.Operator):
    """Open the workspace for iSimp: a 3D view with toolbar and sidebar. It is created if it is missing"""

    bl_idname = "isimp.workspace"
    bl_label = "iSimp Workspace"

    @classmethod
    def poll(cls, context):
        if context.window is None:
            cls.poll_message_set(said("This needs a window"))
        return context.window is not None

    def execute(self, context):
        made = bpy.data.workspaces.get(_NAME)
        if made is None:
            before = set(bpy.data.workspaces)
            bpy.ops.workspace.duplicate()
            made = (set(bpy.data.workspaces) - before).pop()
            made.name = _NAME
            _set_up(made)
        context.window.workspace = made
        return {"FINISHED"}


def _set_up(workspace) -> None:
    """Opens the toolbar, and the sidebar at the tab of the add-on, in the largest 3D view."""
    areas = [area for screen in workspace.screens for area in screen.areas if area.type == "VIEW_3D"]
    if not areas:
        areas = [max((a for s in workspace.screens for a in s.areas), key=lambda area: area.width * area.height)]
        areas[0].type = "VIEW_3D"
    area = max(areas, key=lambda area: area.width * area.height)
    space = area.spaces.active
    space.show_region_ui = space.show_region_toolbar = True
    space.shading.type = "SOLID"
    space.overlay.show_overlays = True
    for region in area.regions:
        if region.type == "UI" and hasattr(region, "active_panel_category"):
            try:
                region.active_panel_category = "iSimp"
            except (AttributeError, TypeError):  # read-only before 4.2, or the sidebar was not drawn yet
                break


CLASSES = (ISIMP_OT_workspace,)
