"""Conversion of many scans to polygon meshes, each in a child process with limits: `isimp batch` as functions.

    from isimp_engine import batch

    outcome = batch.run("scans", "models", options={"proxies": 500}, children=batch.Children(time_limit=600))
    for row in outcome.failed:
        print(row["name"], row["why"])

A second call skips scans that are done. docs/scale.md describes the rows and the folders.
"""

from ..children.clusters import Cluster
from ..children.errors import BatchError
from ..children.nursery import Ending, Limits, Nursery, NurseryEnded
from ..children.runner import Children
from .run import Outcome, State, run
from .scans import Scan, estimated_faces, find_scans, needed_mb
from .table import read_rows

__all__ = [
    "BatchError",
    "Children",
    "Cluster",
    "Ending",
    "Limits",
    "Nursery",
    "NurseryEnded",
    "Outcome",
    "Scan",
    "State",
    "estimated_faces",
    "find_scans",
    "needed_mb",
    "read_rows",
    "run",
]
