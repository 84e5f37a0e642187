"""A scan in any form, as triangles and as a clean mesh, and back to the faces that were given."""

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._core import InvalidInput, Job, Mesh
from .file_faces import cut, largest_shares
from .guides import shared_edges
from .reading import GLTF, check_faces, check_kind, read_polygons, unit_of
from .replay import Surface, face_edges
from .replay.faces import Edges
from .surfaces import areas
from .texturing import TexturedSoup, read_textured
from .texturing.reading import read_shape


@dataclass(frozen=True, eq=False)
class Source:
    """A scan's faces cut into triangles: triangle t is part of the face `polygon[t]`."""

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int32]
    polygon: NDArray[np.int32]
    faces: int
    path: Path | None = None  #: its file
    soup: TexturedSoup | None = None  #: faces with their texture, if the caller requested it
    mesh: Mesh | None = None  #: the scan itself, if it was given repaired
    unit: str | None = None  #: of its coordinates, if its file states one
    digest: str = ""  #: equal for equal scans, where there are several

    @property
    def is_whole(self) -> bool:
        """Whether the numbers of faces and vertices are the caller's: a Mesh of `clean` lacks the last dropped ones."""
        return self.mesh is None or not self.mesh.report["repairs"]

    @property
    def surface(self) -> Surface:
        """Its triangles with their faces."""
        face = self.polygon if self.mesh is None else self.mesh.source_face
        return Surface(self.vertices, self.triangles, face, self.faces)

    def unit_or(self, given: str | None) -> str:
        """The unit of the scene: the caller's, else that of the file, else metres."""
        return given or self.unit or "m"

    def scaled(self, factor: float) -> "Source":
        """The scan, larger by a factor."""
        soup = self.soup
        if soup is not None:
            soup = copy(soup)
            object.__setattr__(soup, "vertices", np.asarray(soup.vertices, np.float64) * factor)
        return replace(
            self, vertices=np.asarray(self.vertices, np.float64) * factor, soup=soup, digest=f"{self.digest}*{factor!r}"
        )

    def as_dict(self) -> dict[str, Any]:
        """Its file and numbers, for reports."""
        numbers = {"vertices": len(self.vertices), "faces": self.faces, "triangles": len(self.triangles)}
        return {"path": self.path and str(self.path)} | numbers

    @cached_property
    def triangle_edges(self) -> Edges:
        """(E, 2) triangles that share an edge, (E, 2) the vertices of that edge."""
        return shared_edges(self.triangles)

    @cached_property
    def face_edges(self) -> Edges:
        """(E, 2) faces that share an edge, (E, 2) the vertices of that edge."""
        pairs, ends = face_edges(self.triangle_edges, self.surface.face)
        known = (pairs >= 0).all(axis=1)
        return (pairs, ends) if known.all() else (pairs[known], ends[known])


def source_of(scan: Any, job: Job | None = None, threads: int = 0, textured: bool = False) -> Source:
    """A scan as `simplify` takes it. textured: read its texture too."""
    if isinstance(scan, (str, PathLike)):
        return load(Path(scan), job, threads, textured)
    if isinstance(scan, Mesh):
        count = _known_faces(scan)
        return Source(scan.vertices, scan.triangles, np.arange(count, dtype=np.int32), count, mesh=scan)
    if isinstance(scan, TexturedSoup):
        return _of_soup(scan, None)
    if not isinstance(scan, Sequence):
        faces = getattr(scan, "faces", None)
        scan = getattr(scan, "vertices", None), getattr(scan, "triangles", None) if faces is None else faces
    if len(scan) != 2 or scan[0] is None or scan[1] is None:
        raise InvalidInput("a scan is a path, a Mesh, (vertices, faces), or an object with `vertices` and `faces`")
    vertices = np.asarray(scan[0])
    triangles, polygon = _triangles(vertices, scan[1])
    return Source(vertices, triangles, polygon, len(scan[1]))


def _known_faces(mesh: Mesh) -> int:
    """The number of faces in the arrays of `clean`, up to the last that its mesh or its report has."""
    places = mesh.report["repaired_at"]
    dropped = [max(found) for key, found in places.items() if len(found) and not key.endswith("vertices")]
    return int(max([mesh.source_face.max(initial=-1), *dropped])) + 1


def _triangles(vertices: NDArray[Any], faces: Any) -> tuple[NDArray[Any], NDArray[np.int32]]:
    """The triangles of faces with any number of corners, and the face of each."""
    try:
        faces = np.asarray(faces)
    except ValueError:  # faces with different numbers of corners
        starts = np.cumsum([0, *(len(face) for face in faces)], dtype=np.int32)[:-1]
        return cut(vertices, np.concatenate([np.asarray(face) for face in faces]), starts)
    if faces.ndim != 2 or faces.shape[1] == 3:
        return faces, np.arange(len(faces), dtype=np.int32)
    return cut(vertices, faces.ravel(), np.arange(0, faces.size, faces.shape[1], dtype=np.int32))


def load(path: Path, job: Job | None, threads: int = 0, textured: bool = False) -> Source:
    """Read a scan's file. Raises FileError, also if it has points without faces, or Cancelled."""
    if check_kind(path) in GLTF:
        return _of_soup(read_textured(path, job=job) if textured else read_shape(path, job), path)
    vertices, loops, loop_start = read_polygons(path, job, threads=threads)
    check_faces(path, len(vertices), len(loop_start))
    triangles, polygon = cut(vertices, loops, loop_start)
    shown = read_textured(path, job=job, threads=threads) if textured else None
    return Source(vertices, triangles, polygon, len(loop_start), path, shown, unit=unit_of(path, job))


def _of_soup(soup: TexturedSoup, path: Path | None) -> Source:
    polygon = soup.polygon if soup.polygon is not None else np.arange(len(soup.triangles), dtype=np.int32)
    return Source(soup.vertices, soup.triangles, polygon, int(polygon.max(initial=-1)) + 1, path, soup)


def facts(mesh: Mesh) -> dict[str, Any]:
    """Properties of the mesh, without its repairs."""
    report = mesh.report
    return {
        key: value for key, value in report.items() if key not in report["repairs"] and not key.startswith("repair")
    }


def labels(source: Source, mesh: Mesh, regions: NDArray[np.int32]) -> NDArray[np.int32]:
    """The region of each face of the scan: the region with the largest share of its area; -1: no region has any."""
    kept = np.flatnonzero((regions >= 0) & (mesh.source_face >= 0))  # a face that covers a hole is in no file
    face, region = source.polygon[mesh.source_face[kept]], regions[kept]
    result = np.full(source.faces, -1, dtype=np.int32)
    result[face] = region
    divided = np.zeros(source.faces, dtype=bool)
    divided[face[result[face] != region]] = True
    shared = divided[face]
    if shared.any():
        area = areas(mesh.vertices, mesh.triangles[kept[shared]])
        place, largest = largest_shares(face[shared], region[shared], area)
        result[place] = largest
    return result
