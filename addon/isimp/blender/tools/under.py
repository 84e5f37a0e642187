"""Finds the face and the region under the mouse, and describes the region."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from bpy_extras import view3d_utils

from ... import pick, regularity, view
from ... import recipe as rcp
from ...engine import engine
from ...gestures import Hit
from ...language import own, said
from ...session import joined_faces
from ...task import Status, Task
from .. import reading
from ..scene import mesh_io, runtime, store, targets
from ..texts import text

_MOST_SHOWN = 200_000  # highlighted triangles of a region
_REACH = 8.0  # pixels from a border within which a press drags it
_INNER = 6.0  # widths of that zone that a small region has at least
_CORNER = 1.5  # reach of corners in reaches of borders


@dataclass
class Hover:
    """The highlight drawn for a tool, and its text."""

    scan: str
    region: int
    fills: list = field(default_factory=list)  #: (points of triangles, colour)
    lines: list = field(default_factory=list)  #: (points of lines, colour, width)
    text: str = ""
    key: tuple | None = None  #: state and regions that the highlight was made for
    at: tuple = (0, 0)
    ring: float = 0.0  #: radius of the brush's circle in pixels; 0 for none
    through: bool = False  #: whether lines are drawn through the scan
    stretch: tuple | None = None  #: two points of the viewport with a line between them


class Ground:
    """A scan for mouse tools: its arrays and its visible regions."""

    def __init__(self, context, obj):
        self.name = obj.name
        self.scan = reading.read(context, obj)
        self.place = mesh_io.place_matrix(obj)
        self.to_scan = np.linalg.inv(self.place)
        self.state = mesh_io.state_of(obj)
        self.label = mesh_io.read_regions(obj)
        outcome = self._outcome = _known(context, obj)
        self.is_partial = outcome is None  #: whether the outcome was not cached
        #: numbers of the locked regions; empty if the outcome was not cached
        self.locked = np.empty(0, int) if outcome is None else np.flatnonzero(outcome.partition.region_locked)
        self._between = None if outcome is None else outcome.border
        self._repair = None if outcome is None else outcome.repair
        self._error = store.numbers(obj).get("error", 0.0)  #: sum over all regions
        self._known_borders: dict = {}  # by region; see _around

    @cached_property
    def _triangle_label(self) -> np.ndarray:
        return self.label[self.scan.triangle_face]

    @property
    def surface(self):
        return runtime.get().surface[1]

    def ray(self, region, view, at):
        """Return (origin, direction) of the ray through a point of the viewport, in the scan's space."""
        origin = np.append(view3d_utils.region_2d_to_origin_3d(region, view, at), 1.0)
        direction = np.append(view3d_utils.region_2d_to_vector_3d(region, view, at), 0.0)
        direction = (self.to_scan @ direction)[:3]
        return (self.to_scan @ origin)[:3], direction / np.linalg.norm(direction)

    def hit(self, ray):
        """Return the Hit of the first face that a ray meets, or None."""
        met = self.surface.cast(*ray)
        if met is None:
            return None
        face = int(self.scan.triangle_face[met[0]])
        return Hit(face, int(self.label[face]), tuple(met[1].tolist()))

    def pixel(self, region, view, at, place) -> float:
        """Return the size of a pixel at a point of the scan, in the scan's space."""
        here = self.to_scan @ np.append(view3d_utils.region_2d_to_location_3d(region, view, at, self.world(place)), 1.0)
        beside = (at[0] + 10, at[1])
        there = self.to_scan @ np.append(
            view3d_utils.region_2d_to_location_3d(region, view, beside, self.world(place)), 1.0
        )
        return float(np.linalg.norm((there - here)[:3])) / 10

    def ring(self, region, view, at, hit) -> float:
        """Return the width in pixels of a ring of faces along the border of the region that was hit.

        On a grid of equilateral triangles a ring moves the border by half their height, .66 roots of their area.
        """
        triangles = self.scan.triangles[self.triangles_of(hit.region)]
        wide = 0.66 * (pick.area(self.scan.vertices, triangles) / max(1, len(triangles))) ** 0.5
        return wide / max(self.pixel(region, view, at, hit.place), 1e-12)

    def world(self, place):
        return (self.place @ np.append(place, 1.0))[:3].tolist()

    def triangles_of(self, region: int) -> np.ndarray:
        return np.flatnonzero(self._triangle_label == region)

    def points(self, triangles) -> np.ndarray:
        """Return (3 T, 3) float32 the corners of triangles."""
        return corners(self.scan.vertices, self.scan.triangles, triangles)

    def mesh(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the vertices and triangles that the regions are of: the scan's own if the outcome was not cached."""
        if self._repair is None:
            return self.scan.vertices, self.scan.triangles
        mesh = runtime.get().session.prepare(self.scan, repair=self._repair).mesh
        return np.asarray(mesh.vertices), np.asarray(mesh.triangles)

    def joined(self, faces: list, start: int) -> list:
        """Return the faces that are connected to `start` on the engine's mesh, `start` first."""
        if self._repair is None:  # the engine's mesh is not cached
            return faces
        repaired = runtime.get().session.prepare(self.scan, repair=self._repair)
        found = joined_faces(repaired, np.unique(faces), start)
        return [start, *found[found != start].tolist()]

    def between(self) -> tuple[np.ndarray, np.ndarray]:
        """Return ((K, 2) faces, (K, 2) vertices) of the edges between regions."""
        pairs, edges = self.scan.face_edges
        if self._between is None:
            self._between = view.border_pairs(self.label, pairs)
        return pairs[self._between], edges[self._between]

    def border(self, region: int) -> np.ndarray:
        """Return (2 B, 3) float32 the border edges of a region."""
        pairs, edges = self.between()
        return self.scan.vertices[edges[(self.label[pairs] == region).any(axis=1)].ravel()].astype(np.float32)

    def reach(self, region, view, at, hit) -> float:
        """Return the length, in the scan's space, within which a press drags a border; smaller in small regions."""
        pixel = self.pixel(region, view, at, hit.place)
        return min(_REACH * pixel, self._around(hit.region)[3] / _INNER)

    def held(self, reach: float, hit):
        """Return (key, (2 L, 3) float32 lines) of the corner or the border that a drag from a hit moves, or None."""
        if hit.region < 0:
            return None
        edges, ends, other, _ = self._around(hit.region)
        if not len(edges):
            return None
        place = np.array(hit.place)
        along = ends[:, 1] - ends[:, 0]
        share = np.einsum("ij,ij->i", place - ends[:, 0], along) / np.maximum((along**2).sum(axis=1), 1e-300)
        away = np.linalg.norm(ends[:, 0] + share.clip(0, 1)[:, None] * along - place, axis=1)
        corner = self.corner(reach, hit)
        if corner is not None:
            near = np.linalg.norm(ends.mean(axis=1) - self.scan.vertices[corner], axis=1) <= 3 * reach
            return ("corner", corner), ends[near].reshape(-1, 3).astype(np.float32)
        if away.min() > reach:
            return None
        beside = int(other[np.argmin(away)])
        return ("border", beside), ends[other == beside].reshape(-1, 3).astype(np.float32)

    def corner(self, reach: float, hit):
        """Return the vertex of the corner of a region that a drag from a hit moves, or None."""
        edges, _, other, _ = self._around(hit.region) if hit.region >= 0 else (np.empty((0, 2), int), 0, 0, 0)
        if not len(edges):
            return None
        met = np.unique(np.stack([edges.ravel(), np.repeat(other, 2)], axis=1), axis=0)
        vertices, count = np.unique(met[:, 0], return_counts=True)
        corners = vertices[count > 1]
        away = np.linalg.norm(self.scan.vertices[corners] - np.array(hit.place), axis=1)
        return int(corners[np.argmin(away)]) if len(away) and away.min() <= _CORNER * reach else None

    def _around(self, region: int):
        """Return (edges, their ends, the regions beyond, the width of the region), of borders to other regions."""
        if region not in self._known_borders:
            faces, edges = self.between()
            beside = self.label[faces]
            mine = (beside == region).any(axis=1) & (beside >= 0).all(axis=1)
            edges, beside = edges[mine], beside[mine]
            triangles = self.scan.triangles[self.triangles_of(region)]
            width = pick.area(self.scan.vertices, triangles) ** 0.5
            ends = self.scan.vertices[edges].astype(np.float64)
            self._known_borders[region] = edges, ends, beside.sum(axis=1) - region, width
        return self._known_borders[region]

    def told(self, unit, region: int) -> str:
        """Return the description of a region in one line. unit: the scene's unit settings."""
        if region < 0:
            return said("Left out: click to make this part a region")
        triangles = self.triangles_of(region)
        share, error, away = pick.flatness(self.scan.vertices, self.scan.triangles, triangles)
        away = text.length(away, unit.system, unit.scale_length)
        whole = self.surface.area
        part = min(1.0, error / self._error) if self._error > 1e-9 * whole else 0.0
        told = said(
            "Region {number} · {area} of the area · {error} of the error · planar within {away}",
            number=region,
            area=f"{share / whole:.1%}",
            error=f"{part:.1%}",
            away=away,
        )
        lean = self._leaning(unit, region)
        return f"{told} · {lean}" if lean else told

    def _leaning(self, unit, region: int) -> str:
        """Return the angle of a region's plane from level or upright; empty if it is large, or not cached."""
        if self._outcome is None or region >= self._outcome.partition.region_count:
            return ""
        held = self._outcome.partition.region_held
        if len(held) and engine.planes.is_fixed(held[region]):
            return said("plane fixed")
        session = runtime.get().session
        if not session.is_prepared(self.scan, self._repair):  # a thread may be at it, and a hover must not wait
            return ""
        normal, _, spread, area = session.region_fits(self.scan, self._outcome)
        if area[region] <= 0:
            return ""
        found = regularity.leaning(normal[region], spread[region], self.place[2, :3])
        if found is None:
            return ""
        off = own("{angle}° off level; snapping moves {length}")
        if not found.is_level:
            off = own("{angle}° off upright; snapping moves {length}")
        return said(off, angle=f"{found.degrees:.1f}", length=text.length(found.adds, unit.system, unit.scale_length))


def corners(vertices: np.ndarray, triangles: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Return (3 T, 3) float32 the corners of chosen triangles to draw."""
    return vertices[triangles[chosen[:_MOST_SHOWN]].ravel()].astype(np.float32)


def _known(context, obj):
    """Return the outcome with the visible regions if it is cached; else None."""
    recipe = (store.load(obj) or rcp.Recipe()).without_mesh()
    return runtime.get().session.known(reading.read(context, obj, recipe.layers(), again=True), recipe)


def ground(context):
    """Return the Ground of the active scan; None while it is not ready."""
    scan, problem = targets.find(context)
    seen = not problem and context.view_layer.objects.active == scan
    return ground_of(context, scan) if seen else None


def ground_of(context, scan, wait: bool = False):
    """Return the Ground of a scan; None while it is not ready. wait: waits for the preparation."""
    if not mesh_io.state_of(scan):
        return None
    current = runtime.get()
    known = current.ground
    try:
        if known is None or not _fits(known, scan) or (known.is_partial and _known(context, scan) is not None):
            known = current.ground = Ground(context, scan)
    except mesh_io.Unusable:
        return None
    return known if _prepare(known, wait) and current.surface[1] is not None else None


def _fits(known, scan) -> bool:
    return (
        known.name == scan.name
        and known.state == mesh_io.state_of(scan)
        and scan.name in runtime.get().scans
        and runtime.get().scans[scan.name].scan is known.scan
        and np.array_equal(known.place, mesh_io.place_matrix(scan))
    )


def _prepare(known, wait: bool) -> bool:
    """Return whether the search structure is ready; starts a thread that makes it."""
    current, scan = runtime.get(), known.scan
    if current.surface is not None and current.surface[0] is scan:
        return True
    if current.digging is None or current.digging[0] is not scan:

        def dig(watch):
            scan.face_edges  # noqa: B018  (computed on this thread and cached, so that tools need not wait for it)
            return pick.Surface(scan.vertices, scan.triangles)

        current.digging = (scan, Task(dig))
    task = current.digging[1]
    if task.wait(None if wait else 0) is Status.RUNNING:
        return False
    current.surface, current.digging = (scan, task.result), None
    return task.result is not None
