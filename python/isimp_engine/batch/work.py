"""The work of a child on one scan: the same as `isimp simplify`, in a folder of its own."""

import argparse
from pathlib import Path
from typing import Any

from .. import recipes
from ..cli import simplify as command
from ..cli.command import EXPECTED, parser, problem
from ..cli.options import settle
from . import picture
from .table import MADE, PICTURE

_DEFAULTS = vars(parser().parse_args(["simplify", "scan.ply", "result.ply"]))
_FIGURES = ("polygons", "vertices", "corners", "closed", "manifold", "planarity_max", "planarity_mean")
_MORE = ("scan_distance", "scan_distance_allowed", "crossing", "flipped", "bent", "intersecting")


def simplify(task: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Simplify `task["input"]` to MADE/`task["output"]` by `task["options"]`; returns the figures, or {"why": ...}."""
    made = folder / MADE
    made.mkdir()
    arguments = argparse.Namespace(**_DEFAULTS | task["options"])
    arguments.input, arguments.output = Path(task["input"]), made / task["output"]
    arguments.quiet = True
    if task["labels"]:
        arguments.labels = arguments.output.with_suffix(".labels.npy")
    if task["reports"]:
        arguments.report = arguments.output.with_suffix(".report.json")
    if task["recipe"] is not None:
        arguments.recipe = recipes.parsed(task["recipe"])
    try:
        settle(arguments)
        done = command.run(arguments)
        if task["picture"]:
            source, polygons = done.source, done.polygons
            scan = (source.vertices, source.triangles)
            model = (polygons.vertices, polygons.loops, polygons.loop_start, polygons.polygon_region)
            (folder / PICTURE).write_bytes(picture.beside(scan, model))
    except MemoryError:
        raise
    except EXPECTED as error:
        return {"why": _plain(problem(error, arguments.input)[0], arguments, task)}
    return figures(done.report)


def figures(report: dict[str, Any]) -> dict[str, Any]:
    """Return the values of a report for a row; see docs/scale.md."""
    output = report["output"]
    return {
        "faces": report["input"]["faces"],
        "repaired": sum(report["repair"].values()),
        "regions": report["regions"],
        "error": report["error"],
        **{name: output[name] for name in _FIGURES + _MORE if name in output},
        "diagonal": report["mesh"]["diagonal"],
        "warnings": report["partition"]["warnings"],
        "step_seconds": report["seconds"],
    }


def _plain(message: str, arguments: argparse.Namespace, task: dict[str, Any]) -> str:
    """Return the message on one line, with the final name of the result and without the name of the scan."""
    text = message.replace(str(arguments.output), task["output"])
    return " ".join(text.removeprefix(f"{arguments.input}: ").split())
