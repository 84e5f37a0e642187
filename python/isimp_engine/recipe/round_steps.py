"""The steps of a recipe for round parts: cylinders, cones, spheres and surfaces of revolution as rings of segments."""

from __future__ import annotations

from dataclasses import dataclass

from .checks import check_choice, must
from .step import AtFace, AtFaces

#: kinds of surface; empty: the simplest that fits
ROUND_KINDS = ("", "cylinder", "cone", "sphere", "revolution", "extrusion")
MOST_SEGMENTS, MOST_RINGS = 256, 64  #: as the engine allows


@dataclass(frozen=True)
class RoundRegions(AtFaces):
    """Make the regions of some faces one round part."""

    described = "Make round: the regions at {0.named}"

    kind: str = ""  #: kind of surface; it hides the property `kind` of steps

    def __post_init__(self) -> None:
        super().__post_init__()
        check_choice(self.kind not in ROUND_KINDS, "kind", ", ".join(ROUND_KINDS[1:]), self.kind)


@dataclass(frozen=True)
class RoundSegments(AtFace):
    """Cut the round part at a face into another number of segments and rings."""

    described = "{0.segments} segments for the round part at face {0.face}"

    segments: int = 12
    rings: int = 0  #: 0: as many as keep about the number of cells

    def __post_init__(self) -> None:
        super().__post_init__()
        must(1 <= self.segments <= MOST_SEGMENTS, "segments", f"in [1, {MOST_SEGMENTS}]", self.segments)
        must(0 <= self.rings <= MOST_RINGS, "rings", f"in [0, {MOST_RINGS}]", self.rings)


@dataclass(frozen=True)
class ExplodeRound(AtFace):
    """Make the cells of the round part at a face ordinary regions."""

    described = "Explode the round part at face {0.face}"
