"""The faces of a scan as a person has them, polygons of any kind, and the faces of its repaired mesh."""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import Mesh, Partition
from ..surfaces import areas

Indices = NDArray[np.integer[Any]]
Edges = tuple[Indices, Indices]
Bools = NDArray[np.bool_]
Labels = NDArray[np.int32]

_BLOCK = 1 << 15  # values that fit into the processor's cache


def face_edges(edges: Edges, triangle_face: Indices) -> Edges:
    """(E, 2) faces that share an edge, (E, 2) the vertices of that edge. edges: the same of triangles."""
    pairs, ends = edges
    if np.array_equal(triangle_face, np.arange(len(triangle_face))):
        return pairs, ends
    faces = triangle_face.astype(np.intp)[pairs.T]
    apart = faces[0] != faces[1]
    return faces[:, apart].T, ends[apart]


@dataclass(frozen=True, eq=False)
class Faces:
    """The maps between the faces of a scan and the faces of its mesh, its triangles; made when they are used."""

    mesh: Mesh
    triangle_face: Indices  #: (T,) the face of each triangle that was repaired
    count: int
    vertices: NDArray[Any]  #: (V, 3) of the scan
    edges_of_scan: Callable[[], Edges]  #: `face_edges` of the scan

    @cached_property
    def mesh_face(self) -> Indices:
        """(F',) the scan's face of each face of the mesh. Covers of openings belong to the nearest one."""
        found: Indices = self.triangle_face[self.mesh.source_face]
        covers = self._covers
        if len(covers):
            found[covers] = _faces_beside(np.asarray(self.mesh.triangles), found, covers)
        return found

    @cached_property
    def _covers(self) -> Indices:
        return np.flatnonzero(np.asarray(self.mesh.source_face) < 0)

    @cached_property
    def shared(self) -> Indices:
        """(K,) faces of the mesh whose scan's face has several of them, in rising order."""
        first, triangle = np.full(self.count, -1, np.int32), np.arange(len(self.mesh_face), dtype=np.int32)
        first[self.mesh_face] = triangle
        is_shared = np.zeros(self.count, bool)
        is_shared[self.mesh_face[first[self.mesh_face] != triangle]] = True
        return np.flatnonzero(is_shared[self.mesh_face])

    @cached_property
    def areas(self) -> NDArray[np.float64]:
        """(K,) areas of `shared`; 0 for covers, which must not determine the region of a face."""
        found = areas(np.asarray(self.mesh.vertices), np.asarray(self.mesh.triangles)[self.shared])
        found[np.isin(self.shared, self._covers)] = 0
        return found

    @cached_property
    def face_triangle(self) -> Labels:
        """(count,) the largest face of the mesh in each face of the scan, -1 if none is left."""
        found = np.full(self.count, -1, np.int32)
        found[self.mesh_face] = np.arange(len(self.mesh_face), dtype=np.int32)
        order = self.shared[np.argsort(self.areas, kind="stable")]
        found[self.mesh_face[order]] = order  # the last one written is the largest
        return found

    @property
    def pairs(self) -> Indices:
        """(E, 2) faces that share an edge."""
        return self.edges_of_scan()[0]

    def pair_lengths(self) -> NDArray[np.float64]:
        """(E,) the length of the shared edge of each of `pairs`."""
        ends = self.vertices[self.edges_of_scan()[1]].astype(np.float64)
        return np.asarray(np.nan_to_num(np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)))

    def triangle_at(self, face: int) -> int:
        """The largest triangle of a face. Raises ValueError if there is none."""
        if face >= self.count:
            raise ValueError(_no_face(face, self.count))
        triangle = int(self.face_triangle[face])
        if triangle < 0:
            raise ValueError(f"face {face} was left out by the repair of the mesh: it has no area or is a duplicate")
        return triangle

    def triangles_at(self, faces: Sequence[int]) -> Indices:
        """The triangles of faces, one of the first face first."""
        first = self.triangle_at(faces[0])
        if max(faces) >= self.count:
            raise ValueError(_no_face(max(faces), self.count))
        wanted = np.zeros(self.count, bool)
        wanted[list(faces)] = True
        triangles = np.flatnonzero(wanted[self.mesh_face])
        return np.concatenate([[first], triangles[triangles != first]])

    def regions(self, part: Partition) -> Labels:
        """(count,) the region of each face, -1 for none.

        A face whose triangles are in several regions belongs to the one with most of its area. A region without a
        face after that gets the face of its seed.
        """
        label = np.asarray(part.face_region)
        region = np.full(self.count, -1, np.int32)
        for begin in range(0, len(label), _BLOCK):
            block = slice(begin, begin + _BLOCK)
            region[self.mesh_face[block]] = label[block]
        if len(self.shared) == 0:
            return region
        face, label = self.mesh_face[self.shared], label[self.shared]
        region[face] = -1
        inside = label >= 0
        key = face[inside].astype(np.int64) * part.region_count + label[inside]
        keys, where = np.unique(key, return_inverse=True)
        area = np.bincount(where, self.areas[inside])
        order = np.lexsort((-keys, area))  # by area; for equal areas the lowest region is last
        region[keys[order] // part.region_count] = keys[order] % part.region_count
        seed_face = self.mesh_face[np.asarray(part.region_seed)]
        has_face = np.zeros(part.region_count + 1, bool)  # the last entry is for faces without region
        has_face[region] = True
        lost = np.flatnonzero(~has_face[:-1])
        region[seed_face[lost]] = lost
        return region

    def joined(self, separated: Indices) -> Bools:
        """(E,) whether no barrier separates each of `pairs`. separated: (K, 2) separated triangles."""
        pairs = self.pairs
        apart = np.sort(self.mesh_face[separated], axis=1)
        count = max(self.count, 1)
        ends = np.sort(pairs, axis=1).astype(np.int64)
        return ~np.isin(ends[:, 0] * count + ends[:, 1], apart[:, 0].astype(np.int64) * count + apart[:, 1])

    def with_split(self, part: Partition, faces: Bools, home: Bools, pairs: Indices) -> Bools:
        """(count,) `faces`, and adjacent faces of `home` whose triangles are in several regions.

        A region is connected over triangles. Painting all triangles of such a face connects its neighbours to the
        region. Faces with a locked triangle are excluded.
        """
        if len(self.shared) == 0:  # each face is one triangle
            return faces
        face = self.mesh_face[self.shared]
        label = np.asarray(part.face_region)[self.shared]
        split = np.zeros(self.count, bool)
        one = np.zeros(self.count, label.dtype)
        one[face] = label
        split[face[one[face] != label]] = True
        split[face[label < 0]] = False
        split[face[(label >= 0) & np.append(part.region_locked, False)[label]]] = False
        beside = np.zeros(self.count, bool)
        beside[pairs[faces[pairs].any(axis=1)].ravel()] = True
        return faces | (beside & home & split)

    def named(self, message: str) -> str:
        """A message of the engine with the numbers of the scan's faces in place of the mesh's."""

        def of_scan(number: re.Match[str]) -> str:
            face = int(number[0])
            return str(self.mesh_face[face]) if face < len(self.mesh_face) else number[0]

        return re.sub(r"\bfaces? \d+(?: and \d+)?", lambda found: re.sub(r"\d+", of_scan, found[0]), message)


def _no_face(face: int, count: int) -> str:
    return f"there is no face {face}: the mesh has {count} faces"


def _faces_beside(triangles: Indices, mesh_face: Indices, covers: Indices) -> Indices:
    """(K,) the scan's face of the triangle nearest to each cover that is not a cover, by steps across edges."""
    near = np.zeros(triangles.max() + 1, bool)
    near[triangles[covers]] = True
    some = np.flatnonzero(near[triangles].sum(axis=1) >= 2)  # covers, and triangles that share an edge with one
    ends = np.sort(triangles[some][:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    _, edge = np.unique(ends, axis=0, return_inverse=True)
    order = np.argsort(edge.ravel(), kind="stable")
    face, edge = np.repeat(np.arange(len(some)), 3)[order], edge.ravel()[order]
    pair = np.flatnonzero(edge[1:] == edge[:-1])
    a, b = face[pair], face[pair + 1]
    known = np.where(np.isin(some, covers), -1, mesh_face[some])
    for _ in range(len(covers)):
        for one, other in ((a, b), (b, a)):
            take = (known[one] < 0) & (known[other] >= 0)
            known[one[take]] = known[other[take]]
        if (known >= 0).all():
            break
    result = np.full(len(triangles), -1, mesh_face.dtype)
    result[some] = known
    return result[covers]
