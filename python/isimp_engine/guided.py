"""Partitions under constraints: cuts that end inside a region, locked regions, parts of a mesh.

The command and the add-on use it; without constraints it is `partition`.
"""

from collections.abc import Sized
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._core import (
    Job,
    Mesh,
    Partition,
    PartitionOptions,
    _inside_regions,
    _open_faces,
    _part_of,
    _parted_at,
)
from ._core import _partition as partition
from .guides import Pairs, _as_pairs, marked_edges

Faces = NDArray[np.intp]
Labels = NDArray[np.int32]


@dataclass(frozen=True)
class Guides:
    """Constraints of a partition. Arrays as in `partition`."""

    weights: NDArray[Any] | None = None  #: (F,) factors of the faces' areas
    barriers: Pairs | None = None  #: (K, 2) edges that no region crosses
    cuts: Pairs | None = None  #: (K, 2) such edges that also split a region that they end in
    faces: NDArray[Any] | None = None  #: split these faces alone, and leave the others in their regions
    before: Partition | None = None  #: its regions are the start; locked ones stay as they are even if `faces` is None

    def arrays(self) -> dict[str, Any]:
        """Weights and barriers in the form for `partition`."""
        edges = [pairs for pairs in (_some(self.barriers), _some(self.cuts)) if pairs is not None]
        return {"weights": self.weights, "barriers": np.concatenate(edges) if edges else None}


@dataclass(frozen=True)
class Part:
    """Some faces of a mesh as a mesh of their own."""

    mesh: Mesh
    face: Faces  #: face of the whole mesh for each of its faces

    def arrays(self, guides: Guides) -> dict[str, Any]:
        """As `Guides.arrays`, for the faces of the part."""
        whole = guides.arrays()
        weights, barriers = whole["weights"], whole["barriers"]
        return {
            "weights": None if weights is None else np.asarray(weights)[self.face],
            "barriers": None if barriers is None else marked_edges(self.mesh, barriers),
        }


def part_of(mesh: Mesh, faces: Faces, job: Job | None = None) -> Part:
    """Faces of a mesh, cut off from the others."""
    alone = _part_of(mesh, faces, job)
    return Part(alone, faces[alone.source_face])


def open_faces(mesh: Mesh, guides: Guides, leave_out: float, proxies: int | None = None) -> Faces | None:
    """The faces that may get new regions; None: all, without a restriction.

    leave_out, proxies: of the later PartitionOptions.
    """
    faces = _open_faces(mesh, _numbers(guides.faces), guides.before, proxies or 1, leave_out)
    return None if faces is None else faces.astype(np.intp)


def partition_guided(
    mesh: Mesh,
    options: PartitionOptions,
    job: Job | None = None,
    guides: Guides | None = None,
    part: Part | None = None,
) -> Partition:
    """A partition with guides.

    A region that contains the end of a cut is split: the border continues from the end half-way between both of its
    sides. Where only some faces are split, borders to the others stay as they are, vertex by vertex, so that polygons
    meet without a crack; others that fall apart by it become several regions. With locked regions and no `faces`,
    options.proxies counts the locked ones too.
    part: the result of `part_of(mesh, open_faces(...))`, if that is known.
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
        part=None if part is None else part.mesh,
    )


def inside_regions(mesh: Mesh, part: Partition, barriers: Pairs) -> int:
    """The number of barriers with the same region on both sides, since they do not cut it in two."""
    return _inside_regions(mesh, part, _as_pairs(barriers))


def parted_at(mesh: Mesh, part: Partition, cuts: Pairs) -> Labels | None:
    """(F,) the regions after splitting regions that contain the end of a cut; None if there is no such end."""
    return _parted_at(mesh, part, _as_pairs(cuts))


def _some(pairs: Pairs | None) -> Pairs | None:
    """None for an empty list of any type."""
    return None if pairs is None or not len(pairs) else pairs


def _numbers(faces: NDArray[Any] | None) -> NDArray[Any] | None:
    """An empty list of any type as one of integers; others as they are, for the engine to check."""
    return np.zeros(0, np.int64) if isinstance(faces, Sized) and not len(faces) else faces
