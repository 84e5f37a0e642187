"""Write a report of a scan's model: tables of planes and round parts (CSV, GeoJSON), a page with pictures (HTML)."""

import argparse
from dataclasses import replace
from pathlib import Path

from .. import reports
from ..drafts import readable
from ..pipeline import make_model, make_regions
from ..source import load
from . import words
from .ending import too_late
from .errors import UsageError, flag
from .files import add_input, check_all, show
from .options import settings_of
from .progress import Steps, wanted


def regions(text: str) -> list[int]:
    """Numbers of regions, as `3,7,12`."""
    try:
        found = [int(part) for part in text.split(",")]
    except ValueError:
        found = []
    if len(set(found)) < 2 or min(found) < 0:
        raise argparse.ArgumentTypeError(f"give two or more numbers of regions, as 3,7,12; got '{text}'")
    return found


def add_options(command: argparse.ArgumentParser) -> None:
    add_input(command)
    command.add_argument("output", type=Path, metavar="OUTPUT_FOLDER", help="made if it is not there")
    command.add_argument(
        "--angles",
        type=regions,
        metavar="N,N,...",
        help="also angles.csv: the angles between the planes of these regions",
    )
    command.add_argument("--quiet", action="store_true", help="no progress, no summary")


def run(arguments: argparse.Namespace) -> None:
    if arguments.output.exists() and not arguments.output.is_dir():
        raise UsageError(f"{arguments.output}: is a file; OUTPUT_FOLDER must be a folder")
    if arguments.output.exists():
        check_all([arguments.output / name for name in reports.NAMES], [arguments.input])
    for name in ("texture", "ao", "tiles", "materials"):
        if getattr(arguments, name) is not None:
            raise UsageError(f"{flag(name)}: a report has no texture")
    settings = settings_of(vars(arguments), arguments.recipe)
    steps = Steps(wanted(arguments.quiet))
    with steps("read") as job:
        source = load(arguments.input, job, settings.partition.threads)
    model = make_model(make_regions(source, replace(settings, texture=None), steps), steps)
    poly = model.polygons
    with steps("measure") as job:
        table = reports.plane_table(model.mesh, model.partition, poly, job)
    angles = None
    if arguments.angles is not None:
        known = {row["region"] for row in table.rows}
        if missing := [number for number in arguments.angles if number not in known]:
            raise UsageError(f"--angles: there is no region {missing[0]}; they are numbered from 0 to {max(known)}")
        angles = reports.angle_rows(table, arguments.angles)
    texts = reports.texts_of(
        readable(arguments.input.name), model.mesh, model.partition, poly, table, settings.crs, step=model.step
    )
    if angles is not None:
        texts[reports.ANGLES] = reports.write_csv(angles, ("region", "other", "angle"))
    with too_late():
        reports.write(arguments.output, texts)
    if not arguments.quiet:
        found = words.count(len(table.rows), "plane")
        if table.round_parts:
            found += f" and {words.count(len(table.round_parts), 'round part')}"
        show(f"{arguments.output}: {found} in {', '.join(texts)}")
