"""The parts of a glTF 2.0 file: its JSON, buffers, accessors, nodes and images."""

import base64
import json
import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from .._core import FileError
from . import images, named
from .gltf_values import Item
from .layers import scaled_colors, to_srgb

MAGIC, JSON, BINARY = b"glTF", 0x4E4F534A, 0x004E4942
_KINDS = {5120: "i1", 5121: "u1", 5122: "i2", 5123: "u2", 5125: "u4", 5126: "f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_OTHER_IMAGES = ("EXT_texture_webp", "EXT_texture_avif")  # extensions whose images are read as others are
#: Extensions that a file may require: read here, or without influence on shape and colour; more in _MATERIALS.
_KNOWN = {"CESIUM_RTC", "KHR_mesh_quantization", "KHR_texture_transform", "KHR_lights_punctual", *_OTHER_IMAGES}
_KNOWN |= {"KHR_xmp_json_ld", "EXT_mesh_features", "EXT_structural_metadata"}
_MATERIALS, _TEXTURES = "KHR_materials_", ("KHR_texture_", "EXT_texture_")
_COLORS = "KHR_materials_pbrSpecularGlossiness"  # has its colours in another place


class GltfFile:
    """The JSON and the buffers of a file."""

    def __init__(self, path: Path, data: bytes | None = None, shape_only: bool = False) -> None:
        """shape_only: images are not used, so that their kind does not matter."""
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
            said = json.loads(text)
        except ValueError:
            raise FileError(f"{path}: is not glTF, or damaged") from None
        self.json = Item(said, f"{path}")
        self._size = len(data)
        self._buffers: dict[int, bytes] = {}
        self._items: dict[tuple[str, int], Item] = {}
        self._arrays: dict[int, NDArray[Any]] = {}
        self._root = named.root_of(path)
        self.linked: list[Path] = []
        self.pictures = images.Pictures()
        self._check_extensions(shape_only)

    def _check_extensions(self, shape_only: bool) -> None:
        for name in map(str, self.json.rows("extensionsRequired")):
            of_looks = name.startswith((_MATERIALS, *_TEXTURES) if shape_only else _MATERIALS)
            if name not in _KNOWN and not (of_looks and (shape_only or name != _COLORS)):
                raise FileError(f"{self.path}: needs the extension {name}, which is not supported; export it without")

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

    def item(self, kind: str, i: int) -> Item:
        if (kind, i) not in self._items:
            items = self.json.rows(kind)
            if not 0 <= i < len(items):
                raise FileError(f"{self.path}: names number {i} of its {kind}, but there are {len(items)}")
            self._items[kind, i] = Item(items[i], f"{self.path}: {kind} {i}")
        return self._items[kind, i]

    def buffer(self, i: int) -> bytes:
        if i not in self._buffers:
            item = self.item("buffers", i)
            if "uri" in item:
                self._buffers[i] = self._linked(item, named.folder_of(self.path))
            elif i == 0:
                self._buffers[i] = self.binary
            else:
                raise FileError(f"{item.place} has no data; export the file without extensions that pack it")
        return self._buffers[i]

    def _linked(self, item: Item, root: Path) -> bytes:
        """The data at the uri of an item."""
        uri = item.text("uri")
        if uri.startswith("data:"):
            return base64.b64decode(uri.partition(",")[2])
        file = named.file(unquote(uri), self.path.parent, root, item.place)
        if not file.is_file():
            raise FileError(f"{self.path}: its file {file} does not exist; put it there")
        self.linked.append(file)
        data = file.read_bytes()
        self._size += len(data)
        return data

    def view(self, i: int) -> tuple[memoryview, int]:
        """The bytes of a view, and their stride; 0: none."""
        view = self.item("bufferViews", i)
        if "EXT_meshopt_compression" in view.item("extensions"):
            raise FileError(f"{view.place} is compressed by meshopt, which is not supported; export it without")
        begin, size = view.whole("byteOffset", 0), view.whole("byteLength")
        data = self.buffer(view.whole("buffer"))
        if begin + size > len(data):
            raise FileError(f"{view.place} reaches beyond its buffer; the file is damaged")
        return memoryview(data)[begin : begin + size], view.whole("byteStride", 0)

    def accessor(self, i: int) -> NDArray[Any]:
        """(n, width) of the accessor's own kind of number; normalised integers as from 0 to 1 or -1 to 1."""
        if i not in self._arrays:
            self._arrays[i] = self._accessor(self.item("accessors", i))
            self._arrays[i].flags.writeable = False
        return self._arrays[i]

    def _accessor(self, accessor: Item) -> NDArray[Any]:
        if "sparse" in accessor:
            raise FileError(f"{self.path}: has sparse accessors, which are not supported")
        number, name = accessor.whole("componentType"), accessor.text("type")
        if number not in _KINDS or name not in _WIDTHS:
            raise FileError(f"{accessor.place}: is of the kind {number}, {name!r}, which glTF does not have")
        kind, width, count = np.dtype("<" + _KINDS[number]), _WIDTHS[name], accessor.whole("count")
        if "bufferView" not in accessor:
            if count > self._size:
                raise FileError(f"{accessor.place}: has no data for its {count:,} elements; the file is damaged")
            return np.zeros((count, width), dtype=kind)
        data, stride = self.view(accessor.whole("bufferView"))
        offset, row = accessor.whole("byteOffset", 0), kind.itemsize * width
        if 0 < stride < row:
            raise FileError(f"{accessor.place}: its elements of {row} bytes are {stride} bytes apart")
        stride = stride or row
        if count and offset + stride * (count - 1) + row > len(data):
            raise FileError(f"{accessor.place} reaches beyond its buffer; the file is damaged")
        if not count:
            return np.zeros((0, width), dtype=kind)
        array = np.ndarray((count, width), kind, data, offset, (stride, kind.itemsize)).copy()
        if accessor.flag("normalized") and kind.kind in "iu" and kind.itemsize < 4:
            return np.maximum(array / np.float32(np.iinfo(kind).max), np.float32(-1))
        return array

    def instances(self) -> Iterator[tuple[Item, NDArray[np.float64]]]:
        """Each mesh of the scene with its place."""
        count = len(self.json.rows("nodes"))
        if not count:
            yield from ((self.item("meshes", k), np.eye(4)) for k in range(len(self.json.rows("meshes"))))
            return
        seen = set[int]()
        stack = [(i, np.eye(4)) for i in reversed(self._roots(count))]
        while stack:
            i, outer = stack.pop()
            node = self.item("nodes", i)
            if i in seen:
                raise FileError(f"{node.place} is named twice, by other nodes or the scene; a node has one parent")
            seen.add(i)
            if "EXT_mesh_gpu_instancing" in node.item("extensions"):
                raise FileError(f"{node.place} has EXT_mesh_gpu_instancing, which is not supported; export it without")
            matrix = outer @ _matrix(node)
            if "mesh" in node:
                yield self.item("meshes", node.whole("mesh")), matrix
            stack += [(child, matrix) for child in reversed(node.indices("children"))]

    def _roots(self, count: int) -> list[int]:
        """The nodes of the default scene; without scenes the nodes that no other one names."""
        if self.json.rows("scenes"):
            return self.item("scenes", self.json.whole("scene", 0)).indices("nodes")
        inner = {child for i in range(count) for child in self.item("nodes", i).indices("children")}
        return [i for i in range(count) if i not in inner]

    def _base(self, material: int) -> Item:
        return self.item("materials", material).item("pbrMetallicRoughness")

    def color_texture(self, material: int) -> Item | None:
        """The base colour of a material, if that is an image."""
        return None if material < 0 else texture_of(self._base(material), "baseColorTexture")

    @staticmethod
    def placing(texture: Item | None) -> tuple[Any, ...]:
        """The UV set of a texture and, with KHR_texture_transform, its scale, turn (radians) and offset."""
        if texture is None:
            return (0,)
        uv_set = texture.whole("texCoord", 0)
        if "KHR_texture_transform" not in texture.item("extensions"):
            return (uv_set,)
        moved = texture.extension("KHR_texture_transform")
        scale, offset = moved.numbers("scale", 2, (1, 1)), moved.numbers("offset", 2, (0, 0))
        return moved.whole("texCoord", uv_set), tuple(scale), moved.number("rotation", 0), tuple(offset)

    def uv(self, primitive: Item, texture: Item | None) -> NDArray[np.float64]:
        """(V, 2) at which a primitive's vertices show a texture, v upward; zeros without."""
        attributes, (uv_set, *placed) = primitive.item("attributes"), self.placing(texture)
        if f"TEXCOORD_{uv_set}" not in attributes:
            count = len(self.accessor(attributes.whole("POSITION"))) if "POSITION" in attributes else 0
            return np.zeros((count, 2))
        uv = self.accessor(attributes.whole(f"TEXCOORD_{uv_set}")).astype(np.float64)
        if uv.shape[1] != 2:
            raise FileError(f"{primitive.place}: TEXCOORD_{uv_set} must be of type VEC2")
        if placed:
            scale, turn, offset = placed
            row = uv * scale
            c, s = np.cos(turn), np.sin(turn)
            uv = np.stack([c * row[:, 0] + s * row[:, 1], c * row[:, 1] - s * row[:, 0]], axis=1) + offset
        uv[:, 1] = 1 - uv[:, 1]
        return uv

    def base_color(self, material: int, plain: bool) -> Any:
        """The image of a material; without one its colour, or None for the colours of the vertices."""
        texture, factor = self.color_texture(material), np.clip(self.factor(material), 0, 1)
        if texture is not None:
            change = lambda image: scaled_colors(image, factor)  # noqa: E731
            return self.pictures.changed(self.picture(texture), tuple(factor), change)
        if not plain:
            return None
        factor[:3] = to_srgb(factor[:3])
        return np.round(factor * 255).astype(np.uint8).reshape(1, 1, 4)

    def factor(self, material: int) -> NDArray[np.float64]:
        """(4,) the linear factor on a material's colour."""
        return np.ones(4) if material < 0 else self._base(material).numbers("baseColorFactor", 4, (1, 1, 1, 1))

    def center(self) -> NDArray[np.float64]:
        """(3,) the place that all coordinates are relative to, z up as in the tileset (CESIUM_RTC)."""
        return self.json.extension("CESIUM_RTC").numbers("center", 3, (0.0, 0.0, 0.0))

    def picture(self, texture: Item) -> images.Image:
        """The image that a material's texture shows."""
        item = self.item("textures", texture.whole("index"))
        others = [item.extension(name) for name in _OTHER_IMAGES if name in item.item("extensions")]
        if others:
            source = others[0].whole("source")
        elif "source" in item:
            source = item.whole("source")
        else:
            raise FileError(f"{self.path}: an image is of a kind that is not supported; export it with PNG or JPEG")
        image = self.item("images", source)
        if "bufferView" in image:
            view = image.whole("bufferView")
            return self._picture(("view", view), image, lambda: bytes(self.view(view)[0]))
        return self._picture(("uri", image.text("uri")), image, lambda: self._linked(image, self._root))

    def _picture(self, key: tuple[str, Any], image: Item, data: Callable[[], bytes]) -> images.Image:
        return self.pictures.once(key, lambda: images.decode(data(), image.place))


def texture_of(item: Item, name: str) -> Item | None:
    return item.item(name) if name in item else None


def _matrix(node: Item) -> NDArray[np.float64]:
    if "matrix" in node:
        return node.numbers("matrix", 16).reshape(4, 4).T
    x, y, z, w = node.numbers("rotation", 4, (0, 0, 0, 1))
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    matrix = np.eye(4)
    matrix[:3, :3] = turn * node.numbers("scale", 3, (1, 1, 1))
    matrix[:3, 3] = node.numbers("translation", 3, (0, 0, 0))
    return matrix
