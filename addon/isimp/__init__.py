"""iSimp: turns dense scans into clean, editable n-gon meshes.

Only `isimp.blender` imports bpy, so that everything else can be used and tested without Blender.
"""

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
