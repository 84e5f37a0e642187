"""The parts of a glTF 2.0 file: its JSON, buffers, accessors, nodes and images."""

import base64
import json
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import FileError
from . import images
from .layers import to_srgb

MAGIC, JSON, BINARY = b"glTF", 0x4E4F534A, 0x004E4942
_KINDS = {5120: "i1", 5121: "u1", 5122: "i2", 5123: "u2", 5125: "u4", 5126: "f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}


class GltfFile:
    """The JSON and the buffers of a file."""

    def __init__(self, path: Path, data: bytes | None = None) -> None:
        self.path = path
        data = path.read_bytes() if data is None else data
        self.binary: bytes = b""
        text = data
        if data[:4] == MAGIC:
            text = b"{}"
            for kind, chunk in self._chunks(data):
                if kind == JSON:
                    text = chunk
                elif kind == BINARY and not self.binary:
                    self.binary = chunk
        try:
            self.json: dict[str, Any] = json.loads(text)
        except ValueError:
            raise FileError(f"{path}: is not glTF, or damaged") from None
        self.buffers: dict[int, bytes] = {}
        self.linked: list[Path] = []
        self.pictures: dict[int, images.Image] = {}

    def _chunks(self, data: bytes) -> Iterator[tuple[int, bytes]]:
        if len(data) < 20 or struct.unpack_from("<I", data, 4)[0] != 2:
            raise FileError(f"{self.path}: is not binary glTF of version 2")
        at = 12
        while at + 8 <= len(data):
            size, kind = struct.unpack_from("<II", data, at)
            if at + 8 + size > len(data):
                raise FileError(f"{self.path}: is cut short")
            yield kind, data[at + 8 : at + 8 + size]
            at += 8 + size

    def item(self, kind: str, i: int) -> dict[str, Any]:
        items = self.json.get(kind, [])
        if not isinstance(i, int) or not 0 <= i < len(items):
            raise FileError(f"{self.path}: names number {i} of its {kind}, but there are {len(items)}")
        item: dict[str, Any] = items[i]
        return item

    def buffer(self, i: int) -> bytes:
        if i not in self.buffers:
            uri = self.item("buffers", i).get("uri")
            self.buffers[i] = self.binary if uri is None else self._linked(uri)
        return self.buffers[i]

    def _linked(self, uri: str) -> bytes:
        if uri.startswith("data:"):
            return base64.b64decode(uri.partition(",")[2])
        file = self.path.parent / uri.replace("%20", " ")
        if not file.is_file():
            raise FileError(f"{self.path}: its file {file} does not exist; put it there")
        self.linked.append(file)
        return file.read_bytes()

    def view(self, i: int) -> tuple[bytes, int]:
        view = self.item("bufferViews", i)
        begin = view.get("byteOffset", 0)
        return self.buffer(view["buffer"])[begin : begin + view["byteLength"]], view.get("byteStride", 0)

    def accessor(self, i: int) -> NDArray[Any]:
        """(n, width) of the accessor's own kind of number; normalised integers as from 0 to 1."""
        accessor = self.item("accessors", i)
        if "sparse" in accessor:
            raise FileError(f"{self.path}: has sparse accessors, which are not supported")
        kind, width, count = (
            np.dtype("<" + _KINDS[accessor["componentType"]]),
            _WIDTHS[accessor["type"]],
            accessor["count"],
        )
        if "bufferView" not in accessor:
            return np.zeros((count, width), dtype=kind)
        data, stride = self.view(accessor["bufferView"])
        offset, row = accessor.get("byteOffset", 0), kind.itemsize * width
        stride = stride or row
        if count and offset + stride * (count - 1) + row > len(data):
            raise FileError(f"{self.path}: accessor {i} reaches beyond its buffer; the file is damaged")
        if not count:
            return np.zeros((0, width), dtype=kind)
        array = np.ndarray((count, width), kind, data, offset, (stride, kind.itemsize)).copy()
        if accessor.get("normalized") and kind.kind == "u":
            return np.asarray(array / np.iinfo(kind).max, dtype=np.float32)
        return array

    def instances(self) -> Iterator[tuple[dict[str, Any], NDArray[np.float64]]]:
        """Each mesh of the scene with its place."""
        nodes = self.json.get("nodes", [])
        if not nodes:
            yield from ((mesh, np.eye(4)) for mesh in self.json.get("meshes", []))
            return
        scenes = self.json.get("scenes")
        roots = scenes[self.json.get("scene", 0)].get("nodes", []) if scenes else range(len(nodes))
        stack = [(i, np.eye(4), 0) for i in reversed(list(roots))]
        while stack:
            i, outer, depth = stack.pop()
            if depth > len(nodes):
                raise FileError(f"{self.path}: its nodes contain each other")
            node = self.item("nodes", i)
            matrix = outer @ _matrix(node)
            if "mesh" in node:
                yield self.item("meshes", node["mesh"]), matrix
            stack += [(child, matrix, depth + 1) for child in reversed(node.get("children", []))]

    def _base(self, material: int) -> dict[str, Any]:
        base: dict[str, Any] = self.item("materials", material).get("pbrMetallicRoughness", {})
        return base

    def color_texture(self, material: int) -> dict[str, Any] | None:
        """What a material shows as its base colour, if that is an image."""
        return None if material < 0 else self._base(material).get("baseColorTexture")

    @staticmethod
    def placing(texture: dict[str, Any] | None) -> tuple[Any, ...]:
        """The UV set of a texture and, with KHR_texture_transform, its scale, turn (radians) and offset."""
        texture = texture or {}
        moved = texture.get("extensions", {}).get("KHR_texture_transform")
        uv_set = int(texture.get("texCoord", 0))
        if moved is None:
            return (uv_set,)
        uv_set = int(moved.get("texCoord", uv_set))
        return (
            uv_set,
            tuple(moved.get("scale", (1, 1))),
            float(moved.get("rotation", 0)),
            tuple(moved.get("offset", (0, 0))),
        )

    def uv(self, primitive: dict[str, Any], texture: dict[str, Any] | None) -> NDArray[np.float64]:
        """(V, 2) at which a primitive's vertices show a texture, v upward; zeros without."""
        attributes, (uv_set, *placed) = primitive.get("attributes", {}), self.placing(texture)
        if f"TEXCOORD_{uv_set}" not in attributes:
            count = self.item("accessors", attributes["POSITION"])["count"] if "POSITION" in attributes else 0
            return np.zeros((count, 2))
        uv = self.accessor(attributes[f"TEXCOORD_{uv_set}"]).astype(np.float64)
        if placed:
            scale, turn, offset = placed
            row = uv * scale
            c, s = np.cos(turn), np.sin(turn)
            uv = np.stack([c * row[:, 0] + s * row[:, 1], c * row[:, 1] - s * row[:, 0]], axis=1) + offset
        uv[:, 1] = 1 - uv[:, 1]
        return uv

    def base_color(self, material: int, plain: bool) -> Any:
        """The image of a material; without one its colour, or None for that of the vertices."""
        base = self._base(material)
        if "baseColorTexture" not in base:
            if not plain:
                return None
            factor = np.asarray(base.get("baseColorFactor", (1, 1, 1, 1)), dtype=np.float64)
            factor[:3] = to_srgb(factor[:3])
            return np.round(np.clip(factor, 0, 1) * 255).astype(np.uint8).reshape(1, 1, 4)
        return self.picture(base["baseColorTexture"])

    def picture(self, texture: dict[str, Any]) -> images.Image:
        """The image that a material's texture shows."""
        source = self.item("textures", texture["index"]).get("source")
        if source is None:
            raise FileError(f"{self.path}: an image is of a kind that is not supported; export it with PNG or JPEG")
        image = self.item("images", source)
        name = f"{self.path}: image {image.get('name', image.get('uri', source))}"
        if source not in self.pictures:
            data = self.view(image["bufferView"])[0] if "bufferView" in image else self._linked(image["uri"])
            self.pictures[source] = images.decode(data, name)
        return self.pictures[source]


def _matrix(node: dict[str, Any]) -> NDArray[np.float64]:
    if "matrix" in node:
        return np.asarray(node["matrix"], dtype=np.float64).reshape(4, 4).T
    x, y, z, w = node.get("rotation", (0, 0, 0, 1))
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    matrix = np.eye(4)
    matrix[:3, :3] = turn * np.asarray(node.get("scale", (1, 1, 1)), dtype=np.float64)
    matrix[:3, 3] = node.get("translation", (0, 0, 0))
    return matrix
