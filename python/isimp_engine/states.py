"""The regions of a scan after a partition step: the one loop of the command and the add-on."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from . import recipe as rcp
from . import recipes
from ._core import CleanOptions, InvalidInput, Job, Partition, PartitionOptions, partition
from .guided import Guides, partition_guided
from .jobs import Steps
from .openings import NOTHING, Lengths, lengths_for, lengths_of_grid
from .parts import weights_of
from .repairs import Meshes, Repair, Repaired
from .settings import OptionError
from .source import Source
from .within import Made

GuidesOf = Callable[[Repaired, Job], Guides]


@dataclass(frozen=True, eq=False)
class State:
    """The regions of a scan on the way through the steps of a recipe."""

    repaired: Repaired
    partition: Partition
    made: Made | None  #: how the partition was made; None after an edit, as another partition would lose it


@dataclass(frozen=True, eq=False)
class Split:
    """How a scan is split into regions."""

    options: PartitionOptions
    repair: Repair
    close_openings: bool  #: whether the openings that regions can't show are closed before, if nothing else forbids it
    guides: GuidesOf  #: makes weights, barriers and cuts
    faces: tuple[int, ...] = ()  #: the scan's faces to split; the others stay in their regions. Empty: all
    more: tuple[tuple[float, ...], ...] = ()  #: parts with smaller regions, in the scan's space

    def guided(self, repaired: Repaired, job: Job) -> Guides:
        """The guides, with the weights of the parts."""
        guides, mesh = self.guides(repaired, job), repaired.mesh
        if not self.more:
            return guides
        weights = weights_of(np.asarray(mesh.vertices), np.asarray(mesh.triangles), self.more)
        return replace(guides, weights=weights if guides.weights is None else weights * guides.weights)

    def closes(self, source: Source) -> bool:
        """Not with a bound, which is a promise for each vertex of the scan, and not if the caller closes openings."""
        chosen = self.repair.closes or (source.mesh is not None and bool(source.mesh.openings))
        return self.close_openings and not (chosen or self.options.bound)

    def keeps(self, before: State | None) -> bool:
        """Whether some of the regions before it stay."""
        return bool(self.faces) or (before is not None and bool(before.partition.region_locked.any()))


def repair_of(step: rcp.Partition, clean: CleanOptions) -> Repair:
    """The repair of a partition step. clean: the options that the step does not have."""
    return Repair.by(CleanOptions(**clean.as_dict() | rcp.engine_options(step, rcp.CLEAN)), step.keep_openings)


def split_of(step: rcp.Partition, guides: GuidesOf, clean: CleanOptions, **more: Any) -> Split:
    """The split of a partition step, also of the add-on's own class. clean: the options that the step does not have.

    more: further values of PartitionOptions.
    """
    repair = repair_of(step, clean)
    options = PartitionOptions(**recipes.partition_options(step) | more)
    return Split(options, repair, step.close_openings, guides, step.faces, step.more)


def partitioned(wanted: Split, source: Source, meshes: Meshes, steps: Steps, before: State | None = None) -> State:
    """The regions of a scan.

    Openings are closed for a guessed number of regions, and again where it is wrong. Regions that stay belong to their
    mesh, so its openings stay as they are.
    """
    options, closes = wanted.options, wanted.closes(source)
    if wanted.keeps(before):
        repaired = before.repaired if before is not None else meshes.repaired(source, wanted.repair.opened, steps)
        with steps("partition") as job:
            chosen = repaired.faces.triangles_at(wanted.faces) if wanted.faces else None
            guides = wanted.guided(repaired, job)
            guides = replace(guides, faces=chosen, before=None if before is None else before.partition)
            part = partition_guided(repaired.mesh, options, job, guides)
        return State(repaired, part, Made(options, guides))
    regions = options.proxies
    while True:
        lengths, repaired = NOTHING, meshes.repaired(source, wanted.repair, steps)
        if closes:
            with steps("clean") as job, refused():
                lengths = _lengths(repaired, options, regions, job)
                if not lengths and wanted.repair.options.outside_only:
                    lengths = lengths_of_grid(repaired.mesh, options, job)
            if lengths:
                repaired = meshes.repaired(source, replace(wanted.repair, lengths=lengths), steps)
        with steps("partition") as job, refused():
            guides = wanted.guided(repaired, job)
            part = partition_guided(repaired.mesh, options, job, guides)
        if lengths.hold_for(part.region_count):
            return State(repaired, part, Made(options, guides))
        regions = part.region_count
        if lengths:
            meshes.forget(repaired)
        del repaired, guides, part  # their memory is needed


def _lengths(repaired: Repaired, options: PartitionOptions, regions: int | None, job: Job) -> Lengths:
    """The lengths up to which openings are closed. regions: their number; None or 0: the partition finds it."""
    mesh = repaired.mesh
    return lengths_for(mesh, options, regions or None, lambda: partition(mesh, options, job=job).region_count, job)


@contextmanager
def refused() -> Iterator[None]:
    """Reports an error of the engine as an error of the options, since the mesh is sound at this point."""
    try:
        yield
    except InvalidInput as error:
        raise OptionError(str(error)) from None
