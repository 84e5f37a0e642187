"""The actions in Blender's window for scripts/pictures.py; run by tests/python/blender/window/drive.py.

The scan is the Stanford bunny, with a texture that is made here.
"""

import json

import bpy
import numpy as np
from actions import drag, place, scan, sketched, tool
from mathutils import Quaternion
from scans import material_of
from scenario_bunny import load, view

import isimp

REGIONS = 200
DETAILS = (0.006, 0.008, 0.011, 0.015, 0.021, 0.03, 0.021, 0.014, 0.01, 0.007)  # like a drag over the field


class Film:
    """Frames of the animation, with their durations in milliseconds."""

    def __init__(self, hand):
        self.hand, self.frames = hand, []

    def take(self, milliseconds):
        name = f"film-{len(self.frames):03d}"
        yield from self.hand.shot(name)
        self.frames.append((name, milliseconds))

    def end(self):
        window, side = self.hand.region("WINDOW"), self.hand.region("UI")
        right, high = max(window.x + window.width, side.x + side.width), self.hand.window.height
        box = (window.x, high - window.y - window.height, right, high - window.y)
        (self.hand.out / "film.json").write_text(json.dumps({"frames": self.frames, "box": box}))


def fur(size=1024):
    """(H, W, 4) float32: brown patches on cream."""
    random, value = np.random.default_rng(4), np.zeros((size, size))
    for cells, weight in ((5, 1.0), (11, 0.5), (40, 0.2), (160, 0.12)):
        grid, at = random.normal(size=(cells + 2, cells + 2)), np.linspace(0, cells, size)
        low, part = at.astype(int), at % 1
        part = part * part * (3 - 2 * part)
        rows = grid[low] * (1 - part)[:, None] + grid[low + 1] * part[:, None]
        value += weight * (rows[:, low] * (1 - part) + rows[:, low + 1] * part)
    share = np.clip(0.5 + 1.6 * value, 0, 1)[..., None]
    color = np.array([0.93, 0.85, 0.72]) * (1 - share) + np.array([0.48, 0.26, 0.13]) * share
    return np.concatenate([color, np.ones((size, size, 1))], axis=2).astype(np.float32)


def paint():
    """Adds the texture of the scan, seen from the front."""
    mesh, image = scan().data, bpy.data.images.new("Fur", 1024, 1024)
    image.pixels.foreach_set(fur().ravel())
    image.pack()
    points, loops = np.empty(3 * len(mesh.vertices), np.float32), np.empty(len(mesh.loops), np.int32)
    mesh.vertices.foreach_get("co", points)
    mesh.loops.foreach_get("vertex_index", loops)
    across = points.reshape(-1, 3)[:, [0, 2]]
    uv = (across - across.min(axis=0)) / np.ptp(across, axis=0).max()
    mesh.uv_layers.new(name="UV").data.foreach_set("uv", uv[loops].ravel())
    mesh.materials.append(material_of("Fur", image))


def partitioned(hand, **settings):
    bpy.ops.isimp.partition(**settings)
    yield from hand.settle()
    yield from sketched()


def film(hand):
    """The scan, regions as Detail is dragged, a click, n-gons, the texture."""
    made, panel = Film(hand), bpy.context.window_manager.isimp
    yield from made.take(1300)
    yield from partitioned(hand, detail=0.005)
    yield from made.take(1200)
    for detail in DETAILS:
        yield from partitioned(hand, detail=detail)
        yield from made.take(170)
    yield from made.take(500)
    yield from tool(hand, "isimp.region_tool.object")
    for x in (0.1, 0.06, 0.02):
        yield from hand.move(*place(hand, x, -0.25))
        yield 0.6
        yield from made.take(300)
    yield from hand.click(*place(hand, 0.02, -0.25))
    yield from hand.settle()
    yield from sketched()
    yield from made.take(900)
    yield from tool(hand, "builtin.select_box")
    panel.summary = True
    bpy.ops.isimp.mesh()
    yield 0.5
    space = hand.area.spaces.active
    space.overlay.show_outline_selected = False
    yield from made.take(900)
    start = space.region_3d.view_rotation.copy()
    for turn in (*range(4, 33, 4), *range(28, -1, -4)):
        space.region_3d.view_rotation = Quaternion((0, 0, 1), np.radians(turn)) @ start
        yield from made.take(90)
    yield from hand.press("isimp.compare")
    from isimp.blender.scene import runtime

    for share in (0.85, 0.78, 0.7, 0.62, 0.54, 0.46, 0.38, 0.3, 0.24, 0.24, 0.3, 0.36, 0.4):
        runtime.get().comparison.share = share
        hand.area.tag_redraw()
        yield from made.take(110)
    made.frames[-1] = (made.frames[-1][0], 2200)
    yield from hand.shot("picture-9-compare")
    yield from hand.into_view()
    yield from hand.key("ESC")
    made.end()


def tools(hand):
    """Pictures 7 and 8 of the manual: a line that cuts, a region shrunk by a drag, a locked one, a smoothing stroke."""
    yield from hand.press("isimp.swap")
    bpy.context.window_manager.isimp.outline = False  # so that the strokes are visible
    yield from partitioned(hand, proxies=40)
    yield from tool(hand, "isimp.cut_tool.object")
    yield from drag(hand, (-0.1, 0.05), (0.6, -0.25), shot="picture-7-cut")
    yield from tool(hand, "isimp.grow_tool.object")
    x, y = place(hand, 0.55, 0.05)
    yield from hand.move(x, y)
    hand.event("LEFTMOUSE", "PRESS")
    yield 0.2
    yield from hand.move(x - 30, y)
    yield 3.0
    yield from hand.shot("picture-7-shrink")
    yield from hand.key("ESC")
    hand.event("LEFTMOUSE", "RELEASE")
    yield from hand.settle()
    yield from tool(hand, "isimp.paint_tool.object")
    bpy.context.window_manager.isimp.brush = 28
    yield from drag(hand, (-0.05, -0.05), (0.35, -0.1), ctrl=True)
    yield from sketched()
    yield from drag(hand, (-0.05, -0.55), (0.35, -0.6), shift=True, shot="picture-8-paint")


def run(hand):
    isimp.register()
    load()
    paint()
    yield 0.5
    yield from hand.open_tab()
    yield from view(hand)
    yield from film(hand)
    yield from tools(hand)
