"""The openings of a scan to close before it is partitioned, by length, for the command and the add-on."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ._core import (
    CleanOptions,
    Job,
    Mesh,
    PartitionOptions,
    _all_opening_lengths,
    _guess_opening_lengths,
    _left_out_count,
    close_openings,
)


@dataclass(frozen=True)
class Lengths:
    """The largest lengths of openings that are closed, scene units. For CleanOptions."""

    holes: float = 0.0
    flat_holes: float = 0.0
    handles: float = 0.0
    #: largest number of regions with these lengths; None: the number is known
    most: int | None = field(default=None, compare=False)
    left_out: int = 0  #: number of components that the partition leaves out, whose openings stay

    def __bool__(self) -> bool:
        return self.handles > 0

    def hold_for(self, regions: int) -> bool:
        """Whether they are right for this number of regions."""
        return self.most is None or regions <= self.most

    def closed(self, mesh: Mesh) -> Mesh:
        """The repaired scan without these openings; the mesh itself if the lengths are 0. See `close_openings`."""
        if not self:
            return mesh
        return close_openings(mesh, CleanOptions(**self.options()), left_out=self.left_out)

    def options(self) -> dict[str, Any]:
        """Return the lengths as keywords of CleanOptions."""
        return {"fill_holes": self.holes, "fill_flat_holes": self.flat_holes, "cut_handles": self.handles}


NOTHING = Lengths()
_HANDLE = 5.0  #: mean edges: the longest loop through a wall that was too thin for the grid that it was cut on


def lengths(mesh: Mesh, regions: int, job: Job | None = None, options: PartitionOptions | None = None) -> Lengths:
    """The lengths up to which openings of a repaired scan are errors of scanning, for this number of regions.

    options: of the partition, which leaves components out; by default with `regions` proxies.

    Holes in walls are closed up to twice sqrt(area / regions) and at most 20 mean edges; for the others see
    `opening_lengths`. Raises InvalidInput (regions below 1) or Cancelled. Cost: O(V + F).
    """
    options = options or PartitionOptions(proxies=max(regions, 1))
    holes, flat, handles = _all_opening_lengths(mesh, regions, options, job)
    return Lengths(holes, flat, handles, None, _left_out_count(mesh, options, job))


def closed_for(mesh: Mesh, regions: int) -> Mesh:
    """The repaired scan without the openings that this number of regions can't show; the mesh itself if it has none.

    Raises InvalidInput (regions below 1). Cost: see `close_openings`.
    """
    return lengths(mesh, regions).closed(mesh)


def lengths_of_grid(mesh: Mesh, options: PartitionOptions, job: Job | None = None) -> Lengths:
    """The lengths for a mesh cut on a grid, which leaves handles in walls thinner than a cell. Cost: O(V + F)."""
    report = mesh.report
    if report["euler"] == 2 * report["components"]:
        return NOTHING
    corners = mesh.vertices[mesh.triangles]
    edge = float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).mean())
    return Lengths(handles=_HANDLE * edge, left_out=_left_out_count(mesh, options, job))


def lengths_for(
    mesh: Mesh, options: PartitionOptions, regions: int | None, count: Callable[[], int], job: Job | None = None
) -> Lengths:
    """The lengths of a repaired scan, none of whose openings are closed yet.

    regions: the number, if it is known. count: finds it, on this mesh, for these options; it is not called if all
    likely numbers have the same lengths. Then the result is a guess: if it is wrong for the partition's number, call
    this again with that number. Cost: O(V + F), and that of `count`.
    """
    if regions is None:
        holes, flat, handles, most, likely = _guess_opening_lengths(mesh, options, job)
        if likely:
            return Lengths(holes, flat, handles, most, _left_out_count(mesh, options, job))
        regions = count()
    return lengths(mesh, regions, job, options)
