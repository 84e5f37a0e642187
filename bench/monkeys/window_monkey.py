"""Clicks, drags and keys at random over the panel and the view of a real window, as fast as Blender takes them.

    python -m bench.monkeys.window_monkey [--seconds 600] [--seed 1] [--out out/window_monkey]

It starts Blender under Xvfb (Debian: blender, xvfb, imagemagick) by tests/python/blender/window/drive.py. The engine is
found by PYTHONPATH. Each event is written to OUT/events.log before it is sent, so that the last line names the one that
ended Blender. Every few events it checks for failures: a traceback, a changed or moved scan, endless work. It ends with
1 after a failure. The same seed gives the same events as far as Blender is as fast.
"""

import argparse
import io
import os
import random
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
WINDOW = ROOT / "tests" / "python" / "blender" / "window"
SIZE = 640, 800  # little to draw
TOOLS = ("region", "paint", "cut", "grow", "opening")
#: keys, and keys held with them; none that ends Blender, deletes or moves objects
KEYS = (
    *(("Z", {"ctrl": True}),) * 4,
    *(("Z", {"ctrl": True, "shift": True}),) * 2,
    *(
        (key, {})
        for key in ("TAB", "L", "F", "ESC", "RET", "A", "NUMPAD_PERIOD", "ONE", "THREE", "NUMPAD_1", "NUMPAD_5")
    ),
)
HELD = ({}, {}, {}, {"ctrl": True}, {"shift": True}, {"alt": True}, {"ctrl": True, "shift": True})


class Monkey:
    def __init__(self, hand, seed: int):
        self.hand, self.random = hand, random.Random(seed)
        self.log = hand.out / "events.log"
        self.log.unlink(missing_ok=True)
        self.count = 0

    def note(self, *what) -> None:
        self.count += 1
        with self.log.open("a") as log:
            log.write(f"{self.count} {' '.join(map(str, what))}\n")

    def place(self) -> tuple:
        """A place in the view or, as often, in the sidebar."""
        view, side = self.hand.region("WINDOW"), self.hand.region("UI")
        if side.width > 1 and self.random.random() < 0.5:
            return side.x + self.random.uniform(5, side.width - 25), side.y + self.random.uniform(5, side.height - 5)
        wide = view.width - (side.width if side.width > 1 else 0)
        return view.x + self.random.uniform(60, max(61, wide - 10)), view.y + self.random.uniform(30, view.height - 80)

    def click(self):
        at, held = self.place(), self.random.choice(HELD)
        self.note("click", *map(int, at), held)
        yield from self.hand.move(*at)
        self.hand.event("LEFTMOUSE", "PRESS", **held)
        yield
        self.hand.event("LEFTMOUSE", "RELEASE", **held)
        yield

    def drag(self):
        begin, held = self.place(), self.random.choice(HELD)
        ends = [self.place() for _ in range(self.random.randint(1, 4))]
        drop = self.random.choice((None, None, None, "ESC", "RIGHTMOUSE", "Z"))
        self.note("drag", *map(int, begin), held, [tuple(map(int, end)) for end in ends], drop)
        yield from self.hand.move(*begin)
        self.hand.event("LEFTMOUSE", "PRESS", **held)
        yield
        for end in ends:
            yield from self.hand.move(*end)
        if drop:
            yield from self.hand.key(drop, **({"ctrl": True} if drop == "Z" else {}))
        self.hand.event("LEFTMOUSE", "RELEASE", **held)
        yield

    def key(self):
        at, (kind, held) = self.place(), self.random.choice(KEYS)
        self.note("key", *map(int, at), kind, held)
        yield from self.hand.move(*at)
        self.hand.event(kind, "PRESS", **held)
        yield
        self.hand.event(kind, "RELEASE", **held)
        yield

    def wheel(self):
        at, kind = self.place(), self.random.choice(("WHEELUPMOUSE", "WHEELDOWNMOUSE"))
        held = self.random.choice(({}, {"ctrl": True}))
        self.note("wheel", *map(int, at), kind, held)
        yield from self.hand.move(*at)
        for _ in range(self.random.randint(1, 4)):
            self.hand.event(kind, "PRESS", **held)
            yield

    def tool(self):
        import bpy

        name = f"isimp.{self.random.choice(TOOLS)}_tool.{bpy.context.mode.lower()}"
        self.note("tool", name)
        with bpy.context.temp_override(window=self.hand.window, area=self.hand.area, region=self.hand.region("WINDOW")):
            if bpy.context.mode in ("OBJECT", "EDIT_MESH"):
                bpy.ops.wm.tool_set_by_id(name=name)
        yield

    def rest(self):
        """Ends all open tools, and waits for the end of work."""
        import bpy

        from isimp.blender.scene import runtime

        for window in list(bpy.context.window_manager.windows)[1:]:
            with bpy.context.temp_override(window=window):
                bpy.ops.wm.window_close()
        yield from self.hand.move(*self.place())
        yield from self.hand.key("ESC")
        end = time.time() + 120
        while runtime.get().running is not None or runtime.get().live.work is not None:
            assert time.time() < end, "work does not end"
            yield 0.1


def scan_there():
    """The scan, if it exists and is visible."""
    import bpy

    scan = bpy.data.objects.get("Scan")
    return scan if scan is not None and scan.visible_get() else None


def run(hand):
    """The scenario that drive.py runs in Blender."""
    sys.path[:0] = [str(WINDOW), str(WINDOW.parent)]
    import bpy
    import scans
    from scenario_main import make_scan

    import isimp
    from isimp import blender

    for cls in blender._CLASSES:
        if issubclass(cls, bpy.types.Panel):
            cls.bl_options = set() if hasattr(cls, "bl_parent_id") else {"HIDE_HEADER"}
    isimp.register()
    seed, seconds = int(os.environ["ISIMP_MONKEY_SEED"]), float(os.environ["ISIMP_MONKEY_SECONDS"])
    make_scan(4)
    bpy.ops.isimp.partition("EXEC_DEFAULT", True, proxies=14)
    path = str(hand.out / "scan.blend")  # opened, so that no undo reaches back before it
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path, load_ui=False)
    yield 0.5
    yield from hand.open_tab()
    scan = bpy.data.objects["Scan"]
    monkey, mesh = Monkey(hand, seed), scan.data.name
    before, place = scans.geometry(scan.data), scan.matrix_world.copy()
    told, sys.stderr = sys.stderr, io.StringIO()
    verbs = {monkey.click: 40, monkey.drag: 25, monkey.key: 15, monkey.wheel: 8, monkey.tool: 8}
    end = time.time() + seconds
    while time.time() < end:
        (verb,) = monkey.random.choices(list(verbs), list(verbs.values()))
        yield from verb()
        if monkey.count % 20:
            continue
        yield from monkey.rest()
        if bpy.context.view_layer.objects.active is None and scan_there():
            bpy.context.view_layer.objects.active = scan_there()
        found = [obj for obj in bpy.data.objects if obj.type == "MESH" and obj.data.name == mesh]
        for obj in found:
            obj.update_from_editmode()
            assert scans.geometry(obj.data) == before, "the scan has changed"
            assert obj.matrix_world == place, "the scan was moved"
        written = sys.stderr.getvalue()
        if "Traceback" in written:
            told.write(written)
            raise AssertionError(f"a traceback at event {monkey.count}")
    sys.stderr = told
    print(f"{monkey.count} events, nothing broke", flush=True)
    yield from hand.shot("end")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seconds", type=float, default=600)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "window_monkey")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    folders = [str(ROOT / "addon"), os.environ.get("ISIMP_SITE", ""), os.environ.get("PYTHONPATH", "")]
    environment = os.environ | {
        "ISIMP_SITE": os.pathsep.join(folders),
        "ISIMP_MONKEY_SEED": str(options.seed),
        "ISIMP_MONKEY_SECONDS": str(options.seconds),
    }
    blender = ["blender", "--factory-startup", "--enable-event-simulate", "-p", "0", "0", *map(str, SIZE)]
    script = ["--python", str(WINDOW / "drive.py"), "--", str(Path(__file__).resolve()), str(options.out)]
    screen = f"-screen 0 {SIZE[0]}x{SIZE[1]}x24"
    with (options.out / "blender.log").open("w+") as log:
        command = ["xvfb-run", "-a", "-s", screen, *blender, *script]
        code = subprocess.run(command, env=environment, stdout=log, stderr=log, check=False).returncode
        log.seek(0)
        print(log.read()[-3000:])
    if code:
        events = options.out / "events.log"
        last = events.read_text().splitlines()[-1:] if events.exists() else ["none"]
        print(f"ended with {code}; the last event: {''.join(last)}")
    return 1 if code else 0


if __name__ == "__main__":
    sys.exit(main())
