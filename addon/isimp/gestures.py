"""State machines of the tools: they turn mouse presses, moves and releases into wishes, without a window.

A tool's operator casts the rays, draws the highlight of a gesture, and makes one recipe step of its wish.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import view

_DRAG = 8.0  # pixels of movement from which a press is a drag
_MIN_RING, _MOST_RINGS = 0.05, 1000  # smallest width of a ring in pixels; most rings of a wish
_MOST_OF = 0.1  # least share of a region, or of a stroke, that counts as painted over


def is_far(begin, at) -> bool:
    """Return whether two points of the mouse are far enough apart for a drag."""
    return (at[0] - begin[0]) ** 2 + (at[1] - begin[1]) ** 2 > _DRAG**2


@dataclass(frozen=True)
class Hit:
    """The face and region under the mouse."""

    face: int  #: the user's face
    region: int  #: -1 for none
    place: tuple = (0.0, 0.0, 0.0)  #: in the scan's space


@dataclass(frozen=True)
class Wish:
    """The result of a gesture: a verb and faces."""

    verb: str  #: add, delete, merge, choose, paint, new, erase, smooth, finer, split, cut, grow or shrink
    faces: tuple
    into: int | None = None  #: a face of the other region of a merge, or of the growing region of a stroke
    rings: int = 0  #: number of rings of faces to grow or shrink by


class Pointing:
    """The Region tool: a click adds, deletes or chooses; a drag to another region merges the two."""

    def __init__(self):
        self.begin = self.over = None
        self._verb, self._from, self._dragged = "", (0.0, 0.0), False

    def press(self, hit: Hit | None, at=(0.0, 0.0), verb: str = "add") -> None:
        """Starts the gesture. verb: of a click; "merge" has none, and drags of this and of "add" merge."""
        self.begin = self.over = hit
        self._verb = verb
        self._from, self._dragged = at, False

    def move(self, hit: Hit | None, at=(0.0, 0.0)) -> None:
        self.over = hit
        self._dragged = self._dragged or is_far(self._from, at)

    @property
    def merging(self) -> bool:
        """Whether a release now would merge two regions."""
        return self._verb in ("add", "merge") and self._dragged and self._parted()

    def _parted(self) -> bool:
        if self.begin is None or self.over is None:
            return False
        begin, over = self.begin.region, self.over.region
        return begin >= 0 and over >= 0 and begin != over

    def release(self) -> Wish | None:
        """Return the wish; None if the press missed the scan or the drag ended in the same region."""
        begin, over = self.begin, self.over
        merging, verb, dragged = self.merging, self._verb, self._dragged
        self.cancel()
        if begin is None:
            return None
        if merging:
            return Wish("merge", (over.face,), into=begin.face)
        return None if verb == "merge" or (dragged and verb == "add") else Wish(verb, (begin.face,))

    def cancel(self) -> None:
        self.begin = self.over = None
        self._dragged = False


class Stroke:
    """The Paint tool: collects the faces under a brush, and makes a wish of them."""

    def __init__(self, surface, triangle_face: np.ndarray, pairs: np.ndarray, radius: float):
        """surface: pick.Surface; triangle_face: the user's face of each triangle; pairs: (E, 2) adjacent triangles."""
        self._surface, self._triangle_face, self._pairs = surface, triangle_face, pairs
        self._radius = radius
        self.covered: set[int] = set()  #: triangles
        self._last = self._first = None
        self._verb = "paint"

    def press(self, hit: Hit | None, facing, verb: str = "paint") -> None:
        self._verb = verb
        self.move(hit, facing)

    def move(self, hit: Hit | None, facing) -> None:
        """Covers the faces between the last place and this one, on the side facing the viewer.

        facing: the view direction. An open scan can be painted from its back, but a thin one not through its front.
        """
        if hit is None:
            self._last = None
            return
        self._first = self._first or hit
        place = np.asarray(hit.place, float)
        begin = place if self._last is None else self._last
        steps = int(np.ceil(np.linalg.norm(place - begin) / max(0.5 * self._radius, 1e-12)))
        steps = min(max(steps, 1), 200)
        self._last = place
        facing = np.asarray(facing, float)
        if self._surface.normal(self._triangle_of(hit)) @ facing > 0:
            facing = -facing
        for share in np.arange(1, steps + 1) / steps:
            self.covered.update(self._surface.ball(begin + share * (place - begin), self._radius, facing).tolist())
        self.covered.add(self._triangle_of(hit))

    def _triangle_of(self, hit: Hit) -> int:
        return int(np.searchsorted(self._triangle_face, hit.face))

    def release(self) -> Wish | None:
        """Return the wish with the painted faces connected to the first one; None if there are none."""
        if self._first is None:
            return None
        begin, verb = self._first, self._verb
        triangles = view.connected(np.array(sorted(self.covered)), self._pairs, self._triangle_of(begin))
        faces = np.unique(self._triangle_face[triangles])
        self.cancel()
        rest = tuple(faces[faces != begin.face].tolist())
        return Wish(verb, (begin.face, *rest), into=begin.face if verb == "paint" and begin.region >= 0 else None)

    def cancel(self) -> None:
        self.covered = set()
        self._first = self._last = None


def painted_over(faces, label: np.ndarray, locked: np.ndarray) -> list[int]:
    """Return a face of each unlocked region that a stroke covers, without regions that it only touches.

    faces: faces of the stroke. label: (F,) the region of each face, -1 for none. locked: numbers of regions.
    """
    faces = np.asarray(faces, np.int64)
    regions, first, count = np.unique(label[faces], return_index=True, return_counts=True)
    size = np.bincount(label[label >= 0], minlength=int(regions[-1]) + 1)
    enough = (count >= _MOST_OF * len(faces)) | (count >= _MOST_OF * size[regions])
    enough &= (regions >= 0) & ~np.isin(regions, locked)
    splits = size[regions] > 1  # a single face can't be split
    found: list[int] = faces[np.sort(first[enough & splits])].tolist()
    return found


class Cut:
    """The Cut tool: a straight line in the view cuts the region below it; a click splits a region in two."""

    def __init__(self):
        self._hits, self._from, self.dragged = [], (0.0, 0.0), False

    def press(self, hit: Hit | None, at=(0.0, 0.0)) -> None:
        self._hits, self._from, self.dragged = [hit], at, False

    def move(self, hit: Hit | None, at=(0.0, 0.0)) -> None:
        """Adds a place on the line."""
        self._hits.append(hit)
        self.dragged = self.dragged or is_far(self._from, at)

    @property
    def target(self) -> Hit | None:
        """The first hit in the region with most hits of the line; without a drag, the hit of the press."""
        hits = [hit for hit in self._hits[: None if self.dragged else 1] if hit is not None and hit.region >= 0]
        if not hits:
            return None
        regions = [hit.region for hit in hits]
        most = max(set(regions), key=lambda region: (regions.count(region), -region))
        return next(hit for hit in hits if hit.region == most)

    def release(self) -> Wish | None:
        target = self.target
        return None if target is None else Wish("cut" if self.dragged else "split", (target.face,))


class Sizing:
    """The Grow tool: a drag to the right grows a region by its distance; a drag to the left shrinks it."""

    def __init__(self, ring: float):
        """ring: width of a ring of faces in pixels."""
        self._ring = ring
        self._hit, self._from, self._click, self._dragged = None, (0.0, 0.0), 1, False
        self._rings = 0  # number of rings to grow by; negative: to shrink by

    def press(self, hit: Hit | None, at=(0.0, 0.0), ctrl: bool = False) -> None:
        """Starts the gesture. A click grows by one ring; with ctrl it shrinks by one."""
        self._hit, self._from, self._click = hit, at, -1 if ctrl else 1
        self._rings, self._dragged = 0, False

    def move(self, at) -> None:
        self._dragged = self._dragged or is_far(self._from, at)
        away = at[0] - self._from[0]
        self._rings = 0 if abs(away) <= _DRAG else rings_in(abs(away), self._ring) * (1 if away > 0 else -1)

    @property
    def wish(self) -> Wish | None:
        """The wish of a release now; None if the mouse is at its start again."""
        rings = self._rings if self._dragged else self._click
        if self._hit is None or self._hit.region < 0 or rings == 0:
            return None
        return Wish("grow" if rings > 0 else "shrink", (self._hit.face,), rings=abs(rings))


def rings_in(pixels: float, ring: float) -> int:
    """Return the number of rings of width `ring` in `pixels`; at least one."""
    return min(max(1, round(pixels / max(ring, _MIN_RING))), _MOST_RINGS)
