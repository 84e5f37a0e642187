"""The Openings tool, with a real mouse: closed openings are shown; a click keeps one open, another closes it again."""

import bpy
import numpy as np
from scenario_main import same, scan
from scenario_tools import begin, place, tool

from isimp.blender.scene import runtime, store


def pierced():
    """A rough sphere with a small hole in front."""
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=5, radius=1.5)
    obj = bpy.context.object
    obj.name = "Scan"
    points = np.empty(3 * len(obj.data.vertices), np.float32)
    obj.data.vertices.foreach_get("co", points)
    points += np.random.default_rng(1).normal(0, 0.008, len(points)).astype(np.float32)
    obj.data.vertices.foreach_set("co", points)
    centers = np.array([polygon.center for polygon in obj.data.polygons])
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    bpy.ops.object.mode_set(mode="OBJECT")
    obj.data.polygons.foreach_set("select", np.linalg.norm(centers - [0, -1.5, 0], axis=1) < 0.09)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.delete(type="FACE")
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.ed.undo_push(message="scan")


def kept():
    numbers = store.numbers(scan())
    return numbers["kept_open"], numbers["repairs"]["filled_holes"]


def run(hand):
    yield from begin(hand, pierced, proxies=8)
    same("the hole is closed", kept(), (0, 1))
    yield from tool(hand, "isimp.opening_tool.object")
    yield from hand.move(*place(hand, 0.02, 0.0))
    yield 0.3
    hover = runtime.get().hover
    same("the opening is shown", (hover is not None and hover.text.startswith("Hole, "), len(hover.lines)), (True, 3))
    yield from hand.shot("openings-1-closed")
    yield from hand.click(*place(hand, 0.0, 0.0))
    yield from hand.settle()
    same("a click keeps it open", kept(), (1, 0))
    yield from hand.move(*place(hand, 0.02, 0.0))
    yield 0.3
    same("the hover text names it", "kept open" in runtime.get().hover.text, True)
    yield from hand.shot("openings-2-kept")
    yield from hand.undo()
    same("undone", kept(), (0, 1))
    yield from hand.click(*place(hand, 0.0, 0.0))
    yield from hand.settle()
    same("kept again", kept(), (1, 0))
    yield from hand.click(*place(hand, 0.0, 0.0))
    yield from hand.settle()
    same("another click closes it", kept(), (0, 1))
    yield from hand.click(*place(hand, 0.6, 0.6))
    yield from hand.settle()
    same("a click beside it does nothing", kept(), (0, 1))
