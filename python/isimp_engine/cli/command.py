"""The command `isimp` with its commands simplify, batch, tiles, report, colliders, info and schema.

Exit status: 0; 2 for wrong usage; 3 for unusable input, with one line that names the error and its place; 4 if some
scans of a batch failed; 130 after Ctrl-C and 143 after SIGTERM, with nothing half-written.
"""

import argparse
import io
import sys
from collections.abc import Sequence
from contextlib import nullcontext, suppress
from pathlib import Path

from .. import FileError, InvalidInput, __version__, _process, exporting
from ..settings import OptionError
from . import batch, colliders, flat, guiding, info, lods, report, schema, simplify, tiles
from .ending import Terminated, terminable
from .errors import BAD_INPUT, INTERRUPTED, OK, TERMINATED, USAGE, UsageError, flag
from .files import add_input, place, show
from .options import simplify_options

EXPECTED = (UsageError, FileError, OSError, MemoryError, InvalidInput, RuntimeError)  #: errors that wrong input raises


def parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="isimp", description="Dense scans into clean, editable n-gon meshes.")
    parser.add_argument("--version", action="version", version=f"isimp {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    shared = [simplify_options()]
    command = commands.add_parser(
        "simplify", help="make a polygon mesh of a scan", description=simplify.__doc__, parents=shared
    )
    command.set_defaults(run=flat.run)
    add_input(command)
    command.add_argument(
        "output",
        type=Path,
        metavar="OUTPUT",
        help=f"{', '.join(exporting.PLAIN)}; with --texture {', '.join(exporting.TEXTURED)}",
    )
    command.add_argument(
        "--lods",
        type=lods.counts,
        metavar="N,N,...",
        help="levels of detail: a result for each number of regions, OUTPUT_LOD0, OUTPUT_LOD1, ...; with --texture "
        "each image has half the side of the one before",
    )
    flat.add_option(command)
    guiding.add_files(command)
    command.add_argument(
        "--labels", type=place, metavar="L.npy", help="one int32 region per face of INPUT, in file order; -1: none"
    )
    command.add_argument("--report", type=place, metavar="R.json", help="the numbers of the result; -: to stdout")
    command.add_argument("--quiet", action="store_true", help="no progress, no summary")

    command = commands.add_parser(
        "batch", help="make polygon meshes of many scans", description=batch.__doc__, parents=shared
    )
    command.set_defaults(run=batch.run)
    batch.add_options(command)

    command = commands.add_parser(
        "tiles", help="make a polygon mesh of a scan in tiles, larger than memory", description=tiles.__doc__
    )
    command.set_defaults(run=tiles.run)
    tiles.add_options(command)

    command = commands.add_parser(
        "report", help="tables of the planes and a page about the model", description=report.__doc__, parents=shared
    )
    command.set_defaults(run=report.run)
    report.add_options(command)

    command = commands.add_parser(
        "colliders", help="make convex parts of a solid, for collisions", description=colliders.__doc__
    )
    command.set_defaults(run=colliders.run)
    colliders.add_options(command)

    command = commands.add_parser(
        "info",
        help="properties of a mesh, and the polygons that it would become",
        description=info.__doc__,
        parents=shared,
    )
    command.set_defaults(run=info.run)
    add_input(command)
    command.add_argument(
        "--mesh-only", action="store_true", help="do not count the polygons, which takes the time of a run"
    )
    command.add_argument(
        "--estimate", action="store_true", help="estimate the polygons from the regions, in a fraction of that time"
    )
    command.add_argument("--json", action="store_true", help="as JSON")

    command = commands.add_parser(
        "schema", help="the commands and their options as JSON, for programs", description=schema.__doc__
    )
    command.set_defaults(run=schema.run, commands=commands.choices, input=None)
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    parsed = parser().parse_args(arguments)
    status = None
    try:
        _process.expect_interrupts()
        if isinstance(sys.stdout, io.TextIOWrapper):  # file names may be any bytes: they are written unchanged
            sys.stdout.reconfigure(errors="surrogateescape")
        with (
            terminable() if parsed.run in (flat.run, report.run, colliders.run, info.run) else nullcontext()
        ):  # the others have their own
            status = parsed.run(parsed)
    except Terminated:
        return _say("terminated, nothing was written", TERMINATED)
    except KeyboardInterrupt:
        return _say("interrupted, nothing was written", INTERRUPTED)
    except EXPECTED as error:
        return _say(*problem(error, parsed.output if parsed.run in (batch.run, tiles.run) else parsed.input))
    finally:
        _process.ignore_interrupts()
    return status if isinstance(status, int) else OK


def problem(error: Exception, path: Path) -> tuple[str, int]:
    """Returns the error message for an input, and the exit status; `error` is one of EXPECTED."""
    if isinstance(error, UsageError):
        return str(error), USAGE
    if isinstance(error, OptionError):
        return f"{path}: {error.shown(flag)}", USAGE
    if isinstance(error, FileError):  # names the file itself
        return str(error), BAD_INPUT
    if isinstance(error, OSError):
        return f"{error.filename or path}: {error.strerror or error}", BAD_INPUT
    if isinstance(error, MemoryError):
        return f"{path}: there is not enough memory for it", BAD_INPUT
    return f"{path}: {error}", BAD_INPUT


def _say(message: str, status: int) -> int:
    with suppress(OSError):  # of stderr: only the status reports the error then
        show(f"isimp: {' '.join(message.split())}", beside=True)
    return status
