"""The round parts of a model: axis, radius, segments, area and distance from the scan."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import Mesh, Partition

ROUND_COLUMNS = (
    *("number", "kind", "axis_x", "axis_y", "axis_z", "point_x", "point_y", "point_z", "radius", "slope", "span"),
    *("segments", "rings", "area", "distance_mean", "distance_rms", "distance_max"),
)


def round_rows(
    mesh: Mesh, part: Partition, planes: list[dict[str, Any]], away: NDArray[np.float64], place: NDArray[np.float64]
) -> list[dict[str, Any]]:
    """One row for each round part, keys: ROUND_COLUMNS.

    planes: the rows of the planes, whose areas count. away: (V,) distances of the mesh's vertices from the polygons.
    place: (4, 4), a rotation and a shift to the coordinates of the table.
    """
    area = {row["region"]: row["area"] for row in planes}
    label, triangles = np.asarray(part.face_region), np.asarray(mesh.triangles)
    rows = []
    for patch in part.curved:
        far = away[np.unique(triangles[np.isin(label, patch["regions"])])]
        far = far[np.isfinite(far)]
        axis = place[:3, :3] @ np.asarray(patch["axis"], np.float64)
        point = place[:3, :3] @ np.asarray(patch["point"], np.float64) + place[:3, 3]
        rows.append(
            {
                "number": patch["number"],
                "kind": patch["kind"],
                **dict(zip(("axis_x", "axis_y", "axis_z"), axis.tolist(), strict=True)),
                **dict(zip(("point_x", "point_y", "point_z"), point.tolist(), strict=True)),
                "radius": patch["radius"],
                "slope": patch["slope"] if patch["kind"] == "cone" else None,
                "span": float(np.degrees(patch["span"])),
                "segments": patch["segments"],
                "rings": patch["rings"],
                "area": float(sum(area.get(region, 0.0) for region in patch["regions"])),
                "distance_mean": float(far.mean()) if len(far) else None,
                "distance_rms": float(np.sqrt((far**2).mean())) if len(far) else None,
                "distance_max": float(far.max()) if len(far) else None,
            }
        )
    return rows
