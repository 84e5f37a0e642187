"""Drives a real Blender window: `blender --enable-event-simulate ... --python drive.py -- SCENARIO.py OUT`.

A scenario is a module with a function `run(hand)`, a generator: every `yield` lets Blender handle the events before it
(`yield 0.5` waits that many seconds). Buttons are found by their action, not by their place. Ends Blender with 0 if the
scenario came to its end. With ISIMP_WINDOW_QUICK set views are drawn plainly, and no pictures are made.
"""

import os
import subprocess
import sys
import time
import traceback
from importlib import util
from pathlib import Path

sys.path[:0] = [folder for folder in os.environ.get("ISIMP_SITE", "").split(os.pathsep) if folder]

import bpy  # noqa: E402  (after the folders above)

bpy.context.preferences.view.show_splash = False
bpy.context.preferences.view.show_tooltips = False
bpy.context.preferences.view.smooth_view = 0
# Mesa draws each pixel on the CPU: without these a view is drawn in a quarter of the time. Pictures are smoothed.
bpy.context.preferences.system.viewport_aa = "OFF"
bpy.context.preferences.system.use_region_overlap = False
QUICK = "ISIMP_WINDOW_QUICK" in os.environ

TICK = 0.02
KEYS = {"0": "ZERO", "1": "ONE", "2": "TWO", "3": "THREE", "4": "FOUR", "5": "FIVE", "6": "SIX", "7": "SEVEN"}
KEYS |= {"8": "EIGHT", "9": "NINE", ".": "PERIOD"}


class Hand:
    """Mouse and keyboard. Methods that take time are generators: `yield from hand.click(...)`."""

    def __init__(self, out):
        self.out = out
        self.at = (0, 0)
        self.known = {}  # last places of buttons

    @property
    def window(self):
        return bpy.context.window_manager.windows[0]

    @property
    def area(self):
        areas = (area for area in self.window.screen.areas if area.type == "VIEW_3D")
        return max(areas, key=lambda area: area.width * area.height)

    def region(self, kind):
        return next(region for region in self.area.regions if region.type == kind)

    def within(self, kind="WINDOW"):
        """The context of operators that are called in a region of the viewport."""
        return bpy.context.temp_override(window=self.window, area=self.area, region=self.region(kind))

    def event(self, kind, value, **more):
        self.window.event_simulate(type=kind, value=value, x=int(self.at[0]), y=int(self.at[1]), **more)

    def move(self, x, y):
        self.at = (x - 1, y)
        self.event("MOUSEMOVE", "NOTHING")
        yield
        self.at = (x, y)
        self.event("MOUSEMOVE", "NOTHING")
        yield

    def jump(self, x, y):
        """As `move`, in half the time. A drag that turns the view does not notice it."""
        for self.at in ((x - 1, y), (x, y)):
            self.event("MOUSEMOVE", "NOTHING")
        yield

    def click(self, x, y, button="LEFTMOUSE", **held):
        yield from self.move(x, y)
        self.event(button, "PRESS", **held)
        yield
        self.event(button, "RELEASE", **held)
        yield 0.1

    def key(self, kind, **held):
        self.event(kind, "PRESS", **held)
        yield
        self.event(kind, "RELEASE", **held)
        yield 0.1

    def into_view(self):
        view = self.region("WINDOW")
        yield from self.move(view.x + view.width * 0.45, view.y + view.height * 0.5)

    def undo(self):
        yield from self.into_view()
        yield from self.key("Z", ctrl=True)
        yield 0.1

    def redo(self):
        yield from self.into_view()
        yield from self.key("Z", ctrl=True, shift=True)
        yield 0.1

    def open_view(self, hide=("header", "tool_header", "toolbar", "ui")):
        """Makes the viewport fill the window, without some bars."""
        with self.within():
            bpy.ops.screen.screen_full_area(use_hide_panels=False)
        yield 0.5
        shown = self.area.spaces.active.overlay
        for name in ("show_floor", "show_ortho_grid", "show_axis_x", "show_axis_y", "show_outline_selected"):
            setattr(shown, name, False)
        if QUICK:
            for name in ("show_cursor", "show_extras", "show_object_origins", "show_relationship_lines"):
                setattr(shown, name, False)
            self.area.spaces.active.shading.light = "FLAT"
            for name in ("use_overlay_smooth_wire", "use_edit_mode_smooth_wire"):
                setattr(bpy.context.preferences.system, name, False)
        for name in hide:
            setattr(self.area.spaces.active, f"show_region_{name}", False)
        yield

    def open_tab(self):
        """Makes the viewport fill the window, and opens the sidebar at the tab of the add-on."""
        yield from self.open_view(hide=("header", "tool_header", "toolbar") if QUICK else ())
        self.area.spaces.active.show_region_ui = True
        yield 0.5
        side = self.region("UI")
        if hasattr(side, "active_panel_category"):
            side.active_panel_category = "iSimp"
            self.area.tag_redraw()
            yield 0.3
            return
        drawn = []
        bpy.types.ISIMP_PT_main.append(lambda panel, context: drawn.append(panel))
        for y in range(side.y + side.height - 20, side.y, -30):  # Blender 3.4: try the tabs from above
            yield from self.click(side.x + side.width - 10, y)
            yield 0.2
            if drawn:
                return
        raise AssertionError("the add-on has no tab in the sidebar")

    def rows(self, near):
        """Heights in the sidebar with possible buttons, those next to `near` first."""
        side = self.region("UI")
        return sorted(range(side.y + side.height - 34, side.y, -16), key=lambda y: abs(y - near))

    def find(self, name):
        """Moves to a button, by its action or the end of its property; tries its last place first."""
        side = self.region("UI")
        full, at = next(((full, at) for full, at in self.known.items() if full.endswith(name)), (None, None))
        if full:
            yield from self.move(*at)
            if self.under_mouse() == full:
                return
        seen = set()
        for y in self.rows(at[1] if full else side.y + side.height):
            for share in (0.3, 0.62):
                yield from self.jump(side.x + (side.width - 20) * share, y)
                under = self.under_mouse()
                if under:
                    seen.add(under)
                    self.known[under] = self.at
                if under.endswith(name):
                    return
        raise AssertionError(f"no button {name}, there are {sorted(seen)}")

    def under_mouse(self):
        """The action or property of the button under the mouse; empty if there is none."""
        manager = bpy.context.window_manager
        for operator, settings in (("copy_python_command_button", {}), ("copy_data_path_button", {"full_path": True})):
            manager.clipboard = ""
            with self.within("UI"):
                call = getattr(bpy.ops.ui, operator)
                if call.poll():
                    call(**settings)
            if manager.clipboard:
                return manager.clipboard.split("(")[0]
        return ""

    def press(self, name):
        """Presses the button of an operator, as `isimp.partition`."""
        yield from self.find(f"bpy.ops.{name}")
        yield from self.click(*self.at)
        yield from self.settle()

    def settle(self, seconds=30):
        """Waits until no work is under way."""
        runtime = module("scene.runtime")
        yield 0.1
        end = time.time() + seconds
        while runtime.get().running is not None:
            assert time.time() < end, "the work takes too long"
            yield 0.05
        yield 0.1

    def type_into(self, path_end, text):
        """Types a number into the field of a property."""
        yield from self.find(path_end)
        yield from self.click(*self.at)
        yield from self.key("A", ctrl=True)
        for letter in text:
            self.event(KEYS[letter], "PRESS", unicode=letter)
            yield
            self.event(KEYS[letter], "RELEASE")
            yield
        yield from self.key("RET")
        yield 0.2

    def shot(self, name):
        """Makes a picture of the window; a quick run draws the view alone."""
        if QUICK:
            self.area.tag_redraw()
            yield 0.1
            return
        system = bpy.context.preferences.system
        system.viewport_aa = "8"
        self.area.tag_redraw()
        yield 0.4
        subprocess.run(["import", "-window", "root", str(self.out / f"{name}.png")], check=True)
        system.viewport_aa = "OFF"
        yield


def module(name):
    """A module of the add-on, which has another package as an extension."""
    return next(found for path, found in sys.modules.items() if path.endswith(f"isimp.blender.{name}"))


def main(scenario, out):
    spec = util.spec_from_file_location("scenario", scenario)
    module = util.module_from_spec(spec)
    sys.path[:0] = [str(scenario.parent), str(scenario.parent.parent)]
    spec.loader.exec_module(module)
    steps = module.run(Hand(out))

    def tick():
        try:
            return next(steps) or TICK
        except StopIteration:
            code = 0
        except BaseException:  # noqa: BLE001  (the test shows it)
            traceback.print_exc()
            code = 1
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)

    bpy.app.timers.register(tick, first_interval=1.0, persistent=True)


main(*map(Path, sys.argv[sys.argv.index("--") + 1 :]))
