"""Panel with all further settings of Partition and Mesh, as one list that can be searched."""

import bpy

from ... import recipe as rcp
from ...language import own, said
from .. import preferences
from ..controls import settings, units
from ..scene import targets
from .common import Panel

_LENGTHS = ("noise", "sharp_edges", "stitch", "grid", "straight_rims")  #: have a tick for the engine's choice
_PARTITION, _MESH = rcp.Partition, rcp.Mesh


def _rows(context) -> list:
    """Return (heading, class of steps, names of properties) of all rows."""
    panel = context.window_manager.isimp
    partition, method = panel.partition, panel.partition.method
    marks = ("seams", "sharp", "materials", *(("face_sets",) if bpy.app.version >= (3, 6, 0) else ()))
    tried = ("metric",) if method == "hierarchy" else ("seeding", "seed", "iterations")
    return [
        (own("Regions"), _PARTITION, ("count_by", "feature", "adaptivity", "smooth", "snap", "curved")),
        ("", _PARTITION, ("weights", *(("influence",) if partition.weights else ()))),
        (own("Scan"), _PARTITION, ("leave_out", "close_openings", "outside_only", "noise_automatic", "noise")),
        ("", _PARTITION, ("sharpens", "sharp_edges", "stitch_found", "stitch", "grid_found", "grid")),
        (own("Barriers"), _PARTITION, (*marks, "angle", "borders")),
        (own("Polygons"), _MESH, ("planar", "planar_most", "convex", "chord_tolerance", "join_junctions", "flatten")),
        ("", _MESH, ("straight_rims_found", "straight_rims")),
        (own("Add-on"), None, ("live", "regularise_first")),
        ("", _PARTITION, ("method", *tried) if preferences.get(context).experimental else ()),
    ]


class ISIMP_PT_options(Panel, bpy.types.Panel):
    bl_label = "More"
    bl_parent_id = "ISIMP_PT_main"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 5

    @classmethod
    def poll(cls, context):
        return not targets.seen(context)[1]

    def draw(self, context):
        layout, panel = self.prepare(context), context.window_manager.isimp
        field = layout.row()
        field.use_property_split = False
        field.prop(panel, "search", text="", icon="VIEWZOOM")
        column = layout.column(align=True)
        wanted, waiting = panel.search.strip().casefold(), ""
        for heading, cls, names in _rows(context):
            group = panel if cls is None else settings.group(context, cls)
            waiting = heading or waiting
            for name in names:
                if not (_is_used(group, name) and _matches(group, cls, name, wanted)):
                    continue
                if waiting:
                    column.label(text=said(waiting))
                    waiting = ""
                _draw_setting(column, group, cls, name)


def _is_used(group, name: str) -> bool:
    """Return whether a length is set by the user, not found by the engine."""
    return name not in _LENGTHS or getattr(group, name) >= 0


def _shown(cls, name: str) -> str:
    return units.INSTEAD.get((cls, name), name)


def _matches(group, cls, name: str, wanted: str) -> bool:
    """Return whether a setting has the searched text in its name, as shown or in English, or in its tooltip."""
    prop = group.bl_rna.properties[_shown(cls, name)]
    texts = (prop.name, said(prop.name), said(prop.description))
    return any(wanted in text.casefold() for text in texts)


def _draw_setting(column, group, cls, name: str) -> None:
    """Draws one setting. Ticks and numbers have the whole width for their names."""
    place = column.row(align=True)
    if group.bl_rna.properties[_shown(cls, name)].type in {"BOOLEAN", "INT", "FLOAT"}:
        place.use_property_split = False
    if name == "planar_most":
        place.active = group.planar
    icons = {"weights": "GROUP_VERTEX", "borders": "SPREADSHEET"}
    place.prop(group, _shown(cls, name), **({"icon": icons[name]} if name in icons else {}))


CLASSES = (ISIMP_PT_options,)
