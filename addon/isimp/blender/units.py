"""Settings in the units that people think in, for the panel: percent, degrees, and "automatic" in place of -1.

Each is another face of a setting of a step. Setting the one sets the other.
"""

from math import degrees, radians

from bpy.props import BoolProperty, FloatProperty

from .. import recipe as rcp
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
    """Whether a length is 0, which stands for the engine's choice. first: the length when it no longer is."""

    def write(self, value: bool) -> None:
        self.length = 0.0 if value else self.length or first

    return BoolProperty(name="Automatic Limit", description=description, get=lambda self: self.length == 0, set=write)


def _set_automatic(self, value: bool) -> None:
    self.noise = -1.0 if value else max(0.0, self.noise)


SHOWN = {
    rcp.Partition: {
        "detail_percent": _percent(PartitionSettings, "detail", 1.0, 0.05, 2),
        "leave_out_percent": _percent(PartitionSettings, "leave_out", 0.99, 0.05, 2, "Leave Out"),
        "angle_turn": _angle(PartitionSettings, 180),
        "noise_automatic": BoolProperty(
            name="Automatic",
            description="Estimate the roughness of the scan, below which nothing counts as a detail",
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
        "chord_percent": _percent(MeshSettings, "chord_tolerance", 10.0, 2.0, 0, "Corners"),
        "join_percent": _percent(MeshSettings, "join_junctions", 10.0, 2.0, 0, "Join Corners"),
    },
    rcp.Regularise: {
        "angle_turn": _angle(RegulariseSettings, 45),
        "length_automatic": _automatic_length(
            "How far planes may go off the scan follows from its noise: all together add a tenth to that",
            0.01,
        ),
    },
    rcp.AlignPlanes: {
        "length_automatic": _automatic_length(
            "A plane that is set by hand may go off its region by one percent of the scan's size", 0.05
        ),
    },
}

#: what the panel shows in place of a setting of a step
INSTEAD = {
    (rcp.Partition, "detail"): "detail_percent",
    (rcp.Partition, "leave_out"): "leave_out_percent",
    (rcp.Partition, "angle"): "angle_turn",
    (rcp.Partition, "noise"): "noise_length",
    (rcp.Mesh, "chord_tolerance"): "chord_percent",
    (rcp.Mesh, "join_junctions"): "join_percent",
    (rcp.Regularise, "angle"): "angle_turn",
}
