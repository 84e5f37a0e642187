"""Writes files of polygons of all kinds."""

from collections.abc import Callable
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._core import FileError, InvalidInput, Job, Mesh, Partition, PolygonMesh
from ..drafts import readable, whole
from ..file_errors import reader
from ..lengths import UNITS
from .formats import PLAIN, Content, format_of, in_metres, require
from .surfaces import Surfaces


def write(
    path: str | PathLike[str],
    polygons: PolygonMesh,
    *,
    job: Job | None = None,
    crs: int | None = None,
    version: str = "2.0",
    like: str | PathLike[str] | None = None,
    surfaces: Surfaces | None = None,
    partition: Partition | None = None,
    mesh: Mesh | None = None,
    unit: str = "m",
    place: NDArray[np.float64] | None = None,
) -> dict[str, Any]:
    """Write polygons: PLY, OBJ, GLB, glTF, STL, 3MF, STEP (.step, .stp), and formats of buildings.

    Buildings: CityJSON (.city.json), DXF, IFC, IDF of EnergyPlus, HBJSON of Honeybee.

    PLY and OBJ keep n-gons. GLB and glTF have triangles, which FB_ngon_encoding groups to n-gons, and contain all
    arrays; STL and 3MF have triangles alone. STL is text where coordinates are too far from zero for its float32.

    The file appears whole or not at all. CityJSON, DXF and IFC have their polygons by class (walls, roofs, ground) and
    keep n-gons and the scan's coordinates in double precision. IDF and HBJSON have convex surfaces. All five are
    in metres.

    STEP is a solid where the polygons are closed, else a shell. Round parts of the partition (`Partition.curved`) have
    true surfaces; where one can't be cut to a valid face, its cells are planes. Non-planar polygons are cut into
    triangles: `MeshingOptions.planar` avoids most of them. Needs the package cadquery-ocp-novtk.

    crs: the number of the EPSG reference system of the coordinates, written to CityJSON and IFC.
    version: of CityJSON, "2.0" or "1.1".
    like: a name with the kind of the file, where `path` is a temporary one.
    surfaces: the result of `surfaces_of` for these polygons, if it is known already.
    partition, mesh: for STEP, the partition and the mesh that the polygons were made from.
    unit: the scene unit, m, mm, cm, um, in or ft. STEP and 3MF state it; files of buildings are converted to metres.
    place: (4, 4), for STEP: a rotation and a shift to the coordinates of the file; None: the polygons' own.
    Returns a dict, empty for all formats except STEP: faces, solids, valid (by OpenCASCADE), volume, gap (largest
    distance of an edge from a face), triangulated (polygons), true_surfaces (number and kind of round parts), planes
    (number of other round parts, and the reason).
    Raises FileError (another extension, a missing package, or the place can't be written), InvalidInput, Cancelled.
    """
    if unit not in UNITS:
        raise InvalidInput(f"unit must be one of {', '.join(UNITS)}, got {unit!r}")
    named = Path(like if like is not None else path)
    found = format_of(named)
    if found is None:
        raise FileError(f"{path}: the extension can't be written; it can be {', '.join(PLAIN)}")
    if found.writer is None:
        _core.write(path, polygons, job=job)
        return {}
    require(named)
    writer, told = found.writer, dict[str, Any]()
    name = readable(named.name[: -len(found.suffix)]) or "building"
    content = Content(polygons, name, job, crs, version, surfaces, partition, mesh, unit, place)
    content = in_metres(content) if found.metres else content
    _whole(Path(path), lambda draft: told.update(writer(draft, content)))
    return told


def _whole(place: Path, put: Callable[[Path], object]) -> None:
    """Write to a file next to the final place, then move the file there."""
    with reader(place, "can't be written"):
        try:
            with whole(place) as draft:
                try:
                    put(draft)
                except FileError as error:
                    raise FileError(str(error).replace(str(draft), str(place))) from None
        except OSError as error:
            raise FileError(f"{place}: can't be written: {error.strerror or error}") from None
