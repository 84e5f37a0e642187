"""A bound that the polygons keep too: the distance of the scan from them, and the search for a smaller one."""

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
    _scan_distances,
    _tightened,
    polygonize,
)
from .guided import Guides, partition_guided
from .jobs import Jobs, stretches

SLACK = 1.5  #: the polygons may be this many times further from the scan than its regions' planes
_NEAR = 0.97  #: share of the wanted triangles from which the search ends
_AIM = 0.985  #: share of the wanted triangles that the next try aims for
_MOST_TRIES = 8
_CHUNK = 1 << 10  # vertices that a thread measures at a time

Points = NDArray[np.float64]


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
    most: int | None = None  #: the number of triangles that was asked for

    @property
    def report(self) -> dict[str, Any]:
        """The polygons' report; with a bound, `scan_distance` and `scan_distance_allowed` in it."""
        if self.distance is None:
            return self.polygons.report
        return self.polygons.report | {"scan_distance": self.distance, "scan_distance_allowed": self.allowed}

    @property
    def warnings(self) -> list[str]:
        """The warnings of the partition, and one if there are too many triangles."""
        found, part = list(self.partition.report["warnings"]), self.partition
        if self.most is not None and (made := triangles_of(self.polygons)) > self.most:
            text = f"{made:,} triangles, {self.most:,} were asked for"
            if part.region_count > part.proxies_asked:
                text += f"; the scan needs at least {part.proxies_needed:,} regions"
            found.append(text)
        return found


@dataclass(frozen=True)
class Made:
    """How a partition was made, so that it can be made again with planes nearer to the scan; see partition_guided."""

    options: PartitionOptions
    guides: Guides | None = None

    def again(self, mesh: Mesh, share: float, job: Job | None) -> Partition:
        """The partition with a share of the bound."""
        options = self.options.as_dict()
        return self._with(mesh, job, options | {"bound": share * options["bound"]})

    def with_count(self, mesh: Mesh, proxies: int, job: Job | None) -> Partition:
        """The partition with another number of regions, in place of one that a number of triangles gives."""
        return self._with(mesh, job, self.options.as_dict() | {"proxies": proxies, "triangles": None})

    def _with(self, mesh: Mesh, job: Job | None, options: dict[str, Any]) -> Partition:
        return partition_guided(mesh, PartitionOptions(**options), job, self.guides)


def triangles_of(polygons: PolygonMesh) -> int:
    """How many triangles polygons make."""
    return len(polygons.loops) - 2 * len(polygons.loop_start)


class TriangleSearch:
    """The largest number of regions whose polygons make at most `most` triangles: which number to try next."""

    def __init__(self, most: int, faces: int) -> None:
        self.most = most
        self._faces = faces
        self._fits: tuple[int, int] | None = None  #: regions and triangles: the most that is not too many
        self._over: tuple[int, int] | None = None  #: the fewest that are too many
        self._best: tuple[bool, int] | None = None
        self.tries = 0

    def take(self, regions: int, triangles: int) -> bool:
        """Records a try. Returns whether it is the best one until now."""
        self.tries += 1
        fits, known = triangles <= self.most, self._fits if triangles <= self.most else self._over
        if known is None or (regions > known[0] if fits else regions < known[0]):
            found = regions, triangles
            self._fits, self._over = (found, self._over) if fits else (self._fits, found)
        rank = fits, triangles if fits else -triangles
        if self._best is not None and rank <= self._best:
            return False
        self._best = rank
        return True

    def next(self) -> int | None:
        """The number of regions to try; None: the last is near enough, or no other is left to try."""
        fits, over = self._fits, self._over
        if self.tries >= _MOST_TRIES or (fits is not None and fits[1] >= _NEAR * self.most):
            return None
        if fits is None or over is None or over[0] <= fits[0]:
            regions, triangles = fits or over or (1, 1)
            wanted = round(regions * _AIM * self.most / max(triangles, 1))
            limits = (regions + 1, self._faces) if fits else (1, regions - 1)
        else:
            share = (_AIM * self.most - fits[1]) / (over[1] - fits[1])
            wanted, limits = round(fits[0] + share * (over[0] - fits[0])), (fits[0] + 1, over[0] - 1)
        return None if limits[0] > limits[1] else min(max(wanted, limits[0]), limits[1])


def scan_distances(mesh: Mesh, part: Partition, polygons: PolygonMesh, job: Job | None = None) -> Points:
    """The distance of each vertex of the scan from the polygons; NaN if it is in no region."""
    return _scan_distances(mesh, part, polygons, 0.0, 0, _CHUNK, job)


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
    With a number of triangles, and `made`, other partitions are made with other numbers of regions, until the polygons
    make nearly as many triangles and not more. Else it is `polygonize`.
    jobs: in place of `job`: makes a job for each part of the work, to show its progress.
    """
    jobs, meshing = jobs or stretches(job), meshing or MeshingOptions()
    if made is not None and made.options.triangles is not None:
        return _within_triangles(mesh, part, meshing, made, jobs)
    if part.bound is None:
        with jobs(0.0, 1.0) as own:
            return Within(part, polygonize(mesh, part, meshing, job=own), None, None, 1)
    allowed, bound = SLACK * part.bound, part.bound
    search, best = _BoundSearch(allowed, made is not None), None
    while (step := search.next()) is not None:
        with jobs(step.begin, step.end) as own:
            if step.anew and made is not None:
                part = made.again(mesh, step.share, own)
                continue
            tight = _tightened(mesh, part, step.share * (part.bound or bound), meshing)
            polygons = polygonize(mesh, part, tight, job=own)
            # Exact above `allowed`: below, a polygon of another region may be nearer.
            away = _scan_distances(mesh, part, polygons, allowed, meshing.threads, _CHUNK, own)
            distance = float(np.nanmax(away))
        if search.take(distance):
            best = part, polygons, distance
    assert best is not None  # the first try always sets it
    return Within(*best, allowed, search.tries)


def _within_triangles(mesh: Mesh, part: Partition, meshing: MeshingOptions, made: Made, jobs: Jobs) -> Within:
    search = TriangleSearch(made.options.triangles or 0, len(mesh.triangles))
    best, done, proxies = None, 0.0, None
    while True:
        end = (1 + done) / 2
        with jobs(done, end) as own:
            if proxies is not None:
                part = made.with_count(mesh, proxies, own)
            polygons = polygonize(mesh, part, meshing, job=own)
        done, tried = end, proxies or part.region_count
        if search.take(tried, triangles_of(polygons)):
            best = part, polygons
        if (proxies := search.next()) is None:
            break
    assert best is not None  # the first try always sets it
    return Within(*best, None, None, search.tries, search.most)
