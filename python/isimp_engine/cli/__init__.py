"""The command `isimp`: `isimp simplify INPUT OUTPUT`, `isimp batch ...`, `isimp tiles ...` and `isimp info INPUT`.

Exit status: 0; 2 for wrong usage; 3 for input that can't be used, with one line that says what and where; 4 if some
scans of a batch failed; 130 after Ctrl-C, with nothing half-written.
"""

import argparse
import io
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from .. import (
    CleanOptions,
    FileError,
    InvalidInput,
    MeshingOptions,
    PartitionOptions,
    RegulariseOptions,
    __version__,
    _process,
    recipes,
)
from . import batch, closing, guiding, info, lods, simplify, texturing, tiles
from .errors import BAD_INPUT, INTERRUPTED, OK, USAGE, UsageError
from .files import place

EXPECTED = (UsageError, FileError, OSError, MemoryError, InvalidInput, RuntimeError)  #: what wrong input raises

Options = type[CleanOptions] | type[MeshingOptions] | type[PartitionOptions] | type[RegulariseOptions]
_COUNTS = ("proxies", "detail", "tolerance", "bound")  # at most one of them
_SHARED = ("threads",)  # one flag for all steps


def parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="isimp", description="Dense scans into clean, editable n-gon meshes.")
    parser.add_argument("--version", action="version", version=f"isimp {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    shared = [simplify_options()]
    command = commands.add_parser(
        "simplify", help="make a polygon mesh of a scan", description=simplify.__doc__, parents=shared
    )
    command.set_defaults(run=simplify.run)
    command.add_argument("input", type=Path, metavar="INPUT", help="PLY (ascii or binary), OBJ, STL, OFF or GLB")
    command.add_argument("output", type=Path, metavar="OUTPUT", help="PLY or OBJ; with --texture OBJ or GLB")
    command.add_argument(
        "--lods",
        type=lods.counts,
        metavar="N,N,...",
        help="levels of detail: a result for each number of regions, OUTPUT_LOD0, OUTPUT_LOD1, ...; with --texture "
        "each image has half the side of the one before",
    )
    guiding.add_files(command)
    command.add_argument(
        "--labels", type=place, metavar="L.npy", help="one int32 region per face of INPUT, in file order; -1: none"
    )
    command.add_argument("--report", type=place, metavar="R.json", help="what was done, in numbers; -: to stdout")
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
        "info", help="what a mesh is and what it would become", description=info.__doc__, parents=shared
    )
    command.set_defaults(run=info.run)
    command.add_argument("input", type=Path, metavar="INPUT", help="PLY (ascii or binary), OBJ, STL, OFF or GLB")
    command.add_argument(
        "--mesh-only", action="store_true", help="do not count the polygons, which takes the time of a run"
    )
    command.add_argument(
        "--estimate", action="store_true", help="estimate the polygons from the regions, in a fraction of that time"
    )
    command.set_defaults(**guiding.NO_FILES)
    command.add_argument("--json", action="store_true", help="as JSON")
    return parser


def simplify_options() -> argparse.ArgumentParser:
    """The options that apply to any scan, for all commands that simplify."""
    command = argparse.ArgumentParser(add_help=False)
    add_fields(command.add_mutually_exclusive_group(), PartitionOptions, _COUNTS)
    add_fields(command, PartitionOptions, names(PartitionOptions, besides=_COUNTS))
    add_fields(command, CleanOptions, names(CleanOptions, besides=_SHARED))
    command.add_argument(
        "--keep-openings",
        action="store_true",
        help="keep all holes and handles; else those of a noisy scan that the regions can't show are closed",
    )
    command.add_argument(
        "--keep-opening",
        type=closing.place,
        action="append",
        metavar="X,Y,Z",
        help="keep the hole or handle at this place open; the report lists the places (may be given several times)",
    )
    guiding.add_angle(command)
    add_fields(command, MeshingOptions, ("planar",))
    turned = "snap planes: level, upright, parallel, coplanar; each turns by at most ANGLE degrees. Default: %(const)s"
    angle = RegulariseOptions().angle
    command.add_argument("--regularise", type=float, nargs="?", const=angle, metavar="ANGLE", help=turned)
    add_fields(command, RegulariseOptions, ("even_spacing",))
    command.add_argument(
        "--texture",
        type=partial(texturing.whole, "size"),
        nargs="?",
        const=texturing.LIKE_THE_SCAN,
        metavar="SIZE",
        help="keep the scan's texture in an image of SIZE x SIZE pixels; without SIZE: as dense as the scan's images. "
        "Beside OUTPUT.obj come OUTPUT.mtl, OUTPUT.png and OUTPUT_normal.png; OUTPUT.glb holds all",
    )
    command.add_argument(
        "--ao",
        type=texturing.distance,
        nargs="?",
        const=texturing.ANY_DISTANCE,
        metavar="DISTANCE",
        help="with --texture: an image of ambient occlusion by the scan's faces up to DISTANCE away, in scene units; "
        "without DISTANCE: by all",
    )
    command.add_argument(
        "--height",
        action="store_true",
        default=None,
        help="with --texture: OUTPUT_height.png, of 16 bits: how far the scan lies above or below each polygon; the "
        "report has its range",
    )
    command.add_argument(
        "--tiles",
        type=partial(texturing.whole, "tiles"),
        metavar="N",
        help="with --texture: N images of that size, as UDIM tiles (OUTPUT.1001.png ...; in GLB a material for each). "
        "Default: 1; where no SIZE is given as many of 8,192 pixels as keep the scan's density",
    )
    command.add_argument(
        "--keep-materials",
        dest="materials",
        action="store_true",
        default=None,
        help="with --texture: images of its own for each of the scan's materials, OUTPUT-MATERIAL.png",
    )
    command.add_argument(
        "--crs",
        type=int,
        metavar="EPSG",
        help="the number of the scan's reference system, written to CityJSON and IFC",
    )
    command.add_argument("--recipe", type=Path, metavar="R.json", help="the steps to do, as the add-on exports them")
    return command


def names(options: Options, besides: Sequence[str] = ()) -> list[str]:
    """The fields of a class of options, in order."""
    return [field["name"] for field in options.fields() if field["name"] not in besides]


def add_fields(command: Any, options: Options, wanted: Sequence[str]) -> None:
    """A flag for each of these fields, made from the engine's table of them."""
    for field in options.fields():
        name, kind, default = field["name"], field["type"].removesuffix(" | None"), field["default"]
        if name not in wanted:
            continue
        about = getattr(options, name).__doc__.replace("%", "%%")
        flag = name.replace("_", "-")
        if kind == "bool":
            if default:
                flag, about = "no-" + flag, f"Turns off: {about}"
            action = "store_false" if default else "store_true"
            command.add_argument("--" + flag, dest=name, action=action, default=None, help=about)
            continue
        about += "" if default is None else f" Default: {default}."
        metavar = "L" if field.get("unit") == "length" else {"int": "N", "float": "X", "str": "NAME"}[kind]
        parse = {"int": int, "float": float, "str": str}[kind]
        command.add_argument("--" + flag, dest=name, type=parse, metavar=metavar, help=about)


def options_of(arguments: argparse.Namespace, kind: Options) -> Any:
    """The engine's options of this kind as the command line has them; else the recipe's, else its defaults."""
    given = {name: getattr(arguments, name) for name in names(kind) if getattr(arguments, name) is not None}
    options = kind(**_of_recipe(arguments, given)) if kind is PartitionOptions else kind()
    for name, value in given.items():
        try:
            setattr(options, name, value)
        except InvalidInput as error:
            flag = "--" + name.replace("_", "-")
            raise UsageError(str(error).replace(f"{kind.__name__}.{name}", flag)) from None
    return options


def _of_recipe(arguments: argparse.Namespace, given: dict[str, Any]) -> dict[str, Any]:
    """The recipe's options of a partition, without those that are given, and without its count if one is given."""
    if arguments.recipe is None:
        return {}
    counted = any(name in given for name in _COUNTS)
    own: dict[str, Any] = arguments.recipe.partition
    return {name: value for name, value in own.items() if name not in given and not (counted and name in _COUNTS)}


def settle(arguments: argparse.Namespace) -> None:
    """Replace what the command line gave by what the steps take: the recipe and the engine's options."""
    if arguments.run is tiles.run:
        return
    arguments.clean = options_of(arguments, CleanOptions)
    if isinstance(arguments.recipe, Path):
        try:
            arguments.recipe = recipes.read(arguments.recipe)
        except recipes.RecipeError as error:
            raise UsageError(str(error)) from None
    if arguments.recipe is not None and arguments.angle is None:
        arguments.angle = arguments.recipe.angle
    if arguments.recipe is not None and arguments.texture is None:
        arguments.texture = arguments.recipe.texture
    if arguments.recipe is not None and arguments.ao is None:
        arguments.ao = arguments.recipe.ao
    if arguments.ao is not None and arguments.texture is None:
        raise UsageError("--ao needs --texture: it is an image of the texture's material")
    if arguments.recipe is not None and arguments.height is None:
        arguments.height = arguments.recipe.height
    if arguments.even_spacing and arguments.regularise is None:
        raise UsageError("--even-spacing needs --regularise: it moves planes that are parallel by it")
    if arguments.height and arguments.texture is None:
        raise UsageError("--height needs --texture: it has the places of the texture")
    for name, flag in (("tiles", "--tiles"), ("materials", "--keep-materials")):
        if arguments.recipe is not None and getattr(arguments, name) is None:
            setattr(arguments, name, getattr(arguments.recipe, name))
        if getattr(arguments, name) and arguments.texture is None:
            raise UsageError(f"{flag} needs --texture: it says how many images the texture has")
    arguments.options = options_of(arguments, PartitionOptions)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    parsed = parser().parse_args(arguments)
    status = None
    try:
        _process.expect_interrupts()
        if isinstance(sys.stdout, io.TextIOWrapper):  # file names may be any bytes: they are written unchanged
            sys.stdout.reconfigure(errors="surrogateescape")
        settle(parsed)
        status = parsed.run(parsed)
        if sys.stdout is not None:
            sys.stdout.flush()
    except KeyboardInterrupt:
        return _say("interrupted, nothing was written", INTERRUPTED)
    except EXPECTED as error:
        return _say(*problem(error, parsed.output if parsed.run is batch.run else parsed.input))
    finally:
        _process.ignore_interrupts()
    return status if isinstance(status, int) else OK


def problem(error: Exception, path: Path) -> tuple[str, int]:
    """The line that says what is wrong with an input, and the exit status; `error` is one of EXPECTED."""
    if isinstance(error, UsageError):
        return str(error), USAGE
    if isinstance(error, FileError):  # names the file itself
        return str(error), BAD_INPUT
    if isinstance(error, OSError):
        return f"{error.filename or path}: {error.strerror or error}", BAD_INPUT
    if isinstance(error, MemoryError):
        return f"{path}: there is not enough memory for it", BAD_INPUT
    return f"{path}: {error}", BAD_INPUT


def _say(message: str, status: int) -> int:
    if sys.stderr is not None:  # it is where it was closed: then the status alone says it
        print("isimp:", " ".join(message.split()), file=sys.stderr)
    return status
