"""The settings of a simplification as typed values, made once from the options and the recipe of a caller."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from numbers import Integral, Real
from typing import Any

from . import recipe as rcp
from ._core import CleanOptions, InvalidInput, MeshingOptions, PartitionOptions, RegulariseOptions, TextureOptions
from .lengths import UNITS, length_of
from .recipe import COUNTS
from .recipe.presets import BY_NAME
from .recipes import Recipe, RecipeLike, recipe_of
from .recipes import options_of as options_of_recipe

Place = tuple[float, float, float]
Kind = type[CleanOptions] | type[MeshingOptions] | type[PartitionOptions] | type[RegulariseOptions]

LIKE_THE_SCAN = 0  #: size of a texture
ANY_DISTANCE = 0.0  #: limit of ambient occlusion
KEEP_CLUTTER, LEAVE_OUT_CLUTTER, BOX_CLUTTER = CLUTTER = ("keep", "leave-out", "box")
CHOICES = {"clutter": CLUTTER, "unit": tuple(UNITS), "preset": tuple(BY_NAME)}
#: options of an engine's class that have another name here, as another class has the name too
RENAMED: dict[tuple[Kind, str], str] = {(RegulariseOptions, "angle"): "regularise"}
_NEEDS = {
    "ao": ("texture", "it is an image of the texture's material"),
    "tiles": ("texture", "it sets the number of images of the texture"),
    "materials": ("texture", "it sets the number of images of the texture"),
    "base": ("part", "it gives the regions of the faces outside the part"),
}


class OptionError(InvalidInput):
    """Options that are wrong, contradict each other or can't be used for this scan.

    names: of the options for each {} in the text, so that the command can show its flags.
    """

    def __init__(self, text: str, *names: str) -> None:
        super().__init__(text.format(*names) if names else text)
        self._text, self._names = text, names

    def shown(self, flag: Callable[[str], str]) -> str:
        """The message with other names of the options."""
        return self._text.format(*map(flag, self._names)) if self._names else self._text


@dataclass(frozen=True)
class Texturing:
    """The texture of a result."""

    size: int  #: size of an image, pixels; LIKE_THE_SCAN: as dense as the scan's images
    tiles: int | None = None  #: number of images; None: as many as the density of the scan needs
    materials: bool = False  #: images of their own for each of the scan's materials
    occlusion: float | None = None  #: largest distance of the faces that keep light off; ANY_DISTANCE; None: no image
    needed: bool = True  #: whether a scan without a texture is refused; else the result has none
    step: Mapping[str, Any] | None = None  #: options of a recipe's texture step


@dataclass(frozen=True)
class Settings:
    """How scans are simplified: by options that hold for any scan."""

    clean: CleanOptions
    partition: PartitionOptions
    meshing: MeshingOptions
    regularise: RegulariseOptions | None  #: None: planes are snapped only as the recipe has it
    scale: (
        tuple[str, float] | None
    )  #: the name of a size and its true length in scene units; None: the scan has its own
    snap_sizes: float | None  #: step of sizes, scene units; None: they are as the recipe has it
    recipe: Recipe | None
    keep_openings: bool
    kept_places: list[Place]  #: places of openings that stay open
    clutter: str  #: one of CLUTTER: treatment of regions with many polygons
    angle: float | None  #: degrees; no region crosses an edge that bends by more
    texture: Texturing | None
    crs: int | None  #: EPSG number
    unit: str | None  #: of the scene; None: that of the file, else metres
    scanned_detail: float = 0.0  #: the detail of a preset for a scan with noise; 0: the same
    strict: bool = False  #: refuse a scan on which a click of the recipe finds no face


def names(kind: Kind, besides: tuple[str, ...] = ()) -> list[str]:
    """The fields of a class of options, in order."""
    return [field["name"] for field in kind.fields() if field["name"] not in besides]


def snapping() -> list[str]:
    """The options of `regularise` besides its angle."""
    return names(RegulariseOptions, besides=("angle", "length", "up"))


def option_names() -> frozenset[str]:
    """The names of all options of `settings_of`."""
    own = {
        "regularise",
        "scale",
        "preset",
        "snap_sizes",
        "keep_openings",
        "keep_opening",
        "clutter",
        "angle",
        "texture",
        "ao",
        "tiles",
    }
    engine = {name for kind in (PartitionOptions, CleanOptions, MeshingOptions) for name in names(kind)}
    return frozenset({"materials", "crs", "unit", "strict"} | own | engine | set(snapping()))


def without_gone(options: Mapping[str, Any]) -> dict[str, Any]:
    """The options without those of earlier versions; each that had an effect gives a warning."""
    kinds = PartitionOptions, RegulariseOptions, TextureOptions
    for kind in kinds:
        kind(**{name: options[name] for name in kind.gone() if name in options})
    return {name: value for name, value in options.items() if not any(name in kind.gone() for kind in kinds)}


def settings_of(options: Mapping[str, Any], recipe: RecipeLike | None = None) -> Settings:
    """The settings of options by their names, and a recipe, whose options come after them. None: not given.

    Raises OptionError, RecipeError or OSError.
    """
    preset = BY_NAME.get(options.get("preset") or "")
    if preset is not None and recipe is not None:
        raise OptionError("{} and {} exclude each other: a preset is a recipe", "preset", "recipe")
    recipe = preset.recipe if preset is not None else None if recipe is None else recipe_of(recipe)
    given = _with_recipe({name: value for name, value in options.items() if value is not None}, recipe)
    if (step := _step_of(given)) is not None:
        given = {"regularise": RegulariseOptions().angle} | given | {"planar": True}
    snaps = dict.fromkeys(snapping(), ("regularise", "it is about its planes"))
    for name, (needed, reason) in (_NEEDS | snaps).items():
        if given.get(name, False) is not False and needed not in given:  # 0 is a value
            raise OptionError(f"{{}} needs {{}}: {reason}", name, needed)
    for name, choices in CHOICES.items():
        if name in given and given[name] not in choices:
            raise OptionError(literal(f" must be one of {', '.join(choices)}, got {given[name]!r}"), name)
    if len(counts := [name for name in COUNTS if name in given]) > 1:
        marks = " and ".join(["{}"] * len(counts))
        raise OptionError(f"{marks} each set the number of regions: give one of them", *counts)
    angle, crs = given.get("angle"), given.get("crs")
    if angle is not None and not (isinstance(angle, Real) and 0 <= float(angle) <= 180):
        raise OptionError(literal(f" must be in [0, 180], got {angle!r}"), "angle")
    if crs is not None and not (isinstance(crs, Integral) and int(crs) > 0):
        raise OptionError(literal(f" must be the number of an EPSG reference system, got {crs!r}"), "crs")
    texture = None
    if "texture" in given:
        shown = None if recipe is None else recipe.texture()
        of_step = None if shown is None else rcp.engine_options(shown, rcp.TEXTURE)
        own = given["texture"], given.get("tiles"), bool(given.get("materials")), given.get("ao")
        texture = Texturing(*own, step=of_step)
    return Settings(
        clean=options_of(given, CleanOptions),
        partition=options_of(given, PartitionOptions),
        meshing=options_of(given, MeshingOptions),
        regularise=_snapping_of(given),
        scale=_scale_of(given, None if preset is not None else recipe),
        snap_sizes=step,
        recipe=recipe,
        keep_openings=bool(given.get("keep_openings")),
        kept_places=_places(given.get("keep_opening", ())),
        clutter=given.get("clutter", KEEP_CLUTTER),
        angle=None if angle is None else float(angle),
        texture=texture,
        crs=None if crs is None else int(crs),
        unit=given.get("unit"),
        scanned_detail=preset.scanned_detail if preset and not any(options.get(name) for name in COUNTS) else 0.0,
        strict=bool(given.get("strict")),
    )


def _places(given: Any) -> list[Place]:
    """The places of openings."""
    try:
        return [(float(x), float(y), float(z)) for x, y, z in given]
    except (TypeError, ValueError):
        raise OptionError(literal(f" must be a list of places (x, y, z), got {given!r}"), "keep_opening") from None


def with_look(settings: Settings, preset: str | None, textured: bool) -> Settings:
    """The settings for a file: with a preset it keeps the look of a scan that has one. textured: whether it can."""
    if not preset or not textured or settings.texture is not None:
        return settings
    return replace(settings, texture=Texturing(LIKE_THE_SCAN, needed=False))


def _step_of(options: Mapping[str, Any]) -> float | None:
    """The step of sizes in scene units; None: they are not snapped."""
    if (given := options.get("snap_sizes")) is None:
        return None
    if options.get("bound") is not None:
        raise OptionError("{} and {} exclude each other: planes that move may leave the bound", "snap_sizes", "bound")
    return _length(given, "snap_sizes", options)


def _scale_of(options: Mapping[str, Any], recipe: Recipe | None) -> tuple[str, float] | None:
    """The name of a size and its true length; None: the scan keeps its scale."""
    if (given := options.get("scale")) is None:
        return None
    if recipe is not None:
        raise OptionError("{} and {} exclude each other: steps have places in the scan", "scale", "recipe")
    name, _, length = str(given).rpartition("=")
    if not name:
        raise OptionError(literal(f" must be the name of a size and its length, as 3-7=40mm, got '{given}'"), "scale")
    return name.strip(), _length(length, "scale", options)


def _length(given: Any, name: str, options: Mapping[str, Any]) -> float:
    """The value of an option that is a length with a unit, in scene units."""
    unit = options.get("unit")
    try:
        return length_of(given, unit)
    except ValueError as error:
        if unit is None and str(error).endswith("needs the unit of the scene"):
            raise OptionError(literal(str(error)) + ": give {}", name, "unit") from None
        raise OptionError(literal(str(error)), name) from None


def scaled(settings: Settings, factor: float) -> Settings:
    """The settings for a scan that is larger by a factor; `scale` and `snap_sizes` are of the larger one already."""
    kinds = {name: getattr(settings, name) for name in ("clean", "partition", "meshing", "regularise")}
    larger = {name: _times(options, factor) for name, options in kinds.items() if options is not None}
    places = [(x * factor, y * factor, z * factor) for x, y, z in settings.kept_places]
    texture = settings.texture
    if texture is not None and texture.occlusion:
        texture = replace(texture, occlusion=texture.occlusion * factor)
    return replace(settings, **larger, kept_places=places, texture=texture)


def _times(options: Any, factor: float) -> Any:
    """Options with other lengths."""
    values = options.as_dict()
    names = [field["name"] for field in options.fields() if field.get("unit") == "length"]
    return type(options)(**values | {name: values[name] * factor for name in names if values[name] is not None})


def _snapping_of(options: Mapping[str, Any]) -> RegulariseOptions | None:
    given = options.get("regularise")
    if given is None or isinstance(given, RegulariseOptions):
        return given
    found: RegulariseOptions = options_of(options, RegulariseOptions)
    return found


def options_of(options: Mapping[str, Any], kind: Kind) -> Any:
    """The engine's options of this kind, with its defaults where they are not given."""
    called = {name: RENAMED.get((kind, name), name) for name in names(kind)}
    given = {name: options[option] for name, option in called.items() if option in options}
    made = kind()
    for name, value in given.items():
        try:
            setattr(made, name, value)
        except InvalidInput as error:
            raise OptionError(literal(str(error).removeprefix(f"{kind.__name__}.{name}")), called[name]) from None
    check_ranges(made)
    return made


def literal(text: str) -> str:
    """A text after the name of an option, for OptionError."""
    return "{}" + text.replace("{", "{{").replace("}", "}}")


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
            wanted = field.get("range", "a finite number").replace("a length", "a finite length")
            raise OptionError(f"{{}} must be {wanted}, got {value:g}", RENAMED.get((type(options), name), name))


def _with_recipe(given: dict[str, Any], recipe: Recipe | None) -> dict[str, Any]:
    """The options with the recipe's in the place of missing ones; a count takes the place of the recipe's."""
    if recipe is None:
        return given
    own = options_of_recipe(recipe)
    if any(name in given for name in COUNTS):
        own = {name: value for name, value in own.items() if name not in COUNTS}
    kept = [*given.get("keep_opening", ()), *own.get("keep_opening", ())]
    return own | given | {"keep_opening": kept}
