"""The settings of each step as Blender's properties: shared by operators and the panel, so that both agree.

Those of the panel call `changed` when they are, which re-runs the recipe (see live.py).
"""

import dataclasses
import math
import struct

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from .. import recipe as rcp
from ..engine_options import MESHING, PARTITION
from ..option import Option
from . import runtime, targets, weights

_PARTITION, _MESH = rcp.Partition(), rcp.Mesh()


def _weights(self, context, edit_text):
    """The suggestions of the field for weights."""
    scan, problem = targets.find(context)
    return [] if problem else weights.names(scan)


def _face_attributes(self, context, edit_text):
    """The suggestions of the field for the attribute of barriers."""
    scan, problem = targets.find(context)
    return [] if problem else weights.face_names(scan)


_CAN_SEARCH = "search" in StringProperty.__doc__
_SEARCHED = {"search": _weights} if _CAN_SEARCH else {}
_FACES_SEARCHED = {"search": _face_attributes} if _CAN_SEARCH else {}


def _range(option: Option) -> dict:
    """The ends of the range of an engine's option, as far as they are in it."""
    number = int if option.kind == "int" else float
    least = {} if option.least is None or option.above_least else {"min": number(option.least)}
    most = {} if option.most is None or option.below_most else {"max": number(option.most)}
    return least | most


class PartitionSettings:
    count_by: EnumProperty(
        name="Count By",
        description="How the number of regions is chosen",
        items=(
            ("detail", "Automatic", "The number follows from the shape, at a detail that is a share of its size"),
            ("proxies", "Count", "An exact number"),
            (
                "tolerance",
                "Tolerance",
                "The number follows from a length: smaller shapes are ignored, below .2 m on a building, say",
            ),
            ("bound", "Bound", "The number follows from the largest distance of a vertex from its region's plane"),
        ),
        default=_PARTITION.count_by,
    )
    detail: FloatProperty(
        name="Detail",
        description="Shapes below this share of the scan's size are ignored. A smaller value gives more regions",
        default=_PARTITION.detail,
        min=0.0001,
        max=1.0,
        soft_max=0.05,
        precision=4,
        step=0.05,
    )
    tolerance: FloatProperty(
        name="Tolerance",
        description="Shapes below this length are ignored. A smaller value gives more regions",
        default=_PARTITION.tolerance,
        min=1e-6,
        soft_max=10.0,
        precision=4,
        step=1,
        unit="LENGTH",
    )
    bound: FloatProperty(
        name="Bound",
        description="Largest distance of a vertex from its region's plane. A smaller value gives more regions",
        default=_PARTITION.bound,
        min=1e-6,
        soft_max=10.0,
        precision=4,
        step=1,
        unit="LENGTH",
    )
    adaptivity: FloatProperty(
        name="Adaptivity",
        description="Smaller regions where the scan is rough. 0: the same detail everywhere",
        default=_PARTITION.adaptivity,
        **_range(PARTITION["adaptivity"]),
    )
    smooth: FloatProperty(
        name="Smooth",
        description="How much short, straight borders count beside the error. 0: least error. 1: cleanest shapes",
        default=_PARTITION.smooth,
        **_range(PARTITION["smooth"]),
    )
    close_openings: BoolProperty(
        name="Close Openings",
        description="Close holes and tunnels of a noisy scan that the regions can't show",
        default=_PARTITION.close_openings,
    )
    noise: FloatProperty(
        name="Noise",
        description="Standard deviation of the scan's points, in the scan's units. Below 0: estimated",
        default=_PARTITION.noise,
        min=-1.0,
        soft_max=0.1,
        precision=5,
    )
    snap: BoolProperty(
        name="Snap to Planes",
        description="If the shape clearly consists of planes, make one region for each plane",
        default=_PARTITION.snap,
    )
    proxies: IntProperty(
        name="Proxies",
        description="Number of regions. Each becomes one polygon, or a few",
        default=_PARTITION.proxies,
        soft_max=5000,
        **_range(PARTITION["proxies"]),
    )
    method: EnumProperty(
        name="Method",
        description="Algorithm of the partition",
        items=(
            (
                "hierarchy",
                "Hierarchy",
                "Merge small patches, then relax the borders: the fastest, with the least error",
            ),
            (
                "teleport",
                "Teleport",
                "As Lloyd; then merge the cheapest pair and split the worst region while the error falls",
            ),
            ("lloyd", "Lloyd", "Flood from the seeds and fit planes, alternately: the method of the first paper"),
            ("queued", "Queued", "As Lloyd, but flood all faces of a queue at once: for GPUs"),
            ("naive", "Naive", "As Lloyd, but every face chooses among the nearest regions: for GPUs"),
            ("hybrid", "Hybrid", "Partition a decimated copy, and carry the regions back to the scan"),
        ),
        default=_PARTITION.method,
    )
    seeding: EnumProperty(
        name="Start",
        description="Faces at which the first regions start (all methods except Hierarchy)",
        items=(
            ("random", "Random", "Random faces"),
            ("farthest", "Farthest", "Each face where the surface differs most from all regions so far"),
            ("hierarchical", "Hierarchical", "One face in each region of the method Hierarchy"),
        ),
        default=_PARTITION.seeding,
    )
    seed: IntProperty(
        name="Seed",
        description="Seed of the random numbers",
        default=_PARTITION.seed,
        **_range(PARTITION["seed"]),
    )
    iterations: IntProperty(
        name="Iterations",
        description="Maximum number of rounds of flooding and fitting. Fewer if the regions stop changing",
        default=_PARTITION.iterations,
        soft_max=100,
        **_range(PARTITION["iterations"]),
    )
    leave_out: FloatProperty(
        name="Leave Out Parts",
        description="Loose parts below this share of the total area get no region and no polygon. 0: keep every part",
        default=_PARTITION.leave_out,
        max=0.99,
        precision=4,
        step=0.01,
        **_range(PARTITION["leave_out"]),
    )

    weights: StringProperty(
        name="Weights",
        description="A vertex group (from weight paint) or an attribute of faces or vertices. Higher weights give more "
        "and smaller regions; with Count, the total number stays. Empty: no weights",
        default=_PARTITION.weights,
        **_SEARCHED,
    )
    influence: FloatProperty(
        name="Influence",
        description="Strength of the weights. At 1, a weight of 1 gives four times as many regions as a weight of 0",
        default=_PARTITION.influence,
        min=0.0,
        max=2.0,
    )

    seams: BoolProperty(
        name="Seams",
        description="No region crosses an edge that is marked as a seam (Edge > Mark Seam)",
        default=_PARTITION.seams,
    )
    sharp: BoolProperty(
        name="Sharp Edges",
        description="No region crosses an edge that is marked as sharp (Edge > Mark Sharp)",
        default=_PARTITION.sharp,
    )
    materials: BoolProperty(
        name="Materials", description="No region has faces of two materials", default=_PARTITION.materials
    )
    face_sets: BoolProperty(
        name="Face Sets",
        description="No region has faces of two face sets (of Sculpt Mode)",
        default=_PARTITION.face_sets,
    )
    angle: FloatProperty(
        name="Angle",
        description="No region crosses an edge with a larger angle between its faces, in degrees. 180: no limit",
        default=_PARTITION.angle,
        min=0.0,
        max=180.0,
        precision=0,
        step=100,
    )
    borders: StringProperty(
        name="Attribute",
        description="No region has faces with different values of this face attribute. Empty: no such barrier",
        default=_PARTITION.borders,
        **_FACES_SEARCHED,
    )


class MeshSettings:
    chord_tolerance: FloatProperty(
        name="Corner Tolerance",
        description="Distance of a border from a straight line at which it gets another corner, as a share of a "
        "region's size. A smaller value follows the scan more closely, with more corners",
        default=_MESH.chord_tolerance,
        min=0.01,
        soft_max=2.0,
    )
    join_junctions: FloatProperty(
        name="Join Junctions",
        description="Largest distance at which two vertices of three polygons become one vertex of four, as a share "
        "of a region's size, where that gives better polygons. 0: none",
        default=_MESH.join_junctions,
        soft_max=2.0,
        **_range(MESHING["join_junctions"]),
    )
    flatten: IntProperty(
        name="Planarize",
        description="Rounds of moving corners to make polygons planar. 0: corners keep their first positions",
        default=_MESH.flatten,
        soft_max=200,
        **_range(MESHING["flatten"]),
    )
    planar: BoolProperty(
        name="Planar Exactly",
        description="Make every polygon exactly planar. Corners that can't be on the plane of their polygon are cut "
        "off as triangles",
        default=_MESH.planar,
    )


def changed(self, context) -> None:
    """A setting in the panel was changed, by hand or by `to_panel`."""
    current = runtime.get()
    if current is not None:
        current.live.touch()


def _watched(settings: type) -> dict:
    """The properties of a class of settings, each of which calls `changed`."""
    return {
        name: prop.function(**prop.keywords | {"update": changed}) for name, prop in settings.__annotations__.items()
    }


def _plain(cls) -> type:
    """Settings of a step that has none of its own here: one property for each field that one can hold."""
    kinds = {"int": IntProperty, "float": FloatProperty, "str": StringProperty, "bool": BoolProperty}
    made = {}
    for field in dataclasses.fields(cls):
        if field.name != "enabled" and field.type in kinds:
            more = {"default": field.default} if field.default is not dataclasses.MISSING else {}
            limits = _LIMITS.get((cls, field.name), {"min": 0} if field.type in {"int", "float"} else {})
            made[field.name] = kinds[field.type](name=_words(field.name), **more, **limits)
    return type(f"{cls.__name__}Settings", (), {"__annotations__": made})


#: of settings that may be below 0, or not 0
_LIMITS = {
    (rcp.PaintFaces, "onto"): {},
    (rcp.SmoothFaces, "rounds"): {"min": 1, "max": rcp.MOST_ROUNDS},
    **{(cls, "rings"): {"min": 1} for cls in (rcp.GrowRegion, rcp.ShrinkRegion)},
    **{(cls, "times"): {"min": 1} for cls in (rcp.AddWorst, rcp.DeleteLeast, rcp.MergeCheapest)},
}


def _words(name: str) -> str:
    return name.replace("_", " ").title()


def _group(cls) -> type:
    """The property group that holds the settings of a step in the panel."""
    annotations = _watched(_SETTINGS.get(cls) or _plain(cls))
    return type(f"Isimp{cls.__name__}", (bpy.types.PropertyGroup,), {"__annotations__": annotations})


_SETTINGS = {rcp.Partition: PartitionSettings, rcp.Mesh: MeshSettings}
_GROUPS = {cls: _group(cls) for cls in rcp.KINDS}
_KNOWN = {cls: frozenset(group.__annotations__) for cls, group in _GROUPS.items()}


class _Shown:
    live: BoolProperty(
        name="Live",
        description="Apply changed settings at once, even while you drag them. If off, press Partition or Mesh",
        default=True,
    )
    open_step: IntProperty(default=-1)
    overlay: BoolProperty(
        name="Lines over the Scan", description="Draw the region borders and the preview of the polygons", default=True
    )
    keep_texture: BoolProperty(
        name="Keep Texture",
        description="Put the images of the scan's materials on the result of Mesh, as one material",
        default=True,
    )
    outline: BoolProperty(
        name="Outline",
        description="Draw the edges and corners of the polygons over the scan, exactly as Mesh will create them",
        default=True,
    )
    heat: BoolProperty(
        name="Flatness",
        description="Colour the previewed polygons: green is planar, red is non-planar by half a percent of the size",
        default=False,
    )
    times: IntProperty(name="Times", description="Number of edits", default=1, min=1, soft_max=50)
    brush: IntProperty(name="Radius", description="Radius of the brush", default=40, min=1, max=500, subtype="PIXEL")
    mirror: EnumProperty(
        name="Mirror",
        description="Mirror strokes at the scan's origin, along this axis",
        items=(("NONE", "No Mirror", ""), ("X", "X", ""), ("Y", "Y", ""), ("Z", "Z", "")),
        default="NONE",
    )
    stroke: EnumProperty(
        name="Stroke",
        description="Effect of a stroke",
        items=(
            ("paint", "Grow", "Extend the region where the stroke begins"),
            ("new", "New", "Paint a new region (Ctrl)"),
            ("smooth", "Smooth", "Smooth the borders between regions (Shift)"),
            (
                "erase",
                "Erase",
                "Erase from the region where the stroke begins; its neighbours take the faces (Ctrl and Shift)",
            ),
        ),
        default="paint",
    )
    lock_painted: BoolProperty(
        name="Lock", description="Lock newly painted regions: only painting changes them", default=True
    )
    all_steps: BoolProperty(name="All Steps", description="List all steps, not only the latest")


def _panel() -> type:
    """The group of all that the panel shows: the settings of each step, and how it is shown."""
    steps = {kind: PointerProperty(type=_GROUPS[cls]) for cls, kind in rcp.KINDS.items()}
    return type("IsimpPanel", (bpy.types.PropertyGroup,), {"__annotations__": steps | _Shown.__annotations__})


IsimpPanel = _panel()


def group(context, cls):
    """The panel's settings of a step."""
    return getattr(context.window_manager.isimp, rcp.KINDS[cls])


def names(cls) -> list:
    """The settings of a step that have a property, in order."""
    return [field.name for field in dataclasses.fields(cls) if field.name in _KNOWN[cls]]


def held(prop, value):
    """A value as a property can hold it: within its limits, and its default in place of an invalid value."""
    if prop.type == "ENUM":
        return value if value in prop.enum_items else prop.default
    if prop.type not in {"INT", "FLOAT"}:
        return value
    if math.isnan(value):
        return prop.default
    return min(max(value, prop.hard_min), prop.hard_max)


def _kinds(properties):
    """The definitions of the properties of a group or of an operator."""
    return getattr(properties, "properties", properties).bl_rna.properties


def _values(cls, properties) -> dict:
    kinds = _kinds(properties)
    values = {name: held(kinds[name], getattr(properties, name)) for name in names(cls)}
    return {name: round(value, 6) if isinstance(value, float) else value for name, value in values.items()}


def to_step(cls, properties):
    """The step of a class with the values of properties of the same names."""
    return cls(**_values(cls, properties))


def updated(step, properties):
    """The step with the values of properties of the same names; a float that equals a property's float32 is kept."""
    new, kinds = _values(type(step), properties), _kinds(properties)
    changed = {name: value for name, value in new.items() if not _alike(value, held(kinds[name], getattr(step, name)))}
    return dataclasses.replace(step, **changed) if changed else step


def _alike(a, b) -> bool:
    if isinstance(a, float) and isinstance(b, (float, int)) and math.isfinite(b):
        return a == b or round(struct.unpack("f", struct.pack("f", b))[0], 6) == a
    return a == b


def copy(cls, source, target) -> None:
    """Copies the settings of a step from one holder (a step, too) to another."""
    kinds = _kinds(target)
    for name in names(cls):
        value = held(kinds[name], getattr(source, name))
        if getattr(target, name) != value:
            setattr(target, name, value)


def give(cls, source, operator) -> None:
    """Sets all settings of a step on a button's operator, as an unset one would keep its last value."""
    kinds = _kinds(operator)
    for name in names(cls):
        setattr(operator, name, held(kinds[name], getattr(source, name)))


def shown_step(recipe, cls):
    """(index, step) that the panel's settings of a class stand for: the open step, else the last one; or None."""
    open_step = bpy.context.window_manager.isimp.open_step
    if 0 <= open_step < len(recipe.steps) and type(recipe.steps[open_step]) is cls:
        return open_step, recipe.steps[open_step]
    found = [(index, step) for index, step in enumerate(recipe.steps) if type(step) is cls]
    return found[-1] if found else None


def to_panel(context, recipe) -> None:
    """Shows the settings of a recipe's steps in the panel, without re-running anything."""
    with runtime.get().live.quiet():
        for cls in _GROUPS:
            found = shown_step(recipe, cls)
            if found is not None:
                copy(cls, found[1], group(context, cls))


def forget_foreign(context, scan) -> None:
    """Empties the fields that name a layer which only another scan has."""
    partition = group(context, rcp.Partition)
    with runtime.get().live.quiet():
        if partition.weights not in weights.names(scan):
            partition.weights = ""
        if partition.borders not in weights.face_names(scan):
            partition.borders = ""


def from_panel(context, recipe):
    """The recipe with the settings that the panel shows."""
    is_open = context.window_manager.isimp.open_step
    for cls in _GROUPS:
        found = shown_step(recipe, cls)
        step = updated(found[1], group(context, cls)) if found is not None else None
        if found is not None and step != found[1]:
            change = recipe.replaced if found[0] == is_open else recipe.changed
            recipe = change(found[0], step)
    return recipe


CLASSES = (*_GROUPS.values(), IsimpPanel)


def register() -> None:
    bpy.types.WindowManager.isimp = PointerProperty(type=IsimpPanel)


def unregister() -> None:
    del bpy.types.WindowManager.isimp
