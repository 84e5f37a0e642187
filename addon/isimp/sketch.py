"""Computes the overlay of a scan, region borders and polygons, as plain arrays without a window."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from . import recipe as rcp
from . import regularity, view
from .engine import engine
from .session import Scan, Session, StepFailed
from .task import Watch


def _points() -> np.ndarray:
    return np.empty((0, 3), np.float32)


@dataclass(frozen=True, eq=False)
class Sketch:
    """Points relative to `origin`, float32. Lines are pairs of points, triangles are triples."""

    #: (2 B, 3) the border edges of regions
    borders: np.ndarray = field(default_factory=_points)
    #: (2 E, 3) the edges of the polygons, the longest first
    outline: np.ndarray = field(default_factory=_points)
    #: (C, 3) their corners, the ones with the longest edges first
    corners: np.ndarray = field(default_factory=_points)
    #: (C,) the mean length of the edges at each corner
    reach: np.ndarray = field(default_factory=lambda: np.empty(0, np.float32))
    #: (3 T, 3) their triangles
    surface: np.ndarray = field(default_factory=_points)
    #: (3 T, 4) RGBA of the corners of the triangles, by the planarity of their polygon
    heat: np.ndarray = field(default_factory=lambda: np.empty((0, 4), np.float32))
    #: (3 T, 4) RGBA by the distance of the scan from their polygon
    away: np.ndarray = field(default_factory=lambda: np.empty((0, 4), np.float32))
    #: (3 T, 4) RGBA by the direction of their region's plane
    directions: np.ndarray = field(default_factory=lambda: np.empty((0, 4), np.float32))
    #: the numbers of the polygons, as Mesh reports them
    numbers: dict = field(default_factory=dict)
    #: (2 E, 3) the edges of defective polygons
    problems: np.ndarray = field(default_factory=_points)
    #: a face of each region with a defective polygon
    problem_faces: tuple = ()
    #: (3 L, 3) the triangles of locked regions
    locked: np.ndarray = field(default_factory=_points)
    #: why there are no polygons; empty if there are
    reason: str = ""
    #: origin of the points in the scan's space, since float32 is too coarse for map coordinates
    origin: tuple = (0.0, 0.0, 0.0)


def borders(scan, border: np.ndarray, origin=(0.0, 0.0, 0.0)) -> np.ndarray:
    """Return (2 B, 3) float32 the chosen edges between faces, relative to `origin`. scan: or its source."""
    return _relative(scan.vertices[scan.face_edges[1][border].ravel()], origin)


def _relative(points: np.ndarray, origin) -> np.ndarray:
    """Return (N, 3) float32 points relative to `origin`."""
    return (points - np.asarray(origin, np.float64)).astype(np.float32)


def outline(vertices: np.ndarray, loops: np.ndarray, loop_start: np.ndarray) -> np.ndarray:
    """Return (2 E, 3) float32 the edges of polygons, each once, the longest first."""
    ends = np.unique(np.sort(polygon_edges(loops, loop_start), axis=1), axis=0)
    order = np.argsort(-_lengths(vertices, ends), kind="stable")
    return vertices[ends[order].ravel()].astype(np.float32)


def corners(vertices: np.ndarray, loops: np.ndarray, loop_start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (C, 3) float32 the corners of polygons, and (C,) the mean length of their edges, the longest first."""
    ends = polygon_edges(loops, loop_start)
    length, count = np.repeat(_lengths(vertices, ends), 2), len(vertices)
    times = np.bincount(ends.ravel(), minlength=count)
    mean = np.bincount(ends.ravel(), length, count) / np.maximum(times, 1)
    order = np.argsort(-mean, kind="stable")
    return vertices[order].astype(np.float32), mean[order].astype(np.float32)


def _lengths(vertices: np.ndarray, ends: np.ndarray) -> np.ndarray:
    return np.linalg.norm(vertices[ends[:, 0]] - vertices[ends[:, 1]], axis=1)


def strength(pixels: float) -> float:
    """Return the opacity of a line by its length on the screen, in [0.15, 1]. Many short lines would hide the scan."""
    return min(1.0, max(0.15, (pixels - 4.0) / 50.0))


def polygon_edges(loops: np.ndarray, loop_start: np.ndarray) -> np.ndarray:
    """Return (L, 2) the two vertices of each edge of each polygon, in order."""
    after = np.roll(loops, -1)
    last = np.append(loop_start[1:], len(loops)) - 1
    after[last] = loops[loop_start]
    return np.stack([loops, after], axis=1)


def heat(planarity: np.ndarray, diagonal: float, bound: float = 0.005) -> np.ndarray:
    """Return (Q,) non-planarity of polygons in [0, 1]. bound: the distance for 1, as a share of the diagonal."""
    if diagonal <= 0:
        return np.zeros(len(planarity))
    return np.clip(planarity / (bound * diagonal), 0.0, 1.0)


def heat_colors(share: np.ndarray) -> np.ndarray:
    """Return (N, 4) float32 RGBA, translucent: green for 0, yellow between, red for 1."""
    red = np.clip(2 * share, 0, 1)
    green = np.clip(2 - 2 * share, 0, 1)
    return np.stack([red, 0.8 * green, 0.1 + 0 * share, 0.6 + 0 * share], axis=1).astype(np.float32)


def at_once(session: Session, scan: Scan, recipe: rcp.Recipe) -> Sketch | None:
    """Return the sketch of a cached partition, without polygons; None if the partition is not cached."""
    outcome = session.known(scan, recipe.without_mesh())
    if outcome is None or not session.is_prepared(scan, outcome.repair):
        return None
    prepared = session.prepare(scan, repair=outcome.repair)
    origin, locked = prepared.mesh.origin, np.flatnonzero(outcome.partition.region_locked)
    lines = borders(prepared.source, outcome.border, origin)
    return Sketch(lines, locked=triangles_of(scan, outcome.face_region, locked, origin), origin=origin)


def borders_of(scan, border: np.ndarray, face_region: np.ndarray, regions: np.ndarray) -> np.ndarray:
    """Return (2 B, 3) float32 the end points of the border edges of chosen regions."""
    ends = border[np.isin(face_region[scan.face_edges[0][border]], regions).any(axis=1)]
    return borders(scan, ends)


def draw(
    session: Session,
    scan: Scan,
    face_region: np.ndarray,
    recipe: rcp.Recipe,
    meshing: rcp.Mesh | None,
    watch: Watch,
    regularise: rcp.Regularise | None = None,
) -> Sketch:
    """Return the sketch of regions, and of the polygons that the recipe would make. Raises Stopped.

    meshing: the Mesh step; None: without polygons. regularise: the step that snaps planes before Mesh.
    """
    prepared = session.prepare(scan, watch, 0.0, 0.1, session.repair_of(scan, recipe))  # with the edges of its faces
    origin = prepared.mesh.origin
    lines = borders(prepared.source, view.border_pairs(face_region, prepared.faces.pairs), origin)
    locked = triangles_of(scan, face_region, session.locked_regions(scan, recipe, watch), origin)
    if meshing is None:
        return Sketch(lines, locked=locked, origin=origin)
    try:
        before = recipe if regularise is None else recipe.regularised(regularise)
        made = session.replay(scan, before.then(meshing), watch)
    except StepFailed as error:
        return Sketch(lines, locked=locked, reason=error.reason, origin=origin)
    polygons = made.polygons
    vertices = _relative(np.asarray(polygons.vertices), origin)
    loops, start = np.asarray(polygons.loops), np.asarray(polygons.loop_start)
    triangles, of = session.triangulate(polygons)
    share = heat(np.asarray(polygons.planarity), made.numbers["diagonal"])
    far = heat(made.region_distance[np.asarray(polygons.polygon_region)], made.numbers["diagonal"], 0.02)
    defective = sorted({polygon for found in made.numbers["flaws"].values() for polygon in found})
    return Sketch(
        lines,
        outline(vertices, loops, start),
        *corners(vertices, loops, start),
        vertices[triangles.ravel()],
        heat_colors(np.repeat(share[of], 3)),
        heat_colors(np.repeat(far[of], 3)),
        np.repeat(_direction_colors(session, scan, made)[np.asarray(polygons.polygon_region)[of]], 3, axis=0),
        made.numbers,
        vertices[edges_of(defective, loops, start).ravel()],
        faces_of(made.face_region, np.asarray(polygons.polygon_region)[defective]),
        locked,
        origin=origin,
    )


def _direction_colors(session: Session, scan: Scan, made) -> np.ndarray:
    """Return (R, 4) the colours by direction of an outcome's regions. A plane that Mesh released counts as free."""
    partition, held = made.partition, made.partition.region_held
    count = partition.region_count
    is_held = engine.planes.is_fixed(held) if len(held) else np.zeros(count, bool)
    is_held[np.asarray(made.polygons.planes_let_go)] = False
    offset = partition.region_offset if len(partition.region_offset) else np.zeros(count)
    area = session.region_fits(scan, made)[3]
    return regularity.direction_colors(np.asarray(partition.region_normal), np.asarray(offset), is_held, area)


def triangles_of(scan: Scan, face_region: np.ndarray, regions: np.ndarray, origin) -> np.ndarray:
    """Return (3 T, 3) float32 the triangles of chosen regions, relative to `origin`."""
    if not len(regions):
        return _points()
    chosen = np.isin(face_region[scan.triangle_face], regions)
    return _relative(scan.vertices[scan.triangles[chosen].ravel()], origin)


def faces_of(face_region: np.ndarray, regions: np.ndarray) -> tuple:
    """Return the first face of each of some regions."""
    found, first = np.unique(face_region, return_index=True)
    return tuple(first[np.isin(found, regions)].tolist())


def edges_of(chosen: list, loops: np.ndarray, loop_start: np.ndarray) -> np.ndarray:
    """Return (K, 2) the edges of chosen polygons."""
    totals = np.diff(loop_start, append=len(loops))
    return polygon_edges(loops, loop_start)[np.repeat(np.isin(np.arange(len(totals)), chosen), totals)]
