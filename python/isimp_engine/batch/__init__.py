"""Conversion of many scans to polygon meshes, each in a child process with limits: `isimp batch` as functions.

    from isimp_engine import batch

    outcome = batch.run("scans", "models", options={"proxies": 500}, children=batch.Children(time_limit=600))
    for row in outcome.failed:
        print(row["name"], row["why"])

A second call skips scans that are done. docs/scale.md describes the rows and the folders.
"""

from typing import TYPE_CHECKING

from .._old_names import by_old_name
from ..children.clusters import Cluster
from ..children.errors import BatchError
from ..children.runner import Children
from .run import run

__all__ = ["BatchError", "Children", "Cluster", "run"]

if not TYPE_CHECKING:
    _OLD = {name: f"children.process.{name}" for name in ("Ending", "Limits")}
    _OLD |= {name: f"batch.run.{name}" for name in ("Outcome", "State")}
    _OLD |= {name: f"batch.scans.{name}" for name in ("Scan", "estimated_faces", "find_scans", "needed_mb")}
    __getattr__ = by_old_name(__name__, _OLD | {"read_rows": "batch.table.read_rows"})
