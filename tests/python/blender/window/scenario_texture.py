"""A texture is made while the window works: the view moves, Esc leaves the last good result, one step to undo."""

import bpy
import numpy as np
from scans import material_of
from scenario_long_work import DELAY, ended, moved_then_stopped, running, slow_down
from scenario_main import make_scan, same, scan

import isimp


def paint(colour):
    """Adds an image of one colour to the scan."""
    image = bpy.data.images.new("Paint", 16, 16)
    image.pixels.foreach_set(np.tile(np.append(colour, 1), 256).astype(np.float32))
    image.pack()
    scan().data.materials.clear()
    scan().data.materials.append(material_of("Scan", image))


def red():
    """The red of the result's image, None without a result; of 255."""
    result = bpy.data.objects.get("Scan.simplified")
    if result is None or not len(result.data.materials):
        return None
    shader = next(n for n in result.data.materials[0].node_tree.nodes if n.type == "BSDF_PRINCIPLED")
    image = shader.inputs["Base Color"].links[0].from_node.image
    return round(255 * image.pixels[0])


def press(hand, name, **settings):
    with bpy.context.temp_override(window=hand.window, area=hand.area, region=hand.region("WINDOW")):
        getattr(bpy.ops.isimp, name)("INVOKE_DEFAULT", True, **settings)


def changed(hand):
    """A setting that is changed on the result makes it again, with its texture; Esc restores the setting."""
    partition, result = bpy.context.window_manager.isimp.partition, bpy.context.object
    partition.proxies = 24
    for _ in range(300):
        yield 0.1
        if len(result.data.polygons) >= 24 and not running():
            break
    same("a changed setting", (len(result.data.polygons) >= 24, red(), bpy.context.object), (True, 255, result))
    count, DELAY[0] = len(result.data.polygons), 300.0
    partition.proxies = 30
    for _ in range(300):
        yield 0.1
        if running():
            break
    yield from hand.into_view()
    yield from hand.key("ESC")
    yield from ended(hand)
    yield 1.0
    same("after Esc", (partition.proxies, len(result.data.polygons), running()), (24, count, False))


def run(hand):
    isimp.register()
    make_scan(4)
    slow_down("texture")
    paint((1.0, 0.0, 0.0))
    bpy.ops.isimp.partition(proxies=12)
    bpy.ops.ed.undo_push(message="partition")
    yield 0.5

    DELAY[0] = 300.0
    press(hand, "mesh")
    yield 0.6
    same("Mesh under way", (running(), red()), (True, None))
    yield from moved_then_stopped(hand)
    same("Mesh after Esc", red(), None)

    DELAY[0] = 1.0
    press(hand, "mesh")
    yield 0.3
    yield from ended(hand)
    yield 0.3
    same("made", red(), 255)

    yield from changed(hand)

    paint((0.0, 0.0, 1.0))
    DELAY[0] = 300.0
    press(hand, "texture", size=64)
    yield 0.6
    same("under way", (running(), red()), (True, 255))
    yield from hand.into_view()
    yield from hand.key("ESC")
    yield from ended(hand)
    same("after Esc", red(), 255)

    DELAY[0] = 0.5
    press(hand, "texture", size=64)
    yield 0.3
    yield from ended(hand)
    yield 0.3
    same("made again", red(), 0)
    yield from hand.undo()
    same("one step to undo", red(), 255)
