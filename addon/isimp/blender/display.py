"""The viewports' shading while regions are shown: set, remembered, and given back."""

from contextlib import suppress

import bpy
from idprop.types import IDPropertyGroup

from . import mesh_io, runtime

_KEPT = "isimp_color_type"  # on the screen, so that a file saved meanwhile can restore it


def _viewports(context):
    for window in context.window_manager.windows:
        for index, area in enumerate(window.screen.areas):
            if area.type == "VIEW_3D":
                for space in area.spaces:
                    if space.type == "VIEW_3D":
                        yield window.screen, f"{index}", space


def _is_ours(screen) -> bool:
    """Whether the property on a screen is the add-on's, or free; a foreign one may have its name."""
    return isinstance(screen.get(_KEPT, None), IDPropertyGroup | None)


def _kept(screen) -> dict:
    """The colour type of each viewport of a screen as it was before."""
    kept = screen.get(_KEPT)
    return kept.to_dict() if isinstance(kept, IDPropertyGroup) else {}


def show(context) -> None:
    """Lets Solid shading show the regions' colours in all viewports."""
    for screen, place, space in _viewports(context):
        if space.shading.color_type != "VERTEX":
            if _is_ours(screen):
                screen[_KEPT] = _kept(screen) | {place: space.shading.color_type}
            space.shading.color_type = "VERTEX"


def give_back(context) -> None:
    """Gives each viewport the colour type that it had before, unless its user chose another one meanwhile."""
    for screen, place, space in _viewports(context):
        kept = _kept(screen)
        if place in kept and space.shading.color_type == "VERTEX":
            with suppress(TypeError):  # no colour type of this version
                space.shading.color_type = kept[place]
    for window in context.window_manager.windows:
        if _KEPT in window.screen and _is_ours(window.screen):
            del window.screen[_KEPT]


def is_shown(context) -> bool:
    return any(space.shading.color_type == "VERTEX" for _, _, space in _viewports(context))


def follow_undo(context) -> None:
    """After undo and redo: colours are shown while the active object is a visible scan with regions.

    Viewports are no part of what undo takes back, so they have to be brought in line with what it did.
    """
    obj = context.view_layer.objects.active
    if obj is None or obj.type != "MESH" or runtime.get() is None:
        return
    if mesh_io.state_of(obj) and not obj.hide_get():
        show(context)
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
