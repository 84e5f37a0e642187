"""Operators for files: export of buildings, solids and levels of detail, reports."""

from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty, StringProperty

from ... import handover, messages
from ... import recipe as rcp
from ...engine import engine
from ...language import own, said
from .. import reading
from ..scene import mesh_io, places, runtime, store, targets
from ..work.modal import PROBLEMS, Aside, RecipeOperator, why

_BEFORE = 0.8  # share of the progress for the steps before the file is written
_UNITS = (("m", "Metre", "A unit is a metre"), ("mm", "Millimetre", "A unit is a millimetre"))


class Writes:
    """Mixin of operators that ask for a place and write there; `written` returns the line that says so."""

    errors: tuple = (ValueError, OSError, mesh_io.Unusable)
    check_existing: BoolProperty(default=True, options={"HIDDEN"})  # Blender's dialog then warns of a file that exists

    def invoke(self, context, event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        try:
            told = self.written(context)
        except self.errors as problem:
            self.report({"ERROR"}, str(problem))
            return {"CANCELLED"}
        self.report({"INFO"}, told)
        return {"FINISHED"}


class _Model(Writes):
    """Mixin of operators that need a result."""

    @classmethod
    def poll(cls, context):
        return targets.allows_with_result(cls, context)


_BUILDINGS = (
    (".ifc", "IFC (.ifc)", "For building information models: walls, roofs and slabs with their classes"),
    (".dxf", "DXF (.dxf)", "For CAD: a mesh for each class"),
    (".city.json", "CityJSON (.city.json)", "For city models: one building with its surfaces"),
)
_ENERGY = (
    (".idf", "EnergyPlus (.idf)", "For energy simulations: convex floors, walls and roofs of a zone"),
    (".hbjson", "Honeybee (.hbjson)", "For energy simulations: convex floors, walls and roofs of a room"),
)
_LEVELS = (
    (".glb", "glTF (.glb)", "For games and the web, with materials and images"),
    (".obj", "Wavefront (.obj)", "With materials"),
    *_BUILDINGS,
)


class _Formats(Writes):
    """Mixin of exports with a menu of formats in the file dialog. An ending of the name wins over the menu."""

    def invoke(self, context, event):
        self.filepath = f"{targets.find(context)[0].name}{self.kind}"
        return super().invoke(context, event)

    def check(self, context):
        """Changes the ending of the name in the dialog to the chosen format. Returns whether it was another."""
        named, known = self.filepath, engine.exporting.formats.format_of(self.filepath)
        stem = named[: -len(known.suffix)] if known is not None else named
        self.filepath = f"{stem}{self.kind}"
        return self.filepath != named

    def path(self) -> Path:
        """Return the file to write. Raises ValueError for an ending of another format."""
        path, known = Path(bpy.path.abspath(self.filepath)), engine.exporting.formats.format_of(self.filepath)
        kinds = [kind for kind, _, _ in self.kinds]
        if known is None and not path.suffix:
            return path.with_name(f"{path.name}{self.kind}")
        if known is None or known.suffix not in kinds:
            raise ValueError(said("The name must end in {kinds}.", kinds=", ".join(kinds)))
        return path


class ISIMP_OT_export_building(_Model, _Formats, bpy.types.Operator):
    """Export the result as a building: for CAD, city models or energy simulations. One unit is one metre"""

    bl_idname = "isimp.export_building"
    bl_label = "Export Building"

    kinds = _BUILDINGS + _ENERGY
    filepath: StringProperty(subtype="FILE_PATH")
    filter_glob: StringProperty(default="*.ifc;*.dxf;*.json;*.idf;*.hbjson", options={"HIDDEN"})
    kind: EnumProperty(name="Format", description="Format of the file", items=_BUILDINGS + _ENERGY)
    epsg: IntProperty(name="EPSG", description="Number of the coordinates' reference system; 0: none", min=0)

    def invoke(self, context, event):
        self.epsg = places.epsg(targets.find(context)[0])
        return super().invoke(context, event)

    def written(self, context):
        scan, result, _ = targets.find_result(context)
        epsg = self.epsg if self.properties.is_property_set("epsg") else places.epsg(scan)
        shown = context.view_layer.objects.active if targets.scan_of(context.view_layer.objects.active) else result
        path, model = self.path(), places.model_of(context, scan, shown)
        handover.export(path, model, epsg or None)
        told = messages.count(len(model.loop_start), "polygon")
        return said("{polygons} written to {file}", polygons=told, file=path.name)


class _OfSteps(_Model, RecipeOperator):
    """Mixin of exports that replay the steps. A subclass defines the recipe (`meshed`) and the writing (`writer`)."""

    bl_options = set()

    _is_asked = False  #: whether Blender's dialog has named the file, so that a window waits

    def invoke(self, context, event):
        self._is_asked = not bpy.app.background
        return super().invoke(context, event)

    def execute(self, context):
        if self._is_asked:
            return RecipeOperator.invoke(self, context, None)
        return RecipeOperator.execute(self, context)

    def _begin(self, context, target):
        if target.problem:
            self.report({"ERROR"}, target.problem)
            return None
        try:
            return self._work(context, target.scan)
        except self.errors as problem:
            self.report({"ERROR"}, str(problem))
            return None

    def _work(self, context, scan):
        """Return the work. Raises one of `errors`."""
        write, recipe = self.writer(context, scan), self.meshed(store.load(scan) or rcp.Recipe())
        arrays, session = reading.read(context, scan, recipe.layers()), runtime.get().session

        def work(watch) -> str:
            with watch.share(0.0, _BEFORE):
                outcome = session.replay(arrays, recipe, watch)
            with watch.part("measuring", _BEFORE, 1.0):
                return write(session.prepare(arrays, repair=outcome.repair).mesh, outcome)

        return Aside(scan, work, self._told)

    def _told(self, context, told: str):
        self.report({"INFO"}, told)
        return {"FINISHED"}

    def _refuse(self, context, work, error):
        if not isinstance(error, (*PROBLEMS, OSError)):
            return super()._refuse(context, work, error)
        self.report({"ERROR"}, why(error))
        return {"CANCELLED"}


def _last_mesh(recipe):
    return next((step for _, step in reversed(list(recipe.active())) if isinstance(step, rcp.Mesh)), None)


class ISIMP_OT_export_step(_OfSteps, bpy.types.Operator):
    """Export the steps' result as a solid for CAD, with true surfaces for round parts. Faces are planar"""

    bl_idname = "isimp.export_step"
    bl_label = "Export STEP"
    adjusted = ("unit",)

    filepath: StringProperty(subtype="FILE_PATH")
    filter_glob: StringProperty(default="*.step;*.stp", options={"HIDDEN"})
    unit: EnumProperty(name="Unit", description="Unit of the scene in the file", items=_UNITS)

    @classmethod
    def poll(cls, context):
        if not super().poll(context):
            return False
        problem = handover.missing(Path("solid.step"), places.modules())
        if problem:
            cls.poll_message_set(problem)
        return not problem

    def invoke(self, context, event):
        self.filepath = f"{targets.find(context)[0].name}.step"
        return super().invoke(context, event)

    def meshed(self, recipe):
        return recipe.without_mesh().then(replace(_last_mesh(recipe) or rcp.Mesh(), planar=True))

    def writer(self, context, scan):
        path, place, unit = Path(bpy.path.abspath(self.filepath)), places.to_world(scan), self.unit
        if engine.exporting.kind_of(path) not in engine.exporting.STEP_KINDS:
            raise ValueError(said("The name must end in .step or .stp."))

        def write(mesh, outcome) -> str:
            told = handover.export_step(path, mesh, outcome, place, unit)
            true, planes = len(told["true_surfaces"]), len(told["planes"])
            text = own("{faces} written to {file}; {true} of {all} have true surfaces")
            faces, parts = messages.count(told["faces"], "face"), messages.count(true + planes, "round part")
            return said(text, faces=faces, file=path.name, true=true, all=parts)

        return write


class ISIMP_OT_export_lods(_Formats, bpy.types.Operator):
    """Export all levels of detail, each to a file of its own: NAME_LOD0, NAME_LOD1; GLB and OBJ with colliders"""

    bl_idname = "isimp.export_lods"
    bl_label = "Export LODs"

    filepath: StringProperty(subtype="FILE_PATH")
    kinds = _LEVELS
    errors = (*Writes.errors, RuntimeError)  # of Blender's own exporters
    filter_glob: StringProperty(default="*.glb;*.obj;*.ifc;*.dxf;*.json", options={"HIDDEN"})
    kind: EnumProperty(name="Format", description="Format of the file", items=_LEVELS)

    @classmethod
    def poll(cls, context):
        return targets.allows(cls, context, lambda scan: "" if _levels(context, scan) else targets.NO_RESULT)

    def written(self, context):
        scan, _ = targets.find(context)
        levels, path = _levels(context, scan), self.path()
        kind = engine.exporting.formats.format_of(path).suffix
        stem = path.name[: len(path.name) - len(kind)]
        for number, obj in enumerate(levels):
            with _alone(context, obj):
                _export_level(context, scan, obj, path.with_name(f"{stem}_LOD{number}{kind}"), kind)
        files = messages.count(len(levels), "file")
        return said("{files} written, the first is {name}", files=files, name=f"{stem}_LOD0{kind}")


def _levels(context, scan) -> list:
    """Return the levels of detail of a scan from fine to coarse: the kept levels, then the result of Mesh.

    Objects in collections that are excluded from the view layer are left out: they can't be selected.
    """
    found = [obj for _, obj in targets.levels(scan)]
    result = targets.result_of(context.scene, scan)
    found = found if result is None or result in found else [*found, result]
    return [obj for obj in found if obj.name in context.view_layer.objects]


@contextmanager
def _alone(context, obj):
    """Makes the object active, and selects it and its children alone. Restores visibility and selection at the end."""
    layer = context.view_layer
    active, chosen = layer.objects.active, [other for other in layer.objects if other.select_get()]
    parts = [each for each in (obj, *obj.children) if each.name in layer.objects]  # its colliders belong to it
    hidden = [(part.hide_get(), part.hide_viewport) for part in parts]
    try:
        for other in chosen:
            other.select_set(False)
        for part in parts:
            part.hide_viewport = False
            part.hide_set(False)
            part.select_set(True)
        layer.objects.active = obj
        layer.update()
        yield
    finally:
        for part, (is_hidden, in_no_view) in zip(parts, hidden, strict=True):
            part.select_set(False)
            part.hide_set(is_hidden)
            part.hide_viewport = in_no_view
        for other in chosen:
            other.select_set(True)
        layer.objects.active = active


def _export_level(context, scan, obj, path: Path, kind: str) -> None:
    if kind == ".glb":
        bpy.ops.export_scene.gltf(filepath=str(path), export_format="GLB", use_selection=True)
    elif kind == ".obj":
        bpy.ops.wm.obj_export(filepath=str(path), export_selected_objects=True)
    else:
        handover.export(path, places.model_of(context, scan, obj), places.epsg(scan) or None)


class ISIMP_OT_write_report(_OfSteps, bpy.types.Operator):
    """Write a table of the planes (CSV, GeoJSON) and a page with pictures and the deviation (HTML) into a folder"""

    bl_idname = "isimp.write_report"
    bl_label = "Write Report"

    directory: StringProperty(subtype="DIR_PATH")
    filter_folder: BoolProperty(default=True, options={"HIDDEN"})

    def meshed(self, recipe):
        return recipe if _last_mesh(recipe) else recipe.then(rcp.Mesh())

    def writer(self, context, scan):
        if not self.directory:
            raise ValueError(said("No folder is named: choose one for the report."))
        folder, about = Path(bpy.path.abspath(self.directory)), (scan.name, places.epsg(scan) or None)
        place = places.to_world(scan)

        def write(mesh, outcome) -> str:
            texts = handover.report_texts(mesh, outcome, place, *about)
            handover.write_report(folder, texts)
            return said("Report written: {files}", files=", ".join(texts))

        return write


CLASSES = (ISIMP_OT_export_building, ISIMP_OT_write_report, ISIMP_OT_export_step, ISIMP_OT_export_lods)
