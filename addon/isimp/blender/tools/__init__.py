"""The tools in the toolbar and their key maps; the other modules of this package implement them."""

from itertools import combinations

import bpy
from gpu_extras.presets import draw_circle_2d

from . import border, furniture, opening, paint, part, point, size


def _hover(keys, **more):
    properties = [("keys", keys), *more.items()]
    return "isimp.hover", {"type": "MOUSEMOVE", "value": "ANY", "any": True}, {"properties": properties}


class _Tool(bpy.types.WorkSpaceTool):
    bl_space_type = "VIEW_3D"


def _press(operator, **held):
    return operator, {"type": "LEFTMOUSE", "value": "PRESS", **held}, None


def _turn(wheel, shrink):
    return "isimp.size_here", {"type": wheel, "value": "PRESS", "ctrl": True}, {"properties": [("shrink", shrink)]}


_HELD = ("ctrl", "shift", "alt")


def _with_rest(*items) -> tuple:
    """Return a key map with an entry for each press of the mouse that the tool does not use.

    Without them Blender would select objects, or move the scan by a drag. Each combination of keys has its own entry,
    since Blender does not keep the order of entries.
    """
    bound = [{key for key in _HELD if how.get(key)} for _, how, _ in items if how["type"] == "LEFTMOUSE"]
    wanted = [set(keys) for count in range(len(_HELD) + 1) for keys in combinations(_HELD, count)]
    return (*items, *(_press("isimp.turn", **dict.fromkeys(keys, True)) for keys in wanted if keys not in bound))


_WHEEL = (_turn("WHEELUPMOUSE", False), _turn("WHEELDOWNMOUSE", True))


class _Region(_Tool):
    bl_idname = "isimp.region_tool"
    bl_label = "Region"
    bl_description = (
        "Edit regions of the scan.\n"
        "• Click: add a region\n• Ctrl-click: delete the region\n"
        "• Drag a lit border or corner: move it\n• Drag to another region: merge both\n"
        "• Modes are in the bar above the view\n"
        "• Shift-click: choose another region; right-click: a menu for the chosen ones; Esc: choose none\n"
        "• Shift-drag: cut it along a line\n"
        "• Ctrl-wheel: grow or shrink it\n• L: lock or unlock it"
    )
    bl_icon = "ops.generic.select_lasso"
    bl_keymap = _with_rest(
        _hover(
            "Click: add region · Ctrl: delete · Drag a lit border: move it · Drag to another: merge · "
            "Shift: choose, drag: cut · Right: menu for the chosen · Ctrl-wheel: grow, shrink · L: lock",
            borders=True,
        ),
        _press("isimp.point"),
        _press("isimp.point", ctrl=True),
        ("isimp.cut", {"type": "LEFTMOUSE", "value": "PRESS", "shift": True}, {"properties": [("collects", True)]}),
        ("isimp.chosen_menu", {"type": "RIGHTMOUSE", "value": "PRESS"}, None),
        ("isimp.choose_none", {"type": "ESC", "value": "PRESS"}, None),
        *_WHEEL,
        ("isimp.lock_here", {"type": "L", "value": "PRESS"}, None),
    )

    @staticmethod
    def draw_cursor(context, tool, at):
        """Draws the brush at the mouse in the mode with strokes."""
        if context.window_manager.isimp.hand == "finer":
            _Paint.draw_cursor(context, tool, at)

    @staticmethod
    def draw_settings(context, layout, tool):
        panel = context.window_manager.isimp
        layout.prop(panel, "hand", expand=True)
        if panel.hand == "finer":
            layout.prop(panel, "brush")


_MIRRORED = [("data_path", "window_manager.isimp.mirror"), ("value_1", "NONE"), ("value_2", "X")]


class _Paint(_Tool):
    bl_idname = "isimp.paint_tool"
    bl_label = "Paint Region"
    bl_description = (
        "Paint regions by hand.\n"
        "• Drag: extend the region where the stroke begins\n• Ctrl: paint a new region\n"
        "• Shift: smooth borders\n• Ctrl and Shift: erase from the region\n• F: radius\n• X: mirror\n"
        "• All of these, and Finer Here, are in the bar above the view"
    )
    bl_icon = "brush.sculpt.draw_face_sets"
    bl_keymap = _with_rest(
        _hover("Drag: extend this region · Ctrl: new · Shift: smooth · Ctrl-Shift: erase · F: radius · X: mirror"),
        _press("isimp.paint"),
        _press("isimp.paint", ctrl=True),
        _press("isimp.paint", shift=True),
        _press("isimp.paint", ctrl=True, shift=True),
        ("isimp.brush", {"type": "F", "value": "PRESS"}, None),
        ("wm.context_toggle_enum", {"type": "X", "value": "PRESS"}, {"properties": _MIRRORED}),
    )

    @staticmethod
    def draw_cursor(context, tool, at):
        """Draws the brush at the mouse before a stroke, without a redraw of the view."""
        draw_circle_2d(at, (1.0, 1.0, 1.0, 0.9), context.window_manager.isimp.brush, segments=48)

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
        "Cut a region.\n• Drag a line over it: cut along the line, as seen\n"
        "• Click: split it where its halves differ most"
    )
    bl_icon = "ops.mesh.knife_tool"
    bl_keymap = _with_rest(_hover("Drag a line over a region: cut it · Click: split it in two"), _press("isimp.cut"))


class _Grow(_Tool):
    bl_idname = "isimp.grow_tool"
    bl_label = "Grow or Shrink Region"
    bl_description = (
        "Grow or shrink a region.\n"
        "• Drag to the right: grow by the distance of the drag\n• Drag to the left: shrink\n"
        "• Click: grow by one ring of faces; ctrl-click: shrink by one\n• Ctrl-wheel: a little"
    )
    bl_icon = "ops.transform.shrink_fatten"
    bl_keymap = _with_rest(
        _hover("Drag right: grow · Drag left: shrink · Click: grow one ring · Ctrl: shrink one · Ctrl-wheel: a little"),
        _press("isimp.size"),
        _press("isimp.size", ctrl=True),
        *_WHEEL,
    )


class _Openings(_Tool):
    bl_idname = "isimp.opening_tool"
    bl_label = "Openings"
    bl_description = (
        "Show the holes and tunnels that Partition closed.\n• Click one: keep it open\n• Click it again: close it"
    )
    bl_icon = "ops.mesh.loopcut_slide"
    bl_keymap = _with_rest(
        (
            "isimp.hover_opening",
            {"type": "MOUSEMOVE", "value": "ANY", "any": True},
            {"properties": [("keys", "Click an opening: keep it open, or close it again")]},
        ),
        _press("isimp.toggle_opening"),
    )


def _for_mode(tool, mode):
    return type(
        f"{tool.__name__}{mode}", (tool,), {"bl_context_mode": mode, "bl_idname": f"{tool.bl_idname}.{mode.lower()}"}
    )


_TOOLS = [
    [_for_mode(tool, mode) for tool in (_Region, _Paint, _Cut, _Grow, _Openings)] for mode in ("OBJECT", "EDIT_MESH")
]
CLASSES = (
    *border.CLASSES,
    *furniture.CLASSES,
    *opening.CLASSES,
    *point.CLASSES,
    *paint.CLASSES,
    *part.CLASSES,
    *size.CLASSES,
)


def register() -> None:
    if bpy.app.background:  # no key maps and no toolbar
        return
    for tools in _TOOLS:
        for number, tool in enumerate(tools):
            bpy.utils.register_tool(tool, separator=number == 0)
    point.register()


def unregister() -> None:
    if bpy.app.background:
        return
    for tools in _TOOLS:
        for tool in reversed(tools):
            bpy.utils.unregister_tool(tool)
