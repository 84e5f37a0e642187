"""The presets: settings for kinds of scans. docs/regions.md has the reasons. Standard library only."""

from __future__ import annotations

from dataclasses import dataclass, replace

from .plane_steps import Regularise
from .recipe import Recipe
from .steps import Mesh, Partition


@dataclass(frozen=True)
class Preset:
    """The steps of a recipe for one kind of scan."""

    name: str  #: identifier
    label: str  #: name in the interface
    icon: str  #: one of Blender's icons
    about: str
    partition: Partition
    mesh: Mesh
    regularise: Regularise | None = None  #: the step that snaps planes before Mesh; None: no snapping
    scanned_detail: float = 0.0  #: the detail for scans with noise, if it differs: finer detail is noise there
    is_kind: bool = True  #: whether the panel has an icon for it; the menu lists all presets

    @property
    def recipe(self) -> Recipe:
        steps = (self.partition, self.regularise, self.mesh)
        return Recipe(tuple(step for step in steps if step is not None))

    def partition_for(self, is_scanned: bool) -> Partition:
        """Return the settings of the partition for a scan with noise, or for a drawn model."""
        return (
            replace(self.partition, detail=self.scanned_detail)
            if is_scanned and self.scanned_detail
            else self.partition
        )


PRESETS = (
    Preset(
        "figure",
        "Statue",
        "OUTLINER_OB_ARMATURE",
        "People, animals, statues: rounded shapes with fine details such as faces and hands",
        Partition(count_by="detail", detail=0.005, adaptivity=0.0),
        Mesh(),
    ),
    Preset(
        "building",
        "Building",
        "HOME",
        "One building from outside: large planes with straight edges and noise; planes become regular",
        Partition(count_by="detail", detail=0.0025, adaptivity=0.0, sharp_edges=0.0, curved=True),
        Mesh(planar=True, planar_most=0.1),
        Regularise(),
    ),
    Preset(
        "room",
        "Room",
        "MATCUBE",
        "Rooms from inside: walls, floor and ceiling become regular planes; furniture can be left out",
        Partition(count_by="detail", detail=0.0025, adaptivity=0.0, sharp_edges=0.0),
        Mesh(planar=True, planar_most=0.1),
        Regularise(),
    ),
    Preset(
        "cad",
        "Machine Part",
        "TOOL_SETTINGS",
        "Machine parts, drawn or scanned: planes, cylinders and other round parts. Drawn ones keep finer features",
        Partition(count_by="detail", detail=0.00125, adaptivity=0.0, leave_out=0.0, curved=True),
        Mesh(),
        scanned_detail=0.005,
    ),
    Preset(
        "city",
        "City",
        "MOD_ARRAY",
        "Roofs, walls and ground from the air: few large triangles, many small loose parts",
        Partition(count_by="detail", detail=0.0025, noise=0.0, adaptivity=0.0, leave_out=0.0005),
        Mesh(),
    ),
    Preset(
        "drawn",
        "Drawn",
        "GREASEPENCIL",
        "Models drawn in a program, without noise: all planes and round parts, exactly",
        Partition(count_by="detail", detail=0.00125, noise=0.0, adaptivity=0.0, leave_out=0.0, curved=True),
        Mesh(planar=True),
    ),
    Preset(
        "generated",
        "Generated",
        "SHADERFX",
        "Meshes cut on a grid, such as those made from pictures or texts: stair steps are smoothed, edges are sharp, "
        "parts that are not visible from outside are removed",
        Partition(
            count_by="detail",
            detail=0.005,
            snap=False,
            adaptivity=0.0,
            leave_out=0.002,
            sharp_edges=0.0,
            outside_only=True,
        ),
        Mesh(planar=True),
    ),
    Preset(
        "low_poly",
        "Low Poly",
        "MESH_ICOSPHERE",
        "Few large facets of similar size",
        Partition(count_by="detail", detail=0.01, snap=False, adaptivity=0.0),
        Mesh(),
        is_kind=False,  # a style
    ),
)

BY_NAME = {preset.name: preset for preset in PRESETS}
