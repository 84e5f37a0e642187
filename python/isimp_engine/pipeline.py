"""From a scan to its polygons: the one way of the command and of batches."""

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, fields
from functools import cached_property
from os import PathLike
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from . import exporting
from ._core import (
    CleanOptions,
    InvalidInput,
    Job,
    Mesh,
    Partition,
    PolygonMesh,
    RegulariseOptions,
    TextureOptions,
    __version__,
    expected_polygons,
    partition,
    regularise,
)
from .clutter import Clutter, clutter, without_clutter
from .guided import Guides, partition_guided
from .marks import Marks, guides_of
from .nearer import Nearer, nearer_by_bound
from .openings import Lengths, lengths_for
from .settings import (
    BOX_CLUTTER,
    KEEP_CLUTTER,
    OptionError,
    Settings,
    Texturing,
)
from .source import Cleaned, Source, clean_mesh, close_mesh, facts, labels
from .texturing import Texture, texture
from .within import Made, Within, polygonize_within


class Steps(Protocol):
    """Makes the job of each step of a run, in a context that lasts as long as the step."""

    def __call__(self, name: str, /) -> AbstractContextManager[Job]: ...


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
                "recipe": recipe and recipe.values,
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
    (mesh, repaired, repaired_at), closed, own, part = _partition(source, settings, marks, steps, cleaned)
    if recipe:
        with steps("partition") as job, refused():
            part = recipe.edited(mesh, part, job, regularised=regular is None)
    if regular is not None:
        with steps("regularise") as job, refused():
            part = regularise(mesh, part, regular, job)
    elif recipe is not None and recipe.regular is not None:
        regular = recipe.regular
    # Another partition would lose edits and planes.
    edited = regular is not None or (recipe is not None and recipe.edits)
    made = None if edited else Made(settings.partition, own)
    with steps("partition") as job:
        nearer = nearer_by_bound(mesh, part, made, job) if made else None
    with steps("mesh") as job:
        expected = expected_polygons(mesh, part, settings.meshing, job)
    return Regions(source, settings, mesh, part, repaired, repaired_at, closed, expected, regular, made, nearer)


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


def _partition(
    source: Source, settings: Settings, marks: Marks | None, steps: Steps, cleaned: Cleaned | None
) -> tuple[Cleaned, CleanOptions | None, Guides, Partition]:
    """Repair and partition. Openings are closed for a guessed number of regions, and again where it is wrong."""
    options, keep, regions = settings.partition, settings.kept_places, settings.partition.proxies
    while True:
        lengths, closed = Lengths(), None
        with steps("clean") as job:
            cleaned = cleaned or clean_mesh(source, settings.clean, job, keep)
            if _closes_openings(settings):
                with refused():
                    lengths = _lengths(cleaned[0], settings, regions, job)
                if lengths:
                    closed = CleanOptions(**settings.clean.as_dict() | lengths.options())
                    cleaned = close_mesh(source, cleaned, closed, lengths, job, keep)
        with steps("partition") as job, refused():
            own = guides_of(marks or Marks(), settings.angle, source, cleaned[0], job)
            found = partition_guided(cleaned[0], options, job, own)
        if lengths.hold_for(found.region_count):
            return cleaned, closed, own, found
        regions = found.region_count
        cleaned = None
        del own, found  # their memory is needed


def _closes_openings(settings: Settings) -> bool:
    """False if the user has chosen openings, and with a bound: a bound is a promise for each vertex of the scan."""
    kept = settings.keep_openings or (settings.recipe is not None and not settings.recipe.close_openings)
    clean = settings.clean
    given = max(clean.fill_holes, clean.fill_flat_holes, clean.cut_handles) > 0
    return not (kept or given or settings.partition.bound)


def _lengths(mesh: Mesh, settings: Settings, regions: int | None, job: Job) -> Lengths:
    """The lengths up to which openings are closed. regions: their number; None or 0: the partition finds it."""
    options = settings.partition
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
