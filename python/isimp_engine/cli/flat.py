"""`isimp simplify --flat`: coplanar faces become one polygon, and nothing else changes."""

import argparse
import json
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

from .. import CleanOptions, PolygonMesh, __version__, exporting, machine, merge_flat
from ..drafts import save_array
from ..repairs import Meshes, Repair
from ..settings import KEEP_CLUTTER, names
from ..source import Source, facts, labels, load
from . import simplify, words
from .errors import UsageError, flag
from .files import STDOUT, Outputs, show
from .progress import Steps, wanted
from .task import Simplification

ANGLE = 0.01  #: degrees; the engine's default

#: the arguments that --flat uses: repairs and files; of the others it would do nothing. Openings stay by themselves.
_USED = {*names(CleanOptions), "keep_openings", "keep_opening", "crs", "unit", "labels", "report", "quiet"}
_OWN = {"input", "output", "flat", "run"}
_DEFAULTS = {"clutter": KEEP_CLUTTER, "strict": False}  # None for all others


def add_option(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--flat",
        type=float,
        nargs="?",
        const=ANGLE,
        metavar="ANGLE",
        help="only merge coplanar faces, exactly: their planes differ by at most ANGLE degrees. Default: %(const)s",
    )


def check(arguments: argparse.Namespace) -> None:
    """Refuse options that --flat has no use for, before the work."""
    for name, value in vars(arguments).items():
        if name not in _USED | _OWN and value != _DEFAULTS.get(name):
            other = flag(f"no_{name}" if value is False else name)
            raise UsageError(
                f"--flat and {other} exclude each other: --flat merges coplanar faces and does nothing else"
            )
    if not 0 <= arguments.flat <= 90:
        raise UsageError(f"--flat must be in [0, 90] degrees, got {arguments.flat:g}")


def run(arguments: argparse.Namespace) -> None:
    """Run `isimp simplify`, with --flat or without."""
    task = simplify.task_of(arguments)
    if arguments.flat is None:
        simplify.run(task)
    else:
        check(arguments)
        _merge(task, arguments.flat)


def _merge(task: Simplification, angle: float) -> None:
    simplify.check_places(task)
    settings, steps = task.settings, Steps(wanted(task.quiet))
    with steps("read") as job:
        source = load(task.input, job, settings.partition.threads)
    repaired = Meshes().repaired(source, Repair.by(settings.clean, settings.kept_places), steps)
    mesh = repaired.mesh
    with steps("mesh") as job:
        poly, region = merge_flat(mesh, angle, job=job)
    surfaces = exporting.surfaces_of(poly)
    unit = source.unit_or(settings.unit)
    with Outputs() as outputs:
        with steps("write") as job:
            of: dict[str, Any] = {"crs": settings.crs, "like": task.output, "surfaces": surfaces, "unit": unit}
            told = outputs.write(task.output, partial(exporting.write, polygons=poly, job=job, **of))
            if isinstance(task.labels, Path):
                outputs.write(task.labels, lambda path: save_array(path, labels(source, mesh, region)))
        report = {
            "isimp": __version__,
            **repaired.as_dict(),
            "mesh": facts(mesh),
            "options": {"flat": angle},
            "regions": int(poly.report["regions"]),
            "output": {"path": str(task.output)} | poly.report,
            "validity": exporting.validity(poly, surfaces, unit),
            "step": told or None,
            "seconds": steps.seconds,
            "peak_mb": machine.peak_mb(),
        }
        if task.report:
            outputs.write_text(task.report, json.dumps(report, indent=2, allow_nan=False) + "\n")
        outputs.commit()
    if not task.quiet:
        show("\n".join(_summary(source, poly, report)), beside=task.report == STDOUT)


def _summary(source: Source, poly: PolygonMesh, report: dict[str, Any]) -> Iterator[str]:
    yield f"{source.path}: {words.count(source.faces, 'face')}, {words.shape(report['mesh'])}"
    for line in words.repairs(report["repair"], report["repaired_at"]):
        yield f"  repaired: {line}"
    parts = words.count(report["regions"], "flat part")
    if report["step"] is not None:
        yield f"  {words.step(report['step'])}"
    yield f"  {parts} -> {words.count(len(poly.loop_start), 'polygon')}, {len(poly.vertices):,} vertices"
