"""Properties for the settings of steps, shared by operators and the panel; see settings.py."""

from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from ... import recipe as rcp
from ...recipe import Option
from ..scene import targets, weights

_PARTITION, _REGULARISE = rcp.Partition(), rcp.Regularise()


def _weights(self, context, edit_text):
    """Return suggestions for the field of weights."""
    scan, problem = targets.find(context)
    return [] if problem else weights.names(scan)


def _face_attributes(self, context, edit_text):
    """Return suggestions for the field of the attribute of barriers."""
    scan, problem = targets.find(context)
    return [] if problem else weights.face_names(scan)


_CAN_SEARCH = "search" in StringProperty.__doc__
_SEARCHED = {"search": _weights} if _CAN_SEARCH else {}
_FACES_SEARCHED = {"search": _face_attributes} if _CAN_SEARCH else {}


def of_option(option: Option, default, **more):
    """Return the property of an option of the engine: label, tooltip, range. more: further keywords."""
    texts = {"name": option.label, "description": option.tip, "default": default}
    if option.kind == "str":
        return EnumProperty(items=option.items, **texts, **more)
    if option.kind == "bool":
        return BoolProperty(**texts, **more)
    keywords = texts | _range(option, default)
    if option.kind == "int":
        return IntProperty(**keywords | more)
    if option.is_below_zero:
        keywords |= {"precision": 5}
    elif option.unit == "length":
        keywords |= {"precision": 4, "step": 1, "unit": "LENGTH"}
    elif option.digits:
        keywords |= {"precision": option.digits, "step": 10.0 ** (2 - option.digits)}
    return FloatProperty(**keywords | more)


def _range(option: Option, default) -> dict:
    """Return the limits of a setting and of its slider."""
    ends = {}
    if option.low is not None:
        ends["min"] = option.low
    elif option.least is not None:
        least = _LEAST if option.above_least else option.least
        ends["min"] = least if option.holds(default) else option.unset
    if option.most is not None and not option.below_most:
        ends["max"] = option.most
    if option.high is not None:
        ends["max" if option.below_most else "soft_max"] = option.high
    number = int if option.kind == "int" else float
    return {name: number(value) for name, value in ends.items()}


_LEAST = 1e-6  # minimum of a setting that must be above its lower limit


def with_options(step: rcp.Step, *tables: dict[str, Option], **more: dict):
    """Return a decorator that adds a property for each labelled option. more: further keywords by option."""
    shown = {name: option for table in tables for name, option in table.items() if option.label}

    def add(cls: type) -> type:
        made = {name: of_option(option, getattr(step, name), **more.get(name, {})) for name, option in shown.items()}
        cls.__annotations__ = made | cls.__annotations__
        return cls

    return add


@with_options(_PARTITION, rcp.PARTITION, rcp.CLEAN)
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
                "The number follows from a length: smaller shapes are ignored, for example below .2 m on a building",
            ),
            ("bound", "Bound", "The number follows from the largest distance of a vertex from its region's plane"),
            (
                "triangles",
                "Triangles",
                "As many regions as possible whose polygons have at most this number of triangles",
            ),
        ),
        default=_PARTITION.count_by,
    )
    close_openings: BoolProperty(
        name="Close Openings",
        description="Close holes and tunnels of a noisy scan that the regions can't show",
        default=_PARTITION.close_openings,
    )
    weights: StringProperty(
        name="Weights",
        description="A vertex group (from weight paint) or an attribute of faces or vertices. Higher weights give more "
        "and smaller regions; with a given number, the total stays. Empty: no weights",
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


@with_options(rcp.Mesh(), rcp.MESHING, planar_most={"subtype": "FACTOR"})
class MeshSettings:
    pass


@with_options(rcp.Texture(), rcp.TEXTURE)
class TextureSettings:
    pass


@with_options(_REGULARISE, rcp.REGULARISE)
class RegulariseSettings:
    up: EnumProperty(
        name="Up",
        description="Up axis, which defines level and upright",
        items=(
            ("scene", "Scene", "The Z axis of the scene, however the scan is turned"),
            ("x", "Scan X", "The X axis of the scan"),
            ("y", "Scan Y", "The Y axis of the scan"),
            ("z", "Scan Z", "The Z axis of the scan"),
            ("region", "Region", "The region of the selected face is level"),
            ("none", "None", "No plane is level or upright, only parallel to others"),
        ),
        default=_REGULARISE.up,
    )
    snap_sizes: FloatProperty(
        name="Snap Sizes",
        description="Distances of parallel planes and diameters become multiples of this length, and angles of 5 "
        "degrees, where their uncertainty allows it. Polygons become exactly flat. 0: off",
        default=_REGULARISE.snap_sizes,
        min=0.0,
        soft_max=0.1,
        precision=4,
        unit="LENGTH",
    )


class AlignSettings:
    to: EnumProperty(
        name="To",
        description="Target orientation of the planes",
        items=(
            ("level", "Level", "Level planes: floors, ceilings, flat roofs"),
            ("upright", "Upright", "Upright planes: walls"),
            ("parallel", "Parallel", "Parallel to the plane of the leading region"),
            ("perpendicular", "Perpendicular", "At right angles to the plane of the leading region"),
            ("coplanar", "Coplanar", "One plane for all"),
            ("free", "Free", "As scanned: no longer held, also not by Regularise"),
        ),
    )
    length: of_option(
        rcp.REGULARISE["length"]._replace(
            tip="Largest distance of a plane set by hand from its region. 0: one percent of the scan's size"
        ),
        0.0,
    )
