"""Import of scans: exact coordinates, with the look of the file."""

from contextlib import suppress
from pathlib import Path

import bpy
import numpy as np
from bpy.props import CollectionProperty, EnumProperty, IntProperty, StringProperty
from bpy_extras.io_utils import ImportHelper

from ... import handover, messages
from ...engine import engine
from ...language import own, said
from ..scene import mesh_io, places
from ..texturing import looks
from ..view import clipping

_SCANS = (".ply", ".obj", ".stl", ".off", ".3mf")
_UPS = (
    ("FORMAT", "By Format", "Y for OBJ files, as Blender reads them, unless they have map coordinates; Z for others"),
    ("Y", "Y", "The file has Y up: turn the scan upright"),
    ("Z", "Z", "The file has Z up"),
)
_TURNED = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])  # Y up becomes Z up
_MAP = 10_000  # coordinates as large as these are map coordinates, units
_MOST_FAULTS = 3  # in a message


class ISIMP_OT_import_scan(ImportHelper, bpy.types.Operator):
    """Import scans with their texture. The offset of map coordinates is kept, as Blender's numbers can't hold it"""

    bl_idname = "isimp.import_scan"
    bl_label = "Import Scan (iSimp)"
    bl_options = {"REGISTER", "UNDO"}

    filter_glob: StringProperty(default=";".join(f"*{kind}" for kind in _SCANS), options={"HIDDEN"})
    files: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"HIDDEN", "SKIP_SAVE"})
    directory: StringProperty(subtype="DIR_PATH", options={"HIDDEN", "SKIP_SAVE"})
    up: EnumProperty(name="Up", description="Axis of the file that points up", items=_UPS)
    epsg: IntProperty(name="EPSG", description="Number of the coordinates' reference system; 0: not known", min=0)

    def invoke(self, context, event):
        if self.directory and self.files:  # dropped into the view
            return self.execute(context)
        return super().invoke(context, event)

    def execute(self, context):
        names = [Path(self.directory) / file.name for file in self.files if file.name] or [Path(self.filepath)]
        made, warnings = [], []
        for path in names:
            try:
                made.append(self._import(context, path, warnings))
            except (ValueError, OSError, MemoryError) as problem:
                self.report({"ERROR"}, str(problem))
        if not made:
            return {"CANCELLED"}
        for obj in context.selected_objects:
            obj.select_set(False)
        for obj in made:
            obj.select_set(True)
        context.view_layer.objects.active = made[-1]
        _frame(context)
        faces = messages.count(sum(len(obj.data.polygons) for obj in made), "face")
        self.report({"INFO"}, said("{faces} imported", faces=faces))
        for warning in warnings:  # the last ones are what Blender shows in its status bar
            self.report({"WARNING"}, warning)
        return {"FINISHED"}

    def _import(self, context, path: Path, warnings: list):
        look = engine.texturing.reading.read_look(path)
        engine.reading.check_faces(path, len(look.vertices), len(look.loop_start))
        origin, kind = handover.far_origin(look.vertices), engine.reading.kind_of(path)
        mesh = bpy.data.meshes.new(path.stem)
        mesh_io.fill_polygons(
            mesh, look.vertices - origin, look.loops, look.loop_start, {}, lambda: looks.write(mesh, look, kind)
        )
        faults = [*look.faults, *_dropped(path, len(look.loop_start) - len(mesh.polygons))]
        faults += looks.give_materials(mesh, look)
        obj = bpy.data.objects.new(path.stem, mesh)
        context.collection.objects.link(obj)
        if self.up == "Y" or (self.up == "FORMAT" and kind == ".obj" and np.abs(origin).max() < _MAP):
            obj.rotation_euler, origin = (np.pi / 2, 0.0, 0.0), _TURNED @ origin
        places.keep(obj, origin, self.epsg)
        warnings += _told(path, faults, looks.skipped(look))
        return obj


def _dropped(path: Path, number: int) -> list[str]:
    """Return a warning about the faces of a file that Blender has removed, if there are some."""
    text = own("{file}: {faces} removed, as Blender keeps no face with a vertex twice and no copy of a face")
    return [said(text, file=path.name, faces=messages.count(number, "face"))] if number else []


def _told(path: Path, faults: list, skipped: list) -> list:
    """Return the warnings about a file: what can't be used of it, and what is not read."""
    told = []
    if skipped:
        told.append(said("Not read of {file}: {what}", file=path.name, what=", ".join(skipped)))
    if len(faults) > _MOST_FAULTS:
        rest = messages.count(len(faults) - _MOST_FAULTS, "problem")
        faults = [*faults[:_MOST_FAULTS], said("{problems} more", problems=rest)]
    return [*told, "; ".join(faults)] if faults else told


def _frame(context) -> None:
    """Frames the imported scans in the 3D view that they were dropped into, or else in all, and opens the sidebar."""
    if bpy.app.background or context.window is None:
        return
    context.view_layer.update()
    is_view = context.area is not None and context.area.type == "VIEW_3D"
    for area in [context.area] if is_view else context.window.screen.areas:
        if area.type == "VIEW_3D":
            clipping.frame(context, area)
            area.spaces.active.show_region_ui = True
            side = next((region for region in area.regions if region.type == "UI"), None)
            if hasattr(side, "active_panel_category"):  # Blender 4.2 and later
                with suppress(TypeError, AttributeError):  # until the sidebar has been drawn once
                    side.active_panel_category = "iSimp"


CLASSES: tuple = (ISIMP_OT_import_scan,)

if hasattr(bpy.types, "FileHandler"):  # Blender 4.1 and later

    class ISIMP_FH_scan(bpy.types.FileHandler):
        bl_idname = "ISIMP_FH_scan"
        bl_label = "Scan (iSimp)"
        bl_import_operator = "isimp.import_scan"
        bl_file_extensions = ";".join(_SCANS)

        @classmethod
        def poll_drop(cls, context):
            return context.area is not None and context.area.type == "VIEW_3D"

    CLASSES = (*CLASSES, ISIMP_FH_scan)
