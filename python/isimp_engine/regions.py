"""Numbers of regions, openings and polygons, for the add-on and for reports."""

import math

import numpy as np

from ._core import (
    Mesh,
    Partition,
    _has_noise,
    all_statistics,
    barrier_faces,
    close_openings,
    expected_polygons,
    opening_length,
    opening_lengths,
    region_fits,
    region_sides,
    region_statistics,
    round_part_at,
    triangulate,
)
from .sizes import borders
from .surfaces import areas

__all__ = [
    "all_statistics",
    "barrier_faces",
    "close_openings",
    "expected_polygons",
    "is_drawn",
    "opening_length",
    "opening_lengths",
    "region_fits",
    "region_sides",
    "region_statistics",
    "round_part_at",
    "triangulate",
    "why_not_round",
]

FLAT, ROUGH, FREE_FORM = "flat", "noise", "free"  #: reasons of `why_not_round`

_LEAST_BEND = math.radians(2)
_BENDS = math.radians(35), math.radians(65)  # largest angles of neighbours on a bent surface, and on a rough one
_LEAST_BENT = 0.01  # share of the area that bends in a part with round surfaces
_ROUGH = 0.01  # share of the diagonal: noise that hides any bend
_DEEP = 2.0  # a bend is seen where its height in a region is this many times the noise


def is_drawn(mesh: Mesh) -> bool:
    """Whether a mesh was drawn and not scanned: it has no noise. Cost: O(F)."""
    return not _has_noise(mesh)


def why_not_round(mesh: Mesh, part: Partition) -> str:
    """Why a partition that looked for round parts has none: FLAT, ROUGH or FREE_FORM. Cost: O(F).

    A region bends if it meets two others at small angles. FREE_FORM: some do, but not as cylinders, cones, spheres,
    turned parts or extrusions. ROUGH: the noise hides the height of their bends; then angles may be larger, as few
    regions are left of a rough round part. FLAT: neither, all regions meet at edges.
    """
    label, triangles = np.asarray(part.face_region), np.asarray(mesh.triangles)
    at, regions, noise = np.asarray(mesh.vertices, np.float64), part.region_count, part.noise or 0.0
    pairs, ends = borders(label, triangles)
    length = np.linalg.norm(at[ends[:, 0]] - at[ends[:, 1]], axis=1)
    around = np.bincount(pairs.ravel(), np.repeat(length, 2), regions)
    pairs, normal = np.unique(pairs, axis=0), np.asarray(part.region_normal, np.float64)
    angle = np.arccos(np.clip((normal[pairs[:, 0]] * normal[pairs[:, 1]]).sum(axis=1), -1, 1))
    area = np.bincount(label[label >= 0], areas(at, triangles[label >= 0]), regions)
    for most in _BENDS:
        some = (angle > _LEAST_BEND) & (angle < most)
        times = np.bincount(pairs[some].ravel(), minlength=regions)
        turn = np.bincount(pairs[some].ravel(), np.repeat(angle[some], 2), regions) / np.maximum(times, 1)
        bent = times >= 2
        if not area[bent].sum() > _LEAST_BENT * area.sum():  # none has an area, for one
            continue
        height = 2 * area[bent] / around[bent] * turn[bent] / 8  # of an arc as wide as the region over its chord
        order = np.argsort(height)
        middle = order[np.searchsorted(np.cumsum(area[bent][order]), area[bent].sum() / 2)]
        if noise > height[middle] / _DEEP:
            return ROUGH
        if most == _BENDS[0]:
            return FREE_FORM
    return ROUGH if noise > _ROUGH * mesh.report["diagonal"] else FLAT
