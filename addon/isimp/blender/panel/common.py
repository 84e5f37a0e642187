"""What all panels share."""

from .. import targets, text


class Panel:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "iSimp"

    def prepare(self):
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        return self.layout


class SubPanel(Panel):
    """Of a scan that has regions."""

    bl_parent_id = "ISIMP_PT_main"

    @classmethod
    def poll(cls, context):
        return ready(context)


def ready(context) -> bool:
    scan, problem = targets.find(context)
    return not problem and targets.has_regions(scan)


def draw_lines(context, layout, message: str, icon: str, alert: bool = False) -> None:
    """A message in as many lines as the sidebar's width needs."""
    column = layout.column(align=True)
    column.alert = alert
    for number, line in enumerate(text.wrapped(message, letters(context))):
        column.label(text=line, icon=icon if number == 0 else "BLANK1")


def letters(context) -> int:
    """How many letters fit into a line with an icon before it."""
    width = context.region.width / context.preferences.system.ui_scale if context.region else 260
    return max(16, int((width - 70) / 5.8))
