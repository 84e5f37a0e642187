"""The steps from tiles to polygons, as functions on arrays: for `isimp tiles`, or for a scheduler of one's own.

Letters of shapes: F faces of a tile, H faces of its halo, K patches or regions, E pairs of them, R regions of all
tiles. Sums are (K, 5) float64: x, y, z of the sum of area * normal, twice the area, and the number of faces. Pairs
are (E, 2) int32, and `lengths` (E,) float64 says how long the border of each is. Areas and lengths are in scene units.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import Job, Mesh, MeshingOptions, Partition, PolygonMesh, _core


class Faces(NamedTuple):
    """The faces of a mesh as relaxing needs them, in an order in which near faces are near in memory."""

    record: NDArray[np.float32]  #: (F, 4) unit normal and area
    neighbour: NDArray[np.int32]  #: (F, 3) the face across corner k -> k + 1; -1 where there is none
    mesh_face: NDArray[np.int32]  #: (F,) the face of the mesh that each is
    length: NDArray[np.float32]  #: (F, 3) of these edges


class Patches(NamedTuple):
    """Small regions of a tile, and the graph of them."""

    label: NDArray[np.int32]  #: (F,) the patch of each face, in the order of Faces
    sums: NDArray[np.float64]  #: (K, 5)
    pairs: NDArray[np.int32]  #: (E, 2)
    lengths: NDArray[np.float64]  #: (E,)


class Extent(NamedTuple):
    """What a tile adds to the size and the noise of the whole scan."""

    area: float
    centre: list[float]  #: centroid of the surface
    spread: float  #: mean squared distance of the surface's points from it
    noise: float  #: standard deviation along the normal


class Components(NamedTuple):
    """The connected components of a joined graph."""

    component: NDArray[np.int32]  #: (K,) of each node; -1 where it is left out
    need: NDArray[np.int32]  #: (C,) the least number of regions of each; 0 where it is left out
    left_out: int  #: how many are left out
    area_left_out: float  #: their share of the area


class Found(NamedTuple):
    """How many regions a scan has at a tolerance."""

    regions: int
    cost: float  #: merges up to this were made, scene units squared
    snapped: bool  #: the number is that of the shape's planes


class Merges(NamedTuple):
    """The merges inside a group of tiles, in order."""

    merged: NDArray[np.int32]  #: (M, 2) the second node goes into the first, and is not named again
    price: NDArray[np.float64]  #: (M,) scene units squared; never falls: the highest so far


class Relaxed(NamedTuple):
    """What a round of relaxing did in one tile."""

    label: NDArray[np.int32]  #: (F,) regions of the tile's own faces
    changed: NDArray[np.int32]  #: (C,) the regions that gave or took faces, rising
    change: NDArray[np.float64]  #: (C, 5) what their sums change by
    moves: int


class Thinned(NamedTuple):
    """A mesh without most of what lies inside its regions."""

    vertices: NDArray[np.float64]  #: (V, 3)
    triangles: NDArray[np.int32]  #: (F, 3)
    label: NDArray[np.int32]  #: (F,) region of each face
    moments: NDArray[np.float64]  #: (F, 10) area, centre and second moments of the scan's faces that each stands for


def faces_of(mesh: Mesh) -> Faces:
    """The faces of a mesh as relaxing needs them. Cost: O(F); 44 bytes a face."""
    return Faces(*_core._tile_faces(mesh))


def patches(mesh: Mesh, size: int, smooth: float = 0.5, job: Job | None = None) -> Patches:
    """Split a tile into patches of about `size` faces, by the engine's own partition.

    Nothing is left out and closed components get as many patches as they need, since both are decided on the graph of
    all tiles. Raises InvalidInput (size below 1) or Cancelled. Cost: O(F); 130 bytes a face with the mesh.
    """
    return Patches(*_core._tile_patches(mesh, size, smooth, job))


def measure(mesh: Mesh, job: Job | None = None) -> Extent:
    """What a tile adds to the size and the noise of the whole scan. Cost: O(F)."""
    return Extent(*_core._tile_measure(mesh, job))


def size_and_noise(extents: Sequence[Extent]) -> tuple[float, float]:
    """The size of a scan, which `detail` is a share of, and its noise: the median of the tiles by area."""
    area = np.array([each.area for each in extents])
    centre = np.array([each.centre for each in extents])
    whole = area.sum()
    if not whole > 0:
        return 0.0, 0.0
    apart = ((centre - area @ centre / whole) ** 2).sum(1)
    spread = float(area @ (np.array([each.spread for each in extents]) + apart)) / whole
    noise = np.array([each.noise for each in extents])
    order = np.argsort(noise, kind="stable")
    half = np.searchsorted(np.cumsum(area[order]), whole / 2)
    return 3 * float(np.sqrt(spread)), float(noise[order[min(half, len(order) - 1)]])


def detail_patches(mesh: Mesh, tolerance: float, noise: float, job: Job | None = None) -> Patches:
    """Split a tile into patches that show all detail of a tolerance; scene units, as `noise` of the whole scan.

    Nothing is left out. Raises InvalidInput or Cancelled. Cost: O(F log F); 200 bytes a face with the mesh.
    """
    return Patches(*_core._tile_detail_patches(mesh, tolerance, noise, job))


def find_regions(
    sums: ArrayLike,
    pairs: ArrayLike,
    components: Components,
    tolerance: float,
    noise: float,
    snap: bool = True,
    cost: float | None = None,
    job: Job | None = None,
) -> Found:
    """How many regions the joined graph has at a tolerance: all is merged to one tree, which is cut there.

    The patches must be finer than the tolerance, as `detail_patches` makes them. cost: where to cut the tree; None:
    chosen by tolerance, noise and, with `snap`, a gap in the costs. Raises InvalidInput or Cancelled.
    Cost: O(K log K).
    """
    graph = (sums, pairs, components.component, components.need)
    return Found(*_core._tile_find_regions(*graph, tolerance, noise, snap, cost, job))


def least_cost(tolerance: float, noise: float) -> float:
    """Merges that cost less are made whatever `find_regions` chooses; scene units squared."""
    cost: float = _core._tile_least_cost(tolerance, noise)
    return cost


def find_components(
    sums: ArrayLike, pairs: ArrayLike, lengths: ArrayLike, open_nodes: ArrayLike, proxies: int, leave_out: float = 0.001
) -> Components:
    """Find the components of the joined graph, which of them are left out, and how many regions each needs.

    open_nodes: (K,) whether a node lies on the border of the whole scan. A component without one is closed and needs
    four regions. `leave_out` as in PartitionOptions. Raises InvalidInput (arrays that do not fit). Cost: O(K log K).
    """
    nodes = np.asarray(open_nodes, dtype=np.uint8)
    return Components(*_core._tile_components(sums, pairs, lengths, nodes, proxies, leave_out))


def merge(
    sums: ArrayLike,
    pairs: ArrayLike,
    lengths: ArrayLike,
    components: Components,
    target: int,
    smooth: float = 0.0,
    error: float = 0.0,
    proxies: int = 1,
    job: Job | None = None,
) -> NDArray[np.int32]:
    """Merge neighbours of the joined graph by exact prices, cheapest first, until `target` are left.

    Returns the region (K,) of each node, numbered by first node; -1 where it is left out. No component falls below its
    need. smooth, error (a share of the area) and proxies set the price of borders; smooth 0: borders cost nothing.
    Raises InvalidInput or Cancelled. Cost: O(K log K); 270 bytes a node.
    """
    graph = (sums, pairs, lengths, components.component, components.need)
    labels: NDArray[np.int32] = _core._tile_merge(*graph, target, smooth, error, proxies, job)
    return labels


def merge_inside(
    sums: ArrayLike,
    pairs: ArrayLike,
    lengths: ArrayLike,
    components: Components,
    border: ArrayLike,
    target: int,
    limit: float = math.inf,
    *,
    smooth: float = 0.0,
    error: float = 0.0,
    proxies: int = 1,
    area: float = 0.0,
    job: Job | None = None,
) -> Merges:
    """Merge what a group of tiles has of the joined graph, as far as that is safe, so that no process has all of it.

    border: (K,) bool, nodes that have neighbours outside; they do not merge with each other, and what merges with one
    pays as if it were endless. components: of the group's own graph. It ends at `target` nodes, or before a price above
    `limit`.
    smooth, error, proxies as for `merge`; area: of all tiles, where borders have a price.
    All groups are then cut at the same price, see `common_price`. Raises InvalidInput or Cancelled. Cost: as `merge`.
    """
    at_border = np.asarray(border, dtype=np.uint8)
    graph = (sums, pairs, lengths, components.component, components.need, at_border)
    merged, price = _core._tile_merge_inside(*graph, target, limit, smooth, error, proxies, area, job)
    return Merges(merged, np.maximum.accumulate(price))


def common_price(prices: Sequence[NDArray[np.float64]], nodes: int, target: int) -> float:
    """The price below which the merges of all groups leave at least `target` of `nodes`, and hardly more.

    prices: of the groups, as `merge_inside` gives them. Cost: O(M).
    """
    every = np.concatenate([np.zeros(0), *prices])
    count = max(0, nodes - target)
    return math.inf if count >= len(every) else float(np.partition(every, count)[count])


def labels_after(nodes: int, merges: Merges, price: float) -> NDArray[np.int32]:
    """The cluster (nodes,) of each node after the merges below a price, numbered by first node. Cost: O(nodes)."""
    above = np.arange(nodes, dtype=np.int32)
    count = int(np.searchsorted(merges.price, price))
    above[merges.merged[:count, 1]] = merges.merged[:count, 0]
    while (above != (up := above[above])).any():
        above = up
    first = np.full(nodes, nodes, np.int32)
    np.minimum.at(first, above, np.arange(nodes, dtype=np.int32))
    number: NDArray[np.int32] = np.cumsum(first[above] == np.arange(nodes), dtype=np.int32) - 1
    result: NDArray[np.int32] = number[first[above]]
    return result


def contracted(
    label: NDArray[np.int32], sums: NDArray[np.float64], pairs: NDArray[np.int32], lengths: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.float64]]:
    """The graph in which all nodes of a label are one: its sums, its pairs, each once, and their lengths.

    label: (K,) without gaps. Cost: O(K + E log E).
    """
    count = int(label.max()) + 1 if len(label) else 0
    merged = np.empty((count, 5))
    for k in range(5):
        merged[:, k] = np.bincount(label, sums[:, k], count)
    ends = np.sort(label[pairs], axis=1).astype(np.int64)
    apart = ends[:, 0] != ends[:, 1]
    key, at = np.unique(ends[apart, 0] * count + ends[apart, 1], return_inverse=True)
    both = np.stack([key // max(count, 1), key % max(count, 1)], 1).astype(np.int32)
    total: NDArray[np.float64] = np.bincount(at, lengths[apart], len(key)).astype(np.float64, copy=False)
    return merged, both, total


def relax(
    record: ArrayLike,
    neighbour: ArrayLike,
    owned: int,
    label: ArrayLike,
    frozen: ArrayLike,
    sums: ArrayLike,
    *,
    error: float,
    area: float,
    faces: int,
    regions: int,
    smooth: float = 0.5,
    sweeps: int = 8,
    job: Job | None = None,
) -> Relaxed:
    """Move faces of a tile between neighbouring regions, by the error and the engine's weight of borders.

    record, neighbour, label: of the tile's own faces, `owned` of them, and then of its halo. frozen: (F + H,) bool,
    faces that stay in this round; a region can't fall apart if round each vertex only the tile of the highest rank
    moves faces.
    sums: (R, 5) of all regions. error (a share), area, faces: of all tiles; regions: how many are wanted.
    Raises InvalidInput or Cancelled. Cost: O(F) and what moves; 60 bytes a face.
    """
    stays = np.asarray(frozen, dtype=np.uint8)
    whole = (error, smooth, area, faces, regions, sweeps)
    return Relaxed(*_core._tile_relax(record, neighbour, owned, label, stays, sums, *whole, job))


def touching(
    neighbour: ArrayLike, owned: int, label: ArrayLike, length: ArrayLike
) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """The pairs of regions that meet in a tile or at its border, and half the length of what they share there.

    The other half comes from the other side, so that tiles add up. Cost: O(F).
    """
    pairs, lengths = _core._tile_touching(neighbour, owned, label, length)
    return pairs, lengths


def thin(mesh: Mesh, label: ArrayLike, moments: ArrayLike | None = None, job: Job | None = None) -> Thinned:
    """Take out vertices inside regions; borders of regions and of the mesh stay, and with them all mean normals.

    label: (F,) region of each face; faces with -1 are dropped. moments: (F, 10) of what the faces stand for already;
    sums over regions stay the same. No face turns over, and each looks within 14 degrees of the mean direction of what
    it stands for: what stands inside a region is kept. Raises InvalidInput or Cancelled. Cost: O(F), 1 us a face.
    """
    return Thinned(*_core._tile_thin(mesh, label, moments, job))


def kept_moments(mesh: Mesh, moments: ArrayLike) -> _core._Moments:
    """The moments (F, 10) of a thinned mesh as `polygonize_thinned` keeps them; then the array may go.

    Raises InvalidInput. Cost: O(F); 80 bytes a face.
    """
    return _core._tile_keep_moments(mesh, moments)


def polygonize_thinned(
    mesh: Mesh,
    partition: Partition,
    options: MeshingOptions,
    moments: ArrayLike | _core._Moments,
    job: Job | None = None,
) -> PolygonMesh:
    """As `polygonize`, with planes fitted to the scan's faces that those of a thinned mesh stand for.

    moments: (F, 10) as `thin` gives them, or what `kept_moments` made of them. Raises InvalidInput or Cancelled.
    """
    kept = moments if isinstance(moments, _core._Moments) else kept_moments(mesh, moments)
    polygons: PolygonMesh = _core._tile_polygonize(mesh, partition, options, kept, job)
    return polygons


def weld(points: ArrayLike, tile: ArrayLike, length: float, job: Job | None = None) -> NDArray[np.int32]:
    """Which vertices on borders of tiles are one: the index (N,) of the point whose place each takes.

    points: (N, 3) in the order of their tiles. A point goes to the nearest place of an earlier tile at most `length`
    away; of two points of a tile that want one place the nearer gets it. Cost: O(N) where few are that near.
    """
    to: NDArray[np.int32] = _core._tile_weld(points, tile, length, job)
    return to


def points_on_edges(ends: ArrayLike, points: ArrayLike, length: float, job: Job | None = None) -> NDArray[np.int32]:
    """T-junctions: pairs (J, 2) of an edge and a point inside it, at most `length` off; by edge, then along it.

    ends: (2 E, 3) the two ends of each edge. points: (N, 3).
    """
    found: NDArray[np.int32] = _core._tile_points_on_edges(ends, points, length, job)
    return found


def add_changes(sums: NDArray[np.float64], changes: list[tuple[Any, Any]]) -> NDArray[np.float64]:
    """The sums after a round, from what each tile changed, in the order of the tiles."""
    result = sums.copy()
    for changed, change in changes:
        result[changed] += change
    return result


def error_of(sums: NDArray[np.float64]) -> float:
    """The L2,1 error of all regions, in scene units squared."""
    return float(np.maximum(sums[:, 3] - 2 * np.linalg.norm(sums[:, :3], axis=1), 0).sum())
