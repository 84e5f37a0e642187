"""Draws texts in the viewport, next to the mouse and in a corner, on a dark ground."""

import blf
import bpy
import gpu
from gpu_extras.batch import batch_for_shader

from . import text

_FONT = 0
_GROUND = (0.05, 0.05, 0.05, 0.8)
_BESIDE = 30  # pixels from the bottom of the viewport
_CORNER, _BELOW = 18, 76  # pixels from the left, and from the top: below the names of the view and the object
_GIZMOS = 110  # width in pixels of the axes and buttons at the right of the view


def draw_hover(context, hover) -> None:
    """Draws the text next to the mouse, outside the sidebar and the toolbar over the viewport."""
    scale = _begin(context)
    left, right = _free(context)
    away = 18 * scale
    told, x = text.beside(hover.text, _width, hover.at[0] + away, right - away / 2, left + away / 2)
    _draw(told, x, hover.at[1] - 20 * scale, scale)


def draw_corner(context, told: str) -> None:
    """Draws a text in the upper left corner of the viewport, below Blender's text.

    The text does not cover the sidebar or Blender's gizmos. The panel of the last operation is in the lower corner.
    """
    scale, here = _begin(context), context.region
    left, right = _free(context)
    above = [other for other in context.area.regions if other.type in {"HEADER", "TOOL_HEADER"} and other.height > 1]
    top = min([here.height, *(other.y - here.y for other in above if other.alignment == "TOP")])
    room = right - left - (_CORNER + _GIZMOS) * scale
    _draw(text.fitted(told, _width, room), left + _CORNER * scale, top - _BELOW * scale, scale)


def draw_low(context, lines) -> None:
    """Draws lines in the middle of the viewport, at its bottom."""
    scale = _begin(context)
    left, right = _free(context)
    wide = max(map(_width, lines))
    _draw(lines, max(left + _CORNER * scale, (left + right - wide) / 2), (_BESIDE + 18 * len(lines)) * scale, scale)


def draw_beside(context, said, x: float) -> None:
    """Draws two texts at the bottom of the viewport, left and right of a line at `x`, if there is room for them."""
    scale = _begin(context)
    left, right = _free(context)
    away = 16 * scale
    for text_at, begin in ((said[0], x - away - _width(said[0])), (said[1], x + away)):
        if left + away <= begin and begin + _width(text_at) + away <= right:
            _draw([text_at], begin, _BESIDE * scale, scale)


def _begin(context) -> float:
    scale = context.preferences.system.ui_scale
    blf.size(_FONT, round(12 * scale), *(() if bpy.app.version >= (4, 0, 0) else (72,)))
    return scale


def _free(context) -> tuple:
    """Return (left, right) end of the part of the viewport that no sidebar or toolbar covers."""
    here = context.region
    beside = [other for other in context.area.regions if other.type in {"UI", "TOOLS"} and other.width > 1]
    right = min([here.width, *(other.x - here.x for other in beside if other.alignment == "RIGHT")])
    left = max([0, *(other.x + other.width - here.x for other in beside if other.alignment == "LEFT")])
    return left, right


def _draw(lines, x: float, y: float, scale: float) -> None:
    """Draws lines of text on their ground, the first line at height `y`."""
    high, room = 18 * scale, 6 * scale
    wide = max(map(_width, lines))
    top, bottom = y + high - room / 2, y - high * (len(lines) - 1) - room
    shader = gpu.shader.from_builtin("UNIFORM_COLOR" if bpy.app.version >= (4, 0, 0) else "2D_UNIFORM_COLOR")
    a, b, c, d = [(x - room, bottom), (x + wide + room, bottom), (x + wide + room, top), (x - room, top)]
    gpu.state.blend_set("ALPHA")
    shader.bind()
    shader.uniform_float("color", _GROUND)
    batch_for_shader(shader, "TRIS", {"pos": [a, b, c, a, c, d]}).draw(shader)
    gpu.state.blend_set("NONE")
    blf.color(_FONT, 1.0, 1.0, 1.0, 1.0)
    for number, line in enumerate(lines):
        blf.position(_FONT, x, y - high * number, 0)
        blf.draw(_FONT, line)


def _width(words: str) -> float:
    return blf.dimensions(_FONT, words)[0]
