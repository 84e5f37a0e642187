"""Measures the angle of planes from level and upright, and assigns colours by direction. numpy only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

NEAR = 15.0  #: degrees: largest angle from level or upright that is reported
FREE = (0.55, 0.55, 0.55, 0.85)  #: sRGB and opacity of a region whose plane is not held
# Hues that people with colour-blindness can distinguish, the strongest first; sRGB.
_HUES = ("0077bb", "ee7733", "009988", "cc3311", "33bbee", "aa3377", "ddaa33", "225555", "8877dd", "778800")
_SAME = 1e-6  # 1 minus the cosine below which two normals have one direction
_DARKEST, _OPACITY = 0.55, 0.85


@dataclass(frozen=True)
class Leaning:
    """Angle of a plane from level or upright, whichever is nearer."""

    is_level: bool  #: whether level is nearer, else upright
    degrees: float
    adds: float  #: increase of the root mean square distance of the region if its plane is turned


def leaning(normal: np.ndarray, spread: np.ndarray, up: np.ndarray) -> Leaning | None:
    """Return the leaning of a best-fit plane; None if its angle is above NEAR.

    normal, up: (3,). spread: (3, 3), from `engine.regions.region_fits`.
    """
    up = up / np.linalg.norm(up)
    rise = float(np.clip(normal @ up, -1.0, 1.0))
    to_level, to_upright = np.degrees(np.arccos(abs(rise))), np.degrees(np.arcsin(abs(rise)))
    degrees = float(min(to_level, to_upright))
    if degrees > NEAR:
        return None
    is_level = bool(to_level <= to_upright)
    wanted = up if is_level else normal - rise * up
    wanted = wanted / np.linalg.norm(wanted)
    adds = wanted @ spread @ wanted - normal @ spread @ normal
    return Leaning(is_level, degrees, float(np.sqrt(max(0.0, adds))))


def direction_colors(normal: np.ndarray, offset: np.ndarray, held: np.ndarray, area: np.ndarray) -> np.ndarray:
    """Return (R, 4) float32 sRGB and opacity: a hue for each direction, a shade for each plane, FREE if not held.

    normal: (R, 3) and offset: (R,) of the planes. held: (R,) bool. area: (R,) the largest directions get the first
    hues. Cost: O(R D) for D directions.
    """
    colors = np.tile(np.array(FREE, np.float32), (len(normal), 1))
    left = np.where(held, area, 0.0)
    sizes, groups = [], []
    while left.max(initial=0.0) > 0:
        along = normal @ normal[int(left.argmax())]
        group = np.flatnonzero((left > 0) & (np.abs(along) > 1 - _SAME))
        sizes.append(float(left[group].sum()))
        groups.append((group, np.sign(along[group])))
        left[group] = 0
    for number, which in enumerate(np.argsort(-np.array(sizes), kind="stable").tolist()):
        group, side = groups[which]
        planes, plane = np.unique((side * offset[group]).round(9), return_inverse=True)
        shade = np.linspace(_DARKEST, 1.0, len(planes))[plane.ravel()] if len(planes) > 1 else np.ones(len(group))
        colors[group, :3] = shade[:, None] * _rgb(_HUES[number % len(_HUES)])
        colors[group, 3] = _OPACITY
    return colors


def _rgb(code: str) -> np.ndarray:
    return np.array([int(code[i : i + 2], 16) / 255 for i in (0, 2, 4)])
