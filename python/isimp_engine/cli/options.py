"""The options of `isimp simplify`, which batches take too: flags made from the engine's table, and their values."""

import argparse
import sys
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from .. import CleanOptions, MeshingOptions, PartitionOptions, RegulariseOptions, TextureOptions, recipes, settings
from ..lengths import UNITS
from ..settings import ANY_DISTANCE, CHOICES, CLUTTER, LIKE_THE_SCAN, Kind, OptionError, Settings, names, snapping
from . import closing, guiding, texturing
from .errors import UsageError, flag

_COUNTS = tuple(recipes.COUNTS)  # at most one of them
# Flags whose length may be left out, and the value of the flag alone.
_BARE: dict[str, float | None] = {"sharp_edges": 0.0, "stitch": None, "straight_rims": None}
LIMITS = "limits"  #: attribute of an argparse.Action with a range; see `set_limits`
_SHARED = ("threads",)  # one flag for all steps


def simplify_options() -> argparse.ArgumentParser:
    """The options that apply to any scan, for all commands that simplify."""
    command = argparse.ArgumentParser(add_help=False)
    add_fields(command.add_mutually_exclusive_group(), PartitionOptions, _COUNTS)
    add_fields(command, PartitionOptions, names(PartitionOptions, besides=_COUNTS))
    add_fields(command, CleanOptions, names(CleanOptions, besides=_SHARED))
    command.add_argument(
        "--keep-openings",
        action="store_true",
        default=None,
        help="keep all holes and handles; else those that the regions can't show are closed in a noisy scan",
    )
    command.add_argument(
        "--keep-opening",
        type=closing.place,
        action="append",
        metavar="X,Y,Z",
        help="keep the hole or handle at this place open; the report lists the places (may be given several times)",
    )
    guiding.add_angle(command)
    add_fields(command, MeshingOptions, ("planar", "planar_reach", "convex", "straight_rims"))
    command.add_argument(
        "--clutter",
        choices=CLUTTER,
        default=CLUTTER[0],
        help="the treatment of regions that take more than 8 polygons each, such as foliage: they are kept, left out, "
        "or boxes replace them. Default: %(default)s",
    )
    turned = "snap planes: level, upright, parallel, coplanar; each turns by at most ANGLE degrees. Default: %(const)s"
    angle = RegulariseOptions().angle
    command.add_argument("--regularise", type=float, nargs="?", const=angle, metavar="ANGLE", help=turned)
    add_fields(command, RegulariseOptions, snapping())
    command.add_argument(
        "--scale",
        metavar="NAME=LENGTH",
        help="scale the scan by one known length, as 3-7=40mm: NAME is a size of sizes.csv or of the report (3-7: the "
        "distance of the regions 3 and 7, D1: the diameter of round part 1). Other lengths in options are of the scan "
        "before",
    )
    command.add_argument(
        "--snap-sizes",
        metavar="STEP",
        help="move planes, axes and radii so that distances and diameters are multiples of STEP (1mm, .5mm, 1/16in "
        "with --unit, or a number of scene units) and angles of 5 degrees, where the uncertainty of a size reaches "
        "there and is at most a tenth of the step. It turns on --planar and --regularise",
    )
    for kind in (PartitionOptions, RegulariseOptions, TextureOptions):
        _add_gone(command, kind)
    command.add_argument(
        "--texture",
        type=partial(texturing.whole, "size"),
        nargs="?",
        const=LIKE_THE_SCAN,
        metavar="SIZE",
        help="keep the scan's texture in an image of SIZE x SIZE pixels; without SIZE: as dense as the scan's images. "
        "OUTPUT.obj has the files OUTPUT.mtl, OUTPUT.png and OUTPUT_normal.png, OUTPUT.gltf has images "
        "beside it, OUTPUT.glb contains all",
    )
    command.add_argument(
        "--ao",
        type=texturing.distance,
        nargs="?",
        const=ANY_DISTANCE,
        metavar="DISTANCE",
        help="with --texture: an image of ambient occlusion by the scan's faces up to DISTANCE away, in scene units; "
        "without DISTANCE: by all",
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
    command.add_argument(
        "--unit",
        choices=tuple(UNITS),
        help="unit of the scene: of STEP and 3MF, and for lengths with a unit. IFC, CityJSON, DXF, IDF and HBJSON are "
        "in metres, so their coordinates are converted. Default: that of a 3MF file, else m",
    )
    command.add_argument(
        "--preset",
        choices=CHOICES["preset"],
        help="settings for a kind of scan, as in the add-on's panel; options given beside it come first. A texture or "
        "colours of the scan are kept in GLB, glTF and OBJ",
    )
    command.add_argument("--recipe", type=Path, metavar="R.json", help="the steps to do, as the add-on exports them")
    command.add_argument(
        "--strict", action="store_true", help="refuse a scan on which a click of the recipe finds no face"
    )
    return command


def add_fields(command: Any, options: Kind, wanted: Sequence[str]) -> None:
    """A flag for each of these fields, made from the engine's table of them."""
    for field in options.fields():
        name, kind, default = field["name"], field["type"].removesuffix(" | None"), field["default"]
        if name not in wanted:
            continue
        about = getattr(options, name).__doc__.replace("%", "%%")
        word = name.replace("_", "-")
        if kind == "bool":
            if default:
                word, about = "no-" + word, f"Turns off: {about}"
            action = "store_false" if default else "store_true"
            command.add_argument("--" + word, dest=name, action=action, default=None, help=about)
            continue
        about += "" if default is None else f" Default: {default}."
        metavar = "L" if field.get("unit") == "length" else {"int": "N", "float": "X", "str": "NAME"}[kind]
        parse = _grid if name == "grid" else {"int": int, "float": float, "str": str}[kind]
        metavar = "auto|off|L" if name == "grid" else metavar
        bare = {"nargs": "?", "const": _BARE[name]} if name in _BARE else {}
        made = command.add_argument("--" + word, dest=name, type=parse, metavar=metavar, help=about, **bare)
        set_limits(made, field)


def set_limits(option: argparse.Action, field: Mapping[str, Any]) -> None:
    """The range and the words of an option for `isimp schema`. field: with the keys of `fields()`."""
    setattr(option, LIMITS, field)


def take_limits(command: argparse.ArgumentParser, options: Kind) -> None:
    """The options of a command have the ranges of the fields with their names."""
    fields = {field["name"]: field for field in options.fields()}
    for option in command._actions:
        if option.dest in fields:
            set_limits(option, fields[option.dest])


class _Gone(argparse.Action):
    """An option of an earlier version: it has no effect, with a message on stderr."""

    def __call__(self, parser: Any, namespace: Any, values: Any, option_string: str | None = None) -> None:
        print(f"isimp: {option_string} has no effect: this version does not have it", file=sys.stderr)


def _add_gone(command: Any, options: Kind | type[TextureOptions]) -> None:
    for name, without in options.gone().items():
        count = 0 if isinstance(without, bool) else None
        command.add_argument("--" + name.replace("_", "-"), action=_Gone, nargs=count, help=argparse.SUPPRESS)


def _grid(text: str) -> float | None:
    """auto, off, or the length of a cell."""
    return None if text == "auto" else 0.0 if text == "off" else float(text)


_grid.__name__ = "grid: auto, off or a length"  # in argparse's message


def settings_of(options: Mapping[str, Any], recipe: recipes.RecipeLike | None) -> Settings:
    """The settings of a command line and its recipe. Nothing else reads the arguments of `simplify_options`."""
    try:
        return settings.settings_of(options, recipe)
    except OptionError as error:
        raise UsageError(error.shown(flag)) from None
    except recipes.RecipeError as error:
        raise UsageError(str(error)) from None
