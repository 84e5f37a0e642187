"""Writes files of polygons of all kinds."""

import importlib.util
from collections.abc import Callable
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._core import FileError, InvalidInput, Job, Mesh, Partition, PolygonMesh
from ..drafts import whole
from ..reading import reader
from . import cityjson, dxf, ifc
from .surfaces import Surfaces, surfaces_of

KINDS = (".city.json", ".dxf", ".ifc", ".step", ".stp")
STEP_KINDS = (".step", ".stp")
UNITS = ("m", "mm")  #: what a scene unit may be in STEP
_NEEDS = {".dxf": ("ezdxf", "dxf"), ".ifc": ("ifcopenshell", "ifc")}  # the package, and the extra that installs it
_NEEDS |= dict.fromkeys(STEP_KINDS, ("OCP", "step"))
_NAMES = {"OCP": "cadquery-ocp-novtk"}  # of packages that are imported under another name


def kind_of(path: str | PathLike[str]) -> str | None:
    """The one of KINDS that a name ends in; None for others."""
    name = Path(path).name.lower()
    return next((kind for kind in KINDS if name.endswith(kind)), None)


def missing(path: str | PathLike[str]) -> str:
    """The package, as pip names it, that a file of this kind needs and that is not installed; empty where none is."""
    package, _ = _NEEDS.get(kind_of(path) or "", ("", ""))
    is_there = not package or importlib.util.find_spec(package) is not None
    return "" if is_there else _NAMES.get(package, package)


def require(path: str | PathLike[str]) -> None:
    """Refuse a file for which a package is missing, or can't be loaded. Raises FileError, which names it."""
    package, extra = _NEEDS.get(kind_of(path) or "", ("", ""))
    if not package:
        return
    if name := missing(path):
        raise FileError(f"{path}: to write it the package {name} is needed: pip install 'isimp[{extra}]'")
    with reader(path, f"the package {_NAMES.get(package, package)}, which is needed to write it, can't be loaded"):
        importlib.import_module(package)


def write(
    path: str | PathLike[str],
    polygons: PolygonMesh,
    job: Job | None = None,
    *,
    crs: int | None = None,
    version: str = "2.0",
    like: str | PathLike[str] | None = None,
    surfaces: Surfaces | None = None,
    partition: Partition | None = None,
    mesh: Mesh | None = None,
    unit: str = "m",
    place: NDArray[np.float64] | None = None,
) -> dict[str, Any]:
    """Write polygons: PLY, OBJ; for buildings CityJSON (.city.json), DXF and IFC; STEP (.step, .stp).

    The file appears whole or not at all. CityJSON, DXF and IFC have their polygons by class (walls, roofs, ground) and
    keep n-gons and the scan's coordinates in double precision; they take scene units for metres. DXF needs the package
    ezdxf, IFC ifcopenshell.

    STEP is a solid where the polygons are closed, else a shell. Round parts of the partition (`Partition.curved`) have
    true surfaces; where one can't be cut to a valid face, its cells are planes. Polygons that are not planar beside
    others are triangles: `MeshingOptions.planar` avoids most. Needs the package cadquery-ocp-novtk.

    crs: the number of the EPSG reference system of the coordinates, written to CityJSON and IFC.
    version: of CityJSON, "2.0" or "1.1".
    like: a name with the kind of the file, where `path` is a temporary one.
    surfaces: the result of `surfaces_of` for these polygons, if it is known already.
    partition, mesh: for STEP, of which the polygons were made.
    unit: what a scene unit is in STEP, "m" or "mm".
    place: (4, 4), for STEP: a rotation and a shift to the coordinates of the file; None: the polygons' own.
    Returns a dict, empty but for STEP: faces, solids, valid (by OpenCASCADE), volume, gap (largest distance of an edge
    from a face), triangulated (polygons), true_surfaces (number and kind of round parts), planes (number of other round
    parts, and the reason).
    Raises FileError (another extension, a missing package, or the place can't be written), InvalidInput, Cancelled.
    """
    if unit not in UNITS:
        raise InvalidInput(f"unit must be one of {', '.join(UNITS)}, got {unit!r}")
    named = Path(like if like is not None else path)
    kind = kind_of(named)
    if kind is None:
        _core.write(path, polygons, job)
        return {}
    require(named)
    at = Path(path)
    name = named.name[: -len(kind)] or "building"
    if kind in STEP_KINDS:
        from .step.step_file import write as write_step  # needs OpenCASCADE

        told: dict[str, Any] = {}
        _whole(at, lambda draft: told.update(write_step(draft, polygons, name, partition, mesh, job, unit, place)))
        return told
    surfaces = surfaces or surfaces_of(polygons)
    if kind == ".city.json":
        text = cityjson.cityjson(polygons, surfaces, name, crs, version)
        _whole(at, lambda draft: draft.write_text(text, encoding="utf-8"))
    elif kind == ".dxf":
        _whole(at, lambda draft: dxf.write(draft, polygons, surfaces))
    else:
        _whole(at, lambda draft: ifc.write(draft, polygons, surfaces, name, crs))
    return {}


def _whole(place: Path, put: Callable[[Path], object]) -> None:
    """Write next to the place, then move there."""
    with reader(place, "can't be written"):
        try:
            with whole(place) as draft:
                put(draft)
        except OSError as error:
            raise FileError(f"{place}: can't be written: {error.strerror or error}") from None
