"""HiDPI and the light theme: at a scale of 2, the drawing in the view stays clear of the sidebar."""

from pathlib import Path

import bpy
from scenario_main import make_scan, same
from scenario_tools import view

import isimp


def light() -> bool:
    """Turns to Blender's light theme, where it is installed."""
    files = [path for place in bpy.utils.preset_paths("interface_theme") for path in Path(place).glob("*ight.xml")]
    if files:
        bpy.ops.script.execute_preset(filepath=str(files[0]), menu_idname="USERPREF_MT_interface_theme_presets")
    return bool(files)


def run(hand):
    isimp.register()
    from isimp.blender.texts import viewport_text

    drawn, draw = [], viewport_text._draw

    def noted(lines, x, y, scale):
        drawn.append((x + max(map(viewport_text._width, lines)), len(lines), bpy.context.region.width))
        draw(lines, x, y, scale)

    viewport_text._draw = noted
    make_scan(subdivisions=4)
    yield 0.5
    yield from view(hand)
    yield from hand.open_tab()
    bpy.ops.isimp.partition("EXEC_DEFAULT", True, proxies=14)
    bpy.ops.isimp.mesh("EXEC_DEFAULT", True)
    yield 1.0
    same("one line at first", {lines for _, lines, _ in drawn if lines}, {1})
    for number, theme in enumerate(("dark", "light")):
        if theme == "light" and not light():
            break
        bpy.context.preferences.view.ui_scale = 2.0
        yield 1.0
        drawn.clear()
        hand.area.tag_redraw()
        yield 1.0
        side, here = hand.region("UI"), hand.region("WINDOW")
        right, lines, _ = drawn[-1]
        same("clear of the sidebar", right <= side.x - here.x, True)
        same("in more lines than one", lines > 1, True)
        bpy.ops.isimp.swap("EXEC_DEFAULT", True)
        yield 1.0
        yield from hand.shot(f"scale-{number + 1}-{theme}-scan")
        bpy.ops.isimp.swap("EXEC_DEFAULT", True)
        yield 1.0
        yield from hand.shot(f"scale-{number + 1}-{theme}-result")
