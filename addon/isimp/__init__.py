"""iSimp: turns dense scans into clean, editable n-gon meshes.

Only `isimp.blender` imports bpy, so that everything else can be used and tested without Blender.
"""

import importlib
import sys

bl_info = {
    "name": "iSimp",
    "author": "The iSimp developers",
    "version": (0, 0, 0),  # scripts/build_addon.py writes the version of CMakeLists.txt
    "blender": (3, 4, 0),
    "location": "3D View > Sidebar > iSimp",
    "description": "Turn dense scans into clean, editable n-gon meshes",
    "category": "Mesh",
}


def register() -> None:
    from . import blender

    blender.register()


def unregister() -> None:
    from . import blender

    blender.unregister()
    _forget_failed()


def _forget_failed() -> None:
    """Forgets the add-on's modules if they have no engine, so that another zip or a package installed since is used.

    A loaded engine stays: Python can't load it twice.
    """
    loaded = sys.modules.get(f"{__name__}.engine")
    if getattr(loaded, "engine", None) is not None:
        return
    for name in [name for name in sys.modules if name.startswith(f"{__name__}.")]:
        del sys.modules[name]
        globals().pop(name.removeprefix(f"{__name__}."), None)
    importlib.invalidate_caches()
