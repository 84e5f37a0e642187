"""A scan in tiles that may be larger than memory: `isimp tiles` as a function.

    from isimp_engine import tiles

    outcome = tiles.run("city", "city.obj", proxies=20_000)
    print(outcome.report["unmatched_share"])

An interrupted run continues from its work folder. docs/scale.md describes it.
"""

from typing import TYPE_CHECKING

from .._old_names import by_old_name
from .errors import TileFailed, TilesError
from .run import run

__all__ = ["TileFailed", "TilesError", "run"]

if not TYPE_CHECKING:
    _STEPS = (
        "city",
        "Components",
        "Extent",
        "Faces",
        "Found",
        "Merges",
        "Patches",
        "Relaxed",
        "Thinned",
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
        "size_and_noise",
        "thin",
        "touching",
        "weld",
    )
    _OLD = {name: f"tiles.steps.{name}" for name in _STEPS}
    _OLD |= {name: f"tiles.run.{name}" for name in ("Outcome", "State")}
    __getattr__ = by_old_name(__name__, _OLD)
