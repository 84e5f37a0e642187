"""The panel with all sections open, in English and in German: pictures, and the slider of the smallest feature."""

import bpy
from scenario_main import make_scan, regions, same
from scenario_steps import drag, settled

import isimp


def open_all():
    """Opens all sections from the beginning; called before the add-on is switched on."""
    from isimp.blender import panel

    for cls in panel.CLASSES:
        if issubclass(cls, bpy.types.Panel) and cls.bl_region_type == "UI":
            cls.bl_options = set()


def speak(language):
    view = bpy.context.preferences.view
    known = [name for name in (language, language[:2]) if name in bpy.app.translations.locales]
    if known:
        view.language, view.use_translate_interface = known[0], True
    return bool(known)


def run(hand):
    open_all()
    isimp.register()
    make_scan()
    yield 0.5
    yield from hand.open_tab()
    settings = bpy.context.window_manager.isimp.partition
    yield from hand.press("isimp.partition")
    before, feature = regions(), settings.feature
    yield from drag(hand, "partition.coarseness", -30)
    yield from settled()
    same("to the left it is finer", (settings.feature < feature, regions() > before), (True, True))
    yield from hand.press("isimp.mesh")
    yield from hand.shot("panel-1-english")
    if speak("de_DE"):
        yield 1.0
        yield from hand.shot("panel-2-german")
