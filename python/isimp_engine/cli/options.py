"""The options of `isimp simplify`, which batches take too: flags made from the engine's table, and their values."""

import argparse
import copy
import math
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from .. import CleanOptions, InvalidInput, MeshingOptions, PartitionOptions, RegulariseOptions, recipes
from ..exporting import UNITS
from . import closing, guiding, texturing
from .errors import UsageError
from .settings import GuideFiles, Settings, Texturing

Options = type[CleanOptions] | type[MeshingOptions] | type[PartitionOptions] | type[RegulariseOptions]
_COUNTS = tuple(recipes.COUNTS)  # at most one of them
# Flags whose length may be left out, and the value of the flag alone.
_BARE: dict[str, float | None] = {"sharp_edges": 0.0, "stitch": None, "straight_rims": None}
_SHARED = ("threads",)  # one flag for all steps
_OF_RECIPE = ("angle", "texture", "ao", "height", "tiles", "materials")  # taken from the recipe where not given
_NEEDS = {
    "ao": ("--ao", "texture", "it is an image of the texture's material"),
    "height": ("--height", "texture", "it has the places of the texture"),
    "tiles": ("--tiles", "texture", "it sets the number of images of the texture"),
    "materials": ("--keep-materials", "texture", "it sets the number of images of the texture"),
}
#: options of an engine's class whose flag has another name
_FLAGS: dict[tuple[Options, str], str] = {(RegulariseOptions, "angle"): "regularise"}


KEEP_CLUTTER, LEAVE_OUT_CLUTTER, BOX_CLUTTER = CLUTTER = ("keep", "leave-out", "box")
_CHOICES = {"clutter": CLUTTER, "unit": tuple(UNITS)}


def simplify_options() -> argparse.ArgumentParser:
    """The options that apply to any scan, for all commands that simplify."""
    command = argparse.ArgumentParser(add_help=False)
    add_fields(command.add_mutually_exclusive_group(), PartitionOptions, _COUNTS)
    add_fields(command, PartitionOptions, names(PartitionOptions, besides=_COUNTS))
    add_fields(command, CleanOptions, names(CleanOptions, besides=_SHARED))
    command.add_argument(
        "--keep-openings",
        action="store_true",
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
    add_fields(command, MeshingOptions, ("planar", "straight_rims"))
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
    add_fields(command, RegulariseOptions, _snapping())
    command.add_argument(
        "--texture",
        type=partial(texturing.whole, "size"),
        nargs="?",
        const=texturing.LIKE_THE_SCAN,
        metavar="SIZE",
        help="keep the scan's texture in an image of SIZE x SIZE pixels; without SIZE: as dense as the scan's images. "
        "OUTPUT.obj has the files OUTPUT.mtl, OUTPUT.png and OUTPUT_normal.png; OUTPUT.glb contains all",
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
    command.add_argument("--unit", choices=UNITS, default="m", help="unit of the scene in STEP. Default: %(default)s")
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
        parse = _grid if name == "grid" else {"int": int, "float": float, "str": str}[kind]
        metavar = "auto|off|L" if name == "grid" else metavar
        bare = {"nargs": "?", "const": _BARE[name]} if name in _BARE else {}
        command.add_argument("--" + flag, dest=name, type=parse, metavar=metavar, help=about, **bare)


def _grid(text: str) -> float | None:
    """auto, off, or the length of a cell."""
    return None if text == "auto" else 0.0 if text == "off" else float(text)


_grid.__name__ = "grid: auto, off or a length"  # in argparse's message


def _snapping() -> list[str]:
    """The options of `--regularise` that have flags of their own."""
    return names(RegulariseOptions, besides=("angle", "length", "up"))


def options_of(arguments: argparse.Namespace, recipe: recipes.Recipe | None, kind: Options) -> Any:
    """The engine's options of this kind as the command line has them; else the recipe's, else its defaults."""
    values = {name: getattr(arguments, _FLAGS.get((kind, name), name), None) for name in names(kind)}
    given = {name: value for name, value in values.items() if value is not None}
    options = kind(**_of_recipe(recipe, kind, given))
    for name, value in given.items():
        try:
            setattr(options, name, value)
        except InvalidInput as error:
            flag = "--" + _FLAGS.get((kind, name), name).replace("_", "-")
            raise UsageError(str(error).replace(f"{kind.__name__}.{name}", flag)) from None
    check_ranges(options)
    return options


def check_ranges(options: Any) -> None:
    """Check the numbers of an engine's options before the work. All must be finite: reports are JSON."""
    values = options.as_dict()
    for field in options.fields():
        name, value = field["name"], values[field["name"]]
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            continue
        low, high = field.get("least"), field.get("most")
        fits = math.isfinite(value)
        fits = fits and (low is None or (value > low if field.get("above_least") else value >= low))
        fits = fits and (high is None or (value < high if field.get("below_most") else value <= high))
        if not fits:
            flag = "--" + _FLAGS.get((type(options), name), name).replace("_", "-")
            wanted = field.get("range", "a finite number").replace("a length", "a finite length")
            raise UsageError(f"{flag} must be {wanted}, got {value:g}")


def _of_recipe(recipe: recipes.Recipe | None, kind: Options, given: dict[str, Any]) -> dict[str, Any]:
    """The recipe's options of this kind, without the given ones, and without its count if a count is given."""
    if recipe is None or kind is RegulariseOptions:  # with --regularise the recipe's planes are not snapped
        return {}
    own = {CleanOptions: recipe.repair, MeshingOptions: recipe.meshing, PartitionOptions: recipe.partition}[kind]
    counted = any(name in given for name in _COUNTS)
    return {name: value for name, value in own.items() if name not in given and not (counted and name in _COUNTS)}


def recipe_of(arguments: argparse.Namespace) -> recipes.Recipe | None:
    """Read the recipe of the command line."""
    if arguments.recipe is None:
        return None
    try:
        return recipes.read(arguments.recipe)
    except recipes.RecipeError as error:
        raise UsageError(str(error)) from None


def settings_of(arguments: argparse.Namespace, recipe: recipes.Recipe | None) -> Settings:
    """The settings of a command line and its recipe. Nothing else reads the arguments of `simplify_options`."""
    given = copy.copy(arguments)
    for name in _OF_RECIPE if recipe is not None else ():
        if getattr(given, name) is None:
            setattr(given, name, getattr(recipe, name))
    snapping = {name: ("--" + name.replace("_", "-"), "regularise", "it is about its planes") for name in _snapping()}
    for name, (flag, needed, reason) in (_NEEDS | snapping).items():
        value = getattr(given, name)
        if value is not None and value is not False and getattr(given, needed) is None:  # 0 is a value
            raise UsageError(f"{flag} needs --{needed}: {reason}")
    for name, choices in _CHOICES.items():  # a batch from Python does not pass them through argparse
        if (value := getattr(given, name)) not in choices:
            raise UsageError(f"--{name} must be one of {', '.join(choices)}, got {value!r}")
    if given.angle is not None and not 0 <= given.angle <= 180:
        raise UsageError(f"--angle must be in [0, 180], got {given.angle:g}")
    of_recipe = [(x, y, z) for x, y, z in recipe.keep_openings] if recipe is not None else []
    texture = None
    if given.texture is not None:
        texture = Texturing(given.texture, given.tiles, bool(given.materials), bool(given.height), given.ao)
    return Settings(
        clean=options_of(given, recipe, CleanOptions),
        partition=options_of(given, recipe, PartitionOptions),
        meshing=options_of(given, recipe, MeshingOptions),
        regularise=None if given.regularise is None else options_of(given, recipe, RegulariseOptions),
        recipe=recipe,
        keep_openings=given.keep_openings,
        kept_places=(given.keep_opening or []) + of_recipe,
        clutter=given.clutter,
        angle=given.angle,
        texture=texture,
        crs=given.crs,
        unit=given.unit,
    )


def guide_files(arguments: argparse.Namespace) -> GuideFiles:
    return GuideFiles(**{name: getattr(arguments, name) for name in guiding.FILES})
