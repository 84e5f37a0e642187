"""The command `isimp`: `isimp simplify INPUT OUTPUT` and `isimp info INPUT`.

Exit status: 0; 2 for wrong usage; 3 for input that can't be used, with one line that says what and where; 130 after
Ctrl-C, with nothing half-written.
"""

import argparse
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from .. import CleanOptions, FileError, InvalidInput, PartitionOptions, __version__, _process
from . import guiding, info, simplify
from .errors import UsageError
from .files import place

OK, USAGE, BAD_INPUT, INTERRUPTED = 0, 2, 3, _process.INTERRUPTED

_COUNTS = {  # at most one of them
    "proxies": (int, "N"),
    "detail": (float, "X"),
    "tolerance": (float, "T"),
    "bound": (float, "T"),
}
_FIELDS = {
    "noise": (float, "S"),
    "adaptivity": (float, "X"),
    "seed": (int, "S"),
    "method": (str, "NAME"),
    "iterations": (int, "N"),
    "leave_out": (float, "X"),
    "threads": (int, "N"),
    "backend": (str, "NAME"),
    "nearest": (int, "N"),
    "search": (str, "NAME"),
    "connect": (str, "NAME"),
    "fraction": (float, "X"),
}
_CLEAN_FIELDS = {"weld": (float, "L"), "fill_holes": (float, "L"), "cut_handles": (float, "L")}


def parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="isimp", description="Dense scans into clean, editable n-gon meshes.")
    parser.add_argument("--version", action="version", version=f"isimp {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    command = commands.add_parser("simplify", help="make a polygon mesh of a scan", description=simplify.__doc__)
    command.set_defaults(run=simplify.run)
    command.add_argument("input", type=Path, metavar="INPUT", help="PLY (ascii or binary), OBJ, STL or OFF")
    command.add_argument("output", type=Path, metavar="OUTPUT", help="PLY or OBJ")
    counts = command.add_mutually_exclusive_group()
    add_fields(counts, PartitionOptions, _COUNTS)
    add_fields(command, PartitionOptions, _FIELDS)
    about = f"Turns off: {PartitionOptions.snap.__doc__}"
    command.add_argument("--no-snap", dest="snap", action="store_false", default=None, help=about)
    add_fields(command, CleanOptions, _CLEAN_FIELDS)
    guiding.add_options(command)
    command.add_argument(
        "--labels", type=place, metavar="L.npy", help="one int32 region per face of INPUT, in file order; -1: none"
    )
    command.add_argument("--report", type=place, metavar="R.json", help="what was done, in numbers; -: to stdout")
    command.add_argument("--quiet", action="store_true", help="no progress, no summary")

    command = commands.add_parser("info", help="what a mesh is and what would be repaired", description=info.__doc__)
    command.set_defaults(run=info.run)
    command.add_argument("input", type=Path, metavar="INPUT", help="PLY (ascii or binary), OBJ, STL or OFF")
    add_fields(command, CleanOptions, _CLEAN_FIELDS | {"threads": (int, "N")})
    command.add_argument("--json", action="store_true", help="as JSON")
    return parser


def add_fields(command: Any, options: type, fields: dict[str, tuple[type, str]]) -> None:
    """A flag for each of these fields, which says what the field's documentation says."""
    defaults = options()
    for name, (kind, metavar) in fields.items():
        default = getattr(defaults, name)
        about = getattr(options, name).__doc__ + ("" if default is None else f" Default: {default}.")
        flag = "--" + name.replace("_", "-")
        command.add_argument(flag, dest=name, type=kind, metavar=metavar, help=about.replace("%", "%%"))


def options_of(arguments: argparse.Namespace, kind: type, fields: Iterable[str]) -> Any:
    """The engine's options of this kind as the command line has them; its defaults for the rest."""
    options = kind()
    for name in fields:
        value = getattr(arguments, name)
        if value is None:
            continue
        try:
            setattr(options, name, value)
        except InvalidInput as error:
            flag = "--" + name.replace("_", "-")
            raise UsageError(str(error).replace(f"{kind.__name__}.{name}", flag)) from None
    return options


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    parsed = parser().parse_args(arguments)
    try:
        _process.expect_interrupts()
        if sys.stdout is not None:  # names of files may be any bytes: what is no text goes out as it came in
            sys.stdout.reconfigure(errors="surrogateescape")
        parsed.clean = options_of(parsed, CleanOptions, (*_CLEAN_FIELDS, "threads"))
        if parsed.run is simplify.run:
            parsed.options = options_of(parsed, PartitionOptions, (*_COUNTS, *_FIELDS, "snap"))
        parsed.run(parsed)
        if sys.stdout is not None:
            sys.stdout.flush()
    except KeyboardInterrupt:
        return _say("interrupted, nothing was written", INTERRUPTED)
    except UsageError as error:
        return _say(str(error), USAGE)
    except FileError as error:  # names the file itself
        return _say(str(error), BAD_INPUT)
    except OSError as error:
        return _say(f"{error.filename or parsed.input}: {error.strerror or error}", BAD_INPUT)
    except MemoryError:
        return _say(f"{parsed.input}: there is not enough memory for it", BAD_INPUT)
    except (InvalidInput, RuntimeError) as error:
        return _say(f"{parsed.input}: {error}", BAD_INPUT)
    finally:
        _process.ignore_interrupts()
    return OK


def _say(message: str, status: int) -> int:
    if sys.stderr is not None:  # it is where it was closed: then the status alone says it
        print("isimp:", " ".join(message.split()), file=sys.stderr)
    return status
