"""The settings of each step as Blender's properties: shared by operators and the panel, so that both agree."""

import dataclasses

import bpy
from bpy.props import EnumProperty, FloatProperty, IntProperty, PointerProperty

from .. import recipe as rcp

_PARTITION, _MESH = rcp.Partition(), rcp.Mesh()


class PartitionSettings:
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


class IsimpPartition(PartitionSettings, bpy.types.PropertyGroup):
    """Settings of Partition in the panel"""


class IsimpMeshing(MeshSettings, bpy.types.PropertyGroup):
    """Settings of Mesh in the panel"""


class IsimpPanel(bpy.types.PropertyGroup):
    """What the panel shows"""

    partition: PointerProperty(type=IsimpPartition)
    meshing: PointerProperty(type=IsimpMeshing)


def to_step(cls, properties):
    """The step of a class with the values of properties of the same names."""
    names = [field.name for field in dataclasses.fields(cls) if field.name != "enabled"]
    values = {name: getattr(properties, name) for name in names}
    return cls(**{name: round(value, 6) if isinstance(value, float) else value for name, value in values.items()})


def copy(cls, source, target) -> None:
    """Copies the settings of a step from one holder to another."""
    for field in dataclasses.fields(cls):
        if field.name != "enabled":
            setattr(target, field.name, getattr(source, field.name))


CLASSES = (IsimpPartition, IsimpMeshing, IsimpPanel)


def register() -> None:
    bpy.types.WindowManager.isimp = PointerProperty(type=IsimpPanel)


def unregister() -> None:
    del bpy.types.WindowManager.isimp
