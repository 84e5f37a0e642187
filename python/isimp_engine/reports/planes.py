"""The planes of a model: area, tilt, azimuth, distance from the scan, and the angles between them."""

import csv
import io
import json
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import InvalidInput, Job, Mesh, Partition, PolygonMesh
from ..exporting.surfaces import rings, surfaces_of
from ..within import scan_distances
from .round_parts import round_rows

_LEVEL = np.sin(np.radians(0.05))  # least horizontal part of a normal: a plane with less has no azimuth

COLUMNS = (
    *("region", "class", "polygons", "area", "tilt", "azimuth", "normal_x", "normal_y", "normal_z"),
    *("centre_x", "centre_y", "centre_z", "distance_mean", "distance_rms", "distance_max"),
)


@dataclass(frozen=True)
class PlaneTable:
    """One row a region and a round part, and the distance of each vertex of the scan from the polygons."""

    rows: list[dict[str, Any]]  #: keys: COLUMNS; scene units, degrees; None where there is no value
    away: NDArray[np.float64]  #: (V,) of the vertices of the mesh; NaN: in no region
    corners: list[NDArray[np.float64]]  #: corners of each polygon, in the coordinates of the table
    polygon_region: list[int]
    round_parts: list[dict[str, Any]]  #: one row a round part; keys: ROUND_COLUMNS; scene units, degrees


def plane_table(
    mesh: Mesh,
    part: Partition,
    poly: PolygonMesh,
    job: Job | None = None,
    place: NDArray[np.float64] | None = None,
) -> PlaneTable:
    """The planes of the polygons of each region.

    area: of its polygons. tilt: of the plane from level, in [0, 180] degrees; 90 is a wall, above it faces down.
    azimuth: the compass direction in which it faces, clockwise from +Y, in [0, 360) degrees; none if it is level.
    distance: of the region's vertices of the scan from the polygons. class: as in `exporting.surfaces_of`, of the
    largest polygon. place: (4, 4), a rotation and a shift to the coordinates of the table, which may mirror; None: the
    mesh's own. Raises InvalidInput (another shape) as scan_distances does.
    """
    place = np.eye(4) if place is None else np.asarray(place)
    if place.shape != (4, 4) or place.dtype.kind not in "fiu" or not np.isfinite(place).all():
        raise InvalidInput(f"place must have the shape (4, 4) and finite numbers, got {place.shape} and {place.dtype}")
    away = scan_distances(mesh, part, poly, job=job)
    places = np.asarray(poly.vertices, np.float64) @ place[:3, :3].T + place[:3, 3]
    step = -1 if np.linalg.det(place[:3, :3]) < 0 else 1  # a mirrored polygon has its corners in the other order
    kinds = surfaces_of(poly, tuple(place[2, :3].tolist())).kind
    corners = [places[loop[::step]] for loop in rings(poly)]
    origin = places.mean(axis=0) if len(places) else np.zeros(3)
    of = np.asarray(poly.polygon_region)
    polygons: dict[int, list[int]] = {}
    for polygon, region in enumerate(of.tolist()):
        polygons.setdefault(region, []).append(polygon)
    ends, count = _vertices_of(mesh, part)
    rows = []
    for region in sorted(polygons):
        sides = [_side(corners[polygon] - origin) for polygon in polygons[region]]
        area = np.array([np.linalg.norm(normal) for normal, _ in sides])
        normal = np.sum([normal for normal, _ in sides], axis=0)
        total, length = float(area.sum()), float(np.linalg.norm(normal))
        unit = normal / length if length > 0 else np.zeros(3)
        centre = np.average([centre for _, centre in sides], axis=0, weights=area if total > 0 else None) + origin
        far = away[ends[count[region] : count[region + 1]]]
        far = far[np.isfinite(far)]
        rows.append(
            {
                "region": region,
                "class": kinds[polygons[region][int(area.argmax())]],
                "polygons": len(sides),
                "area": total,
                "tilt": _tilt(unit) if length > 0 else None,
                "azimuth": _azimuth(unit),
                **dict(zip(("normal_x", "normal_y", "normal_z"), unit.tolist(), strict=True)),
                **dict(zip(("centre_x", "centre_y", "centre_z"), centre.tolist(), strict=True)),
                "distance_mean": float(far.mean()) if len(far) else None,
                "distance_rms": float(np.sqrt((far**2).mean())) if len(far) else None,
                "distance_max": float(far.max()) if len(far) else None,
            }
        )
    return PlaneTable(rows, away, corners, of.tolist(), round_rows(mesh, part, rows, away, place))


def _side(corners: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(area times normal, centroid) of a polygon."""
    first = corners[0]
    parts = np.cross(corners[1:-1] - first, corners[2:] - first) / 2
    normal = parts.sum(axis=0)
    length = np.linalg.norm(normal)
    if not length > 0:
        return normal, corners.mean(axis=0)
    weights = parts @ (normal / length)
    return normal, weights @ (first + corners[1:-1] + corners[2:]) / 3 / length


def _tilt(unit: NDArray[np.float64]) -> float:
    return float(np.degrees(np.arctan2(np.hypot(unit[0], unit[1]), unit[2])))


def _azimuth(unit: NDArray[np.float64]) -> float | None:
    if np.hypot(unit[0], unit[1]) < _LEVEL:
        return None
    return float(np.degrees(np.arctan2(unit[0], unit[1])) % 360)


def _vertices_of(mesh: Mesh, part: Partition) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The vertices of each region, region after region, and where each begins."""
    label = np.repeat(np.asarray(part.face_region), 3)
    pairs = np.stack([label, np.asarray(mesh.triangles).ravel()], axis=1)
    pairs = np.unique(pairs[label >= 0], axis=0)
    return pairs[:, 1].astype(np.int64), np.searchsorted(pairs[:, 0], np.arange(part.region_count + 1))


def angle_rows(table: PlaneTable, regions: Sequence[int]) -> list[dict[str, Any]]:
    """The angle between the normals of each two of some regions, in [0, 180] degrees. Raises KeyError for no region."""
    normals = {row["region"]: np.array([row["normal_x"], row["normal_y"], row["normal_z"]]) for row in table.rows}
    rows = []
    for a, b in combinations(regions, 2):
        cross, dot = np.linalg.norm(np.cross(normals[a], normals[b])), normals[a] @ normals[b]
        rows.append({"region": a, "other": b, "angle": float(np.degrees(np.arctan2(cross, dot)))})
    return rows


def write_csv(rows: list[dict[str, Any]], columns: Sequence[str] = COLUMNS) -> str:
    """The rows as CSV, with all digits that make a difference."""
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows({key: "" if value is None else value for key, value in row.items()} for row in rows)
    return text.getvalue()


def write_geojson(table: PlaneTable, crs: int | None = None) -> str:
    """A feature for each region: its polygons with heights, and its row."""
    parts: dict[int, list[Any]] = {}
    for corners, region in zip(table.corners, table.polygon_region, strict=True):
        ring = corners.tolist()
        parts.setdefault(region, []).append([[*ring, ring[0]]])
    features = [
        {
            "type": "Feature",
            "id": row["region"],
            "properties": row,
            "geometry": {"type": "MultiPolygon", "coordinates": parts[row["region"]]},
        }
        for row in table.rows
    ]
    whole: dict[str, Any] = {"type": "FeatureCollection"}
    if crs is not None:
        whole["crs"] = {"type": "name", "properties": {"name": f"urn:ogc:def:crs:EPSG::{crs}"}}
    return json.dumps(whole | {"features": features}, allow_nan=False) + "\n"
