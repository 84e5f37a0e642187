"""Recipes of the add-on, applied to files: the steps that hold for every scan.

A recipe is the JSON text that the add-on exports. Steps that name faces belong to one scan, and the engine reads no
file with marks such as seams; a recipe with such a step is refused.
"""

import json
import math
import reprlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ._core import (
    CleanOptions,
    Job,
    Mesh,
    MeshingOptions,
    Partition,
    PartitionOptions,
    RegulariseOptions,
    TextureOptions,
    add_worst,
    delete_least,
    even_borders,
    improve,
    merge_cheapest,
    regularise,
)

_MOST_TIMES = 1 << 31  # that an edit may be made
VERSION = 1  #: version of recipes, as the add-on writes them
COUNTS = ("detail", "tolerance", "bound", "proxies", "triangles")  #: at most one of them gives the number of regions

_EDITS = {"add_worst": add_worst, "delete_least": delete_least, "merge_cheapest": merge_cheapest}
_OF_BLENDER = {"weights": "", "borders": "", "seams": False, "sharp": False, "materials": False, "face_sets": False}
#: Settings that steps saved by earlier versions lack, as in the add-on: a saved step has all settings of its version.
_EARLIER: dict[str, tuple[set[str], dict[str, Any]]] = {
    "partition": (
        {"seed", "leave_out"},
        {"smooth": 0.0, "close_openings": False, "stitch": 0.0, "grid": 0.0},
    ),
    "mesh": ({"chord_tolerance", "flatten"}, {"join_junctions": 0.0, "straight_rims": 0.0}),
}


class RecipeError(ValueError):
    """A recipe can't be used; the message names the step and the reason."""


@dataclass(frozen=True)
class Regularise:
    """A step that snaps planes."""

    options: RegulariseOptions
    up: tuple[float, float, float] | None  #: the upward direction, in place of options.up


@dataclass(frozen=True)
class Recipe:
    """The settings of the steps of a recipe."""

    values: dict[str, Any]  #: the recipe's JSON value
    partition: dict[str, Any]  #: options of PartitionOptions
    close_openings: bool  #: close openings that the regions can't show
    keep_openings: tuple[tuple[float, float, float], ...]  #: except the openings at these places
    angle: float | None  #: no region crosses an edge that bends by more, in degrees
    #: steps after the partition, with their times or strength, or how planes are snapped
    edits: tuple[tuple[str, float | Regularise], ...]
    meshing: dict[str, Any]  #: options of MeshingOptions
    repair: dict[str, Any]  #: of CleanOptions
    texture: int | None = None  #: keep the texture in an image of this size; 0: as dense as the scan's; None: do not
    ao: float | None = None  #: with ambient occlusion by faces up to this distance; 0: by all; None: without
    height: bool = False  #: with a height map
    tiles: int | None = None  #: images of that size; None: as many as its density needs
    materials: bool = False  #: with images for each of the scan's materials

    @property
    def regular(self) -> Regularise | None:
        """The last snapping of planes; None: there is none."""
        found = [amount for _, amount in self.edits if isinstance(amount, Regularise)]
        return found[-1] if found else None

    def edited(self, mesh: Mesh, part: Partition, job: Job | None = None, *, regularised: bool = True) -> Partition:
        """The partition after the steps that follow it. regularised: whether planes are snapped."""
        for kind, amount in self.edits:
            if isinstance(amount, Regularise):
                part = regularise(mesh, part, amount.options, job, amount.up) if regularised else part
            elif kind == "improve":
                part = improve(mesh, part, job)
            elif kind == "even_borders":
                part = even_borders(mesh, part, amount, job)
            else:
                part = _EDITS[kind](mesh, part, int(amount), job)
        return part


def read(path: Path) -> Recipe:
    """The recipe in a file. Raises RecipeError or OSError."""
    try:
        values = json.loads(path.read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:  # a UnicodeDecodeError is a ValueError
        raise RecipeError(f"{path}: is not a recipe, since it is not JSON ({error})") from None
    try:
        return parsed(values)
    except RecipeError as error:
        raise RecipeError(f"{path}: {error}") from None


def parsed(values: Any) -> Recipe:
    """The recipe in a JSON value. Raises RecipeError."""
    if not isinstance(values, dict) or "isimp_recipe" not in values or not isinstance(values.get("steps"), list):
        raise RecipeError("is not a recipe: it needs 'isimp_recipe' and the list 'steps'")
    version = values["isimp_recipe"]
    if not isinstance(version, int) or version > VERSION:
        raise RecipeError(f"the recipe has version {version!r}, this isimp reads up to {VERSION}: update isimp")
    partition: dict[str, Any] | None = None
    meshing: dict[str, Any] = {}
    meshed = False  # whether the step before makes polygons, or their texture
    angle, edits, closing = None, list[tuple[str, float | Regularise]](), True
    textured: dict[str, Any] = {}
    keep: tuple[tuple[float, float, float], ...] = ()
    repair: dict[str, Any] = {}
    for number, step in enumerate(values["steps"], 1):
        try:
            kind, settings = _settings(step)
            if not settings.pop("enabled", True):
                continue
            meshed = kind == "mesh" or (meshed and kind == "texture")
            if kind == "partition":
                closing, keep = _flag(settings, "close_openings"), _places(settings, "keep_openings")
                repair = {name: settings.pop(name) for name in ("stitch", "grid") if name in settings}
                repair = _checked(CleanOptions, repair | _found(repair, "stitch", "grid"))
                partition, angle, edits = *_partition(settings), []
            elif kind == "mesh":
                meshing = _checked(MeshingOptions, settings | _found(settings, "straight_rims"))
            elif kind == "texture":
                textured = _texture(settings, meshed)
            else:
                edits.append(_edit(kind, settings, partition is None))
        except RecipeError as error:
            raise RecipeError(f"step {number}: {error}") from None
    if partition is None:
        raise RecipeError("the recipe has no partition step")
    if not meshed:
        textured = {}
    return Recipe(values, partition, closing, keep, angle, tuple(edits), meshing, repair, **textured)


def _settings(step: Any) -> tuple[str, dict[str, Any]]:
    """The kind of a step and its settings, with their meaning when they were saved."""
    if not isinstance(step, dict) or not isinstance(step.get("step"), str):
        raise RecipeError("is not a step: it has no name 'step'")
    settings = dict(step)
    kind = settings.pop("step")
    names, meant = _EARLIER.get(kind, (set(), {}))
    return kind, (meant | settings if names <= settings.keys() else settings)


def _flag(settings: dict[str, Any], name: str) -> bool:
    """A setting that is on where it is not given."""
    value = settings.pop(name, True)
    if not isinstance(value, bool):
        raise RecipeError(f"{name} must be true or false, got {value!r}")
    return value


def _found(settings: dict[str, Any], *names: str) -> dict[str, Any]:
    """Those of some settings that are below 0: the engine finds them."""
    return {name: None for name in names if isinstance(settings.get(name), (int, float)) and settings[name] < 0}


def _places(settings: dict[str, Any], name: str) -> tuple[tuple[float, float, float], ...]:
    """A setting that is a list of places."""
    values = settings.pop(name, [])
    try:
        places = np.array(values, np.float64).reshape(-1, 3)
        fits = isinstance(values, list) and len(places) == len(values) and bool(np.isfinite(places).all())
    except (TypeError, ValueError, OverflowError):
        fits = False
    if not fits:
        raise RecipeError(f"{name} must be a list of places of three finite numbers, got {reprlib.repr(values)}")
    return tuple((float(x), float(y), float(z)) for x, y, z in places)


def _partition(settings: dict[str, Any]) -> tuple[dict[str, Any], float | None]:
    """The options of a partition step, and its angle."""
    if settings.pop("faces", ()):
        raise RecipeError("splits chosen faces of one scan, which other scans do not have; switch it off")
    for name, none in _OF_BLENDER.items():
        if settings.pop(name, none) != none:
            raise RecipeError(f"'{name}' needs marks of an object in Blender, which files do not have; clear it")
    settings.pop("influence", None)  # influence of the weights
    angle = settings.pop("angle", 180.0)
    if not _is_finite(angle) or not 0 <= angle <= 180:
        raise RecipeError(f"angle must be in [0, 180] degrees, got {reprlib.repr(angle)}")
    given = [name for name in COUNTS if settings.get(name) is not None]
    by = settings.pop("count_by", "")
    if not by and len(given) > 1:
        raise RecipeError(f"{' and '.join(given)} each set the number of regions: give one of them, or count_by")
    if by and by not in COUNTS:
        raise RecipeError(f"count_by must be one of {', '.join(COUNTS)}, got {by!r}")
    by = by or (given[0] if given else "detail")
    settings = {name: value for name, value in settings.items() if name not in COUNTS or name == by}
    settings |= _found(settings, "noise", "sharp_edges")
    return _checked(PartitionOptions, settings), angle if angle < 180 else None


def _edit(kind: str, settings: dict[str, Any], is_first: bool) -> tuple[str, float | Regularise]:
    if is_first:
        raise RecipeError("there are no regions yet: a partition step must come first")
    if kind == "regularise":
        return kind, _regularise(settings)
    if kind not in ("improve", "even_borders") and kind not in _EDITS:
        raise RecipeError(f"'{kind}' names faces of one scan, which other scans do not have; switch it off")
    strength = settings.pop("strength", 1.0) if kind == "even_borders" else 1.0
    if not _is_finite(strength) or not 0 <= strength <= 1:
        raise RecipeError(f"strength must be in [0, 1], got {reprlib.repr(strength)}")
    times = settings.pop("times", 1)
    if settings:
        raise RecipeError(f"{kind} has no setting '{next(iter(settings))}'")
    if isinstance(times, bool) or not isinstance(times, int) or not 1 <= times < _MOST_TIMES:
        raise RecipeError(f"times must be a whole number, at least 1, got {reprlib.repr(times)}")
    return kind, float(strength) if kind == "even_borders" else times


def _regularise(settings: dict[str, Any]) -> Regularise:
    """The settings of a step that snaps planes."""
    up, given = settings.pop("up", "scene"), settings.pop("direction", [])
    if up == "region":
        raise RecipeError("takes up from a region of one scan, which other scans do not have; choose an axis")
    settings.pop("face", -1)  # face of that region
    length = settings.pop("length", 0)
    direction = _direction(given) if up == "scene" and given != [] else None
    up = "z" if up == "scene" else up
    options = _checked(RegulariseOptions, settings | {"up": up, "length": None if length == 0 else length})
    return Regularise(RegulariseOptions(**options), direction)


def _is_finite(value: Any) -> bool:
    """Whether a value is a number that double precision can hold."""
    try:
        return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
    except OverflowError:
        return False


def _is_in(value: Any, field: dict[str, Any]) -> bool:
    """Whether a number is in the range of an option."""
    least: float = field["least"]
    most: float = field.get("most", math.inf)
    return (
        _is_finite(value)
        and (value > least if field["above_least"] else value >= least)
        and (value < most if field.get("below_most") else value <= most)
    )


def _direction(value: Any) -> tuple[float, float, float]:
    try:
        x, y, z = (float(number) for number in value)
        fits = isinstance(value, list) and all(map(math.isfinite, (x, y, z))) and any((x, y, z))
    except (TypeError, ValueError, OverflowError):
        fits = False
    if not fits:
        raise RecipeError(f"direction must be three finite numbers, not all 0, got {reprlib.repr(value)}")
    return x, y, z


def _texture(settings: dict[str, Any], meshed: bool) -> dict[str, Any]:
    """The texture settings of a Recipe."""
    if not meshed:
        raise RecipeError("there are no polygons yet: a mesh step must come right before")
    size, tiles = _whole(settings, "size"), _whole(settings, "tiles")
    flags = {name: settings.pop(name, False) for name in ("occlusion", "height", "materials")}
    distance = settings.pop("occlusion_distance", 0.0)
    if settings:
        raise RecipeError(f"texture has no setting '{next(iter(settings))}'")
    for name, flag in flags.items():
        if not isinstance(flag, bool):
            raise RecipeError(f"{name} must be true or false, got {flag!r}")
    if not _is_finite(distance) or distance < 0:
        raise RecipeError(f"occlusion_distance must be a finite length, at least 0, got {reprlib.repr(distance)}")
    ao = float(distance) if flags.pop("occlusion") else None
    return {"texture": size, "tiles": tiles or None, "ao": ao} | flags


def _whole(settings: dict[str, Any], name: str) -> int:
    """A whole number of TextureOptions; 0: not given."""
    value: Any = settings.pop(name, 0)
    if isinstance(value, bool) or not isinstance(value, int):
        raise RecipeError(f"{name} must be a whole number, got {value!r}")
    field = next(field for field in TextureOptions.fields() if field["name"] == name)
    if value and not field["least"] <= value <= field["most"]:
        raise RecipeError(f"{name} must be 0, or {field['range']}, got {value}")
    return value


def _checked(
    kind: type[CleanOptions] | type[PartitionOptions] | type[MeshingOptions] | type[RegulariseOptions],
    settings: dict[str, Any],
) -> dict[str, Any]:
    """The settings, if they are options of the engine and in their ranges."""
    known = {field["name"] for field in kind.fields()}
    for name in settings:
        if name not in known:
            raise RecipeError(f"has no setting '{name}'")
    try:
        kind(**settings)
    except (ValueError, TypeError) as error:  # InvalidInput is a ValueError
        raise RecipeError(str(error).splitlines()[0]) from None
    for field in kind.fields():
        value = settings.get(field["name"])
        if "least" in field and value is not None and not _is_in(value, field):
            raise RecipeError(f"{field['name']} must be {field['range']}, got {reprlib.repr(value)}")
    return settings
