"""Work that takes long: the window stays usable, Esc restores all, and no event in between does harm."""

import shutil
import time

import bpy
from scenario_main import make_scan, regions, same, scan

import isimp

DELAY = [0.0]


def slow_down(name):
    """Makes a method of the session wait, polled like the engine, before its work; its last argument is the watch."""
    from isimp.blender.scene import runtime

    session = runtime.get().session
    work = getattr(session, name)

    def slowly(*given):
        end = time.monotonic() + DELAY[0]
        with given[-1].part("waiting", 0.0, 0.5):
            while time.monotonic() < end:
                given[-1].poll()
                time.sleep(0.01)
        return work(*given)

    setattr(session, name, slowly)


def running():
    from isimp.blender.scene import runtime

    return runtime.get().running is not None


def press_slowly(hand, seconds):
    DELAY[0] = seconds
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
    from isimp.engine import engine

    def endless(*given, job, **more):
        while not job.cancelled:
            time.sleep(0.01)
        raise engine.Cancelled("cancelled")

    cut, before = engine.convex_parts, len(bpy.data.objects)
    for work, more in ((endless, 0), (cut, 1)):
        engine.convex_parts = work
        with bpy.context.temp_override(window=hand.window, area=hand.area, region=hand.region("WINDOW")):
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
    for DELAY[0], is_written in ((300.0, False), (1.0, True)):
        with bpy.context.temp_override(window=hand.window, area=hand.area, region=hand.region("WINDOW")):
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


def run(hand):
    isimp.register()
    make_scan()
    slow_down("replay")
    yield 0.5
    yield from hand.open_tab()
    yield from hand.press("isimp.partition")
    before = regions()
    assert before > 0
    bpy.context.window_manager.isimp.live = False  # else the number alone would be a step
    bpy.context.window_manager.isimp.partition.count_by = "proxies"
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
    DELAY[0] = 0.0
    bpy.context.window_manager.isimp.partition.count_by = "proxies"
    yield 0.3
    yield from hand.type_into("partition.proxies", "6")
    yield from hand.press("isimp.partition")
    same("works in the new file", len(bpy.context.object.data.attributes["isimp_region"].data), 6)
    yield from hand.press("isimp.mesh")
    yield from colliders_stopped(hand)
    yield from report_stopped(hand)
