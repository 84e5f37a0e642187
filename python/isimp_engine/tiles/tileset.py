"""3D Tiles: the leaves of a tileset, and their meshes in the tileset's coordinates."""

import json
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import unquote, urlsplit

import numpy as np
from numpy.typing import NDArray

from .._core import FileError
from ..file_errors import reader
from ..file_faces import joined
from ..texturing import glb, named
from ..texturing.gltf_values import Item

CONTENTS = (".b3dm", ".cmpt", ".glb", ".gltf")  #: files of leaves that hold meshes
_DEEPEST = 64  # depth of tilesets in tilesets, at most
_AGAIN = 100_000  # most tiles from tilesets that were read before
_B3DM, _CMPT = 28, 16  # sizes of their headers, bytes
_POINTS = {b"pnts": "points", b"i3dm": "instances of a model"}
_UP: dict[str, NDArray[np.float64]] = {  # from the axes of glTF to z upward
    "Y": np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]]),
    "X": np.array([[0.0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]),
    "Z": np.eye(4),
}

Mesh = tuple[NDArray[np.float64], NDArray[np.int32]]


class Leaf(NamedTuple):
    """A file of the finest level, and its place."""

    path: Path
    place: list[float]  #: (16,) the rows of the matrix to the tileset's coordinates
    up: str = "Y"  #: the axis of glTF that points upward


def tileset_of(path: Path) -> Path | None:
    """Return the tileset of a path: a .json file, or tileset.json in a folder; None for other paths."""
    if path.is_dir():
        path = path / "tileset.json"
    return path if path.suffix.lower() == ".json" and path.is_file() else None


def leaves(path: Path) -> list[Leaf]:
    """Return the files of a tileset's finest level, in its order. Raises FileError with the name of the bad file."""
    walk = _Walk(path)
    walk.into(path, np.eye(4), 0)
    return walk.found


class _File:
    """A tileset file; other tilesets may name it."""

    def __init__(self, path: Path) -> None:
        self.path, self.is_known = path, False
        content = json.loads(path.read_bytes())
        axis = str(content.get("asset", {}).get("gltfUpAxis", "Y")).upper()
        self.root, self.up = content["root"], axis if axis in _UP else "Y"


class _Walk:
    """A traversal of a tileset and all tilesets that it names."""

    def __init__(self, path: Path) -> None:
        self.found: list[Leaf] = []
        self._root = named.root_of(path)
        self._files: dict[Path, _File] = {}
        self._places: dict[tuple[Path, str], Path] = {}  # files by the names in tiles
        self._again = 0  # tiles of files that were traversed before

    def into(self, path: Path, place: NDArray[np.float64], depth: int) -> None:
        """Find the leaves of a tileset at a place."""
        if depth > _DEEPEST:
            raise FileError(f"{path}: tilesets are nested more than {_DEEPEST} times; one of them names itself")
        with reader(path, "is no tileset of 3D Tiles, or damaged"):
            if path not in self._files:
                self._files[path] = _File(path)
            file = self._files[path]
            self._tile(file, file.root, place, "REPLACE", depth)
            file.is_known = True

    def _tile(self, file: _File, tile: dict[str, Any], place: NDArray[np.float64], refine: str, depth: int) -> None:
        self._again += file.is_known
        if self._again > _AGAIN:
            raise FileError(f"{file.path}: is named so often that {_AGAIN:,} tiles come again, where each comes once")
        if "implicitTiling" in tile or "3DTILES_implicit_tiling" in tile.get("extensions", {}):
            raise FileError(f"{file.path}: has implicit tiling, which is not supported; convert it to explicit tiles")
        if "transform" in tile:
            place = place @ Item(tile, f"{file.path}: a tile").numbers("transform", 16).reshape(4, 4).T
            if not np.isfinite(place).all():
                raise FileError(f"{file.path}: the transforms of a tile are so large that they are not finite")
        refine, count = str(tile.get("refine", refine)).upper(), len(self.found)
        contents = tile.get("contents", [tile["content"]] if "content" in tile else [])
        for content in contents if refine == "ADD" else ():
            self._content(file, content, place, depth)
        for child in tile.get("children", ()):
            self._tile(file, child, place, refine, depth)
        if refine != "ADD" and len(self.found) == count:  # else finer tiles replace all of it
            for content in contents:
                self._content(file, content, place, depth)

    def _content(self, file: _File, content: dict[str, Any], place: NDArray[np.float64], depth: int) -> None:
        key = (file.path, str(content.get("uri", content.get("url"))))
        if key not in self._places:
            self._places[key] = self._named(*key)
        found = self._places[key]
        if found.suffix.lower() == ".json":
            self.into(found, place, depth + 1)
        else:
            self.found.append(Leaf(found, place.ravel().tolist(), file.up))

    def _named(self, path: Path, uri: str) -> Path:
        """Return the file that a tile of a tileset names."""
        parts = urlsplit(uri)
        if len(parts.scheme) > 1 or parts.netloc:
            raise FileError(f"{path}: the tile {uri} is not a file of this machine; fetch the tileset first")
        found = named.file(unquote(parts.path), path.parent, self._root, str(path))
        if found.suffix.lower() not in (".json", *CONTENTS):
            raise FileError(f"{path}: the tile {uri} must end in one of {', '.join(CONTENTS)}")
        if found.suffix.lower() != ".json" and not found.is_file():
            raise FileError(f"{path}: the tile {uri} is not there")
        return found


def read(leaf: Leaf) -> Mesh:
    """Read the vertices (V, 3) and triangles (F, 3) of a leaf, in the tileset's coordinates. Raises FileError."""
    path, place = leaf.path, np.array(leaf.place).reshape(4, 4)
    with reader(path, "is damaged, or not of 3D Tiles"):
        return joined(list(_meshes(path, path.read_bytes(), place, _UP[leaf.up])))


def _meshes(path: Path, data: bytes, place: NDArray[np.float64], up: NDArray[np.float64]) -> Iterator[Mesh]:
    magic = data[:4]
    if magic in _POINTS:
        raise FileError(f"{path}: holds {_POINTS[magic]}, not a mesh")
    if magic == b"cmpt":
        at = _CMPT
        for _ in range(struct.unpack_from("<I", data, 12)[0]):
            size = struct.unpack_from("<I", data, at + 8)[0]
            if size < _CMPT or at + size > len(data):
                raise FileError(f"{path}: is cut short")
            yield from _meshes(path, data[at : at + size], place, up)
            at += size
        return
    centre = np.zeros(3)
    if magic == b"b3dm":
        centre, data = _unpacked(path, data)
    vertices, triangles, relative_to = glb.geometry(path, data)
    matrix = place @ _moved(centre + relative_to) @ up
    if np.linalg.det(matrix[:3, :3]) < 0:
        triangles = triangles[:, ::-1]
    yield vertices @ matrix[:3, :3].T + matrix[:3, 3], triangles


def _moved(by: NDArray[np.float64]) -> NDArray[np.float64]:
    matrix = np.eye(4)
    matrix[:3, 3] = by
    return matrix


def _unpacked(path: Path, data: bytes) -> tuple[NDArray[np.float64], bytes]:
    """Return the centre of a b3dm file, to which its coordinates are relative, and the glTF file in it."""
    size, text, binary, batch_text, batch_binary = struct.unpack_from("<5I", data, 8)
    if size > len(data):
        raise FileError(f"{path}: is cut short")
    table = json.loads(data[_B3DM : _B3DM + text] or b"{}") if text else {}
    centre = table.get("RTC_CENTER", [0.0, 0.0, 0.0])
    if isinstance(centre, dict):
        at = Item(centre, f"{path}: RTC_CENTER").whole("byteOffset")
        centre = struct.unpack_from("<3f", data, _B3DM + text + at)
    return Item({"RTC_CENTER": centre}, f"{path}").numbers("RTC_CENTER", 3), data[
        _B3DM + text + binary + batch_text + batch_binary : size
    ]
