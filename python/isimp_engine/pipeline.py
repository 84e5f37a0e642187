"""From a scan to its polygons: the one way of the command, of batches and of `simplify`."""

import json
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, fields, replace
from functools import cached_property
from os import PathLike
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from . import exporting, recipes
from . import recipe as rcp
from ._core import (
    CleanOptions,
    InvalidInput,
    Job,
    Mesh,
    Partition,
    PartitionOptions,
    PolygonMesh,
    RegulariseOptions,
    TextureOptions,
    __version__,
    _Stretch,
    expected_polygons,
    partition,
    regularise,
)
from .clutter import Clutter, clutter, without_clutter
from .guided import Guides, Part, partition_guided
from .guides import shared_edges
from .marks import MARKS, Marks, guides_of, marks_of
from .nearer import Nearer, nearer_by_bound
from .openings import Lengths, lengths_for
from .replay import Faces, edited, face_edges, placed
from .settings import (
    ANY_DISTANCE,
    BOX_CLUTTER,
    KEEP_CLUTTER,
    LIKE_THE_SCAN,
    OptionError,
    Settings,
    Texturing,
    option_names,
    settings_of,
)
from .source import Cleaned, Source, clean_mesh, close_mesh, facts, labels, source_of
from .texturing import Texture, texture, write_textured
from .within import Made, Within, polygonize_within


class Steps(Protocol):
    """Makes the job of each step of a run, in a context that lasts as long as the step."""

    def __call__(self, name: str, /) -> AbstractContextManager[Job]: ...


#: by name of a step: the share of all work that is done after its first call, its second one, and all later ones
_ENDS = {
    "read": (0.05,),
    "clean": (0.15,),
    "partition": (0.35, 0.4, 0.45),
    "regularise": (0.45,),
    "mesh": (0.5, 0.95),
    "texture": (1.0,),
}


class OneJob:
    """All steps in the job of a caller."""

    def __init__(self, job: Job | None) -> None:
        self._job, self._done = job or Job(), 0.0
        self._begun = dict.fromkeys(_ENDS, 0)
        self.seconds: dict[str, float] = {}

    @contextmanager
    def __call__(self, name: str) -> Iterator[Job]:
        begun, ends, number = time.perf_counter(), _ENDS[name], self._begun[name]
        self._begun[name] += 1
        begin, self._done = self._done, max(self._done, ends[min(number, len(ends) - 1)])
        with _Stretch(self._job, begin, self._done):
            yield self._job
        self.seconds[name] = round(self.seconds.get(name, 0.0) + time.perf_counter() - begun, 6)

    def end(self) -> None:
        with _Stretch(self._job, self._done, 1.0):
            pass


@dataclass(frozen=True, eq=False)
class Regions:
    """The regions of a scan, and the inputs that they were made of."""

    source: Source
    settings: Settings
    mesh: Mesh
    partition: Partition
    repaired: dict[str, int]
    repaired_at: dict[str, list[int]]
    closed: CleanOptions | None  #: how openings were closed; None where none were
    expected: dict[str, int]  #: estimated counts of polygons: see `expected_polygons`
    regular: RegulariseOptions | None
    made: Made | None  #: how the partition was made; None if it was edited since
    nearer: Nearer | None  #: a bound with regions nearer to a drawn model
    #: how faces that a recipe names were found: by "place" or "number", and the steps that are left out; None: no faces
    clicks: dict[str, Any] | None


@dataclass(frozen=True, eq=False)
class Model(Regions):
    """The regions of a scan, as they are after meshing, and their polygons."""

    found: Within
    clutter: list[Clutter]  #: regions that took many polygons; where the settings leave them out, they are since
    texture: Texture | None

    @property
    def polygons(self) -> PolygonMesh:
        return self.found.polygons

    @cached_property
    def surfaces(self) -> exporting.Surfaces:
        """The polygons by class: walls, roofs and others."""
        return exporting.surfaces_of(self.polygons)

    def labels(self) -> NDArray[np.int32]:
        """The region of each face of the scan, -1 for none."""
        return labels(self.source, self.mesh, self.partition.face_region)

    def write(self, path: str | PathLike[str], job: Job | None = None, **given: Any) -> dict[str, Any]:
        """Write the polygons without their texture; see `exporting.write`."""
        known: dict[str, Any] = {"surfaces": self.surfaces, "partition": self.partition, "mesh": self.mesh}
        known |= {"crs": self.settings.crs, "unit": self.settings.unit}
        return exporting.write(path, self.polygons, job, **known | given)

    def report(self) -> dict[str, Any]:
        """Inputs, settings and numbers of the result."""
        source, settings, part, closed = self.source, self.settings, self.partition, self.closed
        recipe = settings.recipe
        return {
            "isimp": __version__,
            "input": {
                "path": source.path and str(source.path),
                "vertices": len(source.vertices),
                "faces": source.faces,
                "triangles": len(source.triangles),
            },
            "repair": self.repaired,
            "repaired_at": self.repaired_at,
            "closed_below": closed.fill_holes if closed else None,
            "openings": openings_of(self.mesh),
            "mesh": facts(self.mesh),
            "options": settings.partition.as_dict()
            | {
                "clean": (closed or settings.clean).as_dict(),
                "keep_openings": settings.kept_places,
                "clutter": settings.clutter,
                "meshing": settings.meshing.as_dict(),
                "guides": {"angle": settings.angle},
                "recipe": recipe and json.loads(recipe.to_json()),
                "regularise": self.regular and self.regular.as_dict(),
            },
            "regions": part.region_count,
            "error": part.error,
            "history": part.history.tolist(),
            "partition": part.report | {"warnings": self.found.warnings},
            "curved": part.report["curved"],
            "expected": self.expected,
            "output": self.found.report,
            "nearer": self.nearer and self.nearer.as_dict(),
            "clicks": self.clicks,
            "clutter": [each.as_dict() for each in self.clutter],
            "validity": exporting.validity(self.polygons, surfaces=self.surfaces),
            "texture": self.texture and self.texture.report,
        }


def make_regions(
    source: Source, settings: Settings, steps: Steps, cleaned: Cleaned | None = None, marks: Marks | None = None
) -> Regions:
    """Repair, partition and edit, and estimate the number of polygons.

    cleaned: the repaired scan, if it is known already; a mesh caches data of a partition for the next one.
    """
    recipe, regular = settings.recipe, settings.regularise
    replay = Replay(source, settings, steps, marks or Marks())
    state = replay.partitioned(cleaned) if recipe is None else replay.replayed(recipe, cleaned)
    (mesh, repaired, repaired_at), part, made = state.cleaned, state.partition, state.made
    if regular is not None:
        with steps("regularise") as job, refused():
            part, made = regularise(mesh, part, regular, job), None
    elif recipe is not None:
        regular = recipes.regularise_options(recipe)
    with steps("partition") as job:
        nearer = nearer_by_bound(mesh, part, made, job) if made else None
    with steps("mesh") as job:
        expected = expected_polygons(mesh, part, settings.meshing, job)
    known = (repaired, repaired_at, state.closed, expected, regular, made, nearer)
    return Regions(source, settings, mesh, part, *known, replay.clicks)


def make_model(regions: Regions, steps: Steps) -> Model:
    """The polygons of regions, without clutter and with a texture where the settings ask for that."""
    source, settings, mesh = regions.source, regions.settings, regions.mesh
    with steps("mesh") as job:
        found = polygonize_within(mesh, regions.partition, settings.meshing, job, regions.made)
    many, shown = clutter(found.polygons), None
    if many and settings.clutter != KEEP_CLUTTER:
        with steps("mesh") as job, refused():
            part = without_clutter(mesh, found.partition, many, settings.clutter == BOX_CLUTTER)
            found = polygonize_within(mesh, part, settings.meshing, job)
    if settings.texture is not None:
        with steps("texture") as job, refused():  # for example, there are too many charts for its size
            shown = _textured(settings.texture, source, mesh, found, settings.partition.threads, job)
    own = {each.name: getattr(regions, each.name) for each in fields(regions)}
    return Model(**own | {"partition": found.partition}, found=found, clutter=many, texture=shown)


@contextmanager
def refused() -> Iterator[None]:
    """Reports an error of the engine as an error of the options, since the mesh is sound at this point."""
    try:
        yield
    except InvalidInput as error:
        raise OptionError(str(error)) from None


@dataclass(frozen=True, eq=False)
class State:
    """A partition on its way through the steps of a recipe."""

    cleaned: Cleaned
    closed: CleanOptions | None
    partition: Partition
    made: Made | None  #: how the partition was made; None after an edit, as another partition would lose it


class Replay:
    """Makes the partition of a scan, and does the steps of a recipe."""

    def __init__(self, source: Source, settings: Settings, steps: Steps, marks: Marks) -> None:
        self._source, self._settings, self._steps, self._marks = source, settings, steps, marks
        self.clicks: dict[str, Any] | None = None  #: how faces of a recipe were found; None without any
        self._known: Faces | None = None  #: of the last mesh

    def partitioned(self, cleaned: Cleaned | None, settings: Settings | None = None) -> State:
        """Repair and partition."""
        settings = settings or self._settings
        meshes = _Meshes(self._source, settings, self._steps, cleaned)

        def guided(mesh: Mesh, job: Job) -> tuple[Guides, Part | None]:
            return guides_of(self._marks, settings.angle, self._source, mesh, job), None

        closes = _closes_openings(settings, self._source)
        part, made = split(meshes, settings.partition, closes, self._steps, guided)
        assert meshes.cleaned is not None  # opened by now
        return State(meshes.cleaned, meshes.options, part, made)

    def replayed(self, recipe: rcp.Recipe, cleaned: Cleaned | None) -> State:
        """Do the steps of a recipe, with its faces at their places in this scan."""
        named, by_number = recipe.faces(), recipe.places is None
        recipe, lost = placed(recipe, self._source.surface)
        if named:
            self.clicks = {"by": "number" if by_number else "place", "lost": []}
        for index in lost:
            self._lose(index, recipe.steps[index], "no face of this scan is near its place and faces its way")
        whole, _ = recipe.whole()
        others: tuple[type[rcp.Step], ...] = (rcp.Mesh, rcp.Texture)
        if self._settings.regularise is not None:
            others = (*others, rcp.Regularise)
        # The last partition of all faces replaces all regions except locked ones.
        first = 0 if recipe.locks_before(whole) else whole
        state = None
        for index, step in recipe.active():
            if index < first or isinstance(step, others):
                continue
            try:
                state = self._done(step, index == whole, state, cleaned)
            except OptionError as error:
                if index == whole:
                    raise
                if state is None or not rcp.faces_of(step):
                    raise OptionError(f"step {index + 1}: {error}") from None
                self._lose(index, step, str(error))
        assert state is not None  # there is a partition of all faces
        return state

    def _lose(self, index: int, step: rcp.Step, why: str) -> None:
        if self._settings.strict:
            raise OptionError(f"step {index + 1}: {why}")
        assert self.clicks is not None  # the step names faces
        self.clicks["lost"].append({"step": index + 1, "kind": rcp.KINDS[type(step)], "why": why})

    def _done(self, step: rcp.Step, is_last: bool, state: State | None, cleaned: Cleaned | None) -> State:
        """The state after a step. is_last: of the partition of all faces that the options belong to."""
        if isinstance(step, rcp.Partition):
            settings = self._settings if is_last else self._settings_of(step)
            if state is None or not (step.faces or state.partition.region_locked.any()):
                return self.partitioned(cleaned if state is None else None, settings)
            return self._parted(step, settings, state)
        assert state is not None
        with self._steps("partition") as job, self._faces(state) as faces:
            part = edited(rcp.KINDS[type(step)], step, faces, state.partition, job)
        return replace(state, partition=part, made=None)

    def _parted(self, step: rcp.Partition, settings: Settings, state: State) -> State:
        """The state after a partition that keeps some regions, on the same mesh."""
        mesh, marks = state.cleaned[0], replace(self._marks, part=None, base=None)
        with self._steps("partition") as job, self._faces(state) as faces:
            own = guides_of(marks, settings.angle, self._source, mesh, job)
            chosen = faces.triangles_at(step.faces) if step.faces else None
            own = replace(own, faces=chosen, before=state.partition)
            part = partition_guided(mesh, settings.partition, job, own)
        return replace(state, partition=part, made=Made(settings.partition, own))

    def _settings_of(self, step: rcp.Partition) -> Settings:
        """The settings of a partition that is not the last one of all faces."""
        known = self._settings.partition
        own = recipes.partition_options(step) | {"threads": known.threads, "backend": known.backend}
        clean = self._settings.clean.as_dict() | rcp.engine_options(step, rcp.CLEAN)
        return replace(
            self._settings,
            partition=PartitionOptions(**own),
            clean=CleanOptions(**clean),
            keep_openings=not step.close_openings,
            kept_places=[(x, y, z) for x, y, z in step.keep_openings],
            angle=step.angle if step.angle < 180 else None,
        )

    @contextmanager
    def _faces(self, state: State) -> Iterator[Faces]:
        """The faces of the scan for a step; an error becomes one of the options, with the numbers of these faces."""
        mesh, surface = state.cleaned[0], self._source.surface
        if self._known is None or self._known.mesh is not mesh:
            self._known = Faces(mesh, self._source.polygon, surface.count, surface.vertices, self._edges)
        try:
            yield self._known
        except InvalidInput as error:
            raise OptionError(self._known.named(str(error))) from None
        except ValueError as error:  # it names faces of the scan
            raise OptionError(str(error)) from None

    def _edges(self) -> tuple[NDArray[Any], NDArray[Any]]:
        surface = self._source.surface
        pairs, ends = face_edges(shared_edges(surface.triangles), surface.face)
        known = (pairs >= 0).all(axis=1)
        return pairs[known], ends[known]


def _closes_openings(settings: Settings, source: Source) -> bool:
    """False if the user has chosen openings, and with a bound: a bound is a promise for each vertex of the scan."""
    clean = settings.clean
    given = max(clean.fill_holes, clean.fill_flat_holes, clean.cut_handles) > 0
    given = given or (source.mesh is not None and bool(source.mesh.openings))
    return not (settings.keep_openings or given or settings.partition.bound)


class Meshes(Protocol):
    """The repaired mesh of a scan."""

    def opened(self) -> Mesh:
        """The mesh with its openings as they are."""

    def closed(self, lengths: Lengths) -> Mesh:
        """The mesh with its openings closed up to these lengths, in the place of the other one."""


def split(
    meshes: Meshes,
    options: PartitionOptions,
    closes: bool,
    steps: Steps,
    guided: Callable[[Mesh, Job], tuple[Guides, Part | None]],
) -> tuple[Partition, Made]:
    """The partition of a scan, for the command and the add-on.

    Openings are closed for a guessed number of regions, and again where it is wrong.
    closes: whether they are closed at all. guided: makes the guides of a mesh, and its part if that is known.
    """
    regions = options.proxies
    while True:
        lengths, mesh = Lengths(), meshes.opened()
        if closes:
            with steps("clean") as job, refused():
                lengths = _lengths(mesh, options, regions, job)
            if lengths:
                mesh = meshes.closed(lengths)
        with steps("partition") as job, refused():
            own, part = guided(mesh, job)
            found = partition_guided(mesh, options, job, own, part)
        if lengths.hold_for(found.region_count):
            return found, Made(options, own, part)
        regions = found.region_count
        del mesh, own, part, found  # their memory is needed


class _Meshes:
    """The meshes of a source; one of them is kept at a time, for its memory."""

    def __init__(self, source: Source, settings: Settings, steps: Steps, cleaned: Cleaned | None) -> None:
        self._source, self._settings, self._steps = source, settings, steps
        self.cleaned = cleaned
        self.options: CleanOptions | None = None  #: how openings were closed; None where none were

    def opened(self) -> Mesh:
        if self.options is not None:
            self.cleaned = self.options = None
        with self._steps("clean") as job:
            keep = self._settings.kept_places
            self.cleaned = self.cleaned or clean_mesh(self._source, self._settings.clean, job, keep)
        return self.cleaned[0]

    def closed(self, lengths: Lengths) -> Mesh:
        assert self.cleaned is not None  # opened before
        self.options = CleanOptions(**self._settings.clean.as_dict() | lengths.options())
        with self._steps("clean") as job:
            keep = self._settings.kept_places
            self.cleaned = close_mesh(self._source, self.cleaned, self.options, lengths, job, keep)
        return self.cleaned[0]


def _lengths(mesh: Mesh, options: PartitionOptions, regions: int | None, job: Job) -> Lengths:
    """The lengths up to which openings are closed. regions: their number; None or 0: the partition finds it."""
    return lengths_for(mesh, options, regions or None, lambda: partition(mesh, options, job).region_count, job)


def openings_of(mesh: Mesh) -> list[dict[str, Any]]:
    """The openings of a repaired mesh for the report, the longest first."""
    names = ("kind", "kept", "center", "length")
    found = [{name: opening[name] for name in names} for opening in mesh.openings]
    return sorted(found, key=lambda opening: -opening["length"])


def require_texture(source: Source) -> None:
    """Raises InvalidInput for a scan without a texture."""
    if source.soup is None or not source.soup.has_texture:
        raise InvalidInput(
            "has neither an image nor colours, so there is no texture to keep; leave out the option "
            "`texture`, or the recipe's texture step"
        )


def _textured(wanted: Texturing, source: Source, mesh: Mesh, found: Within, threads: int, job: Job) -> Texture:
    assert source.soup is not None  # see require_texture
    options = TextureOptions(
        size=wanted.size or None,
        tiles=wanted.tiles,
        materials=wanted.materials,
        height=wanted.height,
        occlusion=wanted.occlusion is not None,
        occlusion_distance=wanted.occlusion or None,
        threads=threads,
    )
    return texture(mesh, found.partition, found.polygons, source.soup, options, job)


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

    @property
    def labels(self) -> NDArray[np.int32]:
        """(faces,) the region of each face of the caller's scan, -1 for none."""
        return self._model.labels()

    @property
    def texture(self) -> Texture | None:
        """The texture of the polygons; None without the option `texture`."""
        return self._model.texture

    @cached_property
    def report(self) -> dict[str, Any]:
        """Inputs, options and numbers of the result, as `isimp simplify --report` writes them."""
        return self._model.report() | {"seconds": self._seconds}

    def write(self, path: str | PathLike[str], job: Job | None = None) -> None:
        """Write the polygons, with their texture if there is one, as `write` and `write_textured` do."""
        if self.texture is None:
            self._model.write(path, job)
        else:
            write_textured(path, self.polygons, self.texture, job)

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
    planar: bool = False,
    regularise: float | bool | RegulariseOptions | None = None,
    curved: bool = False,
    texture: int | bool | None = None,
    keep_openings: bool = False,
    recipe: recipes.Recipe | str | PathLike[str] | dict[str, Any] | None = None,
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
    texture: keep the scan's texture in an image of this size; True: as dense as the scan's.
    keep_openings: keep all holes and handles; else the ones that the regions can't show are closed in a noisy scan.
    recipe: steps that the add-on exported: a path, or the value of its JSON. Options given here come before its own.
    Clicks act at their places, so they can be done on another version of their scan.
    strict: raise InvalidInput where a click finds no face; else it is left out, and the report has it (`clicks`).
    options: all others of the command by their names (`clutter="box"`, `angle=30`, `seed=2`), every field of
    PartitionOptions, MeshingOptions and CleanOptions, and the arrays weights, borders, cuts, part and base.
    Raises InvalidInput (the scan, or options that do not fit it), FileError, recipes.RecipeError, Cancelled, or
    TypeError for an option that does not exist.
    """
    if unknown := options.keys() - option_names() - MARKS:
        raise TypeError(f"simplify has no option {min(unknown)!r}; it has {', '.join(sorted(option_names() | MARKS))}")
    given = options | {
        "proxies": proxies,
        "triangles": triangles,
        "detail": detail,
        "tolerance": tolerance,
        "bound": bound,
        "planar": planar or None,
        "curved": curved or None,
        "regularise": _value(regularise, RegulariseOptions().angle),
        "texture": _value(texture, LIKE_THE_SCAN),
        "ao": _value(options.get("ao"), ANY_DISTANCE),
        "keep_openings": keep_openings,
        "strict": strict,
    }
    settings = settings_of(given, None if recipe is None else recipes.recipe_of(recipe))
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
