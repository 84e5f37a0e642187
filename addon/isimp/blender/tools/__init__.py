"""The tools in the toolbar: what each is bound to; what they do is in the modules beside."""

import bpy

from . import paint, point, size


def _hover(keys):
    return "isimp.hover", {"type": "MOUSEMOVE", "value": "ANY", "any": True}, {"properties": [("keys", keys)]}


class _Tool(bpy.types.WorkSpaceTool):
    bl_space_type = "VIEW_3D"


def _press(operator, **held):
    return operator, {"type": "LEFTMOUSE", "value": "PRESS", **held}, None


def _turn(wheel, shrink):
    return "isimp.size_here", {"type": wheel, "value": "PRESS", "ctrl": True}, {"properties": [("shrink", shrink)]}


_WHEEL = (_turn("WHEELUPMOUSE", False), _turn("WHEELDOWNMOUSE", True))


class _Region(_Tool):
    bl_idname = "isimp.region_tool"
    bl_label = "Region"
    bl_description = (
        "Regions of the scan.\n"
        "• Click: a new region here\n• Ctrl-click: delete the region\n• Alt-click: select its faces\n"
        "• Drag to another region: merge the two\n"
        "• Shift-click: split it in two\n• Shift-drag: cut it along a line\n"
        "• Ctrl-wheel: grow or shrink it\n• L: lock or unlock it"
    )
    bl_icon = "ops.generic.select_lasso"
    bl_keymap = (
        _hover(
            "Click: new region · Ctrl: delete · Alt: select · Drag: merge · Shift: split, drag: cut · "
            "Ctrl-wheel: grow, shrink · L: lock"
        ),
        _press("isimp.point"),
        _press("isimp.point", ctrl=True),
        _press("isimp.point", alt=True),
        _press("isimp.cut", shift=True),
        *_WHEEL,
        ("isimp.lock_here", {"type": "L", "value": "PRESS"}, None),
    )


_MIRRORED = [("data_path", "window_manager.isimp.mirror"), ("value_1", "NONE"), ("value_2", "X")]


class _Paint(_Tool):
    bl_idname = "isimp.paint_tool"
    bl_label = "Paint Region"
    bl_description = (
        "Regions drawn by hand.\n"
        "• Paint: into the region first touched\n• Ctrl: a new region\n"
        "• Shift: smooth borders\n• Ctrl and Shift: erase from the region\n• F: radius\n• X: mirror"
    )
    bl_icon = "brush.sculpt.draw_face_sets"
    bl_keymap = (
        _hover("Paint: into this region · Ctrl: a new one · Shift: smooth · Ctrl-Shift: erase · F: radius · X: mirror"),
        _press("isimp.paint"),
        _press("isimp.paint", ctrl=True),
        _press("isimp.paint", shift=True),
        _press("isimp.paint", ctrl=True, shift=True),
        ("isimp.brush", {"type": "F", "value": "PRESS"}, None),
        ("wm.context_toggle_enum", {"type": "X", "value": "PRESS"}, {"properties": _MIRRORED}),
    )

    @staticmethod
    def draw_settings(context, layout, tool):
        panel = context.window_manager.isimp
        layout.prop(panel, "stroke", expand=True)
        layout.prop(panel, "brush")
        layout.prop(panel, "mirror")
        layout.prop(panel, "lock_painted")


class _Cut(_Tool):
    bl_idname = "isimp.cut_tool"
    bl_label = "Cut Region"
    bl_description = (
        "Parts a region.\n• Drag a line over it: there, as seen\n• Click: in two, where its halves differ most"
    )
    bl_icon = "ops.mesh.knife_tool"
    bl_keymap = (_hover("Drag a line over a region: cut it there · Click: split it in two"), _press("isimp.cut"))


class _Grow(_Tool):
    bl_idname = "isimp.grow_tool"
    bl_label = "Grow or Shrink Region"
    bl_description = (
        "How large a region is.\n"
        "• Drag to the right: it grows as far as the mouse goes\n• Drag to the left: it shrinks\n"
        "• Click: by one ring of faces; ctrl-click: less by one\n• Ctrl-wheel: a little"
    )
    bl_icon = "ops.transform.shrink_fatten"
    bl_keymap = (
        _hover("Drag right: grow · Drag left: shrink · Click: one ring of faces · Ctrl: one less · Ctrl-wheel"),
        _press("isimp.size"),
        _press("isimp.size", ctrl=True),
        *_WHEEL,
    )


def _for_mode(tool, mode):
    return type(
        f"{tool.__name__}{mode}", (tool,), {"bl_context_mode": mode, "bl_idname": f"{tool.bl_idname}.{mode.lower()}"}
    )


_TOOLS = [[_for_mode(tool, mode) for tool in (_Region, _Paint, _Cut, _Grow)] for mode in ("OBJECT", "EDIT_MESH")]
CLASSES = (*point.CLASSES, *paint.CLASSES, *size.CLASSES)


def register() -> None:
    for tools in _TOOLS:
        for number, tool in enumerate(tools):
            bpy.utils.register_tool(tool, separator=number == 0)


def unregister() -> None:
    for tools in _TOOLS:
        for tool in reversed(tools):
            bpy.utils.unregister_tool(tool)
