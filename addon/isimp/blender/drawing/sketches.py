"""Draws a sketch: borders, outline and corners of polygons, colours, highlights of the tools."""

from dataclasses import dataclass, field
from itertools import pairwise

import bpy
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader

from ... import sketch
from .. import preferences
from . import shaders
from .space import ON

OVER = 0.03  #: like ON, for lines of polygons, since the scan bulges over them
_GROUPS = 8  # number of groups of lines by length
_LEAST_DOT = 0.5  # corners below this strength are not drawn


@dataclass
class Drawing:
    """A sketch and its batches, each made at its first draw."""

    sketch: sketch.Sketch
    batches: dict = field(default_factory=dict)


def draw_sketch(context, space, drawing) -> None:
    panel, wish, made = context.window_manager.isimp, preferences.get(context), drawing.sketch
    if len(made.locked):
        shader = shaders.hatched()
        shader.bind()
        shaders.draw(_batch(drawing, "locked", "TRIS", shader), shader)
    pixels = space.pixels(context)
    usual = sketch.strength(pixels * float(np.median(made.reach))) if len(made.reach) else 1.0
    _draw_lines(drawing, "borders", _faded(wish.border_color, max(0.4, usual)), wish.line_width * max(0.6, usual))
    space.nearer(OVER)
    if panel.away and len(made.surface):
        _draw_heat(drawing, "away")
    elif panel.heat and len(made.surface):
        _draw_heat(drawing, "heat")
    elif panel.directions and len(made.surface):
        _draw_heat(drawing, "directions")
    if panel.outline:
        draw_outline(drawing, pixels, wish)
    _draw_lines(drawing, "problems", wish.problem_color, 2 * wish.line_width)
    space.nearer(ON)


def _faded(color, share: float) -> tuple:
    return (*color[:3], color[3] * share)


def draw_outline(drawing, pixels: float, wish, most: float = 1.0) -> None:
    """Draws lines and corners in groups of similar length. Shorter lines on the screen are fainter and thinner.

    most: strength of the longest lines.
    """
    made = drawing.sketch
    edges = np.linalg.norm(made.outline[::2] - made.outline[1::2], axis=1)
    for name, points, length, each in (
        ("outline", made.outline, edges, 2),
        ("corners", made.corners, made.reach, 1),
    ):
        ends = np.linspace(0, len(length), min(_GROUPS, len(length)) + 1).astype(int)
        for group, (begin, end) in enumerate(pairwise(ends.tolist())):
            share = most * sketch.strength(pixels * float(length[(begin + end) // 2]))
            color, part = _faded(wish.outline_color, share), slice(each * begin, each * end)
            if each == 2:
                shader = line_shader(color, wish.line_width * (0.5 + 0.5 * share))
                shaders.draw(_part(drawing, f"{name} {group}", points[part], "LINES", shader), shader)
            elif share > _LEAST_DOT:
                _draw_points(drawing, f"{name} {group}", points[part], color, 3 * wish.line_width * share)


def _part(drawing, name, points, kind, shader):
    if name not in drawing.batches:
        drawing.batches[name] = batch_for_shader(shader, kind, {"pos": points})
    return drawing.batches[name]


def _batch(drawing, name, kind, shader, **more):
    if name not in drawing.batches:
        drawing.batches[name] = batch_for_shader(shader, kind, {"pos": getattr(drawing.sketch, name), **more})
    return drawing.batches[name]


def lines(points, color, width) -> None:
    """Draws pairs of points as lines, without keeping the batch."""
    if len(points):
        shader = line_shader(color, width)
        shaders.draw(batch_for_shader(shader, "LINES", {"pos": points}), shader)


def line_shader(color, width):
    shader = gpu.shader.from_builtin(_named("POLYLINE_UNIFORM_COLOR"))
    shader.bind()
    view = gpu.state.viewport_get()
    shader.uniform_float("viewportSize", (view[2], view[3]))
    shader.uniform_float("lineWidth", width)
    shader.uniform_float("color", color)
    return shader


def _named(name):
    return f"3D_{name}" if bpy.app.version < (4, 0, 0) else name


def _draw_lines(drawing, name, color, width) -> None:
    if len(getattr(drawing.sketch, name)):
        shader = line_shader(color, width)
        shaders.draw(_batch(drawing, name, "LINES", shader), shader)


def _draw_points(drawing, name, points, color, size) -> None:
    shader = gpu.shader.from_builtin(_named("UNIFORM_COLOR"))
    gpu.state.point_size_set(size)
    shader.bind()
    shader.uniform_float("color", color)
    shaders.draw(_part(drawing, name, points, "POINTS", shader), shader)


def _draw_heat(drawing, by: str) -> None:
    shader = gpu.shader.from_builtin(_named("SMOOTH_COLOR"))
    shader.bind()
    if by not in drawing.batches:
        values = {"pos": drawing.sketch.surface, "color": getattr(drawing.sketch, by)}
        drawing.batches[by] = batch_for_shader(shader, "TRIS", values)
    shaders.draw(drawing.batches[by], shader)


def draw_hover(hover) -> None:
    shader = gpu.shader.from_builtin(_named("UNIFORM_COLOR"))
    shader.bind()
    for points, color in hover.fills:
        if len(points):
            shader.uniform_float("color", color)
            shaders.draw(batch_for_shader(shader, "TRIS", {"pos": points}), shader)
    if hover.through:
        gpu.state.depth_test_set("NONE")
    for points, color, width in hover.lines:
        lines(points, color, width)
    gpu.state.depth_test_set("LESS_EQUAL")
