"""The first model of the manual, made of the bunny with real mouse and keys; it makes the manual's pictures."""

import os
from pathlib import Path

import bpy
import numpy as np
import scans
from actions import place, regions, same, scan, show_steps, sketched, tool

import isimp
from isimp.blender.scene import runtime
from isimp.session import engine

FOLDER = Path(os.environ.get("ISIMP_DATA", Path(__file__).parents[5] / "shared" / "data"))
DATA = FOLDER / "scan" / "bunny_69k.ply"


def load(path=DATA, upright=False):
    """The bunny, or another scan, as an object three units long; y points up in the file unless it is `upright`."""
    points, triangles = engine.read(str(path))
    if not upright:
        points = np.stack([points[:, 0], -points[:, 2], points[:, 1]], axis=1)
    low, high = points.min(axis=0), points.max(axis=0)
    points = (points - (low + high) / 2) * 3 / (high - low).max()
    return alone(points, triangles)


def alone(points, triangles):
    """Makes an object the only one of the file, active and selected; returns its mesh."""
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()
    mesh = bpy.data.meshes.new("Scan")
    mesh.from_pydata(points.tolist(), [], triangles.tolist())
    obj = bpy.data.objects.new("Scan", mesh)
    bpy.context.scene.collection.objects.link(obj)
    scans.activate(obj)
    bpy.ops.ed.undo_push(message="scan")
    return mesh


def view(hand, turn=(1.25, 0.0, 0.4), at=(0.25, 0.0, 0.0), distance=5.2):
    """Turns the view to a place, and hides the floor, axes, cursor and outlines."""
    from mathutils import Euler

    space = hand.area.spaces.active
    space.region_3d.view_rotation = Euler(turn).to_quaternion()
    space.region_3d.view_perspective = "ORTHO"
    space.region_3d.view_location, space.region_3d.view_distance = at, distance
    for name in ("floor", "axis_x", "axis_y", "cursor", "outline_selected"):
        setattr(space.overlay, f"show_{name}", False)
    yield 0.5


def run(hand):
    if not DATA.exists():
        print(f"no {DATA}: left out")
        return
    show_steps()
    isimp.register()
    load()
    yield 0.5
    yield from hand.open_tab()
    yield from view(hand)
    yield from hand.shot("bunny-1-scan")
    bpy.context.window_manager.isimp.partition.count_by = "proxies"
    yield from hand.press("isimp.partition")
    same("regions", regions(), 200)
    yield from sketched()
    yield from hand.shot("bunny-2-partition")

    yield from tool(hand, "isimp.region_tool.object")
    x, y = place(hand, 0.0, 0.0)
    view_region = hand.region("WINDOW")
    x, y = view_region.x + view_region.width * 0.45, view_region.y + view_region.height * 0.45
    for _ in range(200):
        yield from hand.move(x, y)
        if runtime.get().hover is not None:
            break
        yield 0.1
    assert "of the area" in runtime.get().hover.text
    yield from hand.shot("bunny-3-hover")
    yield from hand.click(x, y, ctrl=True)
    yield from hand.settle()
    same("deleted", regions(), 199)
    yield from hand.click(x, y)
    yield from hand.settle()
    same("added", regions(), 200)
    bpy.context.window_manager.isimp.heat = True
    yield from sketched()
    yield 0.5
    yield from hand.shot("bunny-4-flatness")
    bpy.context.window_manager.isimp.heat = False
    yield from hand.shot("bunny-5-steps")
    yield from hand.press("isimp.mesh")
    result = bpy.context.object
    same("result", (result.name, scan().hide_get()), ("Scan.simplified", True))
    assert 200 <= len(result.data.polygons) <= 300, len(result.data.polygons)
    yield from hand.shot("bunny-6-mesh")
