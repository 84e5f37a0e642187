"""The settings of each step as Blender's properties: shared by operators and the panel, so that both agree.

Those of the panel call `changed` when they are, which re-runs the recipe (see live.py).
"""

import dataclasses
import math
import struct

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from .. import recipe as rcp
from . import runtime, targets, weights

_PARTITION, _MESH = rcp.Partition(), rcp.Mesh()


def _weights(self, context, edit_text):
    """What the field of the weights offers."""
    scan, problem = targets.find(context)
    return [] if problem else weights.names(scan)


def _face_attributes(self, context, edit_text):
    """What the field of the attribute that parts regions offers."""
    scan, problem = targets.find(context)
    return [] if problem else weights.face_names(scan)


_CAN_SEARCH = "search" in StringProperty.__doc__
_SEARCHED = {"search": _weights} if _CAN_SEARCH else {}
_FACES_SEARCHED = {"search": _face_attributes} if _CAN_SEARCH else {}


class PartitionSettings:
    count_by: EnumProperty(
        name="Number By",
        description="What says how many regions there are",
        items=(
            ("detail", "Automatic", "As many as the shape asks for, at a detail that is a share of its size"),
            ("proxies", "Count", "Just so many"),
            ("tolerance", "Tolerance", "As many as show what is larger than a length: .2 m on a building, say"),
            ("bound", "Bound", "As many as keep every vertex within a length of its region's plane"),
        ),
        default=_PARTITION.count_by,
    )
    detail: FloatProperty(
        name="Detail",
        description="What is larger than this share of the scan's size shows. Less makes more regions",
        default=_PARTITION.detail,
        min=0.0001,
        max=1.0,
        soft_max=0.05,
        precision=4,
        step=0.05,
    )
    tolerance: FloatProperty(
        name="Tolerance",
        description="What is larger than this shows. Less makes more regions",
        default=_PARTITION.tolerance,
        min=1e-6,
        soft_max=10.0,
        precision=4,
        step=1,
        unit="LENGTH",
    )
    bound: FloatProperty(
        name="Bound",
        description="The most that a vertex may be off its region's plane. Less makes more regions",
        default=_PARTITION.bound,
        min=1e-6,
        soft_max=10.0,
        precision=4,
        step=1,
        unit="LENGTH",
    )
    adaptivity: FloatProperty(
        name="Adaptivity",
        description="How much denser regions get where the scan is rough",
        default=_PARTITION.adaptivity,
        min=0.0,
        max=1.0,
    )
    noise: FloatProperty(
        name="Noise",
        description="How much the scan's points stray (standard deviation, in the scan's units). Below 0: found out",
        default=_PARTITION.noise,
        min=-1.0,
        soft_max=0.1,
        precision=5,
    )
    snap: BoolProperty(
        name="Take Clear Numbers",
        description="Where the shape clearly is made of so many planes, make just as many regions",
        default=_PARTITION.snap,
    )
    proxies: IntProperty(
        name="Proxies",
        description="How many regions to make. Each becomes one polygon or a few",
        default=_PARTITION.proxies,
        min=1,
        soft_max=5000,
    )
    method: EnumProperty(
        name="Method",
        description="How the regions are found",
        items=(
            (
                "hierarchy",
                "Hierarchy",
                "Merge small patches step by step, then relax the borders: the best and the quickest",
            ),
            (
                "teleport",
                "Teleport",
                "As Lloyd, then merge the cheapest pair and split the worst region while it helps",
            ),
            ("lloyd", "Lloyd", "Flood and fit in turn from the starting faces, as first published"),
            ("queued", "Queued", "As Lloyd, with all faces of a queue flooded at once: for many processors"),
            ("naive", "Naive", "As Lloyd, with every face choosing among the nearest regions: for many processors"),
            ("hybrid", "Hybrid", "Partition a decimated copy of the scan, and carry the regions back to it"),
        ),
        default=_PARTITION.method,
    )
    seeding: EnumProperty(
        name="Start",
        description="Where the first proxies are put (by Lloyd and Teleport)",
        items=(
            ("random", "Random", "Faces drawn by the random seed"),
            ("farthest", "Farthest", "Each where the surface differs most from all before"),
            ("hierarchical", "Hierarchical", "Where the regions of Hierarchy are"),
        ),
        default=_PARTITION.seeding,
    )
    seed: IntProperty(
        name="Seed",
        description="Number that starts the random choice (of Lloyd and Teleport)",
        default=_PARTITION.seed,
        min=0,
    )
    iterations: IntProperty(
        name="Iterations",
        description="The most rounds of flooding and fitting. It ends earlier once nothing changes any more",
        default=_PARTITION.iterations,
        min=1,
        soft_max=100,
    )
    leave_out: FloatProperty(
        name="Leave Out Parts",
        description="Loose parts below this share of the whole area get no region and no polygon. 0 keeps every part",
        default=_PARTITION.leave_out,
        min=0.0,
        max=0.99,
        precision=4,
        step=0.01,
    )

    weights: StringProperty(
        name="Weights",
        description="A vertex group, as Blender's own weight paint makes them, or an attribute of faces or vertices. "
        "Where its weight is higher, there are more regions, while their number stays. Empty: all alike",
        default=_PARTITION.weights,
        **_SEARCHED,
    )
    influence: FloatProperty(
        name="Influence",
        description="How much the weights do. At 1, a weight of 1 draws four times as many regions as one of 0",
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
        description="No region has faces of two face sets, as sculpt mode makes them",
        default=_PARTITION.face_sets,
    )
    angle: FloatProperty(
        name="Bend",
        description="No region crosses an edge where the surface bends by more than so many degrees. 180: it may",
        default=_PARTITION.angle,
        min=0.0,
        max=180.0,
        precision=0,
        step=100,
    )
    borders: StringProperty(
        name="Attribute",
        description="No region has faces with different values of this attribute of faces. Empty: it may",
        default=_PARTITION.borders,
        **_FACES_SEARCHED,
    )


class MeshSettings:
    chord_tolerance: FloatProperty(
        name="Corner Tolerance",
        description="How far a border between two regions may leave a straight line before it gets another corner, "
        "as a share of a region's size. Less follows the scan more closely, with more corners",
        default=_MESH.chord_tolerance,
        min=0.01,
        soft_max=2.0,
    )
    flatten: IntProperty(
        name="Flatten",
        description="Rounds of moving corners until polygons are flat. 0 leaves the corners where they are first put",
        default=_MESH.flatten,
        min=0,
        soft_max=200,
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
        description="Show what a changed setting gives at once, as it is dragged; what follows it is done again",
        default=True,
    )
    open_step: IntProperty(default=-1)
    overlay: BoolProperty(
        name="Lines over the Scan", description="Draw where regions end, and how the polygons would be", default=True
    )
    outline: BoolProperty(
        name="Outline",
        description="Draw the edges and corners that the polygons would have over the scan. Mesh makes just these",
        default=True,
    )
    heat: BoolProperty(
        name="Flatness",
        description="Fill the polygons to be by how flat they are: green is flat, red is bent by half a percent",
        default=False,
    )
    times: IntProperty(name="Times", description="How many at once", default=1, min=1, soft_max=50)
    brush: IntProperty(name="Radius", description="Of the brush", default=40, min=1, max=500, subtype="PIXEL")
    mirror: EnumProperty(
        name="Mirror",
        description="Paint on the other side of the scan's own origin too",
        items=(("NONE", "No Mirror", ""), ("X", "X", ""), ("Y", "Y", ""), ("Z", "Z", "")),
        default="NONE",
    )
    stroke: EnumProperty(
        name="Stroke",
        description="What painting does",
        items=(
            ("paint", "Grow", "Into the region first touched"),
            ("new", "New", "A region of its own (Ctrl)"),
            ("smooth", "Smooth", "Even out borders between regions (Shift)"),
            ("erase", "Erase", "From the region first touched; those around it take its place (Ctrl and Shift)"),
        ),
        default="paint",
    )
    lock_painted: BoolProperty(
        name="Lock", description="Lock regions that are painted anew: nothing but painting changes them", default=True
    )
    all_steps: BoolProperty(name="All Steps", description="List all steps, not only the last ones")


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
    """A value as a property can hold it: within its limits, and its default in place of what is no such value."""
    if prop.type == "ENUM":
        return value if value in prop.enum_items else prop.default
    if prop.type not in {"INT", "FLOAT"}:
        return value
    if math.isnan(value):
        return prop.default
    return min(max(value, prop.hard_min), prop.hard_max)


def _kinds(properties):
    """What each property of a group, or of an operator, is."""
    return getattr(properties, "properties", properties).bl_rna.properties


def _values(cls, properties) -> dict:
    kinds = _kinds(properties)
    values = {name: held(kinds[name], getattr(properties, name)) for name in names(cls)}
    return {name: round(value, 6) if isinstance(value, float) else value for name, value in values.items()}


def to_step(cls, properties):
    """The step of a class with the values of properties of the same names."""
    return cls(**_values(cls, properties))


def updated(step, properties):
    """The step with what properties of the same names say; a float that a property can't tell apart is kept."""
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
    """Gives a button's operator the settings of a step, each of them: what is not given it takes from its last use."""
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
