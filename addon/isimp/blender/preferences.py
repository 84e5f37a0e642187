"""The preferences, which apply to all files."""

import bpy
import rna_keymap_ui
from bpy.props import BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty, IntProperty

from .. import session
from .scene import targets
from .texts import text
from .widths import letters

_BACKENDS = tuple(session.backends()) or ("cpu",)
_ADDON = __package__.rpartition(".")[0]  # "isimp", or "bl_ext....isimp" as an extension


def _color(name, description, default):
    limits = {"subtype": "COLOR", "size": 4, "min": 0.0, "max": 1.0}
    return FloatVectorProperty(name=name, description=description, default=default, **limits)


class IsimpPreferences(bpy.types.AddonPreferences):
    """Preferences of the add-on"""

    bl_idname = _ADDON

    border_color: _color("Borders", "Lines between regions", (0.02, 0.02, 0.02, 0.9))
    outline_color: _color("Outline", "Edges and corners of the previewed polygons", (1.0, 1.0, 1.0, 1.0))
    problem_color: _color("Defects", "Outlines of defective polygons", (1.0, 0.0, 1.0, 1.0))
    line_width: FloatProperty(
        name="Line Width",
        description="Width of the lines over the scan",
        default=1.5,
        min=0.5,
        max=6.0,
        subtype="PIXEL",
    )

    threads: IntProperty(
        name="Threads",
        description="Number of threads; 0: one for each core. The result is the same with any number",
        default=0,
        min=0,
        soft_max=64,
    )
    backend: EnumProperty(
        name="Back End",
        description="Device of the methods Queued and Naive. The result is the same on all",
        items=[(name, name.upper(), "") for name in _BACKENDS],
        default=_BACKENDS[0],
    )

    quick_start: BoolProperty(
        name="Quick Start",
        description="Show three lines of help in the 3D view until the first Partition, or a click there",
        default=True,
    )

    experimental: BoolProperty(
        name="Methods of the Papers",
        description="Show the other methods of partition, with their settings, in More Settings",
        default=False,
    )

    show_keys: BoolProperty(name="Shortcuts of the Tools", description="Show and change the shortcuts")

    def draw(self, context):
        layout = self.layout
        for number, line in enumerate(text.wrapped(targets.install_problem(), letters(context))):
            layout.label(text=line, icon="ERROR" if number == 0 else "BLANK1")
        layout.use_property_split = True
        for title, names in _DRAWN:
            layout.label(text=title)
            for name in names:
                layout.prop(self, name)
        title = layout.row()
        title.use_property_split, title.alignment = False, "LEFT"
        icon = "DISCLOSURE_TRI_DOWN" if self.show_keys else "DISCLOSURE_TRI_RIGHT"
        title.prop(self, "show_keys", icon=icon, emboss=False)
        if self.show_keys:
            _draw_keys(context, layout)


def _draw_keys(context, layout) -> None:
    keys = context.window_manager.keyconfigs.user
    for keymap in tool_keymaps(keys):
        layout.label(text=keymap.name.removeprefix("3D View Tool: "))
        for item in keymap.keymap_items:
            if item.idname not in ("isimp.hover", "isimp.turn"):
                rna_keymap_ui.draw_kmi([], keys, keymap, item, layout, 0)


def tool_keymaps(keys) -> list:
    """The key maps of the tools in a key configuration."""
    tools = (keymap for keymap in keys.keymaps if keymap.name.startswith("3D View Tool: "))
    return [keymap for keymap in tools if any(i.idname.startswith("isimp.") for i in keymap.keymap_items)]


# The back end is left out if there is only one.
_DRAWN = (
    ("Colours", ("border_color", "outline_color", "problem_color", "line_width")),
    ("Help", ("quick_start",)),
    ("Performance", ("threads", "backend") if len(_BACKENDS) > 1 else ("threads",)),
    ("Experimental", ("experimental",)),
)


class _Default:
    """Default preferences, for an add-on that a script registered without enabling it in Blender."""


for _name, _property in IsimpPreferences.__annotations__.items():
    setattr(_Default, _name, _property.keywords.get("default"))
_Default.quick_start = False  # scripts need no help


def get(context):
    addon = context.preferences.addons.get(_ADDON)
    return addon.preferences if addon is not None and addon.preferences is not None else _Default


def obey(context, working) -> None:
    """Sets threads and back end of a session by the preferences."""
    wish = get(context)
    working.threads = wish.threads
    working.backend = wish.backend if wish.backend in _BACKENDS else _BACKENDS[0]


CLASSES = (IsimpPreferences,)
