"""The steps that set the planes of regions. Standard library only."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .checks import check, check_choice, check_options, indices, numbers
from .engine_fields import RegulariseFields
from .engine_options import REGULARISE
from .language import said
from .step import Step, count_faces

#: upward directions: the scene's Z in `direction`, an axis of the scan, the normal of a region, none
UPS = ("scene", *(axis for axis in REGULARISE["up"].choices if axis != "none"), "region", "none")
#: target orientations of planes
ALIGNMENTS = ("level", "upright", "parallel", "perpendicular", "coplanar", "free")


@dataclass(frozen=True)
class _Upward(Step):
    """Base of steps with an upward direction."""

    up: str = "scene"  #: one of UPS
    direction: tuple[float, ...] = ()  #: the scene's Z in the scan's space; empty: z
    face: int = -1  #: a face of the region whose normal is up
    length: float = 0.0  #: largest increase of a region's distance from its plane, scene units; 0: the engine's choice

    def __post_init__(self) -> None:
        check_choice(self.up not in UPS, "up", ", ".join(UPS), self.up)
        object.__setattr__(self, "direction", numbers(self.direction, "direction"))
        three = len(self.direction) in (0, 3)
        check(not three, said("direction must have 3 numbers, got {number}", number=len(self.direction)))
        check(len(self.direction) == 3 and not any(self.direction), said("direction must not be 0"))
        check_options(self, {name: option for name, option in REGULARISE.items() if name != "up"})


@dataclass(frozen=True)
class Regularise(_Upward, RegulariseFields):
    """Snap the planes of regions: level, upright with right angles, equal slopes, parallel, coplanar."""

    snap_sizes: float = 0.0  #: step that distances and diameters move to, scene units; 0: they do not

    def __post_init__(self) -> None:
        super().__post_init__()
        check(
            not 0 <= self.snap_sizes < math.inf,
            said("snap_sizes must be a length of at least 0, got {number}", number=self.snap_sizes),
        )

    def describe(self) -> str:
        return "Regularise"


@dataclass(frozen=True)
class AlignPlanes(_Upward):
    """Set the planes of the regions of some faces; the first leads. Regularise and later edits keep them."""

    faces: tuple[int, ...] = ()
    to: str = "level"  #: one of ALIGNMENTS

    def __post_init__(self) -> None:
        super().__post_init__()
        check_choice(self.to not in ALIGNMENTS, "to", ", ".join(ALIGNMENTS), self.to)
        object.__setattr__(self, "faces", indices(self.faces))

    def describe(self) -> str:
        return f"Make the planes at {count_faces(self.faces)} {self.to}"
