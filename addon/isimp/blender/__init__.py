"""Everything that touches Blender."""

import bpy

from . import (
    command,
    comparison,
    display,
    live,
    menus,
    operators,
    overlay,
    panel,
    preferences,
    presets,
    runtime,
    settings,
    store,
    tools,
)

_CLASSES = (
    *store.CLASSES,
    *settings.CLASSES,
    *operators.CLASSES,
    *live.CLASSES,
    *tools.CLASSES,
    *presets.CLASSES,
    *preferences.CLASSES,
    *panel.CLASSES,
    *menus.CLASSES,
)


def register():
    runtime.start()
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    store.register()
    settings.register()
    display.register()
    live.register()
    overlay.register()
    tools.register()
    menus.register()
    command.register()


def unregister():
    command.unregister()
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
    runtime.stop()
