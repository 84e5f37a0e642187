"""`simplify`: from a scan to the result of the command, as one function of Python."""

from functools import cached_property
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._core import Job, Mesh, Partition, PolygonMesh, RegulariseOptions
from .jobs import OneJob
from .marks import MARKS, marks_of
from .pipeline import Model, make_model, make_regions, require_texture
from .recipes import RecipeLike
from .settings import ANY_DISTANCE, LIKE_THE_SCAN, option_names, settings_of, without_gone
from .source import source_of
from .texturing import Texture, write_textured


class Result:
    """The result of `simplify`."""

    _model: Model
    _seconds: dict[str, float]

    @classmethod
    def _of(cls, model: Model, seconds: dict[str, float]) -> "Result":
        made = cls()
        made._model, made._seconds = model, seconds
        return made

    @property
    def polygons(self) -> PolygonMesh:
        """The polygons."""
        return self._model.polygons

    @property
    def partition(self) -> Partition:
        """The regions that the polygons were made of, for edits such as `add_proxy`."""
        return self._model.partition

    @property
    def mesh(self) -> Mesh:
        """The repaired scan, with its openings closed, that the regions are of."""
        return self._model.mesh

    @cached_property
    def labels(self) -> NDArray[np.int32]:
        """(faces,) the region of each face of the caller's scan, -1 for none. A Mesh may lack the last ones."""
        return self._model.labels()

    @property
    def texture(self) -> Texture | None:
        """The texture of the polygons; None without the option `texture`."""
        return self._model.texture

    @cached_property
    def report(self) -> dict[str, Any]:
        """Inputs, options and numbers of the result, as `isimp simplify --report` writes them."""
        return self._model.report() | {"seconds": self._seconds}

    def write(self, path: str | PathLike[str], *, job: Job | None = None) -> None:
        """Write the polygons, with their texture if there is one, as `write` and `write_textured` do."""
        if self.texture is None:
            self._model.write(path, job=job)
        else:
            write_textured(path, self.polygons, self.texture, job=job)

    def __repr__(self) -> str:
        return f"<Result: {len(self.polygons.loop_start):,} polygons of {self.partition.region_count:,} regions>"


def simplify(
    scan: Any,
    *,
    proxies: int | None = None,
    triangles: int | None = None,
    detail: float | None = None,
    tolerance: float | None = None,
    bound: float | None = None,
    planar: bool | None = None,
    regularise: float | bool | RegulariseOptions | None = None,
    scale: str | None = None,
    snap_sizes: float | str | None = None,
    curved: bool | None = None,
    texture: int | bool | None = None,
    keep_openings: bool | None = None,
    preset: str | None = None,
    recipe: RecipeLike | None = None,
    strict: bool = False,
    job: Job | None = None,
    **options: Any,
) -> Result:
    """Make polygons of a scan, bit for bit as `isimp simplify` does with the same options.

    scan: a path, `(vertices, faces)`, an object with `vertices` and `faces` or `triangles`, a TexturedSoup, or a Mesh,
    which is not repaired again. Faces are (F, 3), (F, K), or a list of faces with any number of corners.
    proxies, triangles, detail, tolerance, bound: at most one; the number of regions as in PartitionOptions.
    planar, curved: as in MeshingOptions and PartitionOptions.
    regularise: snap planes by at most this many degrees; True: by the default angle.
    scale: scale the scan by one known length: the name of a size in report["sizes"] and its true length, "3-7=40mm".
    Other lengths in the options are of the scan before.
    snap_sizes: move planes, axes and radii so that sizes are multiples of this length (1.0 in scene units; "1mm" or
    "1/16in" with `unit`) where their uncertainty allows it; report["sizes"] lists the moves. It turns on planar and
    regularise.
    texture: keep the scan's texture in an image of this size; True: as dense as the scan's. With `preset` too the
    result has none without it, while the command keeps it where OUTPUT can have one.
    keep_openings: keep all holes and handles; else the ones that the regions can't show are closed in a noisy scan.
    preset: settings for a kind of scan: "figure", "building", "room", "cad", "city", "drawn", "generated", "low_poly".
    recipe: steps that the add-on exported: a path, or the value of its JSON. Options given here come before its own.
    Clicks act at their places, so they can be done on another version of their scan.
    strict: raise InvalidInput where a click finds no face; else it is left out, and the report has it (`clicks`).
    options: all others of the command by their names (`clutter="box"`, `angle=30`, `seed=2`), every field of
    PartitionOptions, MeshingOptions and CleanOptions, and the arrays weights, borders, cuts, part and base.
    Raises InvalidInput (the scan, or options that do not fit it), FileError, RecipeError, Cancelled, or
    TypeError for an option that does not exist.
    """
    options = without_gone(options)
    if unknown := options.keys() - option_names() - MARKS:
        raise TypeError(f"simplify has no option {min(unknown)!r}; it has {', '.join(sorted(option_names() | MARKS))}")
    given = options | {
        "proxies": proxies,
        "triangles": triangles,
        "detail": detail,
        "tolerance": tolerance,
        "bound": bound,
        "planar": planar,
        "curved": curved,
        "regularise": _value(regularise, RegulariseOptions().angle),
        "scale": scale,
        "snap_sizes": snap_sizes,
        "preset": preset,
        "texture": _value(texture, LIKE_THE_SCAN),
        "ao": _value(options.get("ao"), ANY_DISTANCE),
        "keep_openings": keep_openings,
        "strict": strict,
    }
    settings = settings_of(given, recipe)
    steps = OneJob(job)
    with steps("read") as own:
        source = source_of(scan, own, settings.partition.threads, textured=settings.texture is not None)
        marks = marks_of(source, {name: options[name] for name in MARKS & options.keys()})
        if settings.texture is not None:
            require_texture(source)
    model = make_model(make_regions(source, settings, steps, marks=marks), steps)
    steps.end()
    return Result._of(model, steps.seconds)


def _value(given: Any, default: Any) -> Any:
    """A value in the place of True and False."""
    return default if given is True else None if given is False else given
