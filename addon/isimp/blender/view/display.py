"""Sets the colour type of the viewports while regions are shown, and restores the former one."""

from contextlib import suppress

import bpy

from ..scene import mesh_io, runtime, targets
from ..texturing import texture

_KEPT = "isimp_color_type"  # property of the screen, so that a saved file can restore the colour type


def _viewports(context):
    for window in context.window_manager.windows:
        for index, area in enumerate(window.screen.areas):
            if area.type == "VIEW_3D":
                for space in area.spaces:
                    if space.type == "VIEW_3D":
                        yield window.screen, f"{index}", space


def _kept(screen) -> dict:
    """Return the former colour type of each viewport of a screen. Keys with ".set" have the type set by the add-on."""
    return screen[_KEPT].to_dict() if _KEPT in screen else {}


def show(context, kind: str = "VERTEX") -> None:
    """Sets the colour type of Solid shading in all viewports. VERTEX: colours of regions. TEXTURE: images."""
    for screen, place, space in _viewports(context):
        if space.shading.color_type != kind:
            kept = _kept(screen)
            before = kept[place] if _is_set(kept, place, space) else space.shading.color_type
            screen[_KEPT] = kept | {place: before, f"{place}.set": kind}
            space.shading.color_type = kind


def _is_set(kept: dict, place: str, space) -> bool:
    """Return whether a viewport has the colour type set by the add-on, not a later choice of the user."""
    return place in kept and space.shading.color_type == kept.get(f"{place}.set", "VERTEX")


def show_result(context, result) -> None:
    """Shows the texture of a result that has one; otherwise restores the colour type of each viewport."""
    give_back(context)
    if texture.image_width(result):
        show(context, "TEXTURE")


def give_back(context) -> None:
    """Restores the former colour type of each viewport, unless the user has chosen another one."""
    for screen, place, space in _viewports(context):
        kept = _kept(screen)
        if _is_set(kept, place, space):
            with suppress(TypeError):  # this version has no such colour type
                space.shading.color_type = kept[place]
    for window in context.window_manager.windows:
        if _KEPT in window.screen:
            del window.screen[_KEPT]


def is_shown(context) -> bool:
    """Return whether a viewport shows the regions' colours; only Solid shading does."""
    shadings = (space.shading for _, _, space in _viewports(context))
    return any(shading.type == "SOLID" and shading.color_type == "VERTEX" for shading in shadings)


def follow_undo(context) -> None:
    """Shows the colours if the active object is a visible scan with regions. Called after undo and redo.

    Undo does not restore viewports, so their colour type must follow the restored objects.
    """
    obj = context.view_layer.objects.active
    if obj is None or obj.type != "MESH" or runtime.get() is None:
        return
    if mesh_io.state_of(obj) and not obj.hide_get():
        show(context)
    elif targets.scan_of(obj) is not None:
        show_result(context, obj)
    else:
        give_back(context)
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


@bpy.app.handlers.persistent
def _after_undo(*_):
    follow_undo(bpy.context)


_HANDLERS = (bpy.app.handlers.undo_post, bpy.app.handlers.redo_post)


def register() -> None:
    for handlers in _HANDLERS:
        handlers.append(_after_undo)


def unregister() -> None:
    give_back(bpy.context)
    for handlers in _HANDLERS:
        handlers.remove(_after_undo)
