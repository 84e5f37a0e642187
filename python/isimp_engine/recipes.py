"""Recipes of the add-on, applied to files: the steps that hold for every scan.

A recipe is the JSON text that the add-on exports; `isimp_engine.recipe` reads and checks it. Steps that name faces
belong to one scan, and the engine reads no file with marks such as seams; a recipe with such a step is refused.
"""

from collections.abc import Callable
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

from . import recipe as rcp
from ._core import (
    Job,
    Mesh,
    Partition,
    RegulariseOptions,
    add_worst,
    delete_least,
    even_borders,
    improve,
    merge_cheapest,
    regularise,
)
from .recipe import COUNTS, RecipeError

__all__ = ["COUNTS", "Recipe", "RecipeError", "parsed", "read", "recipe_of"]

#: settings of a partition that refer to data of an object in Blender
_OF_BLENDER = ("weights", "borders", *rcp.MARKS)


@dataclass(frozen=True)
class Recipe:
    """The settings of the steps of a recipe."""

    values: dict[str, Any]  #: the recipe's JSON value
    partition: dict[str, Any]  #: options of PartitionOptions
    close_openings: bool  #: close openings that the regions can't show
    keep_openings: tuple[tuple[float, ...], ...]  #: except the openings at these places
    angle: float | None  #: no region crosses an edge that bends by more, in degrees
    edits: tuple[rcp.Step, ...]  #: steps after the partition
    meshing: dict[str, Any]  #: options of MeshingOptions
    repair: dict[str, Any]  #: options of CleanOptions
    texture: int | None = None  #: keep the texture in an image of this size; 0: as dense as the scan's; None: do not
    ao: float | None = None  #: with ambient occlusion by faces up to this distance; 0: by all; None: without
    height: bool = False  #: with a height map
    tiles: int | None = None  #: images of that size; None: as many as its density needs
    materials: bool = False  #: with images for each of the scan's materials

    @property
    def regular(self) -> RegulariseOptions | None:
        """The options of the last snapping of planes; None: there is none."""
        found = [step for step in self.edits if isinstance(step, rcp.Regularise)]
        return regularise_options(found[-1]) if found else None

    def edited(self, mesh: Mesh, part: Partition, job: Job | None = None, *, regularised: bool = True) -> Partition:
        """The partition after the steps that follow it. regularised: whether planes are snapped."""
        for step in self.edits:
            if regularised or not isinstance(step, rcp.Regularise):
                part = _EDITS[type(step)](step, mesh, part, job)
        return part


def regularise_options(step: rcp.Regularise) -> RegulariseOptions:
    """The engine's options of a step that snaps planes."""
    up = "z" if step.up == "scene" else step.up
    return RegulariseOptions(**rcp.engine_options(step, rcp.REGULARISE) | {"up": up})


def _regularised(step: Any, mesh: Mesh, part: Partition, job: Job | None) -> Partition:
    direction = step.direction if step.up == "scene" and step.direction else None
    return regularise(mesh, part, regularise_options(step), job, direction)


#: how each step that holds for every scan changes a partition
_EDITS: dict[type[rcp.Step], Callable[[Any, Mesh, Partition, Job | None], Partition]] = {
    rcp.AddWorst: lambda step, mesh, part, job: add_worst(mesh, part, step.times, job),
    rcp.DeleteLeast: lambda step, mesh, part, job: delete_least(mesh, part, step.times, job),
    rcp.MergeCheapest: lambda step, mesh, part, job: merge_cheapest(mesh, part, step.times, job),
    rcp.Improve: lambda step, mesh, part, job: improve(mesh, part, job),
    rcp.EvenBorders: lambda step, mesh, part, job: even_borders(mesh, part, step.strength, job),
    rcp.Regularise: _regularised,
}


def recipe_of(given: Recipe | str | PathLike[str] | dict[str, Any]) -> Recipe:
    """The recipe of a caller: in a file, or as a JSON value. Raises RecipeError or OSError."""
    if isinstance(given, Recipe):
        return given
    return read(Path(given)) if isinstance(given, (str, PathLike)) else parsed(given)


def read(path: Path) -> Recipe:
    """The recipe in a file. Raises RecipeError or OSError."""
    try:
        return parsed(rcp.parsed(path.read_text(encoding="utf-8"), "not a recipe"))
    except UnicodeDecodeError as error:
        raise RecipeError(f"{path}: not a recipe: it is not JSON ({error})") from None
    except RecipeError as error:
        raise RecipeError(f"{path}: {error}") from None


def parsed(values: Any) -> Recipe:
    """The recipe in a JSON value. Raises RecipeError."""
    made: dict[str, Any] = {}
    meshed = False  # whether the step before makes polygons, or their texture
    for index, step in rcp.Recipe.from_values(values).active():
        meshed = isinstance(step, rcp.Mesh) or (meshed and isinstance(step, rcp.Texture))
        try:
            if isinstance(step, rcp.Partition):
                made |= _partition(step, values["steps"][index])
            elif isinstance(step, rcp.Mesh):
                made["meshing"] = rcp.engine_options(step, rcp.MESHING)
            elif isinstance(step, rcp.Texture):
                made |= _texture(step, meshed)
            else:
                made["edits"] = (*_before(made, step), step)
        except RecipeError as error:
            raise RecipeError(f"step {index + 1}: {error}") from None
    if "partition" not in made:
        raise RecipeError("the recipe has no partition step")
    if not meshed:
        made = {name: value for name, value in made.items() if name not in _NO_TEXTURE}
    return Recipe(values, **{"meshing": {}} | made)


def _partition(step: rcp.Partition, values: dict[str, Any]) -> dict[str, Any]:
    """The fields of a Recipe that a partition gives. values: the step's JSON value."""
    if step.faces:
        raise RecipeError("splits chosen faces of one scan, which other scans do not have; switch it off")
    for name in _OF_BLENDER:
        if getattr(step, name):
            raise RecipeError(f"'{name}' needs marks of an object in Blender, which files do not have; clear it")
    options = rcp.engine_options(step, rcp.PARTITION)
    options = {name: value for name, value in options.items() if name not in COUNTS or name == step.count_by}
    if "adaptivity" not in values:  # the add-on's default is not the command's
        del options["adaptivity"]
    return {
        "partition": options,
        "close_openings": step.close_openings,
        "keep_openings": step.keep_openings,
        "angle": step.angle if step.angle < 180 else None,
        "repair": rcp.engine_options(step, rcp.CLEAN),
        "edits": (),
    }


def _before(made: dict[str, Any], step: rcp.Step) -> tuple[rcp.Step, ...]:
    """The steps after the partition and before this one."""
    if "partition" not in made:
        raise RecipeError("there are no regions yet: a partition step must come first")
    if type(step) not in _EDITS:
        raise RecipeError(
            f"'{rcp.KINDS[type(step)]}' names faces of one scan, which other scans do not have; switch it off"
        )
    if isinstance(step, rcp.Regularise) and step.up == "region":
        raise RecipeError("takes up from a region of one scan, which other scans do not have; choose an axis")
    edits: tuple[rcp.Step, ...] = made["edits"]
    return edits


_NO_TEXTURE = ("texture", "ao", "height", "tiles", "materials")


def _texture(step: rcp.Texture, meshed: bool) -> dict[str, Any]:
    """The fields of a Recipe that a texture gives."""
    if not meshed:
        raise RecipeError("there are no polygons yet: a mesh step must come right before")
    ao = step.occlusion_distance if step.occlusion else None
    values = (step.size, ao, step.height, step.tiles or None, step.materials)
    return dict(zip(_NO_TEXTURE, values, strict=True))
