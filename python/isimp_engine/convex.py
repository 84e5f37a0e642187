"""Convex parts of a solid, for collisions."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._core import InvalidInput, Job, PolygonMesh, _convex_parts
from .result import Result
from .settings import OptionError
from .source import Source, source_of

_Arrays = tuple[NDArray[Any], NDArray[Any], NDArray[Any], NDArray[Any]]
#: the name of part `number` of `name`, by program
NAMES: Mapping[str, Callable[[str, int], str]] = {
    "unreal": lambda name, number: f"UCX_{name}_{number:02}",
    "unity": lambda name, number: f"{name}_collider_{number:02}",
    "godot": lambda name, number: f"{name}_{number:02}-convcol",
    "plain": lambda name, number: f"{name}_{number:02}",
}
_FEWEST_VERTICES = 8  # of a box
_FARTHEST = 1e30  # as in meshes
MOST_VERTICES = 64  #: the default; engines of games allow at most 64 to 255
THICKNESS = 0.02  #: of walls, share of the diagonal


@dataclass(frozen=True, eq=False)
class Convex:
    """A convex polyhedron: no vertex is outside the plane of a triangle, by exact arithmetic."""

    vertices: NDArray[np.float64]  #: (N, 3)
    triangles: NDArray[np.int32]  #: (T, 3), counter-clockwise seen from outside
    volume: float

    def __repr__(self) -> str:
        return f"<Convex: {len(self.vertices)} vertices, volume {self.volume:.6g}>"


def convex_parts(
    polygons: Any,
    *,
    enclose: bool | ArrayLike = False,
    tolerance: float | None = None,
    parts: int | None = None,
    most_vertices: int = MOST_VERTICES,
    thickness: bool | float = False,
    job: Job | None = None,
) -> list[Convex]:
    """Cut a solid into convex parts along the planes of its polygons, for collisions in games and simulations.

    polygons: a PolygonMesh, a Result, `(vertices, faces)`, or an object with `vertices` and `faces`; closed, facing
    outwards, or with `thickness` open.
    enclose: False: parts of the solid's true size. True: every vertex is in a part, for a Result every vertex of its
    scan; planes are pushed outwards for this, the least possible. (N, 3): these points are.
    tolerance: free space may be filled this deep, in scene units: no point of a part is farther from the solid. It
    is also the least thickness that matters. None: half a per cent of the diagonal.
    parts: the most parts; they may fill free space then. None: as many as the tolerance needs.
    most_vertices: of each part, at least 8.
    thickness: of the walls of an open surface that faces free space, such as a scanned room. Each polygon becomes a
    slab behind it, or a few if it is concave. They meet at the edges without a gap. Walls with two sides get no thicker
    than they are, and openings stay free. True: two per cent of the diagonal. False: the polygons bound a solid.

    Each part has `vertices` (N, 3), `triangles` (T, 3) and `volume`; the largest is first. It is convex by exact
    arithmetic: no vertex is outside the plane of a triangle. Solids that overlap count once.
    Raises InvalidInput (the surface is open, faces inwards or encloses no volume: the message names the place) or
    Cancelled.
    """
    if tolerance is not None and not tolerance > 0:
        raise OptionError(f"{{}} must be a length above 0, got {tolerance}", "tolerance")
    if thickness is not False and not thickness > 0:
        raise OptionError(f"{{}} must be a length above 0, got {thickness}", "thickness")
    if parts is not None and parts < 1:
        raise OptionError(f"{{}} must be at least 1, got {parts}", "parts")
    if most_vertices < _FEWEST_VERTICES:
        raise OptionError(f"{{}} must be at least {_FEWEST_VERTICES}, got {most_vertices}", "most_vertices")
    arrays, points = _content(polygons, job)
    if enclose is False:
        points = np.zeros((0, 3))
    elif enclose is not True:
        points = np.asarray(enclose)
    for of, some in (("vertex", arrays[0]), ("point to enclose", points)):
        far = np.abs(some) if np.asarray(some).dtype.kind in "fiu" else np.zeros(0)
        if ((far > _FARTHEST) & np.isfinite(far)).any():
            raise InvalidInput(f"a {of} has a coordinate that is larger than {_FARTHEST:g}, the largest supported")
    vertices, loops, loop_start, region = arrays
    if thickness is True:
        thickness = THICKNESS * float(np.linalg.norm(np.ptp(vertices, axis=0))) if len(vertices) else 0.0
    found = _convex_parts(
        vertices, loops, loop_start, region, points, tolerance or 0.0, parts or 0, most_vertices, thickness, job
    )
    return [Convex(*part) for part in found]


def _content(polygons: Any, job: Job | None) -> tuple[_Arrays, NDArray[Any]]:
    """Vertices, loops, loop_start and region of the polygons, and the vertices that they stand for."""
    if isinstance(polygons, Result):
        return _content(polygons.polygons, job)[0], used_vertices(polygons._model.source)
    if isinstance(polygons, PolygonMesh):
        vertices = polygons.vertices
        return (vertices, polygons.loops, polygons.loop_start, polygons.polygon_region), vertices
    source = polygons if isinstance(polygons, Source) else source_of(polygons, job)
    start = np.arange(0, source.triangles.size, 3, dtype=np.int32)
    face = source.surface.face
    region = np.where(face >= 0, face, source.faces + np.arange(len(face), dtype=np.int32))  # patches
    return (source.vertices, source.triangles.ravel(), start, region), used_vertices(source)


def used_vertices(source: Source) -> NDArray[Any]:
    """The vertices of a scan that some face has."""
    return source.vertices[np.unique(source.triangles)]
