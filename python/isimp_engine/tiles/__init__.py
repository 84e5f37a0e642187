"""A scan in tiles that may be larger than memory: `isimp tiles` as a function, and its steps as functions on arrays.

    from isimp_engine import tiles

    outcome = tiles.run("city", "city.obj", proxies=20_000)
    print(outcome.report["unmatched_share"])

An interrupted run continues from its work folder. docs/scale.md describes the steps.
"""

from .errors import TileFailed, TilesError
from .run import Outcome, State, run
from .steps import (
    Components,
    Extent,
    Faces,
    Found,
    Merges,
    Patches,
    Relaxed,
    Thinned,
    WholeScan,
    add_changes,
    common_price,
    contracted,
    detail_patches,
    error_of,
    faces_of,
    find_components,
    find_regions,
    kept_moments,
    labels_after,
    least_cost,
    measure,
    merge,
    merge_inside,
    patches,
    points_on_edges,
    polygonize_thinned,
    relax,
    size_and_noise,
    thin,
    touching,
    weld,
)

__all__ = [
    "Components",
    "Extent",
    "Faces",
    "Found",
    "Merges",
    "Outcome",
    "Patches",
    "Relaxed",
    "State",
    "Thinned",
    "TileFailed",
    "TilesError",
    "WholeScan",
    "add_changes",
    "common_price",
    "contracted",
    "detail_patches",
    "error_of",
    "faces_of",
    "find_components",
    "find_regions",
    "kept_moments",
    "labels_after",
    "least_cost",
    "measure",
    "merge",
    "merge_inside",
    "patches",
    "points_on_edges",
    "polygonize_thinned",
    "relax",
    "run",
    "size_and_noise",
    "thin",
    "touching",
    "weld",
]
