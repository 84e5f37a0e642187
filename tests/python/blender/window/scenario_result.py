"""The result follows the settings until a user edits it by hand; the tools report that they work on the scan."""

import bpy
from scenario_main import make_scan, same
from scenario_steps import settings, settled
from scenario_tools import view

import isimp


def run(hand):
    isimp.register()
    make_scan(subdivisions=4)
    yield 0.5
    yield from view(hand)
    bpy.ops.isimp.partition("EXEC_DEFAULT", True, proxies=14)
    bpy.ops.isimp.mesh("EXEC_DEFAULT", True)
    yield 0.5
    result = bpy.context.object
    count = len(result.data.polygons)
    settings().partition.proxies = 40
    yield from settled()
    yield 0.5
    same("it follows", (bpy.context.object, len(result.data.polygons) >= 40 > count), (result, True))
    yield from hand.shot("result-1-followed")

    result.data.vertices[0].co.x += 0.2
    result.data.update()
    bpy.ops.ed.undo_push(message="by hand")
    count = len(result.data.polygons)
    settings().partition.proxies = 20
    yield 2.0
    same("edited by hand, it stays", (len(result.data.polygons), len(bpy.data.objects)), (count, 2))
    bpy.ops.isimp.mesh("INVOKE_DEFAULT", True)
    yield from hand.settle()
    made = bpy.context.object
    same("a new one", (made.name, result.hide_get()), ("Scan.simplified.001", True))
    same("with the new setting", 20 <= len(made.data.polygons) < 30, True)
    same("the old one is kept", len(result.data.polygons), count)
    yield from hand.undo()
    same("undone", "Scan.simplified.001" in bpy.data.objects, False)
    yield from hand.shot("result-2-undone")
