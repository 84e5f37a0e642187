"""The actions in Blender's window for picture 10 of the manual; run by tests/python/blender/window/drive.py.

The scan is the castle: its polygons in the colours of their directions next to the panel Planes.
"""

import bpy
from actions import sketched
from scenario_bunny import FOLDER, load, view

import isimp

REGIONS = 300


def run(hand):
    from isimp.blender.panel import edit, planes

    for panel in (edit.ISIMP_PT_clean_up, planes.ISIMP_PT_planes):  # open from the beginning
        panel.bl_options = set()
    isimp.register()
    load(FOLDER / "building" / "openmvs_castle_175k.ply", upright=True)
    yield 0.5
    yield from hand.open_tab()
    yield from view(hand, (1.0, 0.0, 0.75), (0.1, 0.0, 0.0), 4.3)
    panel = bpy.context.window_manager.isimp
    panel.partition.count_by = "proxies"
    bpy.ops.isimp.partition(proxies=REGIONS)
    yield from hand.settle()
    yield from hand.press("isimp.regularise")
    yield from hand.settle()
    panel.directions = panel.summary = True
    yield from sketched()
    free = hand.region("WINDOW")
    yield from hand.move(free.x + 8, free.y + 8)  # so that no tooltip appears under the mouse
    hand.area.tag_redraw()
    yield 0.5
    yield from hand.shot("picture-10-regularity")
