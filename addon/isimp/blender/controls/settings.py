"""Property groups with the settings of each step, shared by operators and the panel.

The panel's properties call `changed` on each change, which re-runs the recipe (see live.py).
"""

import dataclasses
import math
import struct

import bpy
from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    IntVectorProperty,
    PointerProperty,
    StringProperty,
)

from ... import recipe as rcp
from ..scene import runtime, targets, weights
from . import units
from .properties import AlignSettings, MeshSettings, PartitionSettings, RegulariseSettings, TextureSettings

KNOWN_LENGTH = FloatProperty(
    name="Known Length",
    description="The true length of the chosen size: the distance of two chosen planes, or a diameter",
    default=1.0,
    min=1e-6,
    soft_max=1e4,
    precision=4,
    unit="LENGTH",
)


def changed(self, context) -> None:
    """Reports a changed setting of the panel to `live`. `to_panel` and other code suppress this by `live.quiet`."""
    current = runtime.get()
    if current is not None:
        current.live.touch()


def _watched(settings: type) -> dict:
    """Return the properties of a class of settings with `changed` as their update function."""
    return {
        name: prop.function(**prop.keywords | {"update": changed}) for name, prop in settings.__annotations__.items()
    }


def _plain(cls) -> type:
    """Return a settings class for a step without one: a property for each field of a plain type."""
    kinds = {"int": IntProperty, "float": FloatProperty, "str": StringProperty, "bool": BoolProperty}
    made = {}
    for field in dataclasses.fields(cls):
        if field.name != "enabled" and field.type in kinds:
            more = {"default": field.default} if field.default is not dataclasses.MISSING else {}
            limits = _LIMITS.get((cls, field.name), {"min": 0} if field.type in {"int", "float"} else {})
            made[field.name] = kinds[field.type](name=_words(field.name), **more, **limits)
    return type(f"{cls.__name__}Settings", (), {"__annotations__": made})


#: limits of settings whose minimum is not 0
_LIMITS = {
    (rcp.PaintFaces, "onto"): {},
    (rcp.SmoothFaces, "rounds"): {"min": 1, "max": rcp.MOST_ROUNDS},
    (rcp.EvenBorders, "strength"): {"min": 0.0, "max": 1.0, "subtype": "FACTOR"},
    **{(cls, "rings"): {"min": 1} for cls in (rcp.GrowRegion, rcp.ShrinkRegion)},
    **{(cls, "times"): {"min": 1} for cls in (rcp.AddWorst, rcp.DeleteLeast, rcp.MergeCheapest)},
}


def _words(name: str) -> str:
    return name.replace("_", " ").title()


def _group(cls) -> type:
    """Return the property group with the panel's settings of a step."""
    own = _SETTINGS.get(cls) or _OTHERS.get(cls) or _plain(cls)
    annotations = _watched(own) | units.SHOWN.get(cls, {})
    return type(f"Isimp{cls.__name__}", (bpy.types.PropertyGroup,), {"__annotations__": annotations})


#: by class of step, for the steps whose settings the panel shows before a scan has regions
_SETTINGS = {rcp.Partition: PartitionSettings, rcp.Mesh: MeshSettings, rcp.Regularise: RegulariseSettings}
_OTHERS = {rcp.AlignPlanes: AlignSettings, rcp.Texture: TextureSettings}
_GROUPS = {cls: _group(cls) for cls in rcp.KINDS}
_KNOWN = {cls: frozenset(group.__annotations__) for cls, group in _GROUPS.items()}


def draw(layout, cls, properties, name: str, **more) -> None:
    """Draws a setting of a step, in the panel's unit if it has one; see units.py."""
    layout.prop(properties, units.INSTEAD.get((cls, name), name), **more)


_COLOURS = ("away", "heat", "directions")  #: colourings of polygons; the first one that is on is drawn


def _colour(self) -> int:
    return next((number for number, name in enumerate(_COLOURS, 1) if getattr(self, name)), 0)


def _set_colour(self, chosen: int) -> None:
    for number, name in enumerate(_COLOURS, 1):
        setattr(self, name, number == chosen)


def _kind(self) -> str:
    scan, problem = targets.seen(bpy.context)
    return "" if problem else scan.isimp.kind


def _set_kind(self, name: str) -> None:
    scan, problem = targets.seen(bpy.context)
    if not problem and scan.isimp.kind != name:
        scan.isimp.kind = name


class _Shown:
    kind: StringProperty(get=_kind, set=_set_kind)  #: name of the preset chosen for the active scan
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
    away: BoolProperty(
        name="Distance",
        description="Colour the previewed polygons by the largest distance of the scan from them: green is none, red "
        "is two percent of the size or more",
        default=False,
    )
    directions: BoolProperty(
        name="Directions",
        description="Colour the previewed polygons by their direction, where planes are snapped or set by hand: "
        "a hue for each direction, a shade for each plane. Grey is free",
        default=False,
    )
    colour: EnumProperty(
        name="Colour",
        description="Meaning of the colours over the scan",
        items=(
            ("NONE", "Regions", "A colour for each region"),
            (
                "AWAY",
                "Distance",
                "Green polygons are near the scan, red ones are off by two percent of the size or more",
            ),
            ("HEAT", "Flatness", "Green polygons are planar, red ones bend by half a percent of the size or more"),
            ("DIRECTIONS", "Directions", "A hue for each direction of snapped planes, a shade for each plane"),
        ),
        get=_colour,
        set=_set_colour,
    )
    known_length: KNOWN_LENGTH
    regularise_first: BoolProperty(
        name="Regularise When Meshing",
        description="Mesh regularises the planes first, with these settings",
        default=False,
    )
    summary: BoolProperty(
        name="Summary",
        description="Show the numbers of regions and polygons and the distance from the scan in a corner of the view",
        default=True,
    )
    hand: EnumProperty(
        name="Mode",
        description="Effect of a click or a drag with the Region tool",
        items=(
            ("add", "Add", "Click: add a region. Drag a border or a corner: move it. Drag to another region: merge"),
            ("delete", "Delete", "Click: delete the region; its neighbours take its faces (Ctrl)"),
            ("merge", "Merge", "Drag to another region: merge both, also from a border"),
            ("cut", "Cut", "Drag a line over a region: cut it. Click: split it where its halves differ most"),
            ("choose", "Choose", "Click: choose one more region, or no longer (Shift). Buttons act on chosen regions"),
            ("finer", "Finer Here", "Stroke: split each region under it where its halves differ most"),
            ("more", "More Here", "Click a head, a hand or a tool: more regions up to its neck. Drag: a larger part"),
        ),
        default="add",
    )
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
            ("finer", "Finer Here", "Split each region under the stroke where its halves differ most"),
        ),
        default="paint",
    )
    lock_painted: BoolProperty(
        name="Lock", description="Lock newly painted regions: only painting changes them", default=True
    )
    lods: IntVectorProperty(
        name="Polygons",
        description="Polygons of each level of detail; 0: no such level",
        size=3,
        min=0,
        default=(300, 100, 33),
    )
    lod_colliders: BoolProperty(
        name="Colliders", description="Convex parts of the coarsest level, for collisions", default=True
    )
    all_steps: BoolProperty(name="All Steps", description="List all steps, not only the latest")
    notes: BoolProperty(
        name="Notes", description="List repairs, closed openings, ignored faces and planes that were not held"
    )
    search: StringProperty(
        name="Search", description="List only the settings with this text in their names", options={"TEXTEDIT_UPDATE"}
    )


def _panel() -> type:
    """Return the property group of the panel: the settings of each step, and the display options."""
    steps = {kind: PointerProperty(type=_GROUPS[cls]) for cls, kind in rcp.KINDS.items()}
    return type("IsimpPanel", (bpy.types.PropertyGroup,), {"__annotations__": steps | _Shown.__annotations__})


IsimpPanel = _panel()


def group(context, cls):
    """Return the panel's settings of a class of steps."""
    return getattr(context.window_manager.isimp, rcp.KINDS[cls])


def names(cls) -> list:
    """Return the names of a step's fields that have a property, in order."""
    return [field.name for field in dataclasses.fields(cls) if field.name in _KNOWN[cls]]


def held(prop, value):
    """Return a value that the property can hold: clamped to its limits, the default for an invalid value."""
    if prop.type == "ENUM":
        return value if value in prop.enum_items else prop.default
    if prop.type not in {"INT", "FLOAT"}:
        return value
    if math.isnan(value):
        return prop.default
    return min(max(value, prop.hard_min), prop.hard_max)


def _kinds(properties):
    """Return the definitions of the properties of a group or an operator."""
    return getattr(properties, "properties", properties).bl_rna.properties


def _values(cls, properties) -> dict:
    kinds = _kinds(properties)
    values = {name: held(kinds[name], getattr(properties, name)) for name in names(cls)}
    return {name: round(value, 6) if isinstance(value, float) else value for name, value in values.items()}


def to_step(cls, properties):
    """Return a step of the class with the values of the properties of the same names."""
    return cls(**_values(cls, properties))


def updated(step, properties):
    """Return the step with the values of the properties. A float that equals its property in float32 is kept."""
    new, kinds = _values(type(step), properties), _kinds(properties)
    changed = {name: value for name, value in new.items() if not _alike(value, held(kinds[name], getattr(step, name)))}
    return dataclasses.replace(step, **changed) if changed else step


def _alike(a, b) -> bool:
    if isinstance(a, float) and isinstance(b, (float, int)) and math.isfinite(b):
        return a == b or round(struct.unpack("f", struct.pack("f", b))[0], 6) == a
    return a == b


def copy(cls, source, target) -> None:
    """Copies the settings of a step from one holder (a step or properties) to another."""
    kinds = _kinds(target)
    for name in names(cls):
        value = held(kinds[name], getattr(source, name))
        if getattr(target, name) != value:
            setattr(target, name, value)


def give(cls, source, operator) -> None:
    """Sets all settings of a step on a button's operator. An unset property would keep its last value."""
    kinds = _kinds(operator)
    for name in names(cls):
        setattr(operator, name, held(kinds[name], getattr(source, name)))


def shown_step(recipe, cls):
    """Return (index, step) shown by the panel's settings of a class: the open step, else the last one, else None."""
    open_step = bpy.context.window_manager.isimp.open_step
    if 0 <= open_step < len(recipe.steps) and type(recipe.steps[open_step]) is cls:
        return open_step, recipe.steps[open_step]
    found = [(index, step) for index, step in enumerate(recipe.steps) if type(step) is cls]
    return found[-1] if found else None


def to_panel(context, recipe) -> None:
    """Copies the settings of a recipe's steps to the panel without re-running them."""
    with runtime.get().live.quiet():
        for cls in _GROUPS:
            found = shown_step(recipe, cls)
            if found is not None:
                copy(cls, found[1], group(context, cls))


def shown(context) -> tuple:
    """Return the panel's settings of Partition, Mesh and Regularise, as steps."""
    return tuple(to_step(cls, group(context, cls)) for cls in _SETTINGS)


def show(context, steps) -> None:
    """Copies settings to the panel without re-running steps. None: the defaults."""
    with runtime.get().live.quiet():
        for step in steps if steps is not None else (cls() for cls in _SETTINGS):
            copy(type(step), step, group(context, type(step)))


def forget_foreign(context, scan) -> None:
    """Clears fields that name a layer which this scan does not have."""
    partition = group(context, rcp.Partition)
    with runtime.get().live.quiet():
        if partition.weights not in weights.names(scan):
            partition.weights = ""
        if partition.borders not in weights.face_names(scan):
            partition.borders = ""


def from_panel(context, recipe):
    """Return the recipe with the panel's settings."""
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
