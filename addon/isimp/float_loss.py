"""Computes the detail that Blender's float32 coordinates lose of a scan far from its own origin. numpy only."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .language import own, said

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

#: the largest negligible step between coordinates, as a share of the diagonal
FINE = 1e-5

#: Blender's unit systems: length of the unit in metres, and its name
_UNITS = {"METRIC": (1.0, "m"), "IMPERIAL": (0.3048, "ft")}


@dataclass(frozen=True)
class Loss:
    """The loss along the axis with the largest loss; lengths in scene units."""

    away: float  #: the largest distance of the scan from zero along this axis
    step: float  #: the distance between two adjacent float32 coordinates there


def loss(low: ArrayLike, high: ArrayLike, scale: ArrayLike = (1.0, 1.0, 1.0)) -> Loss | None:
    """Return the loss of a mesh from its bounding box; None if the loss is negligible.

    low, high: (3,) corners of the box in the mesh's coordinates. scale: (3,) scale of the object along each axis.
    """
    box, scale = np.abs(np.array([low, high], np.float64)), np.abs(np.asarray(scale, np.float64))
    if not (np.isfinite(box).all() and np.isfinite(scale).all() and box.max() < np.finfo(np.float32).max):
        return None
    diagonal = np.linalg.norm((np.asarray(high, np.float64) - np.asarray(low, np.float64)) * scale)
    farthest = box.max(axis=0)
    steps = np.spacing(farthest.astype(np.float32)).astype(np.float64) * scale
    worst = int(np.argmax(steps))
    if not steps[worst] > FINE * diagonal > 0:
        return None
    return Loss(float(farthest[worst] * scale[worst]), float(steps[worst]))


def warning(lost: Loss, system: str, unit_scale: float) -> str:
    """Return the warning about a loss, one line. system, unit_scale: the scene's unit settings."""
    metres, unit = _UNITS.get(system, (unit_scale, said(own("units"))))
    away, step = (f"{_plain(length * unit_scale / metres)} {unit}" for length in (lost.away, lost.step))
    return said(
        "This scan lies {away} from its origin, where Blender's coordinates have steps of {step}. "
        "To keep its detail, import it with an offset near zero.",
        away=away,
        step=step,
    )


def _plain(number: float) -> str:
    """Return a number rounded to two digits, without an exponent."""
    rounded = float(f"{number:.2g}")
    return f"{rounded:,.0f}" if rounded >= 10 else f"{rounded:.12f}".rstrip("0").rstrip(".")
