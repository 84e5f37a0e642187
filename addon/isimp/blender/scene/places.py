"""Stores a scan's place on the map as custom properties: the offset that an exact import subtracted."""

from pathlib import Path

import bpy
import numpy as np

from ... import handover
from . import mesh_io
from .result import turned

ORIGIN, EPSG = "isimp_origin", "isimp_epsg"  #: three doubles; the EPSG number


def keep(obj, origin, epsg: int = 0) -> None:
    """Stores the origin on a scan if it is not zero, and the EPSG number if it is known."""
    if np.any(origin):
        obj[ORIGIN] = [float(x) for x in origin]
    if epsg:
        obj[EPSG] = int(epsg)


def origin(obj) -> np.ndarray:
    """Return (3,) the offset to add to world coordinates; zero if no usable one is stored."""
    try:
        found = np.array(list(obj[ORIGIN]), np.float64)
    except (KeyError, TypeError, ValueError):
        return np.zeros(3)
    return found if found.shape == (3,) and np.isfinite(found).all() else np.zeros(3)


def epsg(obj) -> int:
    found = obj.get(EPSG, 0)
    return found if isinstance(found, int) and found > 0 else 0


def modules() -> Path:
    """Return the folder of Blender's user for Python packages, which Blender searches when it starts."""
    there = bpy.utils.user_resource("SCRIPTS", path="modules")  # empty if it does not exist yet
    return Path(there) if there else Path(bpy.utils.resource_path("USER"), "scripts", "modules")


def to_world(scan) -> np.ndarray:
    """Return (4, 4) from the space of a `Scan` of the object to map coordinates."""
    place = mesh_io.place_matrix(scan).copy()
    place[:3, 3] += origin(scan)
    return place


def model_of(context, scan, result) -> handover.Model:
    """Return the visible result in map coordinates."""
    seen = result.evaluated_get(context.evaluated_depsgraph_get())
    mesh = seen.to_mesh()
    try:
        points = mesh_io.points(mesh).reshape(-1, 3).astype(np.float64)
        loops, start = mesh_io.polygons(mesh)
    finally:
        seen.to_mesh_clear()
    matrix = np.array(result.matrix_world, np.float64)
    if np.linalg.det(matrix[:3, :3]) < 0:
        loops = turned(loops, start)
    return handover.Model(points @ matrix[:3, :3].T + matrix[:3, 3] + origin(scan), loops, start)
