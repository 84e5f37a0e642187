"""The classes of polygons on a building, and the validity of a model."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import PolygonMesh
from ..lengths import UNITS
from ..surfaces import pieces

WALL, ROOF, GROUND, CEILING = "WallSurface", "RoofSurface", "GroundSurface", "OuterCeilingSurface"
CLASSES = (WALL, ROOF, GROUND, CEILING)
PLANAR = 0.01  # metres: the default of validators of city models

_UPRIGHT = 0.25  # largest component along up of a wall's normal: it leans by less than 14.5 degrees
LEVEL = 0.94  # least component along up of the ground's normal: it rises by less than 20 degrees
_FAR = 1e4  # coordinates beyond this are far from zero, where programs do not keep centimetres
_LOW = 0.1  # share of the model's height: ground lies below this


@dataclass(frozen=True)
class Surfaces:
    """The class of each polygon by its plane's direction and place, and the properties of all together."""

    kind: list[str]  # one of CLASSES for each polygon
    normal: NDArray[np.float64]  # (Q, 3), unit; zero without area
    components: int
    volume: float  # volume inside closed polygons; negative where they face inwards
    solid: bool  # whether they are one closed, manifold component that faces outwards

    def of(self, kind: str) -> list[int]:
        """The polygons of a class."""
        return [q for q, own in enumerate(self.kind) if own == kind]


def vector_area(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """The vector area of a polygon with these corners (C, 3): as long as its area, square to it."""
    area: NDArray[np.float64] = np.cross(points - points[0], np.roll(points, -1, axis=0) - points[0]).sum(0) / 2
    return area


def shift_of(poly: PolygonMesh) -> NDArray[np.float64]:
    """The place near a model that its coordinates are written relative to; zero for a model that is near zero."""
    at = np.asarray(poly.vertices, dtype=np.float64).reshape(-1, 3)
    return np.floor(at.min(0)) if np.abs(at).max(initial=0.0) > _FAR else np.zeros(3)


def rings(poly: PolygonMesh) -> list[NDArray[np.int32]]:
    """The corners of each polygon."""
    return np.split(np.asarray(poly.loops), np.asarray(poly.loop_start)[1:]) if len(poly.loop_start) else []


def surfaces_of(poly: PolygonMesh, up: tuple[float, float, float] = (0.0, 0.0, 1.0)) -> Surfaces:
    """Classify polygons as walls, roofs, ground and ceilings.

    Walls are upright within 14.5 degrees. Among the others, ground is level within 20 degrees and in the lowest tenth
    of the model's height. It may face up or down: the underside of a closed building, or the terrain of an open scan.
    Roofs face up and ceilings (of bays and passages) face down.
    """
    at = np.asarray(poly.vertices, dtype=np.float64)
    at = at - at.mean(0) if len(at) else at  # products of large coordinates would lose digits
    axis = np.asarray(up, dtype=np.float64) / np.linalg.norm(up)
    loops = rings(poly)
    areas, heights, volume = np.zeros((len(loops), 3)), np.zeros(len(loops)), 0.0
    for q, loop in enumerate(loops):
        p = at[loop]
        areas[q] = vector_area(p)
        heights[q] = (p @ axis).mean()
        volume += float(p[0] @ areas[q]) / 3
    size = np.linalg.norm(areas, axis=1, keepdims=True)
    normal = np.divide(areas, size, out=np.zeros_like(areas), where=size > 0)
    along = normal @ axis
    heights_all = at @ axis if len(at) else np.zeros(1)
    low = heights_all.min() + _LOW * float(np.ptp(heights_all))
    kind = np.where(np.abs(along) <= _UPRIGHT, WALL, np.where(along > 0, ROOF, CEILING)).astype(object)
    kind[(np.abs(along) >= LEVEL) & (heights <= low)] = GROUND
    parts = len(set(component_of(loops, len(at)).tolist()))
    closed = bool(poly.report["closed"]) and bool(poly.report["manifold"])
    return Surfaces([str(k) for k in kind], normal, parts, volume, closed and parts == 1 and volume > 0)


def part_of(
    poly: PolygonMesh, loops: list[NDArray[np.int32]], some: list[int]
) -> tuple[NDArray[np.float64], list[NDArray[np.int64]]]:
    """Return chosen polygons as a separate mesh: their vertices (V, 3), and the corners of each polygon."""
    used, local = np.unique(np.concatenate([loops[q] for q in some]), return_inverse=True)
    ends = np.cumsum([len(loops[q]) for q in some])[:-1]
    return np.asarray(poly.vertices, dtype=np.float64)[used], np.split(local.ravel(), ends)


def validity(poly: PolygonMesh, surfaces: Surfaces | None = None, unit: str = "m") -> dict[str, Any]:
    """The first checks of validators of city models: polygons planar within PLANAR, a closed shell.

    surfaces: the result of `surfaces_of` for these polygons, if it is known already. unit: the scene unit.
    """
    found, limit = surfaces or surfaces_of(poly), PLANAR / UNITS[unit]
    bent = np.asarray(poly.planarity) > limit
    return {
        "planarity_limit": limit,
        "planarity_max": float(np.max(poly.planarity, initial=0.0)),
        "non_planar": int(bent.sum()),
        "closed": bool(poly.report["closed"]),
        "manifold": bool(poly.report["manifold"]),
        "components": found.components,
        "solid": found.solid,
        "self_intersections": int(poly.report["crossing"] + poly.report["intersecting"] + poly.report["excused"]),
        "surfaces": {kind: len(found.of(kind)) for kind in CLASSES},
    }


def component_of(loops: list[NDArray[np.int32]], vertices: int) -> NDArray[np.int64]:
    """The component of each polygon, from 0 in the order of their first polygons. Polygons share corners in one."""
    first = np.array([loop[0] for loop in loops], dtype=np.int64)
    pairs = np.stack([np.repeat(first, [len(loop) for loop in loops]), np.concatenate([*loops, first[:0]])], axis=1)
    _, at, number = np.unique(pieces(vertices, pairs)[first], return_index=True, return_inverse=True)
    return np.argsort(np.argsort(at))[number.ravel()]
