"""Which openings of a scan to close before it is partitioned, by length, for the command and the add-on."""

from collections.abc import Callable
from dataclasses import dataclass

from ._core import (
    CleanOptions,
    Job,
    Mesh,
    PartitionOptions,
    _guess_opening_lengths,
    close_openings,
    opening_lengths,
)


@dataclass(frozen=True)
class Lengths:
    """Loops of openings up to these lengths are closed, scene units. For CleanOptions."""

    holes: float = 0.0
    handles: float = 0.0
    most: int | None = None  #: a guess, right for up to so many regions; None: made for a number that is known

    def __bool__(self) -> bool:
        return self.handles > 0

    def hold_for(self, regions: int) -> bool:
        """Whether they are those of a partition into so many."""
        return self.most is None or regions <= self.most


def closed_for(mesh: Mesh, regions: int, job: Job | None = None, threads: int = 0) -> Mesh:
    """The repaired scan with the openings closed that so many regions can't show; itself where there are none.

    Raises InvalidInput (regions below 1) or Cancelled. Cost: see `close_openings`.
    """
    holes, handles = opening_lengths(mesh, regions, job)
    if handles == 0:
        return mesh
    return close_openings(mesh, CleanOptions(fill_holes=holes, cut_handles=handles, threads=threads), job)


def lengths_for(
    mesh: Mesh, options: PartitionOptions, regions: int | None, count: Callable[[], int], job: Job | None = None
) -> Lengths:
    """The lengths of a repaired scan, none of whose openings are closed yet.

    regions: the number, where it is known. count: finds it, on this mesh, for these options; it is not asked where all
    numbers that are likely have the same lengths. Then the result is a guess: where it does not hold for the
    partition's number, this is to be asked again with that number. Cost: O(V + F), and that of `count`.
    """
    if regions is None:
        holes, handles, most, likely = _guess_opening_lengths(mesh, options, job)
        if likely:
            return Lengths(holes, handles, most)
        regions = count()
    return Lengths(*opening_lengths(mesh, regions, job))
