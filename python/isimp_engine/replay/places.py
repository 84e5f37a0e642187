"""The faces that a recipe names, at the same places of another version of its scan."""

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import recipe as rcp
from .._core import _distances_to_triangles

SAME = 1e-5  #: share of the scan's size: faces of equal numbers that are nearer are the same
FAR = 0.01  #: share of the scan's size: a place that is further from all faces has none
AGREE = 0.5  #: cosine of the largest angle between normals that agree
_NEAR = 64  # triangles by the distance of their middles, of which the nearest is chosen
_COVERED = 0.6  # a stroke covers faces whose middle is within this many widths of one of its faces

Numbers = NDArray[np.float64]
Faces = NDArray[np.integer[Any]]


@dataclass(frozen=True, eq=False)
class Surface:
    """The triangles of a scan, and the face of each. A face below 0 is none."""

    vertices: NDArray[Any]
    triangles: Faces
    face: Faces
    count: int

    @property
    def size(self) -> float:
        used = self.vertices[np.unique(self.triangles)] if len(self.triangles) else np.zeros((1, 3))
        used = used[np.isfinite(used).all(axis=1)].astype(np.float64)
        return float(np.linalg.norm(np.ptp(used, axis=0))) if len(used) else 0.0

    def middles(self, chosen: Faces) -> tuple[Numbers, Numbers, Numbers]:
        """The middle of some triangles, and their normals: unit, and twice their area."""
        corners = self.vertices[self.triangles[chosen]].astype(np.float64)
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        length = np.linalg.norm(normal, axis=1)
        return corners.mean(axis=1), normal / np.maximum(length, 1e-300)[:, None], length


def places_of(recipe: Any, surface: Surface) -> tuple[Any, ...] | None:
    """The values for `Places` of the faces that a recipe's steps name; None if they name none.

    recipe: of any copy of `isimp_engine.recipe`, as the add-on has its own.
    """
    faces = [face for face in recipe.faces() if face < surface.count]
    if not faces:
        return None
    points, normals, widths = _places(surface, np.array(faces))
    rows = np.round(points, _digits(surface.size)), np.round(normals, 4)
    at, along = (tuple(map(tuple, values.tolist())) for values in rows)
    return surface.size, surface.count, tuple(faces), at, along, tuple(widths.tolist())


def _digits(size: float) -> int:
    """Digits after the point that keep a millionth of the size."""
    return int(np.clip(7 - np.floor(np.log10(max(size, 1e-30))), 0, 30))


def _places(surface: Surface, faces: Faces) -> tuple[Numbers, Numbers, Numbers]:
    """By face: its middle, its normal, and the root of its area."""
    number = np.full(surface.count + 1, -1, np.int64)
    number[faces] = np.arange(len(faces))
    chosen = np.flatnonzero(number[surface.face] >= 0)
    middle, normal, double = surface.middles(chosen)
    of, weight = number[surface.face[chosen]], np.maximum(double, 1e-300)

    def summed(values: Numbers) -> Numbers:
        return np.stack([np.bincount(of, weight * values[:, k], len(faces)) for k in range(3)], axis=1)

    total = np.bincount(of, weight, len(faces))
    along = summed(normal)
    length = np.linalg.norm(along, axis=1)
    unit = np.where(length[:, None] > 1e-200, along / np.maximum(length, 1e-300)[:, None], 0.0)
    return summed(middle) / np.maximum(total, 1e-300)[:, None], unit, np.sqrt(total / 2)


def placed(recipe: Any, surface: Surface) -> tuple[Any, list[int]]:
    """The recipe with the faces of a scan at its places, and the indices of the steps that have no face there.

    These are switched off. Numbers of faces stay without places, and where no place is near the scan, but the faces of
    these numbers are as large: it is the same scan in other coordinates. recipe: see `places_of`.
    """
    if recipe.places is None:
        return recipe, []
    to = _Mapping(recipe.places, surface)
    steps, lost = list(recipe.steps), []
    for index, step in enumerate(recipe.steps):
        found = rcp.moved(step, to.covered if step.is_stroke else to.nearest)
        if found is None and step.enabled:
            lost.append(index)
        steps[index] = found or dataclasses.replace(step, enabled=False)
    if not to.finds_any() and _is_same_scan(recipe.places, surface):
        return dataclasses.replace(recipe, places=None), []
    return dataclasses.replace(recipe, steps=tuple(steps), places=None), lost


def _is_same_scan(places: Any, surface: Surface) -> bool:
    """Whether a scan has as many faces, and the ones of these numbers are as large in proportion."""
    faces = np.array(places.faces, np.int64)
    if places.count != surface.count or not len(faces) or faces.max() >= surface.count:
        return False
    _, _, widths = _places(surface, faces)
    known = np.array(places.widths) * (surface.size / max(places.size, 1e-300))
    return bool((np.abs(widths - known) <= 1e-3 * known.max() + 1e-6 * surface.size).all())


class _Mapping:
    """The faces of a scan at places."""

    def __init__(self, places: Any, surface: Surface) -> None:
        self._surface, self._far = surface, FAR * places.size
        self._place = {face: number for number, face in enumerate(places.faces)}
        self._points = np.array(places.points, np.float64).reshape(-1, 3)
        self._normals = np.array(places.normals, np.float64).reshape(-1, 3)
        self._widths = np.array(places.widths, np.float64)
        self._same = self._equal(np.array(places.faces, np.int64), places.size)
        self._known: dict[int, tuple[int, ...]] = {}
        if not self._same.all():
            usable = np.flatnonzero((surface.face >= 0) & np.isfinite(surface.vertices[surface.triangles]).all((1, 2)))
            self._usable = usable
            self._middle, self._normal, _ = surface.middles(usable)

    def _equal(self, faces: Faces, size: float) -> NDArray[np.bool_]:
        """Whether the faces of these numbers are at their places in this scan."""
        same = (faces >= 0) & (faces < self._surface.count)
        if same.any():
            points, normals, _ = _places(self._surface, faces[same])
            near = np.linalg.norm(points - self._points[same], axis=1) <= SAME * size
            turned = np.einsum("ij,ij->i", normals, self._normals[same]) < AGREE
            flat = (self._normals[same] == 0).all(axis=1)
            same[same] = near & (flat | ~turned)
        return same

    def nearest(self, face: int) -> tuple[int, ...]:
        """The face nearest to the place of a face; none if there is none near or it has no place."""
        number = self._place.get(face)
        if number is None:
            return ()
        if self._same[number]:
            return (face,)
        if number not in self._known:
            self._known[number] = self._found(number)
        return self._known[number]

    def finds_any(self) -> bool:
        """Whether any place has a face."""
        return bool(self._same.any()) or any(self._known.values())

    def _found(self, number: int) -> tuple[int, ...]:
        agree = self._agreeing(number)
        if not len(agree):
            return ()
        point = self._points[number]
        far = ((self._middle[agree] - point) ** 2).sum(axis=1)
        if len(agree) > _NEAR:
            chosen = np.argpartition(far, _NEAR)[:_NEAR]
            agree = np.sort(agree[chosen])
        triangles = self._usable[agree]
        corners = self._surface.vertices[self._surface.triangles[triangles]].astype(np.float64).reshape(-1, 3)
        away = _distances_to_triangles(np.tile(point, (len(agree), 1)), corners)
        best = int(np.argmin(away))
        return (int(self._surface.face[triangles[best]]),) if away[best] <= self._far else ()

    def _agreeing(self, number: int) -> Faces:
        along = self._normal @ self._normals[number]
        return np.flatnonzero(along >= AGREE) if self._normals[number].any() else np.arange(len(along))

    def covered(self, face: int) -> tuple[int, ...]:
        """As `nearest`, with the smaller faces around it that the face covered."""
        number, first = self._place.get(face), self.nearest(face)
        if number is None or not first or self._same[number]:
            return first
        agree = self._agreeing(number)
        away = ((self._middle[agree] - self._points[number]) ** 2).sum(axis=1)
        inside = agree[away <= (_COVERED * self._widths[number]) ** 2]
        return (*first, *dict.fromkeys(self._surface.face[self._usable[inside]].tolist()))
