"""Numbers of regions, openings and polygons, for the add-on and for reports."""

from ._core import (
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
    "opening_length",
    "opening_lengths",
    "region_fits",
    "region_sides",
    "region_statistics",
    "round_part_at",
    "triangulate",
]
