"""Numbers of regions, openings and polygons, for the add-on and for reports."""

import math

from ._core import (
    Mesh,
    _tile_measure,
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
]

_LEAST_NOISE = 0.005  # share of the mean edge: scans have .01 and more, drawn models .001 and less


def is_drawn(mesh: Mesh) -> bool:
    """Whether a mesh was drawn and not scanned: it has no noise. Cost: O(F)."""
    edge = math.sqrt(mesh.report["area"] / len(mesh.triangles) * 4 / math.sqrt(3))
    return bool(_tile_measure(mesh, None)[3] < _LEAST_NOISE * edge)
