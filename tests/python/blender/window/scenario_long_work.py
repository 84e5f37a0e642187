"""Work that takes long: the window stays usable, Esc restores all, and no event in between does harm."""

import shutil
import time

import bpy
import numpy as np
from actions import make_scan, regions, running, same, scan, settings
from scans import material_of

import isimp
from isimp.blender.scene import runtime
from isimp.engine import engine

DELAYS = {"replay": 0.0, "texture": 0.0}  # seconds before the work of these methods of the session


def slow_down(name):
    """Makes a method of the session wait, polled like the engine, before its work; its last argument is the watch."""
    session = runtime.get().session
    work = getattr(session, name)

    def slowly(*given):
        end = time.monotonic() + DELAYS[name]
        with given[-1].part("waiting", 0.0, 0.5):
            while time.monotonic() < end:
                given[-1].poll()
                time.sleep(0.01)
        return work(*given)

    setattr(session, name, slowly)


def press_slowly(hand, seconds):
    DELAYS["replay"] = seconds
    yield from hand.find("bpy.ops.isimp.partition")
    yield from hand.click(*hand.at)
    yield 0.6
    same("under way", running(), True)


def ended(hand):
    for _ in range(100):
        if not running():
            return
        yield 0.1
    raise AssertionError("it did not end")


def moved_then_stopped(hand):
    """While work is under way the view can be moved, and Esc ends it."""
    yield from hand.into_view()
    place = hand.area.spaces.active.region_3d.view_distance
    yield from hand.key("WHEELUPMOUSE")
    yield 0.3
    assert hand.area.spaces.active.region_3d.view_distance != place, "the view can't be moved meanwhile"
    yield from hand.key("ESC")
    yield from ended(hand)


def colliders_stopped(hand):
    """Esc ends Colliders without a new object; pressed again, they are made."""

    def endless(*given, job, **more):
        while not job.cancelled:
            time.sleep(0.01)
        raise engine.Cancelled("cancelled")

    cut, before = engine.convex_parts, len(bpy.data.objects)
    for work, more in ((endless, 0), (cut, 1)):
        engine.convex_parts = work
        with hand.within():
            bpy.ops.isimp.colliders("INVOKE_DEFAULT", True)
        if work is endless:
            yield 0.3
            same("colliders under way", (running(), bpy.ops.isimp.colliders.poll()), (True, False))
            yield from moved_then_stopped(hand)
        yield from hand.settle()
        same("colliders", len(bpy.data.objects), before + more)


def report_stopped(hand):
    """A thread writes a report after Blender's dialog; Esc ends it without a file."""
    folder = hand.out / "report"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    for DELAYS["replay"], is_written in ((300.0, False), (1.0, True)):
        with hand.within():
            bpy.ops.isimp.write_report("INVOKE_DEFAULT", directory=f"{folder}/")
        yield 1.0
        places = [(window, area) for window in bpy.context.window_manager.windows for area in window.screen.areas]
        window, area = next(place for place in places if place[1].type == "FILE_BROWSER")
        region = next(region for region in area.regions if region.type == "WINDOW")
        with bpy.context.temp_override(window=window, area=area, region=region):
            bpy.ops.file.execute()
        yield 0.5
        same("report under way", running(), True)
        if not is_written:
            yield from moved_then_stopped(hand)
        yield from hand.settle()
        same("report", (folder / "report.html").exists(), is_written)


def red():
    """The red of the result's image, None without a result; of 255."""
    result = bpy.data.objects.get("Scan.simplified")
    if result is None or not len(result.data.materials):
        return None
    shader = next(n for n in result.data.materials[0].node_tree.nodes if n.type == "BSDF_PRINCIPLED")
    image = shader.inputs["Base Color"].links[0].from_node.image
    return round(255 * image.pixels[0])


def texture_stopped(hand):
    """Mesh makes the texture too: Esc meanwhile leaves no result."""
    make_scan(4)
    image = bpy.data.images.new("Paint", 16, 16)
    image.pixels.foreach_set(np.tile([1, 0, 0, 1], 256).astype(np.float32))
    image.pack()
    scan().data.materials.append(material_of("Scan", image))
    bpy.ops.isimp.partition(proxies=12)
    bpy.ops.ed.undo_push(message="partition")
    slow_down("texture")
    yield 0.5
    for DELAYS["texture"], made in ((300.0, None), (1.0, 255)):
        with hand.within():
            bpy.ops.isimp.mesh("INVOKE_DEFAULT", True)
        yield 0.6
        same("Mesh under way", (running(), red()), (True, None))
        if made is None:
            yield from moved_then_stopped(hand)
        yield from ended(hand)
        yield 0.3
        same("texture", red(), made)
    yield from texture_changed(hand)


def texture_changed(hand):
    """A setting that is changed on the result makes it again, with its texture; Esc restores the setting."""
    partition, result = settings().partition, bpy.context.object
    partition.proxies = 24
    for _ in range(300):
        yield 0.1
        if len(result.data.polygons) >= 24 and not running():
            break
    same("a changed setting", (len(result.data.polygons) >= 24, red(), bpy.context.object), (True, 255, result))
    count, DELAYS["texture"] = len(result.data.polygons), 300.0
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
    make_scan()
    slow_down("replay")
    yield 0.5
    yield from hand.open_tab()
    yield from hand.press("isimp.partition")
    before = regions()
    assert before > 0
    settings().live = False  # else the number alone would be a step
    settings().partition.count_by = "proxies"
    yield from hand.type_into("partition.proxies", "9")

    yield from press_slowly(hand, 300)
    same("a second press", bpy.ops.isimp.partition.poll(), False)
    yield from hand.shot("6-working")
    yield from moved_then_stopped(hand)
    same("after Esc", regions(), before)
    yield 0.3
    same("ready again", bpy.ops.isimp.partition.poll(), True)

    yield from press_slowly(hand, 300)
    yield from hand.press("isimp.stop")
    same("after Stop", (running(), regions()), (False, before))

    yield from press_slowly(hand, 3)
    yield from ended(hand)
    yield 0.3
    same("done after a wait", regions(), 9)
    yield from hand.undo()
    same("one step to undo", regions(), before)

    yield from press_slowly(hand, 3)
    bpy.data.objects.remove(scan())
    yield from ended(hand)
    same("scan deleted meanwhile", "Scan" in bpy.data.objects, False)

    make_scan()
    yield 0.3
    yield from press_slowly(hand, 300)
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    yield 1.0
    same("file closed meanwhile", running(), False)
    yield from hand.open_tab()
    DELAYS["replay"] = 0.0
    settings().partition.count_by = "proxies"
    yield 0.3
    yield from hand.type_into("partition.proxies", "6")
    yield from hand.press("isimp.partition")
    same("works in the new file", len(bpy.context.object.data.attributes["isimp_region"].data), 6)
    yield from hand.press("isimp.mesh")
    yield from colliders_stopped(hand)
    yield from report_stopped(hand)
    yield from texture_stopped(hand)
