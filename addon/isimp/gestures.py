"""What presses, moves and releases of the mouse mean to the tools. No window needed: places come in, wishes come out.

A tool's operator casts the rays, draws what a gesture shows meanwhile, and makes one recipe step of its wish.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

_DRAG = 8.0  # pixels before a press is a drag


@dataclass(frozen=True)
class Hit:
    """What is under the mouse."""

    face: int  #: the user's face
    region: int  #: -1 for none
    place: tuple = (0.0, 0.0, 0.0)  #: in the scan's space


@dataclass(frozen=True)
class Wish:
    """What a gesture comes to: a verb and the faces it is about."""

    verb: str  #: add, delete, merge, select, paint, new, smooth or cut
    faces: tuple
    into: int | None = None  #: a face of the region that takes part


class Pointing:
    """The Region tool: click adds, ctrl-click deletes, alt-click selects, a drag to another region merges the two."""

    def __init__(self):
        self.begin = self.over = None
        self._verb, self._from, self._dragged = "", (0.0, 0.0), False

    def press(self, hit: Hit | None, at=(0.0, 0.0), ctrl: bool = False, alt: bool = False) -> None:
        self.begin = self.over = hit
        self._verb = "delete" if ctrl else "select" if alt else "add"
        self._from, self._dragged = at, False

    def move(self, hit: Hit | None, at=(0.0, 0.0)) -> None:
        self.over = hit
        far = (at[0] - self._from[0]) ** 2 + (at[1] - self._from[1]) ** 2 > _DRAG**2
        self._dragged = self._dragged or far

    @property
    def merging(self) -> bool:
        """Whether letting go now would merge two regions."""
        return self._verb == "add" and self._dragged and self._parted()

    def _parted(self) -> bool:
        if self.begin is None or self.over is None:
            return False
        begin, over = self.begin.region, self.over.region
        return begin >= 0 and over >= 0 and begin != over

    def release(self) -> Wish | None:
        """What was meant; None if nothing: missed, or dragged back to where it began."""
        begin, over = self.begin, self.over
        merging, verb, dragged = self.merging, self._verb, self._dragged
        self.cancel()
        if begin is None:
            return None
        if merging:
            return Wish("merge", (over.face,), into=begin.face)
        return None if dragged and verb == "add" else Wish(verb, (begin.face,))

    def cancel(self) -> None:
        self.begin = self.over = None
        self._dragged = False


class Stroke:
    """The Paint tool: covers the faces under a brush, mirrored if wished, and says what to make of them."""

    def __init__(self, surface, triangle_face: np.ndarray, radius: float, mirror: int | None = None):
        """surface: pick.Surface; triangle_face: the user's face of each triangle; mirror: 0, 1, 2 for X, Y, Z."""
        self._surface, self._triangle_face, self._mirror = surface, triangle_face, mirror
        self.radius = radius
        self.triangles: set[int] = set()
        self._last = self._first = None
        self._verb = "paint"

    def press(self, hit: Hit | None, facing, new: bool = False, smooth: bool = False) -> None:
        self._verb = "new" if new else "smooth" if smooth else "paint"
        self.move(hit, facing)

    def move(self, hit: Hit | None, facing) -> np.ndarray:
        """Covers what is between the last place and this. Returns the triangles that were not covered before."""
        if hit is None:
            self._last = None
            return np.empty(0, np.int64)
        self._first = self._first or hit
        place = np.asarray(hit.place, float)
        begin = place if self._last is None else self._last
        steps = int(np.ceil(np.linalg.norm(place - begin) / max(0.5 * self.radius, 1e-12)))
        steps = min(max(steps, 1), 200)
        self._last, fresh = place, set()
        for share in np.arange(1, steps + 1) / steps:
            fresh |= self._cover(begin + share * (place - begin), np.asarray(facing, float))
        fresh.add(self._triangle_of(hit))
        fresh -= self.triangles
        self.triangles |= fresh
        return np.array(sorted(fresh), np.int64)

    def _triangle_of(self, hit: Hit) -> int:
        return int(np.searchsorted(self._triangle_face, hit.face))

    def _cover(self, center, facing) -> set:
        covered = set(self._surface.ball(center, self.radius, facing).tolist())
        if self._mirror is not None:
            side = np.ones(3)
            side[self._mirror] = -1
            covered |= set(self._surface.ball(center * side, self.radius, facing * side).tolist())
        return covered

    def release(self) -> Wish | None:
        """What was painted; None if nothing was."""
        if self._first is None:
            return None
        faces = np.unique(self._triangle_face[sorted(self.triangles)])
        begin, verb = self._first, self._verb
        self.cancel()
        return Wish(verb, tuple(faces.tolist()), into=begin.face if verb == "paint" and begin.region >= 0 else None)

    def cancel(self) -> None:
        self.triangles = set()
        self._first = self._last = None


class Cut:
    """The Cut tool: a straight line over a region parts it along the plane through the eye and the line."""

    def __init__(self):
        self.begin = self.end = None
        self._hits = []

    def press(self, ray, hit: Hit | None) -> None:
        """ray: (origin, direction) at the mouse."""
        self.begin = self.end = ray
        self._hits = [hit]

    def move(self, ray, hit: Hit | None) -> None:
        self.end = ray
        self._hits.append(hit)

    @property
    def target(self) -> Hit | None:
        """Where the line meets the region it meets most."""
        hits = [hit for hit in self._hits if hit is not None and hit.region >= 0]
        if not hits:
            return None
        regions = [hit.region for hit in hits]
        most = max(set(regions), key=lambda region: (regions.count(region), -region))
        return next(hit for hit in hits if hit.region == most)

    def plane(self) -> tuple[np.ndarray, float] | None:
        """(normal, offset) of the plane: normal . x = offset; None where the line is but a point."""
        if self.begin is None:
            return None
        (origin, first), (other, last) = ((np.asarray(a, float) for a in ray) for ray in (self.begin, self.end))
        along = (other + last) - (origin + first)
        normal = np.cross(first, along)
        length = np.linalg.norm(normal)
        if length <= 1e-9 * np.linalg.norm(first):
            return None
        normal /= length
        return normal, float(normal @ origin)

    def cancel(self) -> None:
        self.begin = self.end = None
        self._hits = []
