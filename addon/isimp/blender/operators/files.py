"""Scans in and models out: exact import, export of buildings, reports."""

from pathlib import Path

import bpy
import numpy as np
from bpy.props import BoolProperty, CollectionProperty, IntProperty, StringProperty
from bpy_extras.io_utils import ImportHelper

from ... import handover, messages
from ... import recipe as rcp
from ...engine import engine
from ...language import said
from .. import mesh_io, places, reading, runtime, store, targets

_SCANS = (".ply", ".obj", ".stl", ".off")


class ISIMP_OT_import_scan(ImportHelper, bpy.types.Operator):
    """Import scans exactly. Of map coordinates the place is kept beside the mesh, as float32 can't hold it"""

    bl_idname = "isimp.import_scan"
    bl_label = "Import Scan (iSimp)"
    bl_options = {"REGISTER", "UNDO"}

    filter_glob: StringProperty(default=";".join(f"*{kind}" for kind in _SCANS), options={"HIDDEN"})
    files: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"HIDDEN", "SKIP_SAVE"})
    directory: StringProperty(subtype="DIR_PATH", options={"HIDDEN", "SKIP_SAVE"})
    y_up: BoolProperty(name="Y Is Up", description="The file has Y up: turn the scan so that it stands")
    epsg: IntProperty(name="EPSG", description="Number of the coordinates' reference system; 0: not known", min=0)

    def invoke(self, context, event):
        if self.directory and self.files:  # dropped into the view
            return self.execute(context)
        return super().invoke(context, event)

    def execute(self, context):
        names = [Path(self.directory) / file.name for file in self.files if file.name] or [Path(self.filepath)]
        made = []
        for path in names:
            try:
                made.append(self._import(context, path))
            except (ValueError, OSError, MemoryError) as problem:
                self.report({"ERROR"}, str(problem))
        if not made:
            return {"CANCELLED"}
        for obj in context.selected_objects:
            obj.select_set(False)
        for obj in made:
            obj.select_set(True)
        context.view_layer.objects.active = made[-1]
        faces = messages.count(sum(len(obj.data.polygons) for obj in made), "face")
        self.report({"INFO"}, said("{faces} imported", faces=faces))
        return {"FINISHED"}

    def _import(self, context, path: Path):
        vertices, loops, start = engine.read_polygons(path)
        origin = handover.far_origin(vertices)
        mesh = bpy.data.meshes.new(path.stem)
        mesh_io.fill_polygons(mesh, vertices - origin, loops, start, {})
        obj = bpy.data.objects.new(path.stem, mesh)
        context.collection.objects.link(obj)
        if self.y_up:
            obj.rotation_euler = (np.pi / 2, 0.0, 0.0)
        places.keep(obj, origin, self.epsg)
        return obj


class _Model:
    """Mixin of what needs a result."""

    @classmethod
    def poll(cls, context):
        return targets.allows_with_result(cls, context)


class ISIMP_OT_export_building(_Model, bpy.types.Operator):
    """Export the result as a building, with walls, roofs and ground: IFC, DXF or CityJSON. One unit is one metre"""

    bl_idname = "isimp.export_building"
    bl_label = "Export Building"

    filepath: StringProperty(subtype="FILE_PATH")
    filter_glob: StringProperty(default="*.ifc;*.dxf;*.json", options={"HIDDEN"})
    epsg: IntProperty(name="EPSG", description="Number of the coordinates' reference system; 0: not known", min=0)

    def invoke(self, context, event):
        scan, _, _ = targets.find_result(context)
        self.epsg = places.epsg(scan)
        self.filepath = f"{scan.name}.city.json"
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        scan, result, _ = targets.find_result(context)
        path = Path(bpy.path.abspath(self.filepath))
        if engine.exporting.kind_of(path) is None:
            self.report({"ERROR"}, said("The name must end in .city.json, .dxf or .ifc."))
            return {"CANCELLED"}
        shown = context.view_layer.objects.active if targets.scan_of(context.view_layer.objects.active) else result
        try:
            model = places.model_of(context, scan, shown)
            handover.export(path, model, self.epsg or None)
        except (ValueError, OSError) as problem:
            self.report({"ERROR"}, str(problem))
            return {"CANCELLED"}
        told = messages.count(len(model.loop_start), "polygon")
        self.report({"INFO"}, said("{polygons} written to {file}", polygons=told, file=path.name))
        return {"FINISHED"}


class ISIMP_OT_write_report(_Model, bpy.types.Operator):
    """Write a table of the planes (CSV, GeoJSON) and a page with pictures and the deviation (HTML) into a folder"""

    bl_idname = "isimp.write_report"
    bl_label = "Write Report"

    directory: StringProperty(subtype="DIR_PATH")
    filter_folder: BoolProperty(default=True, options={"HIDDEN"})

    def invoke(self, context, event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        scan, _, _ = targets.find_result(context)
        if not self.directory:
            self.report({"ERROR"}, said("No folder is named: choose one for the report."))
            return {"CANCELLED"}
        recipe = store.load(scan)
        meshed = [step for _, step in recipe.active() if isinstance(step, rcp.Mesh)] if recipe else []
        folder = Path(bpy.path.abspath(self.directory))
        try:
            recipe = recipe if meshed else recipe.then(rcp.Mesh())
            arrays, session = reading.read(context, scan, recipe.layers()), runtime.get().session
            outcome = session.replay(arrays, recipe)
            mesh = session.prepare(arrays, closing=outcome.closing).mesh
            texts = handover.report_texts(mesh, outcome, places.to_world(scan), scan.name, places.epsg(scan) or None)
            folder.mkdir(parents=True, exist_ok=True)
            for name, text in texts.items():
                (folder / name).write_text(text, encoding="utf-8")
        except (ValueError, OSError, mesh_io.Unusable) as problem:
            self.report({"ERROR"}, str(problem))
            return {"CANCELLED"}
        self.report({"INFO"}, said("Report written: {files}", files=", ".join(texts)))
        return {"FINISHED"}


CLASSES: tuple = (ISIMP_OT_import_scan, ISIMP_OT_export_building, ISIMP_OT_write_report)


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
