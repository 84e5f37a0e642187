"""The outcome of a recipe, and the exception of a failed step."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from . import recipe as rcp
from . import view


class StepFailed(Exception):
    """A failed step. `outcome` is the result of the steps before it, None if there are none."""

    def __init__(self, index: int, step: rcp.Step, reason: str, outcome: Outcome | None):
        super().__init__(f"Step {index + 1}, {step.describe()}: {reason}")
        self.index, self.step, self.reason, self.outcome = index, step, reason, outcome


EXACT = 1e-6  #: polygons that bend by at most this share of the scan's diagonal count as exactly flat


@dataclass(frozen=True, eq=False)
class Outcome:
    """The result of a recipe. Arrays are by the user's faces."""

    face_region: np.ndarray  #: (face_count,) int32, -1 where a face is in no region
    region_color: np.ndarray  #: (R,) int32 into view.PALETTE
    border: np.ndarray  #: (K,) indices of the scan's `face_edges` between regions, or between a region and none
    partition: Any
    polygons: Any = None  #: the engine's PolygonMesh after Mesh, else None
    origin: tuple = (0.0, 0.0, 0.0)  #: a point near the polygons; 0 if they lie near zero. See `engine.Mesh.origin`
    numbers: dict = field(default_factory=dict)  #: numbers of the last step and of the scan
    made: Any = None  #: `engine.within.Made` of the partition; None after an edit
    region_distance: Any = None  #: after Mesh: (R,) largest distance of a region's vertices from the polygons
    repair: Any = None  #: `engine.repairs.Repair` of the mesh that the regions are of

    @property
    def face_color(self) -> np.ndarray:
        """(face_count,) uint8 into view.COLORS; regions that are left out are grey."""
        color = np.where(self.partition.region_left_out, len(view.PALETTE), self.region_color)
        return view.face_colors(self.face_region, color)
