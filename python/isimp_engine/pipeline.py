"""From a scan to its polygons: the one way of the command, of batches and of `simplify`."""

import json
from dataclasses import dataclass, fields, replace
from functools import cached_property
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import exporting, recipes
from ._core import (
    InvalidInput,
    Job,
    Mesh,
    Partition,
    PartitionOptions,
    PolygonMesh,
    RegulariseOptions,
    TextureOptions,
    __version__,
    expected_polygons,
    regularise,
)
from .clutter import Clutter, clutter, without_clutter
from .dents import dent_rows
from .jobs import Steps
from .marks import Marks
from .regions import is_drawn, why_not_round
from .repairs import Meshes, Repair, Repaired
from .replaying import Replay
from .settings import BOX_CLUTTER, KEEP_CLUTTER, OptionError, Settings, Texturing, literal, scaled
from .sizes import size_rows
from .snapping import snap_sizes
from .source import Source, facts, labels
from .states import refused
from .texturing import Texture, texture
from .within import Made, Within, polygonize_within

_MOST_NAMES = 12  # names of sizes in a message


@dataclass(frozen=True, eq=False)
class Regions:
    """The regions of a scan, and the inputs that they were made of."""

    settings: Settings
    repaired: Repaired
    partition: Partition
    expected: dict[str, int]  #: estimated counts of polygons: see `expected_polygons`
    regular: RegulariseOptions | None
    made: Made | None  #: how the partition was made; None if it was edited since
    #: how faces that a recipe names were found: by "place" or "number", and the steps that are left out; None: no faces
    clicks: dict[str, Any] | None
    scale: dict[str, Any] | None  #: the factor of the scan, and the size that it follows from

    @property
    def source(self) -> Source:
        return self.repaired.source

    @property
    def mesh(self) -> Mesh:
        return self.repaired.mesh

    @property
    def unit(self) -> str:
        """The unit of the scene."""
        return self.source.unit_or(self.settings.unit)

    @property
    def step(self) -> float | None:
        """The step that sizes were snapped to, scene units."""
        own, recipe = self.settings, self.settings.recipe
        return own.snap_sizes if own.regularise or recipe is None else recipe.snap_sizes()


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

    def write(self, path: str | PathLike[str], **given: Any) -> dict[str, Any]:
        """Write the polygons without their texture; see `exporting.write`."""
        known: dict[str, Any] = {"surfaces": self.surfaces, "partition": self.partition, "mesh": self.mesh}
        known |= {"crs": self.settings.crs, "unit": self.unit}
        return exporting.write(path, self.polygons, **known | given)

    def report(self, sizes: bool = True) -> dict[str, Any]:
        """Inputs, settings and numbers of the result. sizes: whether it has them, which take some time; else None."""
        settings, part, closed = self.settings, self.partition, self.repaired.closed
        recipe = settings.recipe
        return {"isimp": __version__, **self.repaired.as_dict()} | {
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
                "snap_sizes": self.step,
            },
            "regions": part.region_count,
            "error": part.error,
            "history": part.history.tolist(),
            "partition": part.report | {"warnings": [*(recipe.gone if recipe else ()), *self.found.warnings]},
            "curved": part.report["curved"],
            "dents": dent_rows(self.mesh, part),
            "not_round": why_not_round(self.mesh, part) if settings.partition.curved and not part.curved else None,
            "sizes": size_rows(self.mesh, part, self.step) if sizes or self.step else None,
            "scale": self.scale,
            "expected": self.expected,
            "output": self.found.report,
            "clicks": self.clicks,
            "clutter": [each.as_dict() for each in self.clutter],
            "validity": exporting.validity(self.polygons, self.surfaces, self.unit),
            "texture": self.texture and self.texture.report,
        }


def make_regions(
    source: Source, settings: Settings, steps: Steps, meshes: Meshes | None = None, marks: Marks | None = None
) -> Regions:
    """Repair, partition and edit, and estimate the number of polygons.

    meshes: of other runs on this scan; a mesh keeps data of a partition for the next one.
    """
    if settings.scale is not None:
        if source.mesh is not None:
            raise OptionError("{} needs arrays or a file: a Mesh keeps its scale", "scale")
        known = scale_of(
            make_regions(source, replace(settings, scale=None, snap_sizes=None), steps, marks=marks), settings
        )
        larger = replace(scaled(settings, known["factor"]), scale=None)
        return replace(make_regions(source.scaled(known["factor"]), larger, steps, meshes, marks), scale=known)
    meshes = meshes or Meshes()
    by_detail = settings.scanned_detail and settings.partition.detail is not None  # a level of detail has a count
    if by_detail and not is_drawn(meshes.repaired(source, Repair.by(settings.clean), steps).mesh):
        given = settings.partition.as_dict() | {"detail": settings.scanned_detail}
        settings = replace(settings, partition=PartitionOptions(**given))
    recipe, regular = settings.recipe, settings.regularise
    replay = Replay(source, settings, steps, marks or Marks(), meshes)
    state = replay.partitioned() if recipe is None else replay.replayed(recipe)
    mesh, part, made = state.repaired.mesh, state.partition, state.made
    if regular is not None:
        with steps("regularise") as job, refused():
            part, made = regularise(mesh, part, regular, job=job), None
            if settings.snap_sizes:
                part = snap_sizes(mesh, part, settings.snap_sizes, job=job)
    elif recipe is not None:
        regular = recipes.regularise_options(recipe)
    with steps("mesh") as job:
        expected = expected_polygons(mesh, part, settings.meshing, job=job)
    return Regions(settings, state.repaired, part, expected, regular, made, replay.clicks, None)


def scale_of(regions: Regions, settings: Settings) -> dict[str, Any]:
    """The factor by which a size of the regions has its true length."""
    assert settings.scale is not None
    name, length = settings.scale
    lengths = {
        row["name"]: row["value"] for row in size_rows(regions.mesh, regions.partition) if row["kind"] != "angle"
    }
    one, _, other = name.partition("-")
    name = name if name in lengths else f"{other}-{one}"  # in any order
    if not lengths.get(name):
        known = ", ".join(f"{other} ({value:.5g})" for other, value in list(lengths.items())[:_MOST_NAMES])
        message = f": there is no length '{settings.scale[0]}'; there are {known or 'none'}"
        raise OptionError(literal(message), "scale")
    return {"factor": length / lengths[name], "name": name, "measured": lengths[name], "length": length}


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


def openings_of(mesh: Mesh) -> list[dict[str, Any]]:
    """The openings of a repaired mesh for the report, the longest first."""
    names = ("kind", "kept", "center", "length")
    found = [{name: opening[name] for name in names} for opening in mesh.openings]
    return sorted(found, key=lambda opening: -opening["length"])


def has_texture(source: Source) -> bool:
    """Whether a scan was read with images or colours."""
    return source.soup is not None and source.soup.has_texture


def require_texture(source: Source) -> None:
    """Raises InvalidInput for a scan without a texture."""
    if not has_texture(source):
        raise InvalidInput(
            "has neither an image nor colours, so there is no texture to keep; leave out the option "
            "`texture`, or the recipe's texture step"
        )


def _textured(wanted: Texturing, source: Source, mesh: Mesh, found: Within, threads: int, job: Job) -> Texture:
    assert source.soup is not None  # see require_texture
    own = {
        "size": wanted.size or None,
        "tiles": wanted.tiles,
        "materials": wanted.materials,
        "occlusion": wanted.occlusion is not None,
        "occlusion_distance": wanted.occlusion or None,
        "threads": threads,
    }
    options = TextureOptions(**{**(wanted.step or {}), **own})
    return texture(mesh, found.partition, found.polygons, source.soup, options, job=job)
