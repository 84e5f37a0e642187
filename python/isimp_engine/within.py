"""A bound that the polygons keep too: the distance of the scan from them, and the search for a smaller one."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._core import (
    Job,
    Mesh,
    MeshingOptions,
    Partition,
    PartitionOptions,
    PolygonMesh,
    _BoundSearch,
    _distances_to_triangles,
    _scan_distances,
    _Stretch,
    _tightened,
    polygonize,
)
from .guided import Guides, Part, partition_guided

SLACK = 1.5  #: the polygons may be this many times further from the scan than its regions' planes
_CHUNK = 1 << 10  # vertices that a thread measures at a time

Points = NDArray[np.float64]
Jobs = Callable[[float, float], AbstractContextManager[Job | None]]  # the job for the work between two shares of all


@dataclass(frozen=True)
class Within:
    """A partition and its polygons; with a bound, the distance of the scan from them."""

    partition: Partition
    polygons: PolygonMesh
    distance: (
        float | None
    )  #: the largest distance of a vertex of the scan from the polygons, scene units; None: no bound
    allowed: float | None  #: its limit: SLACK times the bound
    tries: int

    @property
    def report(self) -> dict[str, Any]:
        """The polygons' report; with a bound, `scan_distance` and `scan_distance_allowed` in it."""
        if self.distance is None:
            return self.polygons.report
        return self.polygons.report | {"scan_distance": self.distance, "scan_distance_allowed": self.allowed}


@dataclass(frozen=True)
class Made:
    """How a partition was made, so that it can be made again with planes nearer to the scan; see partition_guided."""

    options: PartitionOptions
    guides: Guides | None = None
    part: Part | None = None

    def again(self, mesh: Mesh, share: float, job: Job | None) -> Partition:
        """The partition with a share of the bound."""
        options = self.options.as_dict()
        options["bound"] *= share
        return partition_guided(mesh, PartitionOptions(**options), job, self.guides, self.part)


def scan_distances(
    mesh: Mesh, part: Partition, polygons: PolygonMesh, enough: float = 0.0, job: Job | None = None
) -> Points:
    """The distance of each vertex of the scan from the polygons; NaN if it is in no region.

    The polygons of the vertex's own regions come first; if these are farther than `enough`, all polygons are searched.
    So a distance of at most `enough` may be less in truth.
    """
    return _scan_distances(mesh, part, polygons, enough, 0, _CHUNK, job)


def polygonize_within(
    mesh: Mesh,
    part: Partition,
    meshing: MeshingOptions | None = None,
    job: Job | None = None,
    made: Made | None = None,
    jobs: Jobs | None = None,
) -> Within:
    """The polygons of a partition. With a bound, the scan is within SLACK times it of them, if possible.

    Borders may leave their chords, polygons bend and corners move by half the bound, and by less where that is not
    enough. If that is not enough either, and `made` is given, another partition is made with a lower bound.
    Without a bound it is `polygonize`.
    jobs: in place of `job`: makes a job for each part of the work, to show its progress.
    """
    jobs, meshing = jobs or _stretches(job), meshing or MeshingOptions()
    if part.bound is None:
        with jobs(0.0, 1.0) as own:
            return Within(part, polygonize(mesh, part, meshing, own), None, None, 1)
    allowed, bound = SLACK * part.bound, part.bound
    search, best = _BoundSearch(allowed, made is not None), None
    while (step := search.next()) is not None:
        with jobs(step.begin, step.end) as own:
            if step.anew and made is not None:
                part = made.again(mesh, step.share, own)
                continue
            tight = _tightened(mesh, part, step.share * (part.bound or bound), meshing)
            polygons = polygonize(mesh, part, tight, own)
            away = _scan_distances(mesh, part, polygons, allowed, meshing.threads, _CHUNK, own)
            distance = float(np.nanmax(away))
        if search.take(distance):
            best = part, polygons, distance
    assert best is not None  # the first try always sets it
    return Within(*best, allowed, search.tries)


def partition_within(
    mesh: Mesh,
    options: PartitionOptions,
    meshing: MeshingOptions | None = None,
    job: Job | None = None,
    guides: Guides | None = None,
) -> Within:
    """Regions and their polygons. With a bound, the scan is within SLACK times it of them, if possible."""
    made = Made(options, guides)
    return polygonize_within(mesh, partition_guided(mesh, options, job, guides), meshing, job, made)


def _stretches(job: Job | None) -> Jobs:
    """One job for all parts of the work, each of which moves its progress from one share to another."""

    @contextmanager
    def stretch(begin: float, end: float) -> Iterator[Job | None]:
        with nullcontext() if job is None else _Stretch(job, begin, end):
            yield job

    return stretch


def _to_triangles(p: Points, corners: Points) -> Points:
    """(K,) distance of each point from its triangle: to its plane where that is met inside, else to its sides."""
    return _distances_to_triangles(p, np.reshape(corners, (-1, 3)))
