"""The times during which the add-on blocks a real window, on a scan of many faces, by part.

    python -m bench.studies.window_times SCAN.ply [--site FOLDER]  the folder with isimp_engine, if not this Python's

Starts Blender under Xvfb, drags the number of regions, adds and deletes one, and prints the time of each part: the
engine, on one thread; the other work of the worker's thread, in numpy; the add-on on the window's own thread, in sum
and the longest piece at once; its draw calls there, which software drawing (llvmpipe) answers by transforming every
corner, as no graphics card would; Blender itself there (its copy for undo too) until colours are on the screen; and the
excess of that over Blender's own time for as many redraws of the scan as it is, in the same window and scene before the
add-on is switched on; where settings settle, for one with colours written again and a step to undo.
Processor time, as other programs hardly disturb it.
"""

import argparse
import os
import subprocess
import sys
import threading
import time
from contextlib import suppress
from functools import partial
from pathlib import Path
from statistics import median

ROOT = Path(__file__).resolve().parents[2]
WINDOW = ROOT / "tests" / "python" / "blender" / "window"
VALUES = (210, 260, 300, 400, 220, 500, 340)
FACES = (1000, 200_000, 500_000)


def start(scan, site, scenario=None):
    """Runs a file as a scenario (see drive.py); this one if none is given."""
    scenario = scenario or Path(__file__).resolve()
    blender = ["blender", "--factory-startup", "--enable-event-simulate", "-p", "0", "0", "800", "640"]
    script = ["--python", str(WINDOW / "drive.py"), "--", str(scenario), "."]
    environment = os.environ | {"ISIMP_SITE": os.pathsep.join([str(ROOT / "addon"), *site]), "ISIMP_SCAN": str(scan)}
    command = ["xvfb-run", "-a", "-s", "-screen 0 800x640x24", *blender, *script]
    return subprocess.run(command, env=environment, check=False).returncode


class Clock(threading.local):
    """Processor time of the window's thread by owner, since the last report; inner calls count for their own owner."""

    def __init__(self):
        self.spent, self.longest, self.inside = {}, 0.0, []

    def around(self, owner, name, who):
        """Counts the time of a function for an owner, and not for its caller."""
        function = getattr(owner, name)

        def timed(*args, **more):
            begin = time.thread_time()
            self.inside.append(0.0)
            try:
                return function(*args, **more)
            finally:
                taken = 1000 * (time.thread_time() - begin)
                own = taken - self.inside.pop()
                if self.inside:
                    self.inside[-1] += taken
                self.spent[who] = self.spent.get(who, 0.0) + own
                if who == "add-on":
                    self.longest = max(self.longest, own)

        setattr(owner, name, timed)
        return timed

    def told(self):
        told = self.spent, self.longest
        self.spent, self.longest = {}, 0.0
        return told


def by_threads() -> dict:
    """{thread: seconds of processor time} for the present threads of this process."""
    found = {}
    for folder in Path("/proc/self/task").iterdir():
        with suppress(FileNotFoundError):  # it has ended
            found[folder.name] = int((folder / "schedstat").read_text().split()[0]) / 1e9
    return found


class Work:
    """Processor time in the engine and outside it while a recipe is replayed, since the last report.

    The engine works on threads of its own, which end with the call: their time is the time of the process minus the
    time of the threads that were there before.
    """

    def __init__(self):
        self.engine = self.total = 0.0

    def around(self, owner, name, what):
        function = getattr(owner, name)

        def timed(*args, **more):
            begin, before = time.thread_time(), (time.process_time(), by_threads())
            try:
                return function(*args, **more)
            finally:
                taken = time.thread_time() - begin
                if what == "engine":
                    now = by_threads()
                    others = sum(now[thread] - spent for thread, spent in before[1].items() if thread in now)
                    taken = time.process_time() - before[0] - others
                setattr(self, what, getattr(self, what) + 1000 * taken)

        setattr(owner, name, timed)

    def told(self):
        told = self.engine, self.total
        self.engine = self.total = 0.0
        return told


def load(path):
    import bpy
    import numpy as np

    from isimp import session

    points, triangles = session.engine.read(path)
    count = len(triangles)
    mesh = bpy.data.meshes.new("Scan")
    mesh.vertices.add(len(points))
    mesh.loops.add(3 * count)
    mesh.polygons.add(count)
    mesh.vertices.foreach_set("co", np.asarray(points, np.float32).ravel())
    mesh.loops.foreach_set("vertex_index", np.asarray(triangles, np.int32).ravel())
    mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * count, 3, dtype=np.int32))
    mesh.polygons.foreach_set("loop_total", np.full(count, 3, np.int32))
    mesh.update(calc_edges=True)
    for other in list(bpy.data.objects):
        bpy.data.objects.remove(other)
    obj = bpy.data.objects.new("Scan", mesh)
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    obj.select_set(True)
    bpy.ops.ed.undo_push(message="scan")
    print(f"{count:,} faces, Blender {bpy.app.version_string}")


def run(hand):
    import bpy

    import isimp
    from isimp import session
    from isimp.blender import preferences
    from isimp.blender.drawing import shaders
    from isimp.blender.scene import runtime
    from isimp.blender.view import overlay
    from isimp.blender.work import live, modal, panel_changes, preview

    load(os.environ["ISIMP_SCAN"])
    yield 1
    with bpy.context.temp_override(window=hand.window, area=hand.area, region=hand.region("WINDOW")):
        bpy.ops.view3d.view_selected()
    yield 1
    clock, work, drawn, rows = Clock(), Work(), [], []
    add = bpy.types.SpaceView3D.draw_handler_add
    wanted = []  # whether the requested colours are on the screen

    def ended():
        if wanted:
            drawn.append((time.thread_time(), wanted[0]()))

    on_screen = add(ended, (), "WINDOW", "POST_PIXEL")

    def measured(what, do, until=lambda: True):
        clock.told()
        work.told()
        drawn.clear()
        begin = time.thread_time()
        do()
        wanted[:] = [until]
        while not (drawn and drawn[-1][1]):
            yield 0.01
        wanted.clear()
        rows.append((what, 1000 * (drawn[-1][0] - begin), len(drawn), work.told(), *clock.told()))
        yield 0.5

    yield from alone(hand, measured)
    isimp.register()
    preferences.obey = lambda context, session: setattr(session, "threads", 1)
    bpy.context.window_manager.isimp.outline = False
    bpy.ops.isimp.partition("EXEC_DEFAULT", True, proxies=200)
    yield 2
    for owner, name in (
        (session.engine.states, "partitioned"),
        (session.engine.replay, "edited"),
    ):
        work.around(owner, name, "engine")
    for kind in (preview.Work, modal.Work):
        work.around(kind, "run", "total")
        clock.around(kind, "run", "worker")  # where there is no thread for it
    clock.around(shaders, "draw", "driver")
    execute = clock.around(modal.RecipeOperator, "execute", "add-on")
    modal.RecipeOperator.execute = lambda self, context: execute(self, context)  # Blender counts arguments
    clock.around(panel_changes, "write_shown", "add-on")
    clock.around(live, "settle", "Blender")
    tick = clock.around(live, "_tick", "add-on")
    runtime.get().live.wake = lambda: bpy.app.timers.is_registered(tick) or bpy.app.timers.register(tick)
    for handle in runtime.get().handles:
        bpy.types.SpaceView3D.draw_handler_remove(handle, "WINDOW")
    runtime.get().handles = (add(clock.around(overlay, "_draw", "add-on"), (), "WINDOW", "POST_VIEW"),)
    panel = bpy.context.window_manager.isimp.partition

    live._SETTLED = 600.0
    for value in VALUES:

        def is_shown(value=value):
            shown = runtime.get().live.shown
            return shown is not None and shown.work.recipe.steps[0].proxies == value

        yield from measured("slider", lambda value=value: setattr(panel, "proxies", value), is_shown)
    live._SETTLED = 0.0
    yield from measured("settle", runtime.get().live.touch, lambda: runtime.get().live.shown is None)
    for name in ("add_proxy", "delete_proxy"):
        for face in FACES:
            if face < len(bpy.context.object.data.polygons):
                call = partial(getattr(bpy.ops.isimp, name), "EXEC_DEFAULT", True, face=face)
                yield from measured(name, call)
    bpy.types.SpaceView3D.draw_handler_remove(on_screen, "WINDOW")
    show(rows)


def alone(hand, measured):
    """Blender's own time for the work that the add-on causes."""
    import bpy
    import numpy as np

    obj = bpy.context.object
    layer = obj.data.attributes.new("Own", "FLOAT_COLOR", "CORNER")
    obj.data.color_attributes.active_color = obj.data.color_attributes["Own"]
    hand.area.spaces.active.shading.color_type = "VERTEX"
    colors = np.random.default_rng(1).random(4 * len(layer.data), np.float32)

    def write():
        bpy.context.object.data.attributes["Own"].data.foreach_set("color", colors)
        bpy.context.object.data.update()
        bpy.ops.ed.undo_push(message="own")

    yield from measured("", write)
    for _ in range(5):
        yield from measured("redraw alone", hand.area.tag_redraw)
    for _ in range(5):
        yield from measured("colours alone", write)
    obj = bpy.context.object
    obj.data.attributes.remove(obj.data.attributes["Own"])
    bpy.ops.ed.undo_push(message="as before")
    yield 0.5


def show(rows):
    rows = rows[1:]  # without the row of the first colours
    names = ("engine", "numpy", "add-on", "longest", "driver", "Blender", "more", "redraws")
    redraw, colors = (median(row[1] for row in rows if row[0] == f"{what} alone") for what in ("redraw", "colours"))
    print(f"{'':14}" + "".join(f"{name:>12}" for name in names) + "   ms of processor time, median (most)")
    for what in dict.fromkeys(row[0] for row in rows):
        cells = []
        for _, window, redraws, (engine, total), spent, longest in (row for row in rows if row[0] == what):
            ours = {name: spent.get(name, 0.0) for name in ("add-on", "driver", "worker")}
            blender = window - sum(ours.values())
            alone = redraws * redraw if what not in {"settle", "colours alone"} else colors + (redraws - 1) * redraw
            cells.append((engine, total, ours["add-on"], longest, ours["driver"], blender, blender - alone, redraws))
        columns = (sorted(column) for column in zip(*cells, strict=True))
        print(f"{what:14}" + "".join(f"{f'{c[len(c) // 2]:.0f} ({c[-1]:.0f})':>12}" for c in columns), flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("scan", type=Path)
    parser.add_argument("--site", action="append", help="a folder with isimp_engine")
    options = parser.parse_args()
    sys.exit(start(options.scan.resolve(), options.site or [p for p in sys.path if p.endswith("-packages")]))
