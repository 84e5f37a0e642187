"""The repaired meshes of scans, each made once and kept for other steps and other recipes."""

from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ._core import CleanOptions, Job, Mesh, clean, close_openings
from .cache import Cache
from .jobs import Steps
from .openings import NOTHING, Lengths
from .replay import Faces
from .settings import OptionError, Place
from .source import Source

_BYTES = 300  # for each face: the mesh with the adjacency, normals and other data that the engine keeps with it


@dataclass(frozen=True)
class Repair:
    """How a scan is repaired."""

    clean: tuple[tuple[str, Any], ...] = tuple(CleanOptions().as_dict().items())  #: values of CleanOptions
    kept: tuple[Place, ...] = ()  #: places of openings that stay open
    lengths: Lengths = NOTHING  #: up to which openings are closed, since the regions can't show them

    @classmethod
    def by(cls, options: CleanOptions, kept: Iterable[Sequence[float]] = ()) -> "Repair":
        return cls(tuple(options.as_dict().items()), tuple((x, y, z) for x, y, z in kept))

    @property
    def options(self) -> CleanOptions:
        return CleanOptions(**dict(self.clean) | (self.lengths.options() if self.lengths else {}))

    @property
    def opened(self) -> "Repair":
        """The same repair without openings closed for the regions."""
        return replace(self, kept=self.kept if self.closes else (), lengths=NOTHING)

    @property
    def closes(self) -> bool:
        """Whether its options themselves close openings."""
        return any(dict(self.clean)[name] > 0 for name in ("fill_holes", "fill_flat_holes", "cut_handles"))


@dataclass(frozen=True, eq=False)
class Repaired:
    """A scan and its repaired mesh."""

    source: Source
    repair: Repair
    mesh: Mesh

    @cached_property
    def faces(self) -> Faces:
        """The faces of the scan and of the mesh."""
        source = self.source
        return Faces(self.mesh, source.polygon, source.faces, source.vertices, lambda: source.face_edges)

    @property
    def closed(self) -> CleanOptions | None:
        """How openings were closed for the regions; None where none were."""
        return self.repair.options if self.repair.lengths else None

    @property
    def counts(self) -> dict[str, int]:
        """How often each repair was made."""
        found: dict[str, int] = self.mesh.report["repairs"]
        return found

    def as_dict(self) -> dict[str, Any]:
        """The scan, its repairs, and where each was made first, for reports: faces are the scan's."""
        polygon = self.source.polygon
        places = {
            key: found if key.endswith("vertices") else [int(face) for face in dict.fromkeys(polygon[found])]
            for key, found in self.mesh.report["repaired_at"].items()
        }
        return {"input": self.source.as_dict(), "repair": self.counts, "repaired_at": places}


class Meshes:
    """Repairs scans, or returns what it knows."""

    def __init__(self, cache: Cache[Repaired] | None = None) -> None:
        """cache: by default of one mesh, as each takes much memory."""
        self._cache = Cache[Repaired](0) if cache is None else cache

    def known(self, source: Source, repair: Repair) -> bool:
        return self._cache.get(_key(source, repair)) is not None

    def repaired(self, source: Source, repair: Repair, steps: Steps) -> Repaired:
        """The repaired scan. Raises InvalidInput if it has no usable face."""
        key = _key(source, repair)
        if (known := self._cache.get(key)) is not None:
            return known
        opened = self.repaired(source, repair.opened, steps) if repair.lengths else None
        with steps("clean") as job:
            found = Repaired(source, repair, _mesh(source, repair, opened, job))
        self._cache.put(key, found, _BYTES * len(source.triangles))
        return found

    def forget(self, repaired: Repaired) -> None:
        self._cache.drop(_key(repaired.source, repaired.repair))


def _key(source: Source, repair: Repair) -> Hashable:
    return source.digest, repair if repair.lengths else repair.opened  # a place has no effect where nothing is closed


def _mesh(source: Source, repair: Repair, opened: Repaired | None, job: Job) -> Mesh:
    """The repaired mesh. opened: the one whose openings are closed for the regions."""
    options, places = repair.options, np.array(repair.kept, np.float64).reshape(-1, 3)
    if opened is not None:
        return close_openings(opened.mesh, options, job=job, keep=places, left_out=repair.lengths.left_out)
    if source.mesh is None:
        return clean(source.vertices, source.triangles, options, job=job, keep=places)
    default = CleanOptions().as_dict()
    of_scan = ("weld", "stitch", "grid", "outside_only")
    if of_repair := [name for name in of_scan if options.as_dict()[name] != default[name]]:
        raise OptionError("{} is of the repair, which a Mesh has had: give the arrays of the scan", of_repair[0])
    return close_openings(source.mesh, options, job=job, keep=places) if repair.closes else source.mesh
