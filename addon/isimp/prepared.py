"""The engine's repaired mesh of a scan, with the maps between its faces and the user's faces."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from . import view
from .array_pool import blocks
from .engine import engine
from .language import said
from .scan import Scan


@dataclass(frozen=True)
class Closing:
    """Options of the repair before the partition: limits for the openings to close, and other lengths."""

    handles: float = 0.0  #: handles up to this length are cut, scene units
    holes: float = 0.0  #: holes up to this length are filled, scene units
    flat_holes: float = 0.0  #: holes in flat walls up to this length are filled, scene units
    kept: tuple = ()  #: places of openings that stay open
    left_out: int = 0  #: number of components that stay as they are, since the partition leaves them out
    stitch: float | None = None  #: largest distance of borders to stitch; None: the engine finds it
    grid: float | None = None  #: cell of the grid whose steps are smoothed; None: the engine finds it

    def up_to(self, lengths, kept: tuple) -> Closing:
        """Return the repair with openings closed up to these lengths, except openings at the kept places."""
        holes, flat, handles = lengths.holes, lengths.flat_holes, lengths.handles
        return replace(self, handles=handles, holes=holes, flat_holes=flat, kept=kept, left_out=lengths.left_out)

    @property
    def opened(self) -> Closing:
        """The same repair without closing openings."""
        return replace(self, handles=0.0, holes=0.0, flat_holes=0.0, kept=(), left_out=0)


NONE_CLOSED = Closing()


@dataclass(frozen=True, eq=False)
class Prepared:
    """A scan with the engine's mesh of it, and the maps to the user's faces."""

    scan: Scan
    mesh: Any
    mesh_face: np.ndarray  #: (F',) the user's face of each face of the mesh
    face_triangle: np.ndarray  #: (face_count,) the largest face of the mesh in each user's face, -1 if none is left
    layers: dict = field(default_factory=dict, kw_only=True)  #: present layers of the scan
    closing: Closing = field(default=NONE_CLOSED, kw_only=True)  #: the repair that made the mesh
    shared: np.ndarray  #: (K,) faces of the mesh whose user's face has several of them, in rising order
    areas: np.ndarray  #: (K,) areas of `shared`; 0 for covers

    @property
    def face_pairs(self) -> np.ndarray:
        """(E, 2) user's faces that share an edge."""
        return self.scan.face_edges[0]


def prepared_of(scan: Scan, mesh) -> Prepared:
    """Return the scan with the engine's mesh of it. Covers of openings belong to the nearest user's face."""
    mesh_face = scan.triangle_face[mesh.source_face]
    covers = np.flatnonzero(np.asarray(mesh.source_face) < 0)
    if len(covers):
        mesh_face[covers] = _faces_beside(np.asarray(mesh.triangles), mesh_face, covers)
    scan.face_edges  # noqa: B018  (computed here and cached)
    face_triangle = np.full(scan.face_count, -1, np.int32)
    triangle = np.arange(len(mesh_face), dtype=np.int32)
    face_triangle[mesh_face] = triangle
    is_shared = np.zeros(scan.face_count, bool)
    is_shared[mesh_face[face_triangle[mesh_face] != triangle]] = True
    shared = np.flatnonzero(is_shared[mesh_face])
    areas = face_areas(mesh, shared)
    areas[np.isin(shared, covers)] = 0  # covers must not determine the region of a user's face
    order = shared[np.argsort(areas, kind="stable")]
    face_triangle[mesh_face[order]] = order  # the last one written is the largest
    return Prepared(scan, mesh, mesh_face, face_triangle, shared, areas)


def _faces_beside(triangles: np.ndarray, mesh_face: np.ndarray, covers: np.ndarray) -> np.ndarray:
    """Return (K,) the user's face of the triangle nearest to each cover that is not a cover, by steps across edges."""
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


def face_areas(mesh, faces: np.ndarray) -> np.ndarray:
    triangles = np.asarray(mesh.triangles)[faces]
    a, b, c = (np.asarray(mesh.vertices)[triangles[:, k]] for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def pair_lengths(prepared: Prepared) -> np.ndarray:
    """Return (E,) the length of the shared edge of each of `face_pairs`."""
    scan = prepared.scan
    ends = scan.vertices[scan.face_edges[1]].astype(np.float64)
    return np.nan_to_num(np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1))


def joined_pairs(prepared: Prepared, separated: np.ndarray) -> np.ndarray:
    """Return (E,) bool: whether no barrier separates each of `face_pairs`. separated: (K, 2) separated triangles."""
    pairs = prepared.face_pairs
    apart = np.sort(prepared.mesh_face[separated], axis=1)
    count = max(prepared.scan.face_count, 1)
    ends = np.sort(pairs, axis=1).astype(np.int64)
    return ~np.isin(ends[:, 0] * count + ends[:, 1], apart[:, 0].astype(np.int64) * count + apart[:, 1])


def joined_faces(prepared: Prepared, faces: np.ndarray, start: int) -> np.ndarray:
    """Return the faces that are connected to `start` over shared edges of the engine's mesh.

    The repair may have changed edges of the user's mesh, for example flipped them. faces: in rising order.
    """
    inside = np.zeros(prepared.scan.face_count, bool)
    inside[faces] = True
    some = np.flatnonzero(inside[prepared.mesh_face])
    beside, _ = engine.guides.shared_edges(np.asarray(prepared.mesh.triangles)[some])
    return view.connected(faces, prepared.mesh_face[some[beside]], start)


def with_split_faces(prepared: Prepared, partition, faces: np.ndarray, home: np.ndarray, pairs: np.ndarray):
    """Return (F,) bool: `faces`, and adjacent faces of `home` whose triangles are in several regions.

    A region is connected over triangles. Painting all triangles of such a face connects its neighbours to the region.
    Faces with a locked triangle are excluded. faces, home: (F,) bool.
    """
    if len(prepared.shared) == 0:  # each user's face is one triangle
        return faces
    count, face = prepared.scan.face_count, prepared.mesh_face[prepared.shared]
    label = np.asarray(partition.face_region)[prepared.shared]
    split = np.zeros(count, bool)
    one = np.zeros(count, label.dtype)
    one[face] = label
    split[face[one[face] != label]] = True
    split[face[label < 0]] = False
    split[face[(label >= 0) & np.append(partition.region_locked, False)[label]]] = False
    beside = np.zeros(count, bool)
    beside[pairs[faces[pairs].any(axis=1)].ravel()] = True
    return faces | (beside & home & split)


def face_regions(prepared: Prepared, partition) -> np.ndarray:
    """Return (face_count,) int32 the region of each user's face, -1 for none.

    A face whose triangles are in several regions belongs to the one with most of its area. A region without a face
    after that gets the face of its seed.
    """
    label = np.asarray(partition.face_region)
    region = np.full(prepared.scan.face_count, -1, np.int32)
    for block in blocks(len(label)):
        region[prepared.mesh_face[block]] = label[block]
    if len(prepared.shared) == 0:
        return region
    face, label = prepared.mesh_face[prepared.shared], label[prepared.shared]
    region[face] = -1
    inside = label >= 0
    key = face[inside].astype(np.int64) * partition.region_count + label[inside]
    keys, where = np.unique(key, return_inverse=True)
    area = np.bincount(where, prepared.areas[inside])
    order = np.lexsort((-keys, area))  # by area; for equal areas the lowest region is last
    region[keys[order] // partition.region_count] = keys[order] % partition.region_count
    seed_face = prepared.mesh_face[np.asarray(partition.region_seed)]
    has_face = np.zeros(partition.region_count + 1, bool)  # the last entry is for faces without region
    has_face[region] = True
    lost = np.flatnonzero(~has_face[:-1])
    region[seed_face[lost]] = lost
    return region


def scan_numbers(prepared: Prepared) -> dict:
    report = prepared.mesh.report
    names = ("components", "border_loops", "closed", "diagonal", "repairs")
    return {"triangles": len(prepared.scan.triangles), "faces": prepared.scan.face_count} | {
        name: report[name] for name in names if name in report
    }


def in_users_faces(message: str, prepared: Prepared) -> str:
    """Return an engine's message with the user's face numbers in place of the mesh's."""

    def users(number: re.Match) -> str:
        face = int(number[0])
        return str(prepared.mesh_face[face]) if face < len(prepared.mesh_face) else number[0]

    return re.sub(r"\bfaces? \d+(?: and \d+)?", lambda found: re.sub(r"\d+", users, found[0]), message)


def _no_face(face: int, count: int) -> str:
    return said("there is no face {face}: the mesh has {count} faces", face=face, count=count)


def triangle_at(prepared: Prepared, face: int) -> int:
    if face >= prepared.scan.face_count:
        raise ValueError(_no_face(face, prepared.scan.face_count))
    triangle = int(prepared.face_triangle[face])
    if triangle < 0:
        raise ValueError(f"face {face} was left out by the repair of the mesh: it has no area or is a duplicate")
    return triangle


def triangles_at(prepared: Prepared, faces: tuple[int, ...]) -> np.ndarray:
    """Return the triangles of user's faces, one of the first face first."""
    first = triangle_at(prepared, faces[0])
    count = prepared.scan.face_count
    if max(faces) >= count:
        raise ValueError(_no_face(max(faces), count))
    wanted = np.zeros(count, bool)
    wanted[list(faces)] = True
    triangles = np.flatnonzero(wanted[prepared.mesh_face])
    return np.concatenate([[first], triangles[triangles != first]])
