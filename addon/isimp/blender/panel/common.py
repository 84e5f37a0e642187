"""Shared code of the panels."""

from ...language import said
from ..scene import targets
from ..texts import text
from ..widths import letters

_NARROW = 16  # letters in a line


class _Drawn:
    bl_space_type = "VIEW_3D"

    def prepare(self, context):
        self.layout.use_property_split = not is_narrow(context)
        self.layout.use_property_decorate = False
        return self.layout


class Panel(_Drawn):
    bl_region_type = "UI"
    bl_category = "iSimp"


class Popover(_Drawn):
    """Base of popovers with rarely used settings, opened by one button."""

    bl_region_type = "HEADER"
    bl_options = {"INSTANCED"}
    bl_ui_units_x = 13


class SubPanel(Panel):
    """Base of panels that need a scan with regions."""

    bl_parent_id = "ISIMP_PT_main"

    @classmethod
    def poll(cls, context):
        return ready(context)


def ready(context) -> bool:
    scan, problem = targets.seen(context)
    return not problem and targets.has_regions(scan)


def draw_lines(context, layout, message: str, icon: str, alert: bool = False) -> None:
    """Draws a message, wrapped to the width of the sidebar."""
    column = layout.column(align=True)
    column.alert = alert
    for number, line in enumerate(text.wrapped(said(message), letters(context))):
        column.label(text=line, icon=icon if number == 0 else "BLANK1")


def is_narrow(context) -> bool:
    """Return whether the sidebar is too narrow for two columns."""
    return letters(context) < _NARROW


def side_by_side(context, layout, *names: str, icons: bool = True):
    """Return a layout for two buttons: a row, or a column if the sidebar is too narrow for their names.

    names: in English; their translations are measured.
    """
    room = (letters(context) - (8 if icons else 2)) // 2
    fits = not is_narrow(context) and all(len(said(name)) <= room for name in names)
    return layout.row(align=True) if fits else layout.column(align=True)
