"""Partitions under constraints: cuts that end inside a region, locked regions, parts of a mesh.

This is the one way to all of it, for the command line and for the add-on; without any of it it is `partition`.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._core import (
    InvalidInput,
    Job,
    Mesh,
    Partition,
    PartitionOptions,
    clean,
    lock_regions,
    partition,
    partition_from,
)
from .guides import Pairs, inner_edges, marked_edges

Faces = NDArray[np.intp]
Labels = NDArray[np.int32]

_TOGETHER = 10.0  # all parts left out stay below this times leave_out, as in the engine


@dataclass(frozen=True)
class Guides:
    """What to keep to. Arrays as in `partition`."""

    weights: NDArray[Any] | None = None  #: (F,) what the faces' areas are multiplied by
    barriers: Pairs | None = None  #: (K, 2) edges that no region crosses
    cuts: Pairs | None = None  #: (K, 2) such edges that also split a region that they end in
    faces: NDArray[Any] | None = None  #: split these faces alone, and leave the others in their regions
    before: Partition | None = None  #: those regions; locked ones of it stay as they are even if `faces` is None

    def arrays(self) -> dict[str, Any]:
        """Weights and barriers as `partition` takes them."""
        edges = [pairs for pairs in (self.barriers, self.cuts) if pairs is not None and len(pairs)]
        return {"weights": self.weights, "barriers": np.concatenate(edges) if edges else None}


@dataclass(frozen=True)
class Part:
    """Some faces of a mesh as a mesh of their own."""

    mesh: Mesh
    face: Faces  #: of the whole mesh that each of its faces is

    def arrays(self, guides: Guides) -> dict[str, Any]:
        """The same of what speaks of the part."""
        whole = guides.arrays()
        weights, barriers = whole["weights"], whole["barriers"]
        return {
            "weights": None if weights is None else np.asarray(weights)[self.face],
            "barriers": None if barriers is None else marked_edges(self.mesh, barriers),
        }


def part_of(mesh: Mesh, faces: Faces, job: Job | None = None) -> Part:
    """Faces of a mesh, cut off from the others."""
    alone = clean(mesh.vertices, mesh.triangles[faces], job=job)
    return Part(alone, faces[alone.source_face])


def open_faces(mesh: Mesh, guides: Guides, leave_out: float) -> Faces | None:
    """The faces that may get other regions than they have; None: all, and nothing is decided yet."""
    before, count = guides.before, len(mesh.triangles)
    locked = before is not None and before.region_locked.any()
    if guides.faces is None and not locked:
        return None
    free = np.ones(count, bool)
    if guides.faces is not None:
        chosen = np.asarray(guides.faces, np.int64)
        if len(chosen) and not 0 <= chosen.min() <= chosen.max() < count:
            raise InvalidInput(f"faces must be in [0, {count}), got {chosen[(chosen < 0) | (chosen >= count)][0]}")
        free[:] = False
        free[chosen] = True
    else:
        free &= ~_left_out(mesh, leave_out)
    if before is not None and locked:
        region = before.face_region
        free &= ~((region >= 0) & before.region_locked[region])
    if not free.any():
        raise InvalidInput("all faces that would be split are locked" if locked else "no face is given")
    return np.flatnonzero(free)


def partition_guided(
    mesh: Mesh,
    options: PartitionOptions,
    job: Job | None = None,
    guides: Guides | None = None,
    part: Part | None = None,
) -> Partition:
    """A partition that keeps to the guides.

    A region that a cut ends in is split: from its ends the border goes on half-way between both of its sides. Where
    only some faces are split, borders to the others stay as they are, vertex by vertex, so that polygons meet without a
    crack; others that fall apart by it become several regions. With locked regions and no `faces`, options.proxies
    counts the locked ones too.
    part: what `part_of(mesh, open_faces(...))` gave, if that is known.
    """
    guides = guides or Guides()
    inside = open_faces(mesh, guides, options.leave_out)
    if inside is None:
        result = partition(mesh, options, job, **guides.arrays())
    else:
        result = _partition_part(mesh, options, job, guides, part or part_of(mesh, inside, job))
    if guides.cuts is None:
        return result
    labels = parted_at(mesh, result, guides.cuts)
    return result if labels is None else partition_from(mesh, labels, job, **guides.arrays(), before=result)


def _partition_part(mesh: Mesh, options: PartitionOptions, job: Job | None, guides: Guides, part: Part) -> Partition:
    before, own = guides.before, options.as_dict() | {"leave_out": 0.0}
    labels = np.full(len(mesh.triangles), -1, np.int32)
    if before is not None:
        kept = before.region_locked[before.face_region] if guides.faces is None else True
        labels[:] = np.where(kept, before.face_region, -1)
        if guides.faces is None and options.proxies is not None:
            own["proxies"] = max(1, options.proxies - int(before.region_locked.sum()))
    first = int(labels.max()) + 1
    split = partition(part.mesh, PartitionOptions(**own), job, **part.arrays(guides))
    labels[part.face] = first + split.face_region
    result = partition_from(mesh, labels, job, **guides.arrays())
    return result if before is None else _locked_as(mesh, result, before)


def _locked_as(mesh: Mesh, part: Partition, before: Partition) -> Partition:
    """The partition with the regions locked that lie in what is locked."""
    old = before.face_region[part.region_seed]
    seeds = part.region_seed[(old >= 0) & before.region_locked[old]]
    return lock_regions(mesh, part, seeds) if len(seeds) else part


def _left_out(mesh: Mesh, leave_out: float) -> NDArray[np.bool_]:
    """(F,) whether a face is of a component that `partition` leaves out: `leave_out` of its options."""
    corners = mesh.vertices[mesh.triangles]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    of = np.bincount(mesh.component, area) / max(area.sum(), 1e-300)
    order = np.argsort(of, kind="stable")[:-1]  # the largest is always kept
    out = (of[order] < leave_out) & (np.cumsum(of[order]) < _TOGETHER * leave_out)
    gone = np.zeros(len(of), bool)
    gone[order[np.logical_and.accumulate(out)]] = True
    return gone[mesh.component]


def inside_regions(mesh: Mesh, part: Partition, barriers: Pairs) -> int:
    """How many of the barriers have the same region on both sides, since they do not cut it in two."""
    _, a, b = _marked(mesh, barriers)
    return int(np.count_nonzero((part.face_region[a] == part.face_region[b]) & (part.face_region[a] >= 0)))


def parted_at(mesh: Mesh, part: Partition, cuts: Pairs) -> Labels | None:
    """(F,) the regions with those split that a cut ends in; None if there is none."""
    edges, a, b = _marked(mesh, cuts)
    labels, fresh = part.face_region.astype(np.int32), part.region_count
    while True:
        ends = np.flatnonzero((labels[a] == labels[b]) & (labels[a] >= 0))
        if not len(ends):
            return labels if fresh > part.region_count else None
        region = labels[a[ends[0]]]
        ends = ends[labels[a[ends]] == region]
        chain = ends[_chain(edges[ends])]
        faces = np.flatnonzero(labels == region)
        labels[faces[_far_side(mesh.triangles[faces], edges[chain], edges[ends])]] = fresh
        fresh += 1


def _marked(mesh: Mesh, pairs: Pairs) -> tuple[Pairs, Faces, Faces]:
    """Of the edges between two faces those that are among the pairs, and the two."""
    edges, a, b = inner_edges(mesh)
    base, wanted = len(mesh.vertices), np.sort(np.asarray(pairs, np.int64), axis=1)
    marked = np.isin(edges[:, 0].astype(np.int64) * base + edges[:, 1], wanted[:, 0] * base + wanted[:, 1])
    return edges[marked], a[marked], b[marked]


def _far_side(triangles: Pairs, chain: Pairs, cuts: Pairs) -> NDArray[np.bool_]:
    """(F,) which of some faces lie nearer, over edges that are no cuts, to the right side of a chain than to its left.

    chain: (K, 2) edges in order, each between two of the faces.
    """
    ends = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=-1).reshape(-1, 2).astype(np.int64)
    base = 1 + int(triangles.max())
    lower, upper = np.sort(chain, axis=1).T
    known = np.sort(lower * np.int64(base) + upper)

    def key(pairs: NDArray[Any]) -> NDArray[np.int64]:
        keys: NDArray[np.int64] = pairs.min(axis=1).astype(np.int64) * base + pairs.max(axis=1)
        return keys

    keys = key(ends)
    order = np.argsort(keys, kind="stable")
    same = np.flatnonzero(keys[order[1:]] == keys[order[:-1]])
    first, second = order[same], order[same + 1]
    on_cut = np.isin(keys[first], key(cuts))
    beside = _lists(len(triangles), first[~on_cut] // 3, second[~on_cut] // 3)
    # Faces that run along the chain in its direction are on its left.
    along = _directed(chain)
    runs = np.isin(ends[:, 0] * base + ends[:, 1], along[:, 0].astype(np.int64) * base + along[:, 1])
    on_chain = np.isin(keys, known)
    side = np.zeros(len(triangles), np.int8)
    side[np.flatnonzero(on_chain & ~runs) // 3] = 2
    side[np.flatnonzero(on_chain & runs) // 3] = 1
    start = np.flatnonzero(keys == key(along[:1])[0])  # these two differ, whatever the others say
    side[start // 3] = np.where(runs[start], 1, 2)
    front = np.flatnonzero(side)
    while len(front):
        of, to = _of_lists(beside, front[np.argsort(-side[front], kind="stable")])
        new = side[to] == 0
        side[to[new]] = side[of[new]]  # where both come at once the left has it, as it comes last
        front = np.unique(to[new])
    right: NDArray[np.bool_] = side == 2
    return right


def _directed(chain: Pairs) -> Pairs:
    """The edges of a chain, each from the end that it comes from."""
    ways = chain.copy()
    for k in range(len(ways)):
        turned = ways[k, 0] != ways[k - 1, 1] if k else len(ways) > 1 and ways[0, 0] in ways[1]
        if turned:
            ways[k] = ways[k, ::-1]
    return ways


def _lists(count: int, a: Faces, b: Faces) -> tuple[Faces, Faces]:
    """For each of `count` things those beside it, as where each list starts and all lists in a row."""
    of, to = np.concatenate([a, b]), np.concatenate([b, a])
    order = np.argsort(of, kind="stable")
    return np.searchsorted(of[order], np.arange(count + 1)), to[order]


def _of_lists(lists: tuple[Faces, Faces], which: Faces) -> tuple[Faces, Faces]:
    """Each of `which` with each of its list."""
    start, all_of = lists
    size = start[which + 1] - start[which]
    at = np.arange(size.sum()) - np.repeat(np.cumsum(size) - size, size)
    return np.repeat(which, size), all_of[np.repeat(start[which], size) + at]


def _chain(edges: Pairs) -> list[int]:
    """The numbers of edges that make a path without branches, as long as it goes on from an end."""
    at: dict[int, list[int]] = {}
    for number, pair in enumerate(edges.tolist()):
        for vertex in pair:
            at.setdefault(vertex, []).append(number)
    vertex = min((v for v in at if len(at[v]) == 1), default=min(at))
    chain: list[int] = []
    while True:
        ways = [number for number in at[vertex] if number not in chain[-1:]]
        if not ways or ways[0] in chain[:1] or (chain and len(at[vertex]) > 2):
            return chain
        chain.append(ways[0])
        vertex = int(edges[ways[0]].sum()) - vertex
