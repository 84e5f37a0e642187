"""Operators that keep a result as a level of detail, open it for editing, make colliders, or merge coplanar faces."""

from dataclasses import replace
from functools import partial

import bpy
import numpy as np
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty

from ... import messages
from ... import recipe as rcp
from ...applying import engine_call
from ...engine import engine
from ...language import own, said
from ..controls import settings
from ..scene import mesh_io, runtime, selection, store, targets
from ..scene.result import place_at
from ..work import modal, scene_outcome
from ..work.modal import Aside, RecipeOperator
from .clean_up import without_slivers
from .mesh import Meshing


class ISIMP_OT_make_editable(Meshing, bpy.types.Operator):
    """Merge slivers, mesh, and open the result in Edit Mode with face select"""

    bl_idname = "isimp.make_editable"
    bl_label = "Make Editable"
    adjusted = ("slivers", "chord_tolerance", "planar")

    slivers: BoolProperty(name="Merge Slivers", description="Merge small regions with a neighbour first", default=True)

    def wanted(self, context, target):
        recipe = super().wanted(context, target)
        if not self.slivers:
            return recipe
        last = [step for step in recipe.steps if isinstance(step, (rcp.Mesh, rcp.Texture))]
        return without_slivers(context, target.scan, recipe.without_mesh(), 0.1)[0].then(*last)

    def show(self, context, scan, work, outcome):
        kept = super().show(context, scan, work, outcome)
        if context.view_layer.objects.active.visible_get():
            bpy.ops.object.mode_set(mode="EDIT")
            context.tool_settings.mesh_select_mode = (False, False, True)
        return kept


class ISIMP_OT_keep_lod(bpy.types.Operator):
    """Keep the result as a level of detail. The next Partition makes a third of its regions"""

    bl_idname = "isimp.keep_lod"
    bl_label = "Keep as LOD"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return targets.allows_with_result(cls, context)

    def execute(self, context):
        scan, result, _ = targets.find_result(context)
        level = max((number for number, _ in targets.levels(scan)), default=-1) + 1
        while targets.named(scan.name, f"_LOD{level}") in bpy.data.objects:  # an object of the user
            level += 1
        result.name = targets.named(scan.name, f"_LOD{level}")  # Mesh does not overwrite a renamed result
        result.data.name = result.name
        scene_outcome.bring_to_front(context, scan, result)
        regions = store.numbers(scan).get("regions", 0)
        if regions:
            group = settings.group(context, rcp.Partition)
            with runtime.get().live.quiet():
                group.count_by, group.proxies = "proxies", max(4, regions // 3)
        self.report({"INFO"}, said("Kept as '{name}', hidden", name=result.name))
        return {"FINISHED"}


COLLIDER = "isimp_collider"  #: property of colliders and of their collections
_NO_LIMIT = own("At Most does not apply with Wall Thickness: each wall is a part of its own")


class ISIMP_OT_colliders(RecipeOperator, bpy.types.Operator):
    """Cut the result into convex parts for collisions, as objects in a new collection. An open one needs a thickness"""

    bl_idname = "isimp.colliders"
    bl_label = "Colliders"

    names: EnumProperty(
        name="Names",
        description="Names of the parts, as a program knows them",
        items=(
            ("unreal", "Unreal", "UCX_NAME_00"),
            ("unity", "Unity", "NAME_collider_00"),
            ("godot", "Godot", "NAME_00-convcol"),
            ("plain", "Plain", "NAME_00"),
        ),
    )
    parts: IntProperty(
        name="At Most",
        description="Largest number of parts; they may fill free space then. 0: as many as needed",
        min=0,
        soft_max=64,
    )
    enclose: BoolProperty(
        name="Enclose",
        description="Every corner of the result is inside: planes are pushed outwards for this, the least possible",
    )
    thickness: FloatProperty(
        name="Wall Thickness",
        description="Each polygon becomes a slab behind it, as the walls of a scanned room. 0: the result is a solid",
        unit="LENGTH",
        min=0.0,
        soft_max=1.0,
        precision=3,
    )

    @classmethod
    def poll(cls, context):
        return targets.allows_with_result(cls, context)

    def draw(self, context):
        self.layout.use_property_split = True
        for name in ("names", "enclose", "thickness"):
            self.layout.prop(self, name)
        most = self.layout.column()
        most.active = not self.thickness
        most.prop(self, "parts")
        if self.thickness:
            most.label(text=said(_NO_LIMIT), icon="INFO")

    def _begin(self, context, target):
        scan, result, problem = targets.find_result(context)
        if problem:
            self.report({"ERROR"}, said(problem))
            return None
        if self.thickness and self.parts:
            self.report({"WARNING"}, said(_NO_LIMIT))
        self._source = result.name
        return Aside(scan, convex_parts(result, self.enclose, self.parts, self.thickness), self._show)

    def _show(self, context, parts):
        result = bpy.data.objects.get(self._source)
        if result is None:
            self.report({"WARNING"}, said(modal.DISCARDED, name=self._source))
            return {"CANCELLED"}
        name = add_colliders(context, parts, result, self.names)
        triangles = messages.count(sum(len(part.triangles) for part in parts), "triangle")
        text = own("{parts}, {triangles}, in the collection '{name}'")
        found = messages.count(len(parts), "convex part")
        self.report({"INFO"}, said(text, parts=found, triangles=triangles, name=name))
        return {"FINISHED"}


def convex_parts(source, enclose=False, most=0, thickness=0.0):
    """Return a function of a watch that cuts a result into convex parts, on any thread. It raises ValueError.

    Lengths have the result's scale. The parts are in the space of its mesh.
    """
    shape = mesh_io.shape_matrix(source)
    points = mesh_io.points(source.data).reshape(-1, 3).astype(np.float64) @ shape
    loops, start = mesh_io.polygons(source.data)
    limit = None if thickness else most or None
    solid = points, np.split(loops, start[1:])
    cut = partial(engine.convex_parts, solid, enclose=enclose, parts=limit, thickness=thickness or False)

    def found(watch) -> list:
        try:
            parts = engine_call(watch, 0.0, 1.0, "cutting", cut)
            return [replace(part, vertices=part.vertices @ np.linalg.inv(shape)) for part in parts]
        except ValueError as problem:
            raise ValueError(said("No colliders: {reason}", reason=problem)) from None

    return found


def add_colliders(context, parts: list, target, names: str) -> str:
    """Adds convex parts as children of a level, in a new collection, whose name is returned.

    They replace former ones of the same names.
    """
    name = engine.convex.NAMES[names]
    taken = {name(target.name, number) for number in range(len(target.children))}
    for part in target.children:
        if part.get(COLLIDER) and part.name in taken:
            remove_collider(part)
    place = bpy.data.collections.new(said("{name} colliders", name=target.name))
    place[COLLIDER] = True
    (target.users_collection or (context.scene.collection,))[0].children.link(place)
    for number, part in enumerate(parts):
        place.objects.link(_collider(name(target.name, number), part, target))
    return place.name


def _collider(name: str, part, result):
    """Return a new object of a convex part, which follows the result and is drawn as wires."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(part.vertices.tolist(), [], part.triangles.tolist())
    made = bpy.data.objects.new(name, mesh)
    made.parent, made[COLLIDER] = result, True
    made.display_type, made.hide_render = "WIRE", True
    return made


def remove_collider(part) -> None:
    places = [place for place in part.users_collection if place.get(COLLIDER)]
    remove(part)
    for place in places:
        if not (place.objects or place.children):
            bpy.data.collections.remove(place)


def remove(obj) -> None:
    mesh = obj.data
    bpy.data.objects.remove(obj)
    if not mesh.users:
        bpy.data.meshes.remove(mesh)


class ISIMP_OT_merge_flat(RecipeOperator, bpy.types.Operator):
    """Merge coplanar faces of a mesh, without modifiers, into exact polygons of a new object. Materials stay apart"""

    bl_idname = "isimp.merge_flat"
    bl_label = "Merge Flat"
    adjusted = ("angle",)

    angle: FloatProperty(
        name="Angle",
        description="Largest angle between the planes of faces that are merged",
        default=np.radians(0.01),
        min=0.0,
        max=np.radians(90.0),
        precision=3,
        subtype="ANGLE",
    )

    @classmethod
    def poll(cls, context):
        obj = context.view_layer.objects.active
        problem = ""
        if obj is None or obj.type != "MESH" or not len(obj.data.polygons):
            problem = own("No mesh is active: click one first")
        elif context.mode != "OBJECT":
            problem = own("Leave Edit Mode first (Tab)")
        elif engine is None:
            problem = own("The iSimp engine does not load")
        elif runtime.get().running is not None:
            _, problem = targets.find(context)
        if problem:
            cls.poll_message_set(said(problem))
        return not problem

    def _begin(self, context, target):
        source = context.view_layer.objects.active
        return Aside(source, _flat(source, float(np.degrees(self.angle))), partial(self._show, source.name))

    def _show(self, name: str, context, merged):
        source = bpy.data.objects[name]
        selection.leave_modes(context, source)
        made = _new_flat(context, source, *merged)
        scene_outcome.bring_to_front(context, made, source)
        numbers = messages.count(len(source.data.polygons), "face"), messages.count(len(made.data.polygons), "polygon")
        self.report(
            {"INFO"}, said("{faces} -> {polygons}, nothing else changed", faces=numbers[0], polygons=numbers[1])
        )
        return {"FINISHED"}


def _flat(source, angle: float):
    """Return a function of a watch that merges coplanar faces of an object, on any thread. It raises ValueError.

    It returns (the polygons, the material of each).
    """
    mesh = source.data
    points = mesh_io.points(mesh).reshape(-1, 3).astype(np.float64)
    triangles, face = mesh_io.loop_triangles(mesh, "vertices")
    material = np.zeros(len(mesh.polygons), np.int32)
    mesh.polygons.foreach_get("material_index", material)

    def merged(watch) -> tuple:
        clean = engine_call(watch, 0.0, 0.5, "cleaning", engine.clean, points, triangles.reshape(-1, 3))
        group = np.where(clean.source_face >= 0, material[face[np.maximum(clean.source_face, 0)]], 0)
        poly, region = engine_call(watch, 0.5, 1.0, "merging", engine.merge_flat, clean, angle, group)
        of_region = np.zeros(int(region.max()) + 1, np.int32)
        of_region[region] = group
        return poly, of_region[np.asarray(poly.polygon_region)]

    return merged


def _new_flat(context, source, poly, material):
    """Return a new object with merged faces of the source at its place."""
    name = targets.named(source.name, ".flat")
    made = bpy.data.objects.new(name, bpy.data.meshes.new(name))
    for collection in source.users_collection or (context.scene.collection,):
        collection.objects.link(made)
    start = np.array(poly.loop_start)
    vertices, loops = np.asarray(poly.vertices), np.array(poly.loops)
    vertices, loops, _ = place_at(made, source, vertices, np.zeros(3), loops, start)
    for slot in source.material_slots:
        made.data.materials.append(slot.material)
    set_materials = partial(made.data.polygons.foreach_set, "material_index", material)
    mesh_io.fill_polygons(made.data, vertices, loops, start, {}, set_materials)
    made.data.update()
    return made


CLASSES = (ISIMP_OT_make_editable, ISIMP_OT_keep_lod, ISIMP_OT_colliders, ISIMP_OT_merge_flat)
