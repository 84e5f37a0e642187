"""The tools in the toolbar: what each is bound to; what they do is in the modules beside."""

import bpy

from . import point


def _hover(keys):
    return "isimp.hover", {"type": "MOUSEMOVE", "value": "ANY", "any": True}, {"properties": [("keys", keys)]}


class _Tool(bpy.types.WorkSpaceTool):
    bl_space_type = "VIEW_3D"


def _press(operator, **held):
    return operator, {"type": "LEFTMOUSE", "value": "PRESS", **held}, None


class _Region(_Tool):
    bl_idname = "isimp.region_tool"
    bl_label = "Region"
    bl_description = (
        "Regions of the scan.\n"
        "• Click: a new region here\n• Ctrl-click: delete the region\n• Alt-click: select its faces"
    )
    bl_icon = "ops.generic.select_lasso"
    bl_keymap = (
        _hover("Click: new region · Ctrl: delete · Alt: select"),
        _press("isimp.point"),
        _press("isimp.point", ctrl=True),
        _press("isimp.point", alt=True),
    )


def _for_mode(tool, mode):
    return type(
        f"{tool.__name__}{mode}", (tool,), {"bl_context_mode": mode, "bl_idname": f"{tool.bl_idname}.{mode.lower()}"}
    )


_TOOLS = [[_for_mode(tool, mode) for tool in (_Region,)] for mode in ("OBJECT", "EDIT_MESH")]
CLASSES = point.CLASSES


def register() -> None:
    for tools in _TOOLS:
        for number, tool in enumerate(tools):
            bpy.utils.register_tool(tool, separator=number == 0)


def unregister() -> None:
    for tools in _TOOLS:
        for tool in reversed(tools):
            bpy.utils.unregister_tool(tool)
