"""Recipes of the add-on, done on files: their options, and the steps that need Blender.

A recipe is the JSON text that the add-on exports; `isimp_engine.recipe` reads and checks it. The engine reads no file
with marks such as seams; a recipe that needs them is refused.
"""

from os import PathLike
from pathlib import Path
from typing import Any

from . import recipe as rcp
from ._core import RegulariseOptions
from .recipe import COUNTS, Recipe, RecipeError

__all__ = ["COUNTS", "Recipe", "RecipeError"]

#: settings of a partition that refer to data of an object in Blender
_OF_BLENDER = ("weights", "borders", *rcp.MARKS)


RecipeLike = Recipe | str | PathLike[str] | dict[str, Any]


def recipe_of(given: RecipeLike) -> Recipe:
    """The recipe of a caller: in a file, or as a JSON value. Raises RecipeError or OSError."""
    if isinstance(given, Recipe):
        return _checked(given)
    return read(Path(given)) if isinstance(given, (str, PathLike)) else parsed(given)


def read(path: Path) -> Recipe:
    """The recipe in a file. Raises RecipeError or OSError."""
    try:
        return parsed(rcp.parsed(path.read_text(encoding="utf-8-sig"), "not a recipe"))
    except UnicodeDecodeError as error:
        raise RecipeError(f"{path}: not a recipe: it is not JSON ({error})") from None
    except RecipeError as error:
        raise RecipeError(f"{path}: {error}") from None


def parsed(values: Any) -> Recipe:
    """The recipe in a JSON value. Raises RecipeError."""
    return _checked(Recipe.from_values(values))


def _checked(recipe: Recipe) -> Recipe:
    """Refuse a recipe that can't be done on any file."""
    ready = meshed = False  # whether there are regions, and whether the step before makes polygons or their texture
    for index, step in recipe.active():
        ready = ready or (isinstance(step, rcp.Partition) and not step.faces)
        if why := _problem(step, ready, meshed):
            raise RecipeError(f"step {index + 1}: {why}")
        meshed = isinstance(step, rcp.Mesh) or (meshed and isinstance(step, rcp.Texture))
    if not ready:
        raise RecipeError("the recipe has no partition step")
    return recipe


def _problem(step: rcp.Step, ready: bool, meshed: bool) -> str:
    if isinstance(step, rcp.Texture) and not meshed:
        return "there are no polygons yet: a mesh step must come right before"
    if not (ready or isinstance(step, rcp.Mesh)):
        return "there are no regions yet: a partition step must come first"
    marks = [name for name in _OF_BLENDER if isinstance(step, rcp.Partition) and getattr(step, name)]
    return f"'{marks[0]}' needs marks of an object in Blender, which files do not have; clear it" if marks else ""


def options_of(recipe: Recipe) -> dict[str, Any]:
    """The options that a recipe sets, by the names of `simplify`; without the ones that the engine finds."""
    _, whole = recipe.whole()
    assert whole is not None  # checked when it was read
    found = partition_options(whole) | rcp.engine_options(whole, rcp.CLEAN)
    found |= {"keep_openings": not whole.close_openings, "keep_opening": whole.keep_openings}
    if whole.angle < 180:
        found["angle"] = whole.angle
    meshes = [step for _, step in recipe.active() if isinstance(step, rcp.Mesh)]
    if meshes:
        found |= rcp.engine_options(meshes[-1], rcp.MESHING)
    if (shown := recipe.texture()) is not None:
        ao = shown.occlusion_distance if shown.occlusion else None
        found |= {"texture": shown.size, "ao": ao, "tiles": shown.tiles or None}
        found["materials"] = shown.materials
    return {name: value for name, value in found.items() if value is not None}


def partition_options(step: rcp.Partition) -> dict[str, Any]:
    """The engine's options of a partition, with one way to choose the number of regions."""
    options = rcp.engine_options(step, rcp.PARTITION)
    return {name: value for name, value in options.items() if name not in COUNTS or name == step.count_by}


def regularise_options(recipe: Recipe) -> RegulariseOptions | None:
    """The options of the last snapping of planes; None: there is none."""
    found = [step for _, step in recipe.active() if isinstance(step, rcp.Regularise)]
    if not found:
        return None
    up = "z" if found[-1].up in ("scene", "region") else found[-1].up
    return RegulariseOptions(**rcp.engine_options(found[-1], rcp.REGULARISE) | {"up": up})
