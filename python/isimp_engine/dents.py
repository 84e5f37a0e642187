"""Where a scan leaves its cylinders and cones by more than the tolerance: dents and bulges of their walls."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._core import CurvedProxy, Mesh, Partition
from .surfaces import pieces

NOISES = 3  # a vertex that is further away by noise alone is rare
LEAST_SHARE = 0.001  # share of the area of a part
MOST = 20  # rows of a part
DEEPEST, FACING = 0.2, 0.5  # share of the radius, cosine to the wall: other triangles are in no dent


def dent_rows(mesh: Mesh, part: Partition) -> list[dict[str, Any]]:
    """Return a row for each dent, the deepest of each part first.

    part: the number of the round part. place: the centre of its deepest triangle. depth: into the wall, seen from its
    visible side; below 0 for a bulge. area_share: of the part.
    """
    away = max(part.tolerance or 0.0, NOISES * (part.noise or 0.0))
    walls = [patch for patch in part.curved if patch["kind"] in ("cylinder", "cone")]
    if away <= 0 or not walls:
        return []
    label, triangles = np.asarray(part.face_region), np.asarray(mesh.triangles)
    corners = np.asarray(mesh.vertices)[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
    area = np.linalg.norm(normal, axis=1)
    rows: list[dict[str, Any]] = []
    for patch in walls:
        mine, depth = _wall(corners.mean(axis=1), normal, np.isin(label, patch["regions"]), patch)
        found = []
        for side in (depth > away, depth < -away):
            for some in _connected(triangles[mine], side):
                share = float(area[mine[some]].sum() / area[mine].sum())
                if share < LEAST_SHARE:
                    continue
                deepest = some[np.abs(depth[some]).argmax()]
                place = corners[mine[deepest]].mean(axis=0).tolist()
                found.append(
                    {
                        "part": int(patch["number"]),
                        "place": place,
                        "depth": float(depth[deepest]),
                        "area_share": share,
                    }
                )
        rows += sorted(found, key=lambda row: -abs(row["depth"]))[:MOST]
    return rows


def _wall(
    places: NDArray[np.float64], normals: NDArray[np.float64], is_cell: NDArray[np.bool_], patch: CurvedProxy
) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """The triangles of the part and of dents that have regions of their own, and their depths."""
    axis, slope = np.asarray(patch["axis"]), patch["slope"]
    from_point = places - np.asarray(patch["point"])
    along = from_point @ axis
    out = from_point - along[:, None] * axis
    far = np.linalg.norm(out, axis=1)
    radius = patch["radius"] + slope * along
    facing = (normals * out).sum(axis=1)
    side = np.sign(facing[is_cell].sum())  # a hole is seen from inside
    low, high = along[is_cell].min(), along[is_cell].max()
    is_wall = (along > low) & (along < high) & (np.abs(far - radius) < DEEPEST * radius)
    is_wall &= side * facing > FACING * far * np.linalg.norm(normals, axis=1)
    mine = np.flatnonzero(is_cell | is_wall if patch["full"] else is_cell)
    return mine, (side * (radius - far) / np.sqrt(1 + slope**2))[mine]


def _connected(triangles: NDArray[np.int32], chosen: NDArray[np.bool_]) -> list[NDArray[np.intp]]:
    """Sets of chosen triangles that share edges."""
    some = np.flatnonzero(chosen)
    if not len(some):
        return []
    ends = np.sort(np.stack([triangles[some], np.roll(triangles[some], -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    owner = np.repeat(np.arange(len(some)), 3)
    order = np.lexsort(ends.T)
    same = (ends[order[1:]] == ends[order[:-1]]).all(axis=1)
    group = pieces(len(some), np.stack([owner[order[1:][same]], owner[order[:-1][same]]], axis=1))
    return [some[group == number] for number in np.unique(group)]
