"""Partitions under constraints: cuts that end inside a region, locked regions, some faces of a mesh.

The command and the add-on use it; without constraints it is `partition`.
"""

from collections.abc import Sized
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._core import Job, Mesh, Partition, PartitionOptions, _inside_regions
from ._core import _partition as partition
from .guides import Pairs, _as_pairs


@dataclass(frozen=True)
class Guides:
    """Constraints of a partition. Arrays as in `partition`."""

    weights: NDArray[Any] | None = None  #: (F,) factors of the faces' areas
    barriers: Pairs | None = None  #: (K, 2) edges that no region crosses
    cuts: Pairs | None = None  #: (K, 2) such edges that also split a region that they end in
    faces: NDArray[Any] | None = None  #: split these faces alone, and leave the others in their regions
    before: Partition | None = None  #: its regions are the start; locked ones stay as they are even if `faces` is None

    @property
    def edges(self) -> Pairs | None:
        """Barriers and cuts; None without any."""
        edges = [pairs for pairs in (_some(self.barriers), _some(self.cuts)) if pairs is not None]
        return np.concatenate(edges) if edges else None


def partition_guided(
    mesh: Mesh, options: PartitionOptions, job: Job | None = None, guides: Guides | None = None
) -> Partition:
    """A partition with guides.

    A region that contains the end of a cut is split: the border continues from the end half-way between both of its
    sides. Where only some faces are split, borders to the others stay as they are, vertex by vertex, so that polygons
    meet without a crack; others that fall apart by it become several regions. With locked regions and no `faces`,
    options.proxies counts the locked ones too.
    """
    guides = guides or Guides()
    return partition(
        mesh,
        options,
        job,
        weights=guides.weights,
        barriers=_some(guides.barriers),
        cuts=_some(guides.cuts),
        faces=_numbers(guides.faces),
        before=guides.before,
    )


def inside_regions(mesh: Mesh, part: Partition, barriers: Pairs) -> int:
    """The number of barriers with the same region on both sides, since they do not cut it in two."""
    return _inside_regions(mesh, part, _as_pairs(barriers))


def _some(pairs: Pairs | None) -> Pairs | None:
    """None for an empty list of any type."""
    return None if pairs is None or not len(pairs) else pairs


def _numbers(faces: NDArray[Any] | None) -> NDArray[Any] | None:
    """An empty list of any type as one of integers; others as they are, for the engine to check."""
    return np.zeros(0, np.int64) if isinstance(faces, Sized) and not len(faces) else faces
