"""The quick start: visible at first, hidden after a click or the first Partition; and the panel in German."""

import bpy
import numpy as np
from scenario_compare import pixels
from scenario_main import make_scan, same, show_edits

import isimp


def run(hand):
    show_edits()
    isimp.register()
    from isimp.blender import preferences
    from isimp.blender.view import quick_start

    wish = preferences.get(bpy.context)
    wish.quick_start = True
    make_scan()
    yield 0.5
    yield from hand.open_tab()
    same("shown", quick_start.is_shown(bpy.context), True)
    shown, _ = yield from pixels(hand, "start-1-shown")
    yield from hand.into_view()
    yield from hand.click(*hand.at)
    yield 0.3
    same("gone after a click", wish.quick_start, False)
    gone, _ = yield from pixels(hand, "start-2-gone")
    same("and no longer drawn", bool(np.abs(shown - gone)[: len(gone) // 2].max() > 0.3), True)
    same("the click selects as ever", [obj.name for obj in bpy.context.selected_objects], ["Scan"])
    wish.quick_start = True
    hand.area.tag_redraw()
    yield 0.3
    yield from hand.press("isimp.partition")
    same("gone after Partition", wish.quick_start, False)
    view = bpy.context.preferences.view
    if "de_DE" in bpy.app.translations.locales or "de" in bpy.app.translations.locales:
        view.language = "de_DE" if "de_DE" in bpy.app.translations.locales else "de"
        view.use_translate_interface = True
        yield 0.5
        yield from hand.shot("start-3-german")
        view.use_translate_interface = False
