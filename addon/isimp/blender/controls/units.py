"""Panel properties in convenient units: percent, angles, and a tick "automatic" in place of -1.

Each reads and writes a setting of a step.
"""

from math import degrees, exp, log, radians

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty

from ... import recipe as rcp
from ..scene import measure, targets
from .properties import MeshSettings, PartitionSettings, RegulariseSettings


def _of(settings, name: str) -> dict:
    return settings.__annotations__[name].keywords


def _percent(settings, name: str, most: float, soft: float, precision: int, label: str = ""):
    def read(self):
        return 100 * getattr(self, name)

    def write(self, value):
        setattr(self, name, value / 100)

    own = _of(settings, name)
    return FloatProperty(
        name=label or own["name"],
        description=own["description"],
        subtype="PERCENTAGE",
        min=100 * own.get("min", 0.0),
        max=100 * most,
        soft_max=100 * soft,
        precision=precision,
        step=5,
        get=read,
        set=write,
    )


def _angle(settings, most: float):
    own = _of(settings, "angle")
    return FloatProperty(
        name=own["name"],
        description=own["description"].replace(", in degrees", "").replace("180:", "180°:"),
        subtype="ANGLE",
        min=0.0,
        max=radians(most),
        get=lambda self: radians(self.angle),
        set=lambda self, value: setattr(self, "angle", degrees(value)),
    )


def _automatic_length(description: str, first: float):
    """Return a tick for a length of 0, the engine's choice. first: the length after the tick is removed."""

    def write(self, value: bool) -> None:
        self.length = 0.0 if value else self.length or first

    return BoolProperty(name="Automatic Limit", description=description, get=lambda self: self.length == 0, set=write)


def _found_or_length(settings, name: str, label: str = "Automatic") -> dict:
    """Return two properties of a length that is negative if the engine finds it: a tick and the length."""
    own = _of(settings, name)

    def find(self, value: bool) -> None:
        setattr(self, name, -1.0 if value else max(0.0, getattr(self, name)))

    return {
        f"{name}_found": BoolProperty(
            name=label,
            description=own["description"],
            get=lambda self: getattr(self, name) < 0,
            set=find,
        ),
        f"{name}_length": FloatProperty(
            name=own["name"],
            description=own["description"],
            unit="LENGTH",
            min=0.0,
            soft_max=own["soft_max"],
            precision=4,
            get=lambda self: max(0.0, getattr(self, name)),
            set=lambda self, value: setattr(self, name, value),
        ),
    }


def _set_automatic(self, value: bool) -> None:
    self.noise = -1.0 if value else max(0.0, self.noise)


_LENGTHS = ("tolerance", "bound")
_FINEST, _COARSEST = 0.0002, 0.05  # ends of the slider, shares of the scan's size


def _size() -> float:
    """Return the size of the active scan; 1 if there is none."""
    scan, problem = targets.seen(bpy.context)
    return 1.0 if problem else measure.size(scan)


def _share(self) -> float:
    """Return the smallest feature as a share of the scan's size, from the setting that is in use."""
    return getattr(self, self.count_by) / _size() if self.count_by in _LENGTHS else self.detail


def _set_share(self, share: float) -> None:
    if self.count_by in _LENGTHS:
        setattr(self, self.count_by, share * _size())
    else:
        self.detail = min(max(share, 1e-6), 1.0)


def _coarseness(self) -> float:
    share = min(max(_share(self), _FINEST), _COARSEST)
    return 100 * log(share / _FINEST) / log(_COARSEST / _FINEST)


def _set_coarseness(self, percent: float) -> None:
    _set_share(self, _FINEST * exp(percent / 100 * log(_COARSEST / _FINEST)))


_WAYS = ("detail", "proxies", "triangles")  #: values of `count_by` for `way`; lengths count as the first


def _set_way(self, number: int) -> None:
    if number != _way(self):
        self.count_by = _WAYS[number]


def _way(self) -> int:
    return _WAYS.index(self.count_by) if self.count_by in _WAYS else 0


def _set_sharpens(self, value: bool) -> None:
    self.sharp_edges = max(0.0, self.sharp_edges) if value else -1.0


SHOWN = {
    rcp.Partition: {
        "way": EnumProperty(
            name="How Many",
            description="How the number of regions is chosen",
            items=(
                ("SIZE", "By Size", "The number follows from the shape: features below a size are ignored"),
                ("COUNT", "Polygons", "An exact number of regions; each becomes one polygon, or a few"),
                ("TRIANGLES", "Triangles", "As many regions as their polygons may have triangles"),
            ),
            get=_way,
            set=_set_way,
        ),
        "feature": FloatProperty(
            name="Smallest Feature",
            description="Features below this size are ignored. A smaller value gives more regions",
            unit="LENGTH",
            min=0.0,
            soft_max=10.0,
            precision=4,
            step=1,
            get=lambda self: _share(self) * _size(),
            set=lambda self, value: _set_share(self, max(value, 1e-9) / _size()),
        ),
        "coarseness": FloatProperty(
            name="Fine to Coarse",
            description="The smallest feature as a slider: further left is finer, with more regions",
            subtype="PERCENTAGE",
            min=0.0,
            max=100.0,
            precision=0,
            get=_coarseness,
            set=_set_coarseness,
        ),
        "sharpens": BoolProperty(
            name="Sharpen Edges",
            description="Rounded and dented edges become sharp: narrow regions at edges become part of the adjacent "
            "planes",
            get=lambda self: self.sharp_edges >= 0,
            set=_set_sharpens,
        ),
        "sharp_edges_length": _found_or_length(PartitionSettings, "sharp_edges")["sharp_edges_length"],
        **_found_or_length(PartitionSettings, "stitch", "Automatic Stitch"),
        **_found_or_length(PartitionSettings, "grid", "Automatic Grid Cell"),
        "detail_percent": _percent(PartitionSettings, "detail", 1.0, 0.05, 2),
        "leave_out_percent": _percent(PartitionSettings, "leave_out", 0.99, 0.05, 2, "Ignore Parts Below"),
        "angle_turn": _angle(PartitionSettings, 180),
        "noise_automatic": BoolProperty(
            name="Automatic Noise",
            description="Estimate the roughness of the scan. Smaller shapes do not count as details",
            get=lambda self: self.noise < 0,
            set=_set_automatic,
        ),
        "noise_length": FloatProperty(
            name="Noise",
            description="Roughness of the scan, as a standard deviation of its points. 0: a drawn model",
            unit="LENGTH",
            min=0.0,
            soft_max=0.1,
            precision=4,
            get=lambda self: max(0.0, self.noise),
            set=lambda self, value: setattr(self, "noise", value),
        ),
    },
    rcp.Mesh: {
        **_found_or_length(MeshSettings, "straight_rims", "Automatic Straight Rims"),
        "chord_percent": _percent(MeshSettings, "chord_tolerance", 10.0, 2.0, 0, "Corners"),
        "join_percent": _percent(MeshSettings, "join_junctions", 10.0, 2.0, 0, "Join Corners"),
    },
    rcp.Regularise: {
        "angle_turn": _angle(RegulariseSettings, 45),
        "length_automatic": _automatic_length(
            "The limit follows from the noise of the scan: all planes together add a tenth to it",
            0.01,
        ),
    },
    rcp.AlignPlanes: {
        "length_automatic": _automatic_length(
            "The limit of a plane set by hand is one percent of the scan's size", 0.05
        ),
    },
}

#: the panel's property in place of a setting of a step
INSTEAD = {
    (rcp.Partition, "detail"): "detail_percent",
    (rcp.Partition, "leave_out"): "leave_out_percent",
    (rcp.Partition, "angle"): "angle_turn",
    (rcp.Partition, "noise"): "noise_length",
    (rcp.Partition, "sharp_edges"): "sharp_edges_length",
    (rcp.Partition, "stitch"): "stitch_length",
    (rcp.Partition, "grid"): "grid_length",
    (rcp.Mesh, "straight_rims"): "straight_rims_length",
    (rcp.Mesh, "chord_tolerance"): "chord_percent",
    (rcp.Mesh, "join_junctions"): "join_percent",
    (rcp.Regularise, "angle"): "angle_turn",
}
