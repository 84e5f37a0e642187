"""The work of a child on one scan: the same as `isimp simplify`, in a folder of its own."""

from pathlib import Path
from typing import Any

from ..cli import simplify as command
from ..cli.command import EXPECTED, problem
from ..cli.task import Simplification
from . import picture
from .table import MADE, PICTURE

_FIGURES = ("polygons", "vertices", "corners", "closed", "manifold", "planarity_max", "planarity_mean")
_MORE = ("scan_distance", "scan_distance_allowed", "crossing", "flipped", "bent", "intersecting")


def simplify(task: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Simplify `task["input"]` to MADE/`task["output"]` by `task["options"]`; returns the figures, or {"why": ...}."""
    made = folder / MADE
    made.mkdir()
    source, output = Path(task["input"]), made / task["output"]
    try:
        one = Simplification(
            source,
            output,
            command.settings_for(output, task["options"], task["recipe"]),
            labels=output.with_suffix(".labels.npy") if task["labels"] else None,
            report=output.with_suffix(".report.json") if task["reports"] else None,
            quiet=True,
        )
        done = command.run(one)
        if task["picture"]:
            polygons, scan = done.model.polygons, (done.model.source.vertices, done.model.source.triangles)
            model = (polygons.vertices, polygons.loops, polygons.loop_start, polygons.polygon_region)
            (folder / PICTURE).write_bytes(picture.beside(scan, model))
    except MemoryError:
        raise
    except EXPECTED as error:
        return {"why": _plain(problem(error, source)[0], source, output)}
    return figures(done.report)


def figures(report: dict[str, Any]) -> dict[str, Any]:
    """Return the figures of a report that the table of a batch lists; see docs/scale.md."""
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


def _plain(message: str, source: Path, output: Path) -> str:
    """Return the message on one line, with the final name of the result and without the name of the scan."""
    text = message.replace(str(output), output.name)
    return " ".join(text.removeprefix(f"{source}: ").split())
