"""3D Tiles: the leaves of a tileset, and the meshes in them at their places."""

import json
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import unquote, urlsplit

import numpy as np
from numpy.typing import NDArray

from .._core import FileError
from ..texturing import glb

CONTENTS = (".b3dm", ".cmpt", ".glb", ".gltf")  #: files of leaves that hold meshes
_DEEPEST = 64  # tilesets within tilesets
_B3DM, _CMPT = 28, 16  # bytes of their headers
_POINTS = {b"pnts": "points", b"i3dm": "instances of a model"}
_UP: dict[str, NDArray[np.float64]] = {  # from the axes of glTF to z upward
    "Y": np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]]),
    "X": np.array([[0.0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]),
    "Z": np.eye(4),
}

Mesh = tuple[NDArray[np.float64], NDArray[np.int32]]


class Leaf(NamedTuple):
    """A file of the finest level, and where it is."""

    path: Path
    place: list[float]  #: (16,) the rows of the matrix to the tileset's coordinates
    up: str = "Y"  #: the axis of glTF that points upward


def tileset_of(path: Path) -> Path | None:
    """The tileset that a path stands for: a .json file, or a folder with tileset.json; None for others."""
    if path.is_dir():
        path = path / "tileset.json"
    return path if path.suffix.lower() == ".json" and path.is_file() else None


def leaves(path: Path) -> list[Leaf]:
    """The files of a tileset's finest level, in its order. Raises FileError, which names what can't be used."""
    return list(_of_file(path, np.eye(4), 0))


def _of_file(path: Path, place: NDArray[np.float64], depth: int) -> Iterator[Leaf]:
    if depth > _DEEPEST:
        raise FileError(f"{path}: tilesets are nested more than {_DEEPEST} times; one of them names itself")
    try:
        content = json.loads(path.read_bytes())
        axis = str(content.get("asset", {}).get("gltfUpAxis", "Y")).upper()
        yield from _of_tile(path, content["root"], place, "REPLACE", axis if axis in _UP else "Y", depth)
    except OSError as error:
        raise FileError(f"{path}: {error.strerror or error}") from None
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        if isinstance(error, FileError):
            raise
        raise FileError(f"{path}: is no tileset of 3D Tiles, or damaged: {error!r}") from None


def _of_tile(
    path: Path, tile: dict[str, Any], place: NDArray[np.float64], refine: str, up: str, depth: int
) -> Iterator[Leaf]:
    if "implicitTiling" in tile or "3DTILES_implicit_tiling" in tile.get("extensions", {}):
        raise FileError(f"{path}: has implicit tiling, which is not supported; convert it to explicit tiles")
    if "transform" in tile:
        own = np.array(tile["transform"], dtype=np.float64).reshape(4, 4).T
        if not np.isfinite(own).all():
            raise FileError(f"{path}: the transform of a tile is not finite")
        place = place @ own
    refine = str(tile.get("refine", refine)).upper()
    finer = [leaf for child in tile.get("children", ()) for leaf in _of_tile(path, child, place, refine, up, depth)]
    if refine == "ADD" or not finer:  # with REPLACE what is finer stands for all of it
        contents = tile.get("contents", [tile["content"]] if "content" in tile else [])
        for content in contents:
            yield from _of_content(path, content, place, up, depth)
    yield from finer


def _of_content(path: Path, content: dict[str, Any], place: NDArray[np.float64], up: str, depth: int) -> Iterator[Leaf]:
    uri = str(content.get("uri", content.get("url")))
    parts = urlsplit(uri)
    if parts.scheme and len(parts.scheme) > 1:
        raise FileError(f"{path}: the tile {uri} is not a file of this machine; fetch the tileset first")
    file = path.parent / unquote(parts.path)
    if file.suffix.lower() == ".json":
        yield from _of_file(file, place, depth + 1)
        return
    if file.suffix.lower() not in CONTENTS:
        raise FileError(f"{path}: the tile {uri} must end in one of {', '.join(CONTENTS)}")
    if not file.is_file():
        raise FileError(f"{path}: the tile {uri} is not there")
    yield Leaf(file, place.ravel().tolist(), up)


def read(leaf: Leaf) -> Mesh:
    """The vertices (V, 3) and triangles (F, 3) of a leaf, in the tileset's coordinates. Raises FileError."""
    path, place = leaf.path, np.array(leaf.place).reshape(4, 4)
    try:
        parts = list(_meshes(path, path.read_bytes(), place, _UP[leaf.up]))
    except OSError as error:
        raise FileError(f"{path}: {error.strerror or error}") from None
    except (KeyError, TypeError, IndexError, ValueError, struct.error) as error:
        if isinstance(error, FileError):
            raise
        raise FileError(f"{path}: is damaged, or not of 3D Tiles: {error!r}") from None
    first = np.cumsum([0] + [len(vertices) for vertices, _ in parts])
    vertices = np.concatenate([np.zeros((0, 3)), *(part[0] for part in parts)])
    rows = [triangles + base for (_, triangles), base in zip(parts, first, strict=False)]
    return vertices, np.concatenate([np.zeros((0, 3), np.int32), *rows]).astype(np.int32)


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
    """The centre that a b3dm file is relative to, and the glTF file in it."""
    size, text, binary, batch_text, batch_binary = struct.unpack_from("<5I", data, 8)
    if size > len(data):
        raise FileError(f"{path}: is cut short")
    table = json.loads(data[_B3DM : _B3DM + text] or b"{}") if text else {}
    centre = table.get("RTC_CENTER", [0.0, 0.0, 0.0])
    if isinstance(centre, dict):
        centre = struct.unpack_from("<3f", data, _B3DM + text + int(centre["byteOffset"]))
    return np.array(centre, dtype=np.float64).reshape(3), data[_B3DM + text + binary + batch_text + batch_binary : size]
