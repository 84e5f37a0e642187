"""Files of scans with their textures."""

from os import PathLike
from pathlib import Path

from .._core import FileError, Job, read
from ..reading import COMPRESSED, reader
from . import glb, obj, ply
from .soup import TexturedSoup

KINDS = (".obj", ".ply", ".glb", ".gltf", ".stl", ".off")


def read_textured(path: str | PathLike[str], job: Job | None = None, *, threads: int = 0) -> TexturedSoup:
    """Read a scan with UVs, images and colours.

    OBJ with its MTL file (map_Kd, map_Pr, map_Pm, map_Ke, norm and their numbers; colours after the coordinates of
    vertices); PLY with texture coordinates of vertices or faces, TextureFile comments, and colours of vertices or
    faces; binary glTF (.glb) and .gltf with their materials. Vertices and triangles of OBJ and PLY are as in `read`.
    STL and OFF have no texture.
    Raises FileError, which names the file that is missing or damaged and where it is named, or Cancelled.
    """
    place = Path(path)
    kind = place.suffix.lower()
    if kind in COMPRESSED:
        raise FileError(f"{place}: is compressed; decompress it first, as its images are searched for next to it")
    if kind not in KINDS:
        raise FileError(f"{place}: is of a kind that can't be read; it must end in one of {', '.join(KINDS)}")
    with reader(place, "is damaged" if kind not in (".glb", ".gltf") else "is damaged, or not glTF 2.0"):
        if kind in (".stl", ".off"):
            return TexturedSoup(*read(place, job, threads=threads))
        if kind == ".obj":
            return obj.read(place, job, threads)
        if kind == ".ply":
            return ply.read(place, job, threads)
        return glb.read(place)
    raise AssertionError
