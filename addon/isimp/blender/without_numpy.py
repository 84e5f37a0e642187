"""Registers a single panel if Blender's Python has no numpy, like Debian's without the package python3-numpy.

This module must not import modules that import numpy: only the translations do not.
"""

import importlib
import sys
import textwrap

import bpy

from ..language import own, said
from . import translations

PROBLEM = own("Blender's Python has no numpy: install python3-numpy and start Blender again")


def is_missing() -> bool:
    try:
        importlib.import_module("numpy")
    except ImportError:
        return True
    return False


class ISIMP_PT_without_numpy(bpy.types.Panel):
    bl_label = "iSimp"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "iSimp"

    def draw(self, context):
        for number, line in enumerate(textwrap.wrap(said(PROBLEM), 30)):
            self.layout.label(text=line, icon="ERROR" if number == 0 else "BLANK1")


def register() -> None:
    translations.register()
    bpy.utils.register_class(ISIMP_PT_without_numpy)
    print(f"iSimp: {said(PROBLEM)}", file=sys.stderr)


def unregister() -> None:
    bpy.utils.unregister_class(ISIMP_PT_without_numpy)
    translations.unregister()
