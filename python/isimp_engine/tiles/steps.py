"""The steps from tiles to polygons as functions on arrays, for `isimp tiles` and for other schedulers.

Letters of shapes: F faces of a tile, H faces of its halo, K patches or regions, E pairs of them, R regions of all
tiles. Sums are (K, 5) float64: x, y, z of the sum of area * normal, twice the area, and the number of faces. Pairs
are (E, 2) int32, and `lengths` (E,) float64 has the length of the border of each. Areas and lengths are in scene units.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import Job, Mesh, MeshingOptions, Partition, PolygonMesh, _core


class Faces(NamedTuple):
    """The faces of a mesh in the form for `relax`. Adjacent faces are close to each other in memory."""

    record: NDArray[np.float32]  #: (F, 4) unit normal and area
    neighbour: NDArray[np.int32]  #: (F, 3) the face across corner k -> k + 1; -1: none
    mesh_face: NDArray[np.int32]  #: (F,) index in the mesh of each face
    length: NDArray[np.float32]  #: (F, 3) length of the edge k -> k + 1


class Patches(NamedTuple):
    """Small regions of a tile, and their graph."""

    label: NDArray[np.int32]  #: (F,) the patch of each face, in the order of Faces
    sums: NDArray[np.float64]  #: (K, 5)
    pairs: NDArray[np.int32]  #: (E, 2)
    lengths: NDArray[np.float64]  #: (E,)


class Extent(NamedTuple):
    """Measures of a tile, from which the size and the noise of the whole scan follow; see `size_and_noise`."""

    area: float
    centre: list[float]  #: centroid of the surface
    spread: float  #: mean squared distance of the surface from the centre
    noise: float  #: standard deviation along the normal


class Components(NamedTuple):
    """The connected components of a joined graph."""

    component: NDArray[np.int32]  #: (K,) component of each node; -1: left out
    need: NDArray[np.int32]  #: (C,) least number of regions of each component; 0: left out
    left_out: int  #: number of components that are left out
    area_left_out: float  #: their share of the area


class Found(NamedTuple):
    """The number of regions of a scan at a tolerance."""

    regions: int
    cost: float  #: merges up to this cost were made, scene units squared
    snapped: bool  #: the number is the shape's own number of planes


class Merges(NamedTuple):
    """The merges inside a group of tiles, in order."""

    merged: NDArray[np.int32]  #: (M, 2) the second node becomes part of the first and merges no more
    price: NDArray[np.float64]  #: (M,) scene units squared: the highest price up to each merge, so it never falls


class Relaxed(NamedTuple):
    """The result of a round of relaxing in one tile."""

    label: NDArray[np.int32]  #: (F,) regions of the tile's own faces
    changed: NDArray[np.int32]  #: (C,) the regions that gave or took faces, rising
    change: NDArray[np.float64]  #: (C, 5) the changes of their sums
    moves: int


class Thinned(NamedTuple):
    """A mesh without most of the vertices inside its regions."""

    vertices: NDArray[np.float64]  #: (V, 3)
    triangles: NDArray[np.int32]  #: (F, 3)
    label: NDArray[np.int32]  #: (F,) region of each face
    moments: NDArray[np.float64]  #: (F, 10) area, centre and second moments of the scan faces that each represents


def faces_of(mesh: Mesh) -> Faces:
    """Return the faces of a mesh in the form for `relax`. Cost: O(F); 44 bytes a face."""
    return Faces(*_core._tile_faces(mesh))


def patches(mesh: Mesh, size: int, smooth: float = 0.5, job: Job | None = None) -> Patches:
    """Split a tile into patches of about `size` faces, by the engine's own partition.

    No component is left out, because the graph of all tiles decides about that. Each component gets at least the number
    of patches that its topology needs. Raises InvalidInput (size below 1) or Cancelled. Cost: O(F); 130 bytes a face
    with the mesh.
    """
    return Patches(*_core._tile_patches(mesh, size, smooth, job))


def measure(mesh: Mesh, job: Job | None = None) -> Extent:
    """Measure a tile, for the size and the noise of the whole scan. Cost: O(F)."""
    return Extent(*_core._tile_measure(mesh, job))


def size_and_noise(extents: Sequence[Extent]) -> tuple[float, float]:
    """Return the size of a scan, in which `detail` is a share, and its noise: the median of the tiles, by area."""
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
    """Split a tile into patches that show all detail at a tolerance. `tolerance` and `noise`: scene units.

    No component is left out. noise: noise of the whole scan. Raises InvalidInput or Cancelled. Cost: O(F log F);
    200 bytes a face with the mesh.
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
    """Find the number of regions of the joined graph at a tolerance: merge it to one tree, and cut the tree there.

    The patches must be finer than the tolerance, as from `detail_patches` at a fraction of it. cost: the cost at which
    the tree is cut; None: found from tolerance, noise and, with `snap`, a gap in the costs. Raises InvalidInput or
    Cancelled.
    Cost: O(K log K).
    """
    graph = (sums, pairs, components.component, components.need)
    return Found(*_core._tile_find_regions(*graph, tolerance, noise, snap, cost, job))


def least_cost(tolerance: float, noise: float) -> float:
    """Return the cost below which `find_regions` makes every merge at this tolerance; scene units squared."""
    cost: float = _core._tile_least_cost(tolerance, noise)
    return cost


def find_components(
    sums: ArrayLike, pairs: ArrayLike, lengths: ArrayLike, open_nodes: ArrayLike, proxies: int, leave_out: float = 0.001
) -> Components:
    """Find the components of the joined graph and the number of regions that each needs. Leave small ones out.

    open_nodes: (K,) whether a node lies on the border of the whole scan. A component without such a node is closed and
    needs four regions. leave_out: see PartitionOptions. Raises InvalidInput (arrays that do not fit). Cost: O(K log K).
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

    Returns the region (K,) of each node, numbered by first node; -1: left out. No component falls below its need.
    smooth, error (a share of the area) and proxies set the price of borders; smooth 0: borders cost nothing.
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
    """Merge the part of the joined graph that belongs to a group of tiles, as far as that is safe.

    So no process needs the whole graph. Afterwards all groups are cut at the same price; see `common_price`.
    border: (K,) bool, nodes with neighbours outside. They do not merge with each other, and the price of a merge with
    one of them is computed as if that node were infinitely large. components: components of the group's own graph.
    Merging ends at `target` nodes, or before a price above `limit`. smooth, error, proxies: as for `merge`. area: area
    of all tiles, needed if borders have a price. Raises InvalidInput or Cancelled. Cost: as `merge`.
    """
    at_border = np.asarray(border, dtype=np.uint8)
    graph = (sums, pairs, lengths, components.component, components.need, at_border)
    merged, price = _core._tile_merge_inside(*graph, target, limit, (smooth, error, proxies, area), job)
    return Merges(merged, np.maximum.accumulate(price))


def common_price(prices: Sequence[NDArray[np.float64]], nodes: int, target: int) -> float:
    """Return a price: the merges of all groups below it leave at least `target` of `nodes`, and few more.

    prices: the prices of each group, from `merge_inside`. Cost: O(M).
    """
    every = np.concatenate([np.zeros(0), *prices])
    count = max(0, nodes - target)
    return math.inf if count >= len(every) else float(np.partition(every, count)[count])


def labels_after(nodes: int, merges: Merges, price: float) -> NDArray[np.int32]:
    """Return the cluster (nodes,) of each node after the merges below a price. Cost: O(nodes).

    Clusters are numbered by first node.
    """
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
    """Join all nodes of a label; returns the sums, pairs and lengths of the new graph. Each pair appears once.

    label: (K,) numbers without gaps. Cost: O(K + E log E).
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


class WholeScan(NamedTuple):
    """Values of all tiles that `relax` needs."""

    error: float  #: a share
    area: float
    faces: int
    regions: int  #: number of regions to be made
    smooth: float = 0.5
    sweeps: int = 8


def relax(
    record: ArrayLike,
    neighbour: ArrayLike,
    owned: int,
    label: ArrayLike,
    frozen: ArrayLike,
    sums: ArrayLike,
    whole: WholeScan,
    job: Job | None = None,
) -> Relaxed:
    """Move faces of a tile between neighbouring regions, by the error and the engine's weight of borders.

    record, neighbour, label: values of the tile's `owned` own faces, then of its halo. frozen: (F + H,) bool, faces
    that stay in this round. A region can't fall apart if, at each vertex, only the tile with the highest rank moves
    faces. sums: (R, 5) sums of all regions. Raises InvalidInput or Cancelled. Cost: O(F), and in proportion to the
    number of moves; 60 bytes a face.
    """
    stays = np.asarray(frozen, dtype=np.uint8)
    return Relaxed(*_core._tile_relax(record, neighbour, owned, label, stays, sums, whole, job))


def touching(
    neighbour: ArrayLike, owned: int, label: ArrayLike, length: ArrayLike
) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """Return the pairs of regions that meet in a tile or at its border, and the lengths of their borders.

    Each side of an edge counts half of its length, so that the lengths of tiles can be added. Cost: O(F).
    """
    pairs, lengths = _core._tile_touching(neighbour, owned, label, length)
    return pairs, lengths


def thin(mesh: Mesh, label: ArrayLike, moments: ArrayLike | None = None, job: Job | None = None) -> Thinned:
    """Remove vertices inside regions. Borders of regions and of the mesh stay, and therefore all mean normals.

    label: (F,) region of each face; faces with -1 are dropped. moments: (F, 10) moments of the scan faces that each
    face represents; None: each represents itself. Sums over regions stay the same. No face turns over. The normal of
    each face stays within 14 degrees of the mean direction of the scan faces that it represents, so structures inside
    a region stay. Raises InvalidInput or Cancelled. Cost: O(F), 1 us a face.
    """
    return Thinned(*_core._tile_thin(mesh, label, moments, job))


def kept_moments(mesh: Mesh, moments: ArrayLike) -> _core._Moments:
    """Copy the moments (F, 10) of a thinned mesh for `polygonize_thinned`, so that the array can be freed.

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
    """Make polygons as `polygonize` does, with planes fitted to the scan faces that a thinned mesh represents.

    moments: (F, 10) from `thin`, or the result of `kept_moments`. Raises InvalidInput or Cancelled.
    """
    kept = moments if isinstance(moments, _core._Moments) else kept_moments(mesh, moments)
    polygons: PolygonMesh = _core._tile_polygonize(mesh, partition, options, kept, job)
    return polygons


def weld(points: ArrayLike, tile: ArrayLike, length: float, job: Job | None = None) -> NDArray[np.int32]:
    """Match vertices on borders of tiles; returns the index (N,) of the point whose place each takes.

    points: (N, 3) in the order of their tiles. A point moves to the nearest place of an earlier tile, at most `length`
    away. If two points of a tile have the same nearest place, only the nearer one moves. Cost: O(N) if few points are
    this close to each other.
    """
    to: NDArray[np.int32] = _core._tile_weld(points, tile, length, job)
    return to


def points_on_edges(ends: ArrayLike, points: ArrayLike, length: float, job: Job | None = None) -> NDArray[np.int32]:
    """Return T-junctions: pairs (J, 2) of an edge and a point inside it, at most `length` off, in order along edges.

    ends: (2 E, 3) the two ends of each edge. points: (N, 3).
    """
    found: NDArray[np.int32] = _core._tile_points_on_edges(ends, points, length, job)
    return found


def add_changes(sums: NDArray[np.float64], changes: list[tuple[Any, Any]]) -> NDArray[np.float64]:
    """Return the sums after a round: adds the changes of each tile, in the order of the tiles."""
    result = sums.copy()
    for changed, change in changes:
        result[changed] += change
    return result


def error_of(sums: NDArray[np.float64]) -> float:
    """Return the L2,1 error of all regions, in scene units squared."""
    return float(np.maximum(sums[:, 3] - 2 * np.linalg.norm(sums[:, :3], axis=1), 0).sum())
