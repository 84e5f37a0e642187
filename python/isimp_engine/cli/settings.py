"""The settings of the commands for one scan, as typed values, made once from the command line and the recipe."""

from dataclasses import dataclass, field
from pathlib import Path

from .. import CleanOptions, MeshingOptions, PartitionOptions, RegulariseOptions
from ..recipes import Recipe

Place = tuple[float, float, float]


@dataclass(frozen=True)
class Texturing:
    """The texture of a result."""

    size: int  #: size of an image, pixels; LIKE_THE_SCAN: as dense as the scan's images
    tiles: int | None = None  #: number of images; None: as many as the density of the scan needs
    materials: bool = False  #: images of their own for each of the scan's materials
    height: bool = False  #: a height map
    occlusion: float | None = None  #: largest distance of the faces that keep light off; ANY_DISTANCE; None: no image


@dataclass(frozen=True)
class GuideFiles:
    """Arrays of single faces and edges of one scan."""

    weights: Path | None = None
    borders: Path | None = None
    cuts: Path | None = None
    part: Path | None = None
    base: Path | None = None


@dataclass(frozen=True)
class Settings:
    """How scans are simplified: by options that hold for any scan."""

    clean: CleanOptions
    partition: PartitionOptions
    meshing: MeshingOptions
    regularise: RegulariseOptions | None  #: None: planes are snapped only as the recipe has it
    recipe: Recipe | None
    keep_openings: bool
    kept_places: list[Place]  #: places of openings that stay open
    clutter: str  #: one of CLUTTER: treatment of regions with many polygons
    angle: float | None  #: degrees; no region crosses an edge that bends by more
    texture: Texturing | None
    crs: int | None  #: EPSG number
    unit: str


@dataclass(frozen=True)
class Simplification:
    """One run of `isimp simplify`: its files, and how the scan is simplified."""

    input: Path
    output: Path
    settings: Settings
    guides: GuideFiles = field(default_factory=GuideFiles)
    labels: Path | str | None = None  #: STDOUT is refused
    report: Path | str | None = None
    lods: list[int] | None = None  #: number of regions of each level
    quiet: bool = False
