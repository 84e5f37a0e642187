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
    __getattr__ = by_old_name(__name__, {name: f"tiles.run.{name}" for name in ("Outcome", "State")})
