"""Loss of detail by Blender's float32 coordinates, of a scan far from its own zero. numpy only."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .language import own, said

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

#: the largest step between coordinates, as a share of the diagonal, that is no loss
FINE = 1e-5

#: Blender's unit systems: length of the unit in metres, and its name
_UNITS = {"METRIC": (1.0, "m"), "IMPERIAL": (0.3048, "ft")}


@dataclass(frozen=True)
class Loss:
    """The loss along the axis where it is largest; lengths in scene units."""

    away: float  #: how far from zero the scan reaches
    step: float  #: between a coordinate there and the next one


def loss(low: ArrayLike, high: ArrayLike, scale: ArrayLike = (1.0, 1.0, 1.0)) -> Loss | None:
    """The loss of a mesh in a box of its own coordinates; None if it is too small to be seen.

    low, high: (3,) corners of the box. scale: (3,) what the object's transform makes of a unit along each axis.
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


def told(lost: Loss, system: str, unit_scale: float) -> str:
    """The loss as one line. system, unit_scale: the scene's unit settings."""
    metres, unit = _UNITS.get(system, (unit_scale, said(own("units"))))
    away, step = (f"{_plain(length * unit_scale / metres)} {unit}" for length in (lost.away, lost.step))
    return said(
        "This scan lies {away} from its origin, where Blender's coordinates have steps of {step}. "
        "To keep its detail, import it with an offset near zero.",
        away=away,
        step=step,
    )


def _plain(number: float) -> str:
    """Two digits of a number, with no exponent."""
    rounded = float(f"{number:.2g}")
    return f"{rounded:,.0f}" if rounded >= 10 else f"{rounded:.12f}".rstrip("0").rstrip(".")
