"""Energy models as text: IDF of EnergyPlus and HBJSON of Honeybee, with a zone for each component."""

import json
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import PolygonMesh, triangulate
from .surfaces import CEILING, GROUND, LEVEL, ROOF, WALL, Surfaces, component_of, rings, shift_of, vector_area

_TOLERANCE = 0.01  # metres: both programs take corners that are nearer for one
_UPRIGHT = 0.17  # largest component along up of a roof's normal that is called a wall: 10 degrees
_LEAST = 0.1  # cubic metres: the volume of a zone that has none
_IDF_VERSION = "25.2"
_CONSTRUCTION = "Construction"


@dataclass(frozen=True)
class _Face:
    kind: str  # WALL, ROOF, GROUND (a floor on the ground) or CEILING (a floor above air)
    corners: NDArray[np.float64]  # (C, 3), turn left seen from outside


@dataclass(frozen=True)
class _Zone:
    volume: float
    faces: list[_Face]


def _zones(poly: PolygonMesh, surfaces: Surfaces, name: str, shift: NDArray[np.float64]) -> dict[str, _Zone]:
    """The zones by name. A scanned room faces inwards: its polygons are turned. Concave polygons become triangles."""
    at = np.asarray(poly.vertices, dtype=np.float64).reshape(-1, 3) - shift
    loops = rings(poly)
    triangles, source = triangulate(at, poly.loops, poly.loop_start)
    begin = np.searchsorted(source, np.arange(len(loops) + 1))
    component = component_of(loops, len(at))
    zones = {}
    for number in range(int(component.max(initial=-1)) + 1):
        some = np.flatnonzero(component == number)
        middle = np.mean([at[loops[q]].mean(0) for q in some], axis=0)
        areas = [vector_area(at[loops[q]] - middle) for q in some]
        volume = sum(float(area @ (at[loops[q][0]] - middle)) for q, area in zip(some, areas, strict=True)) / 3
        inwards = volume < 0
        faces = []
        for q, area in zip(some, areas, strict=True):
            rise = float(area[2]) / (float(np.linalg.norm(area)) or 1.0)
            whole = _turning(at[loops[q]])
            parts = (
                [whole]
                if _is_convex(whole, area)
                else [_turning(at[corners]) for corners in triangles[begin[q] : begin[q + 1]]]
            )
            kind = _kind(surfaces.kind[q], -rise if inwards else rise)
            faces += [_Face(kind, part[::-1] if inwards else part) for part in parts if len(part) > 2]
        zones[name if number == 0 else f"{name}_{number}"] = _Zone(abs(volume), faces)
    return zones


def _kind(kind: str, rise: float) -> str:
    """Floors of zones are level and face down, roofs face up; all other surfaces are walls."""
    if rise <= -LEVEL:
        return GROUND if kind == GROUND else CEILING
    return ROOF if rise > _UPRIGHT else WALL


def _is_convex(points: NDArray[np.float64], area: NDArray[np.float64]) -> bool:
    along = np.roll(points, -1, axis=0) - points
    return bool((np.cross(np.roll(along, 1, axis=0), along) @ area >= 0).all())


def _turning(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """A polygon without corners on a straight line or on another corner: neighbours need them, zones do not."""
    k = 0
    while k < len(points) > 2:
        step, along = points[k] - points[k - 1], points[(k + 1) % len(points)] - points[k - 1]
        off = float(np.linalg.norm(np.cross(along, step)))
        if np.linalg.norm(step) < _TOLERANCE or off <= _TOLERANCE * np.linalg.norm(along):
            points = np.delete(points, k, axis=0)
            k = max(0, k - 1)
        else:
            k += 1
    return points


def _identifier(name: str) -> str:
    """A name that both formats allow: ASCII letters, digits, underscores and hyphens, at most 80."""
    return re.sub(r"[^A-Za-z0-9_-]", "_", name)[:80] or "building"


def idf(poly: PolygonMesh, surfaces: Surfaces, name: str) -> str:
    """The text of an IDF file: BuildingSurface:Detailed objects of one plain construction.

    Coordinates are in metres. A model far from the origin is written near it; a comment has the shift.
    """
    shift = shift_of(poly)
    names = {WALL: "Wall", ROOF: "Roof", GROUND: "Floor", CEILING: "Floor"}
    objects = list(_head(_identifier(name)))
    for title, zone in _zones(poly, surfaces, _identifier(name), shift).items():
        objects.append(("Zone", title, 0, 0, 0, 0, 1, 1, "autocalculate", max(zone.volume, _LEAST)))
        for number, face in enumerate(zone.faces):
            kind = names[face.kind]
            beyond = (
                ("Ground", "", "NoSun", "NoWind")
                if face.kind == GROUND
                else ("Outdoors", "", "SunExposed", "WindExposed")
            )
            head = (
                f"{title}_{kind}_{number}",
                kind,
                _CONSTRUCTION,
                title,
                "",
                *beyond,
                "autocalculate",
                len(face.corners),
            )
            objects.append(("BuildingSurface:Detailed", *head, *face.corners.ravel().tolist()))
    place = ", ".join(repr(x) for x in shift.tolist())
    return "\n".join([f"! Coordinates are less by: {place}", *map(_object, objects), ""])


def _head(name: str) -> Iterator[tuple[Any, ...]]:
    yield "Version", _IDF_VERSION
    yield "Building", name, 0, "Suburbs", 0.04, 0.4, "FullExterior", 25, 6
    yield "GlobalGeometryRules", "UpperLeftCorner", "Counterclockwise", "World"
    yield "Material", "Concrete", "MediumRough", 0.2, 1.4, 2300, 900
    yield "Construction", _CONSTRUCTION, "Concrete"


def _object(fields: tuple[Any, ...]) -> str:
    head, *rest = (repr(each) if isinstance(each, float) else str(each) for each in fields)
    return ",\n  ".join([head, *rest]) + ";"


def hbjson(poly: PolygonMesh, surfaces: Surfaces, name: str) -> str:
    """The text of an HBJSON file: a Room for each component, of Faces with their class and boundary condition.

    Coordinates are in metres. A model far from the origin is written near it; `user_data` has the shift.
    """
    shift = shift_of(poly)
    names = {WALL: "Wall", ROOF: "RoofCeiling", GROUND: "Floor", CEILING: "Floor"}
    rooms = [
        {
            "type": "Room",
            "identifier": title,
            "properties": {"type": "RoomPropertiesAbridged"},
            "faces": [
                {
                    "type": "Face",
                    "identifier": f"{title}_{names[face.kind]}_{number}",
                    "geometry": {"type": "Face3D", "boundary": face.corners.tolist()},
                    "face_type": names[face.kind],
                    "boundary_condition": {"type": "Ground" if face.kind == GROUND else "Outdoors"},
                    "properties": {"type": "FacePropertiesAbridged"},
                }
                for number, face in enumerate(zone.faces)
            ],
        }
        for title, zone in _zones(poly, surfaces, _identifier(name), shift).items()
    ]
    model = {
        "type": "Model",
        "identifier": _identifier(name),
        "display_name": name,
        "units": "Meters",
        "tolerance": _TOLERANCE,
        "angle_tolerance": math.degrees(_TOLERANCE),
        "properties": {"type": "ModelProperties"},
        "user_data": {"shift": shift.tolist()},
        "rooms": rooms,
    }
    return json.dumps(model, allow_nan=False, separators=(",", ":")) + "\n"
