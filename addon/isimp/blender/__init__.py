"""Everything that touches Blender."""

import bpy

from . import display, live, operators, panel, runtime, settings, store

_CLASSES = (*store.CLASSES, *settings.CLASSES, *operators.CLASSES, *live.CLASSES, *panel.CLASSES)


def register():
    runtime.start()
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    store.register()
    settings.register()
    display.register()
    live.register()


def unregister():
    live.unregister()
    display.unregister()
    settings.unregister()
    store.unregister()
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
    runtime.stop()
