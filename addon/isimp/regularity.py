"""Planes of regions: how far they are from level and upright, and colours by direction. numpy only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

NEAR = 15.0  #: degrees: of a plane that is further from level and upright, nothing is told
FREE = (0.55, 0.55, 0.55, 0.85)  #: sRGB and opacity of a region whose plane is not held
# Hues that are told apart by people with colour-blindness too, the strongest first; sRGB.
_HUES = ("0077bb", "ee7733", "009988", "cc3311", "33bbee", "aa3377", "ddaa33", "225555", "8877dd", "778800")
_SAME = 1e-6  # of two normals that are one direction
_DARKEST, _OPACITY = 0.55, 0.85


@dataclass(frozen=True)
class Leaning:
    """How far a plane is from level or upright."""

    is_level: bool  #: else upright
    degrees: float
    adds: float  #: to the root mean square distance of its region, if it is turned there


def leaning(normal: np.ndarray, spread: np.ndarray, up: np.ndarray) -> Leaning | None:
    """That of a plane of best fit to the nearer of both; None beyond NEAR.

    normal, up: (3,). spread: (3, 3), as of `engine.region_fits`.
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
    """(R, 4) float32 sRGB and opacity: a hue for each direction, a shade for each plane of it, FREE where none is held.

    normal: (R, 3) and offset: (R,) of the planes. held: (R,) bool. area: (R,); the hues go to the largest directions.
    Cost: O(R D) for D directions.
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
