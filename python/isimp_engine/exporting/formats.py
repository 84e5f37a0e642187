"""The table of file formats for polygons, used by the command, tiles, textures and the add-on."""

import importlib.util
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from .._core import FileError, Job, Mesh, Partition, PolygonMesh
from ..file_errors import reader
from ..lengths import UNITS
from . import cityjson, dxf, energy, ifc, triangles
from .surfaces import Surfaces, surfaces_of


@dataclass(frozen=True)
class Content:
    """The content of a file; see `write`."""

    polygons: PolygonMesh
    name: str  #: name of the building or solid in the file
    job: Job | None
    crs: int | None
    version: str
    known: Surfaces | None
    partition: Partition | None
    mesh: Mesh | None
    unit: str
    place: NDArray[np.float64] | None

    @cached_property
    def surfaces(self) -> Surfaces:
        """The polygons by class."""
        return self.known or surfaces_of(self.polygons)


@dataclass(frozen=True, eq=False)
class _Polygons:
    """The attributes of PolygonMesh that the writers of buildings read."""

    vertices: NDArray[np.float64]
    loops: NDArray[np.int32]
    loop_start: NDArray[np.int32]
    report: dict[str, Any]


def in_metres(of: Content) -> Content:
    """The content with the coordinates in metres."""
    factor = UNITS[of.unit]
    if factor == 1:
        return of
    poly, surfaces = of.polygons, of.surfaces
    vertices = np.asarray(poly.vertices, np.float64) * factor
    larger = cast(PolygonMesh, _Polygons(vertices, poly.loops, poly.loop_start, poly.report))
    return replace(of, polygons=larger, known=replace(surfaces, volume=surfaces.volume * factor**3), unit="m")


Writer = Callable[[Path, Content], dict[str, Any]]  # returns facts for the report


def _cityjson(draft: Path, of: Content) -> dict[str, Any]:
    text = cityjson.cityjson(of.polygons, of.surfaces, of.name, of.crs, of.version)
    draft.write_text(text, encoding="utf-8")
    return {}


def _dxf(draft: Path, of: Content) -> dict[str, Any]:
    draft.write_text(dxf.dxf(of.polygons, of.surfaces), encoding="ascii")
    return {}


def _ifc(draft: Path, of: Content) -> dict[str, Any]:
    draft.write_text(ifc.ifc(of.polygons, of.surfaces, of.name, of.crs), encoding="ascii")
    return {}


def _idf(draft: Path, of: Content) -> dict[str, Any]:
    draft.write_text(energy.idf(of.polygons, of.surfaces, of.name), encoding="ascii")
    return {}


def _hbjson(draft: Path, of: Content) -> dict[str, Any]:
    draft.write_text(energy.hbjson(of.polygons, of.surfaces, of.name), encoding="utf-8")
    return {}


def _step(draft: Path, of: Content) -> dict[str, Any]:
    from .step.step_file import write  # needs OpenCASCADE

    return write(draft, of.polygons, of.name, of.partition, of.mesh, of.job, of.unit, of.place)


def _stl(draft: Path, of: Content) -> dict[str, Any]:
    triangles.write_stl(draft, of.polygons, of.job)
    return {}


def _3mf(draft: Path, of: Content) -> dict[str, Any]:
    triangles.write_3mf(draft, of.polygons, of.unit, of.job)
    return {}


def _glb(draft: Path, of: Content) -> dict[str, Any]:
    from ..texturing.glb import plain  # reads the table of formats itself

    draft.write_bytes(plain(of.name, of.polygons, of.job).glb(draft))
    return {}


def _gltf(draft: Path, of: Content) -> dict[str, Any]:
    from ..texturing.glb import plain

    draft.write_bytes(plain(of.name, of.polygons, of.job).gltf())
    return {}


@dataclass(frozen=True)
class Format:
    """A format of files of polygons."""

    suffix: str
    writer: Writer | None = None  #: None: the engine writes it itself
    package: str = ""  #: package that the writer imports
    pip: str = ""  #: name of that package for pip
    extra: str = ""  #: extra of isimp that installs it
    plain: bool = True  #: for polygons without a texture
    textured: bool = False  #: for polygons with a texture
    tiles: bool = False  #: for the result of `isimp tiles`
    lods: bool = False  #: for levels of detail from Blender
    metres: bool = False  #: its lengths are metres
    menu: str = ""  #: in Blender's File > Export: "building" or "solid"

    @property
    def is_missing(self) -> bool:
        """Whether its package is not installed."""
        return bool(self.package) and importlib.util.find_spec(self.package) is None


FORMATS = (
    Format(".ply", tiles=True),
    Format(".obj", tiles=True, textured=True, lods=True),
    Format(".glb", _glb, textured=True, lods=True),
    Format(".gltf", _gltf, textured=True),
    Format(".stl", _stl),
    Format(".3mf", _3mf),
    Format(".city.json", _cityjson, lods=True, metres=True, menu="building"),
    Format(".dxf", _dxf, lods=True, metres=True, menu="building"),
    Format(".ifc", _ifc, lods=True, metres=True, menu="building"),
    Format(".idf", _idf, metres=True, menu="building"),
    Format(".hbjson", _hbjson, metres=True, menu="building"),
    Format(".step", _step, "OCP", "cadquery-ocp-novtk", "step", menu="solid"),
    Format(".stp", _step, "OCP", "cadquery-ocp-novtk", "step", menu="solid"),
)


def suffixes(wanted: Callable[[Format], object]) -> tuple[str, ...]:
    """The endings of the formats that a rule accepts."""
    return tuple(each.suffix for each in FORMATS if wanted(each))


PLAIN = suffixes(lambda each: each.plain)
TEXTURED = suffixes(lambda each: each.textured)
TILES = suffixes(lambda each: each.tiles)
LODS = suffixes(lambda each: each.lods)
BUILDING_KINDS = suffixes(lambda each: each.menu == "building")
STEP_KINDS = suffixes(lambda each: each.menu == "solid")
KINDS = suffixes(lambda each: each.writer)  #: formats that this package writes


def format_of(path: str | PathLike[str]) -> Format | None:
    """The format that a name ends in; None for others."""
    name = Path(path).name.lower()
    return next((each for each in FORMATS if name.endswith(each.suffix)), None)


def kind_of(path: str | PathLike[str]) -> str | None:
    """The kind in KINDS that a name ends in; None for others."""
    found = format_of(path)
    return found.suffix if found and found.writer else None


def missing(path: str | PathLike[str]) -> str:
    """The missing package for a file of this kind, as pip names it; empty if none is missing."""
    found = format_of(path)
    return found.pip if found and found.is_missing else ""


def require(path: str | PathLike[str]) -> None:
    """Raises FileError, which names the package, if a file needs a package that is missing or can't be loaded."""
    found = format_of(path)
    if found is None or not found.package:
        return
    if found.is_missing:
        raise FileError(f"{path}: to write it the package {found.pip} is needed: pip install 'isimp[{found.extra}]'")
    with reader(path, f"the package {found.pip}, which is needed to write it, can't be loaded"):
        importlib.import_module(found.package)
