"""Measures the size of a scan like the engine, for settings that are shares of it."""

import numpy as np

from . import mesh_io, runtime

_MOST = 200_000  # approximate number of sampled triangles


def size(obj) -> float:
    """Return 3 standard deviations of the surface's points, scene units: a detail is a share of it. The size is cached.

    Every n-th triangle of a large scan is sampled. An object without area has size 1.
    """
    mesh, known = obj.data, runtime.get().sizes
    box = tuple(tuple(corner) for corner in (obj.bound_box[0], obj.bound_box[6]))
    key = len(mesh.vertices), len(mesh.polygons), box, tuple(tuple(row[:3]) for row in obj.matrix_world[:3])
    if known.get(obj.name, (None, 0.0))[0] != key:
        known[obj.name] = key, _measured(obj)
    return known[obj.name][1]


def _measured(obj) -> float:
    if obj.mode != "OBJECT":  # the mesh is not up to date in other modes
        return float(np.linalg.norm(obj.dimensions)) or 1.0
    try:
        points = mesh_io.points(obj.data).reshape(-1, 3).astype(np.float64) @ mesh_io.shape_matrix(obj)
    except mesh_io.Unusable:
        return 1.0
    triangles = mesh_io.loop_triangles(obj.data, "vertices")[0].reshape(-1, 3)
    corners = points[triangles[:: max(1, len(triangles) // _MOST)]]
    return spread(corners) or 1.0


def spread(corners: np.ndarray) -> float:
    """Return 3 standard deviations of the points of triangles, (T, 3, 3); 0 if they have no area.

    Triangles with coordinates that are not finite do not count, as in the engine.
    """
    corners = corners[np.isfinite(corners).all(axis=(1, 2))]
    if not len(corners):
        return 0.0
    corners = corners - corners[0, 0]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    if not area.sum() > 0:
        return 0.0
    sums = corners.sum(axis=1)
    squares = (corners**2).sum(axis=(1, 2)) + (sums**2).sum(axis=1)
    mean = area @ sums / 3 / area.sum()
    return 3 * float(np.sqrt(max(0.0, area @ squares / 12 / area.sum() - mean @ mean)))
