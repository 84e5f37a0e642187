"""Files of scans with their textures."""

from dataclasses import replace
from os import PathLike
from pathlib import Path

from .._core import FileError, Job, _read_columns
from ..file_errors import reader
from ..reading import GLTF, KINDS, check_kind, is_compressed, plain, read, read_polygons
from . import glb, obj, ply
from .look import Fault, Look
from .soup import TexturedSoup

_WITH_LOOK = tuple(kind for kind in KINDS if kind not in GLTF)


def read_textured(path: str | PathLike[str], *, job: Job | None = None, threads: int = 0) -> TexturedSoup:
    """Read a scan with UVs, images and colours.

    OBJ with its MTL file (map_Kd, map_Pr, map_Pm, map_Ke, norm and their numbers; colours after the coordinates of
    vertices); PLY with texture coordinates of vertices or faces, TextureFile comments, and colours of vertices or
    faces; binary glTF (.glb) and .gltf with their materials. Vertices and triangles of OBJ and PLY are as in `read`.
    STL and OFF have no texture. The texture of a 3MF file is not read.
    Raises FileError, which names the file that is missing or damaged and where it is named, or Cancelled.
    """
    place = Path(path)
    if is_compressed(place):
        raise FileError(f"{place}: is compressed; decompress it first, as its images are searched for next to it")
    kind = check_kind(place)
    with reader(place, "is damaged" if kind not in GLTF else "is damaged, or not glTF 2.0"):
        if kind in (".stl", ".off", ".3mf"):
            return TexturedSoup(*read(place, job=job, threads=threads))
        if kind == ".obj":
            return obj.read(place, job, threads)
        if kind == ".ply":
            return ply.read(place, job, threads)
        return glb.read(place)
    raise AssertionError


def read_shape(path: Path, job: Job | None = None) -> TexturedSoup:
    """The triangles of a glTF file, also .gz and .zst, with their polygons; images and colours are not read."""
    with plain(path, job=job) as place, reader(path, "is damaged, or not glTF 2.0"):
        return glb.read(place, shape_only=True)


def read_look(path: str | PathLike[str], job: Job | None = None) -> Look:
    """Read the polygons of a PLY, OBJ, STL, OFF or 3MF file, also .gz and .zst, with the look that it describes.

    Nothing is refused because of the look: what can't be used is in `faults`, words for what is not read in `skipped`.
    Raises FileError or Cancelled as `read_polygons`.
    """
    scan = Path(path)
    check_kind(scan, _WITH_LOOK)
    with plain(scan, job=job) as place:
        stands = scan if place == scan else scan.with_name(place.name)
        faults: list[str] = []
        try:
            found = _look(place, stands, job, faults.append)
        except FileError as error:
            found = Look(*read_polygons(place, job))  # raises if it is not the look that is damaged
            faults.append(str(error))
    return replace(found, faults=faults)


def _look(place: Path, stands: Path, job: Job | None, fault: Fault) -> Look:
    kind = place.suffix.lower()
    if kind == ".obj":
        return obj.read_look(place, stands, job, fault)
    if kind == ".ply":
        return ply.read_look(place, stands, job, fault)
    if kind == ".3mf":
        return Look(*read_polygons(place, job))
    vertices, loops, start, *_, skipped = _read_columns(place, [], job, 0)
    return Look(vertices, loops, start, skipped=skipped)
