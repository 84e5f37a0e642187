"""The pieces of the add-on that block a real window longest, action by action, on a scan of many faces.

    python -m bench.studies.window_pieces SCAN.ply [--site FOLDER]  the folder with isimp_engine, if not this Python's

Starts Blender under Xvfb, presses, points and clicks, and prints for each action the longest call of the add-on by
Blender on the window's thread, with everything that it calls, in processor time. The time of Blender's own functions in
it is listed too, largest first: reading and writing of arrays, changes of mode, draw calls (which software drawing
answers by transforming every corner). At the end: the process's peak of memory.
"""

import argparse
import os
import resource
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))  # Blender runs a file, not a module

from bench.studies import window_times

# Functions of Blender's, by the ends of their names. Functions called by way of RNA, such as `update_from_editmode`,
# are not seen.
BLENDERS = ("foreach_get", "foreach_set", "GPUBatch.draw", "attr_fill")
LAYER_UPDATE = "_view_layer_update"  # function of bpy.ops that evaluates changed data


class Pieces:
    """Calls of the add-on on this thread, recorded by a profiler."""

    def __init__(self):
        self.outermost, self.begin, self.open, self.blenders = None, 0.0, [], []
        self.found = []  # (ms, where, [(ms, function of Blender's)])

    def profile(self, frame, event, called):
        if event == "call":
            if self.outermost is None and "/addon/isimp/" in frame.f_code.co_filename:
                self.outermost, self.open, self.blenders = frame, [], []
                self.begin = time.thread_time()
            elif self.outermost is not None:
                self.open.append((frame.f_code.co_name, time.thread_time()))
        elif event == "c_call" and self.outermost is not None:
            self.open.append((getattr(called, "__qualname__", ""), time.thread_time()))
        elif event == "return" and frame is self.outermost:
            where = f"{Path(frame.f_code.co_filename).name}: {frame.f_code.co_name}"
            self.found.append((1000 * (time.thread_time() - self.begin), where, sorted(self.blenders, reverse=True)))
            self.outermost = None
        elif event in {"return", "c_return", "c_exception"} and self.outermost is not None and self.open:
            name, begin = self.open.pop()
            if name.endswith(BLENDERS) or name == LAYER_UPDATE:
                self.blenders.append((1000 * (time.thread_time() - begin), name.rpartition(".")[2]))

    def show(self, action):
        """Prints the longest call since the last time."""
        taken, where, blenders = max(self.found, key=lambda piece: piece[0], default=(0.0, "", []))
        self.found.clear()
        told = ", ".join(f"{name} {ms:.0f}" for ms, name in blenders[:3] if ms >= 1)
        print(f"{action:18}{taken:8.0f}{taken - sum(ms for ms, _ in blenders):8.0f}   {where} ({told})", flush=True)


def run(hand):
    import bpy

    import isimp
    from isimp.blender.scene import runtime

    def here():
        return bpy.context.temp_override(window=hand.window, area=hand.area, region=hand.region("WINDOW"))

    def ended():
        """Waits until nothing is under way, the overlay too."""
        still = 0
        while still < 3:
            current = runtime.get()
            busy = current.running is not None or current.sketching is not None or current.live.work is not None
            still = 0 if busy else still + 1
            hand.area.tag_redraw()
            yield 0.3

    window_times.load(os.environ["ISIMP_SCAN"])
    yield 1
    with here():
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_selected()
    isimp.register()
    yield 1
    pieces = Pieces()
    print(f"{'':18}{'ms':>8}{'own':>8}   longest call (of it Blender's, ms)")
    sys.setprofile(pieces.profile)

    def did(action, steps):
        pieces.found.clear()
        yield from steps or ()
        yield from ended()
        pieces.show(action)

    def pressed(name, **settings):
        with here():
            getattr(bpy.ops.isimp, name)("INVOKE_DEFAULT", True, **settings)
        yield 0.1

    view = hand.region("WINDOW")
    middle = view.x + 0.5 * view.width, view.y + 0.5 * view.height

    def pointed():
        for step in range(200):
            yield from hand.move(middle[0] + step % 40, middle[1] + step % 7)
            yield 0.05
            if runtime.get().hover is not None and step > 40:
                return

    def told(action, **held):
        yield from did(action, hand.click(*middle, **held))
        yield from did(f"{action}: point", pointed())

    def stroke(width):
        """A stroke with the Paint tool over a share of the view."""
        here = view.x + (0.5 - 0.5 * width) * view.width
        yield from hand.move(here, middle[1])
        hand.event("LEFTMOUSE", "PRESS", ctrl=True)
        yield 0.1
        for step in range(1, 21):
            hand.at = (here + width * view.width * step / 20, middle[1])
            hand.event("MOUSEMOVE", "NOTHING", ctrl=True)
            yield 0.05
        hand.event("LEFTMOUSE", "RELEASE", ctrl=True)
        yield 0.1

    yield from did("partition", pressed("partition"))
    with here():
        bpy.ops.wm.tool_set_by_id(name="isimp.region_tool.object")
    yield from did("point", pointed())
    yield from told("add")
    yield from told("delete", ctrl=True)
    yield from told("select", alt=True)
    yield from did("undo", hand.undo())
    yield from did("undo: point", pointed())
    with here():
        bpy.ops.wm.tool_set_by_id(name="isimp.paint_tool.object")
    bpy.context.window_manager.isimp.brush = 60
    yield from did("stroke", stroke(0.1))
    yield from did("large stroke", stroke(0.6))
    with here():
        bpy.ops.wm.tool_set_by_id(name="isimp.region_tool.object")
    yield from did("even borders", pressed("even_borders"))
    yield from did("mesh", pressed("mesh"))
    yield from did("swap", pressed("swap"))
    yield from did("select small", pressed("select_by", by="SIZE"))
    yield from did("select up, edit", pressed("select_by", by="DIRECTION"))
    yield from did("select bent, edit", pressed("select_by", by="FLATNESS"))
    yield from hand.into_view()
    yield from did("out of Edit Mode", hand.key("TAB"))
    yield from hand.into_view()
    yield from did("into Edit Mode", hand.key("TAB"))
    yield from did("add, Edit Mode", pressed("add_proxy", face=1000))
    sys.setprofile(None)
    print(f"peak {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:,.0f} MB")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("scan", type=Path)
    parser.add_argument("--site", action="append", help="a folder with isimp_engine")
    options = parser.parse_args()
    folders = options.site or [p for p in sys.path if p.endswith("-packages")]
    sys.exit(window_times.start(options.scan.resolve(), folders, Path(__file__).resolve()))
