"""Writes files of polygons of all kinds."""

import importlib.util
from collections.abc import Callable
from os import PathLike
from pathlib import Path

from .. import _core
from .._core import FileError, Job, PolygonMesh
from ..drafts import whole
from ..reading import reader
from . import cityjson, dxf, ifc
from .surfaces import Surfaces, surfaces_of

KINDS = (".city.json", ".dxf", ".ifc")
_NEEDS = {".dxf": ("ezdxf", "dxf"), ".ifc": ("ifcopenshell", "ifc")}  # the package, and the extra that installs it


def kind_of(path: str | PathLike[str]) -> str | None:
    """The one of KINDS that a name ends in; None for others."""
    name = Path(path).name.lower()
    return next((kind for kind in KINDS if name.endswith(kind)), None)


def require(path: str | PathLike[str]) -> None:
    """Refuse a file for which a package is missing, or can't be loaded. Raises FileError, which names it."""
    package, extra = _NEEDS.get(kind_of(path) or "", (None, None))
    if package is None:
        return
    if importlib.util.find_spec(package) is None:
        raise FileError(f"{path}: to write it the package {package} is needed: pip install 'isimp[{extra}]'")
    with reader(path, f"the package {package}, which is needed to write it, can't be loaded"):
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
) -> None:
    """Write polygons: PLY, OBJ, and for buildings CityJSON (.city.json), DXF and IFC.

    The file appears whole or not at all. CityJSON, DXF and IFC have their polygons by class (walls, roofs, ground) and
    keep n-gons and the scan's coordinates in double precision; they take scene units for metres. DXF needs the package
    ezdxf, IFC ifcopenshell.

    crs: the number of the EPSG reference system of the coordinates, written to CityJSON and IFC.
    version: of CityJSON, "2.0" or "1.1".
    like: a name with the kind of the file, where `path` is a temporary one.
    surfaces: the result of `surfaces_of` for these polygons, if it is known already.
    Raises FileError (another extension, a missing package, or the place can't be written), InvalidInput, Cancelled.
    """
    named = Path(like if like is not None else path)
    kind = kind_of(named)
    if kind is None:
        _core.write(path, polygons, job)
        return
    require(named)
    place = Path(path)
    surfaces, name = surfaces or surfaces_of(polygons), named.name[: -len(kind)] or "building"
    if kind == ".city.json":
        text = cityjson.cityjson(polygons, surfaces, name, crs, version)
        _whole(place, lambda draft: draft.write_text(text, encoding="utf-8"))
    elif kind == ".dxf":
        _whole(place, lambda draft: dxf.write(draft, polygons, surfaces))
    else:
        _whole(place, lambda draft: ifc.write(draft, polygons, surfaces, name, crs))


def _whole(place: Path, put: Callable[[Path], object]) -> None:
    """Write next to the place, then move there."""
    with reader(place, "can't be written"):
        try:
            with whole(place) as draft:
                put(draft)
        except OSError as error:
            raise FileError(f"{place}: can't be written: {error.strerror or error}") from None
