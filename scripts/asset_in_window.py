"""The actions in Blender's window for the manual's six steps to a game asset; run as pictures_in_window.py is.

The scan is the owl of bench/generators/painted_scans.py, which scripts/pictures.py has put into a file.
"""

import bpy
import numpy as np
from actions import place, scan, sketched, tool
from scans import material_of
from scenario_bunny import alone, view

import isimp

LEVELS = (600, 200, 60)  # regions


def load(folder):
    """The owl with its image, 2.2 units high."""
    stored = np.load(folder / "owl.npz")
    mesh = alone(stored["vertices"], stored["triangles"])
    mesh.uv_layers.new(name="UV").data.foreach_set("uv", stored["uv"].astype(np.float32).ravel())
    height, width = stored["image"].shape[:2]
    image = bpy.data.images.new("Owl", width, height)
    pixels = np.ones((height, width, 4), np.float32)
    pixels[:, :, :3] = stored["image"][::-1] / 255
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    mesh.materials.append(material_of("Owl", image))


def look(hand, distance=4.6, across=0.0):
    yield from view(hand, (1.4, 0.0, 0.35), (across, 0.0, 0.1), distance)


def shade(hand, textured):
    shading = hand.area.spaces.active.shading
    shading.type, shading.light = "SOLID", "FLAT" if textured else "STUDIO"
    shading.color_type = "TEXTURE" if textured else "MATERIAL"


def levels(hand):
    """Three levels of detail in a row, with their textures and edges."""
    shown = scan()
    for number, regions in enumerate(LEVELS):
        shown.hide_set(False)
        bpy.context.view_layer.objects.active = shown
        bpy.ops.isimp.partition(proxies=regions)
        yield from hand.settle()
        bpy.ops.isimp.mesh(keep_texture=False)
        bpy.ops.isimp.texture(size=2048 >> number)
        yield 0.5
        bpy.ops.isimp.keep_lod()
    shown.hide_set(True)
    for number in range(len(LEVELS)):
        level = bpy.data.objects[f"{shown.name}_LOD{number}"]
        level.hide_set(False)
        level.location.x += 1.75 * number
        level.show_wire = level.show_all_edges = True
    yield 0.3


def run(hand):
    isimp.register()
    load(hand.out)
    yield 0.5
    yield from hand.open_tab()
    yield from look(hand)
    panel = bpy.context.window_manager.isimp
    shade(hand, True)
    yield from hand.shot("asset-1-scan")
    shade(hand, False)
    bpy.ops.isimp.partition(proxies=300)
    yield from hand.settle()
    yield from sketched()
    yield from hand.shot("asset-2-regions")
    yield from tool(hand, "isimp.region_tool.object")
    for x, z in ((0.16, 0.38), (-0.2, 0.38), (0.02, 0.3)):  # finer at the eyes and the beak
        yield from hand.click(*place(hand, x, z))
        yield from hand.settle()
    yield from sketched()
    yield from hand.shot("asset-3-clicks")
    yield from tool(hand, "builtin.select_box")
    panel.summary = True
    bpy.ops.isimp.mesh(keep_texture=False)
    yield 0.5
    hand.area.spaces.active.overlay.show_outline_selected = False
    yield from hand.shot("asset-4-polygons")
    bpy.ops.isimp.texture(size=1024)
    yield 0.5
    shade(hand, True)
    bpy.context.object.show_wire = False
    yield from hand.shot("asset-5-texture")
    bpy.context.object.show_wire = True
    yield from levels(hand)
    bpy.ops.object.select_all(action="DESELECT")
    yield from look(hand, 6.7, 2.1)
    yield from hand.shot("asset-6-levels")
