"""Registers a single panel if Blender's Python has no numpy, like Debian's without the package python3-numpy.

This module must not import modules that import numpy: only the translations do not.
"""

import importlib
import sys
import textwrap

import bpy

from ..language import own, said
from . import translations, widths

PROBLEM = own("numpy is missing in Blender's Python: install python3-numpy and start Blender again")
_ADDON = __package__.rpartition(".")[0]


def is_missing() -> bool:
    try:
        importlib.import_module("numpy")
    except ImportError:
        return True
    return False


def _draw_problem(context, layout) -> None:
    for number, line in enumerate(textwrap.wrap(said(PROBLEM), widths.letters(context))):
        layout.label(text=line, icon="ERROR" if number == 0 else "BLANK1")


class ISIMP_PT_without_numpy(bpy.types.Panel):
    bl_label = "iSimp"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "iSimp"

    def draw(self, context):
        _draw_problem(context, self.layout.column(align=True))


class IsimpPreferencesWithoutNumpy(bpy.types.AddonPreferences):
    bl_idname = _ADDON

    def draw(self, context):
        _draw_problem(context, self.layout.column(align=True))


_CLASSES = (ISIMP_PT_without_numpy, IsimpPreferencesWithoutNumpy)


def register() -> None:
    translations.register()
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    print(f"iSimp: {said(PROBLEM)}", file=sys.stderr)


def unregister() -> None:
    for cls in _CLASSES:
        bpy.utils.unregister_class(cls)
    translations.unregister()
