"""What a user may set once for all files."""

import bpy
from bpy.props import FloatProperty, FloatVectorProperty

_ADDON = __package__.rpartition(".")[0]  # "isimp", or "bl_ext....isimp" as an extension


def _color(name, description, default):
    limits = {"subtype": "COLOR", "size": 4, "min": 0.0, "max": 1.0}
    return FloatVectorProperty(name=name, description=description, default=default, **limits)


class IsimpPreferences(bpy.types.AddonPreferences):
    """Preferences of the add-on"""

    bl_idname = _ADDON

    border_color: _color("Borders", "Lines where regions meet", (0.02, 0.02, 0.02, 0.9))
    outline_color: _color("Outline", "Lines and corners of the polygons to be", (1.0, 1.0, 1.0, 1.0))
    problem_color: _color("Problems", "Polygons that something is amiss with", (1.0, 0.0, 1.0, 1.0))
    line_width: FloatProperty(
        name="Line Width", description="Of what is drawn over the scan", default=1.5, min=0.5, max=6.0, subtype="PIXEL"
    )

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        for name in self.__annotations__:
            layout.prop(self, name)


class _Default:
    """The preferences where the add-on was not switched on by the user, but by a script."""


for _name, _property in IsimpPreferences.__annotations__.items():
    setattr(_Default, _name, _property.keywords["default"])


def get(context):
    addon = context.preferences.addons.get(_ADDON)
    return addon.preferences if addon is not None and addon.preferences is not None else _Default


CLASSES = (IsimpPreferences,)
