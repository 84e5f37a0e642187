"""The steps of a recipe for round parts: cylinders, cones, spheres and surfaces of revolution as rings of segments."""

from __future__ import annotations

from dataclasses import dataclass

from .checks import check_choice, check_face, indices, must
from .step import Step, count_faces

#: kinds of surface; empty: the simplest that fits
ROUND_KINDS = ("", "cylinder", "cone", "sphere", "revolution", "extrusion")
MOST_SEGMENTS, MOST_RINGS = 256, 64  #: as the engine allows


@dataclass(frozen=True)
class RoundRegions(Step):
    """Make the regions of some faces one round part."""

    faces: tuple[int, ...] = ()
    kind: str = ""  #: kind of surface; it hides the property `kind` of steps

    def __post_init__(self) -> None:
        object.__setattr__(self, "faces", indices(self.faces))
        check_choice(self.kind not in ROUND_KINDS, "kind", ", ".join(ROUND_KINDS[1:]), self.kind)

    def describe(self) -> str:
        return f"Make round: the regions at {count_faces(self.faces)}"


@dataclass(frozen=True)
class RoundSegments(Step):
    """Cut the round part at a face into another number of segments and rings."""

    face: int = 0
    segments: int = 12
    rings: int = 0  #: 0: as many as keep about the number of cells

    def __post_init__(self) -> None:
        check_face(self.face)
        must(1 <= self.segments <= MOST_SEGMENTS, "segments", f"in [1, {MOST_SEGMENTS}]", self.segments)
        must(0 <= self.rings <= MOST_RINGS, "rings", f"in [0, {MOST_RINGS}]", self.rings)

    def describe(self) -> str:
        return f"{self.segments} segments for the round part at face {self.face}"


@dataclass(frozen=True)
class ExplodeRound(Step):
    """Make the cells of the round part at a face ordinary regions."""

    face: int = 0

    def __post_init__(self) -> None:
        check_face(self.face)

    def describe(self) -> str:
        return f"Explode the round part at face {self.face}"
