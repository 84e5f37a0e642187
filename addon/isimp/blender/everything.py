"""Registers all classes, properties, menus and handlers of the add-on, in order."""

import bpy

from . import command, menus, operators, panel, preferences, tools, translations
from .controls import presets, settings
from .scene import runtime, store
from .view import clipping, comparison, display, overlay, quick_start
from .work import live

_CLASSES = (
    *store.CLASSES,
    *settings.CLASSES,
    *operators.CLASSES,
    *clipping.CLASSES,
    *live.CLASSES,
    *tools.CLASSES,
    *presets.CLASSES,
    *preferences.CLASSES,
    *panel.CLASSES,
    *menus.CLASSES,
    *quick_start.CLASSES,
)
for _cls in _CLASSES:
    if issubclass(_cls, (bpy.types.Operator, bpy.types.Menu, bpy.types.Panel)):
        _cls.bl_translation_context = translations.CONTEXT


def register():
    runtime.start()
    translations.register()
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    store.register()
    settings.register()
    display.register()
    live.register()
    overlay.register()
    tools.register()
    menus.register()
    quick_start.register()
    command.register()


def unregister():
    command.unregister()
    quick_start.unregister()
    menus.unregister()
    tools.unregister()
    comparison.stop()
    overlay.unregister()
    live.unregister()
    display.unregister()
    settings.unregister()
    store.unregister()
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
    translations.unregister()
    runtime.stop()
