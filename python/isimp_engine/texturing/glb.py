"""Binary glTF 2.0: what the format's specification lays out, as far as scans and our results need it."""

import base64
import json
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import FileError
from . import gltf_layers, images
from .layers import to_srgb
from .soup import TexturedSoup

_MAGIC, _JSON, _BINARY = b"glTF", 0x4E4F534A, 0x004E4942
_KINDS = {5120: "i1", 5121: "u1", 5122: "i2", 5123: "u2", 5125: "u4", 5126: "f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_FLOAT, _UNSIGNED, _ARRAY_BUFFER, _ELEMENT_BUFFER = 5126, 5125, 34962, 34963
_FAR = 1e3  # coordinates this many times the size are given by the node, which has double precision


def read(path: Path) -> TexturedSoup:
    """The triangles of the default scene of a .glb or .gltf, placed by their nodes."""
    file = _File(path)
    parts = [_primitive(file, p, m) for mesh, m in file.instances() for p in mesh.get("primitives", ())]
    parts = [part for part in parts if len(part["triangles"])]
    if not parts:
        raise FileError(f"{path}: has no triangles")
    offset, triangles = 0, []
    for part in parts:
        triangles.append(part["triangles"] + offset)
        offset += len(part["vertices"])
    used = list(dict.fromkeys(int(part["material"]) for part in parts if part["material"] >= 0))
    number = {m: i for i, m in enumerate(used)} | {-1: -1}
    has_colors = any(part["colors"] is not None for part in parts)
    colors = None
    if has_colors:
        white = np.full((1, 4), 255, dtype=np.uint8)
        colors = np.concatenate(
            [np.broadcast_to(white, (len(p["vertices"]), 4)) if p["colors"] is None else p["colors"] for p in parts]
        )
    pictures = [file.base_color(m, plain=not has_colors) for m in used]
    vertices, uv = np.concatenate([p["vertices"] for p in parts]), np.concatenate([p["uv"] for p in parts])
    faces = np.concatenate(triangles).astype(np.int32)
    material = np.concatenate([np.full(len(p["triangles"]), number[p["material"]]) for p in parts])
    names = [str(file.json["materials"][m].get("name", m)) for m in used]
    corner_colors = None if colors is None else colors[faces]
    layers = gltf_layers.read(file, used, [(part["primitive"], part["triangles"]) for part in parts])
    return TexturedSoup(vertices, faces, uv[faces], material, pictures, corner_colors, names, file.linked, layers)


def geometry(path: Path, data: bytes) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.float64]]:
    """Vertices (V, 3) and triangles (F, 3) of a glTF file's contents, and the centre that they are relative to."""
    file = _File(path, data)
    parts = [_primitive(file, p, m) for mesh, m in file.instances() for p in mesh.get("primitives", ())]
    first = np.cumsum([0] + [len(part["vertices"]) for part in parts])
    vertices = np.concatenate([np.zeros((0, 3)), *(part["vertices"] for part in parts)])
    rows = [part["triangles"] + base for part, base in zip(parts, first, strict=False)]
    centre = file.json.get("extensions", {}).get("CESIUM_RTC", {}).get("center", (0.0, 0.0, 0.0))
    triangles = np.concatenate([np.zeros((0, 3), np.int64), *rows]).astype(np.int32)
    return vertices, triangles, np.array(centre, dtype=np.float64).reshape(3)


def _primitive(file: "_File", primitive: dict[str, Any], matrix: NDArray[np.float64]) -> dict[str, Any]:
    """Vertices, triangles, UVs (v upward) and colours of a primitive."""
    if "KHR_draco_mesh_compression" in primitive.get("extensions", {}):
        raise FileError(f"{file.path}: is compressed by Draco, which is not supported; export it without compression")
    attributes = primitive.get("attributes", {})
    points = file.accessor(attributes["POSITION"]).astype(np.float64) if "POSITION" in attributes else np.zeros((0, 3))
    if "indices" in primitive:
        index = file.accessor(primitive["indices"]).astype(np.int64).ravel()
    else:
        index = np.arange(len(points))
    triangles = _triangles(index, primitive.get("mode", 4))
    if len(triangles) and triangles.max() >= len(points):
        raise FileError(f"{file.path}: a triangle uses vertex {triangles.max()}, but there are {len(points)}")
    if np.linalg.det(matrix[:3, :3]) < 0:  # a mirrored object: its triangles are turned to look outward
        triangles = triangles[:, ::-1]
    uv = file.uv(primitive, file.color_texture(primitive.get("material", -1)))
    colors = None
    if "COLOR_0" in attributes:
        colors = _stored_colors(file.accessor(attributes["COLOR_0"]))
    vertices = points @ matrix[:3, :3].T + matrix[:3, 3]
    return {"vertices": vertices, "triangles": triangles, "uv": uv, "colors": colors} | {
        "material": primitive.get("material", -1),
        "primitive": primitive,
    }


def _triangles(index: NDArray[np.int64], mode: int) -> NDArray[np.int64]:
    if mode == 4:
        return index[: len(index) // 3 * 3].reshape(-1, 3)
    if mode == 5:  # a strip: every second one is wound the other way
        strip = np.stack([index[:-2], index[1:-1], index[2:]], axis=1)
        strip[1::2] = strip[1::2, [1, 0, 2]]
        return strip
    if mode == 6:
        return np.stack([np.full(max(len(index) - 2, 0), index[0]), index[1:-1], index[2:]], axis=1)
    return np.zeros((0, 3), dtype=np.int64)  # points and lines


def _stored_colors(linear: NDArray[Any]) -> NDArray[np.uint8]:
    """glTF's colours of vertices are linear; stored ones are those of sRGB, as images have them."""
    if linear.dtype == np.uint8:
        linear = linear / 255
    elif linear.dtype == np.uint16:
        linear = linear / 65535
    linear = np.clip(linear.astype(np.float64), 0, 1)
    if linear.shape[1] == 3:
        linear = np.hstack([linear, np.ones((len(linear), 1))])
    linear[:, :3] = to_srgb(linear[:, :3])
    return np.round(linear * 255).astype(np.uint8)


class _File:
    """The JSON and the buffers of a file."""

    def __init__(self, path: Path, data: bytes | None = None) -> None:
        self.path = path
        data = path.read_bytes() if data is None else data
        self.binary: bytes = b""
        text = data
        if data[:4] == _MAGIC:
            text = b"{}"
            for kind, chunk in self._chunks(data):
                if kind == _JSON:
                    text = chunk
                elif kind == _BINARY and not self.binary:
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

    def _item(self, kind: str, i: int) -> dict[str, Any]:
        items = self.json.get(kind, [])
        if not isinstance(i, int) or not 0 <= i < len(items):
            raise FileError(f"{self.path}: names number {i} of its {kind}, but there are {len(items)}")
        item: dict[str, Any] = items[i]
        return item

    def buffer(self, i: int) -> bytes:
        if i not in self.buffers:
            uri = self._item("buffers", i).get("uri")
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
        view = self._item("bufferViews", i)
        begin = view.get("byteOffset", 0)
        return self.buffer(view["buffer"])[begin : begin + view["byteLength"]], view.get("byteStride", 0)

    def accessor(self, i: int) -> NDArray[Any]:
        """(n, width) of the accessor's own kind of number; normalised integers as from 0 to 1."""
        accessor = self._item("accessors", i)
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
            node = self._item("nodes", i)
            matrix = outer @ _matrix(node)
            if "mesh" in node:
                yield self._item("meshes", node["mesh"]), matrix
            stack += [(child, matrix, depth + 1) for child in reversed(node.get("children", []))]

    def _base(self, material: int) -> dict[str, Any]:
        base: dict[str, Any] = self._item("materials", material).get("pbrMetallicRoughness", {})
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
            count = self._item("accessors", attributes["POSITION"])["count"] if "POSITION" in attributes else 0
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
        source = self._item("textures", texture["index"]).get("source")
        if source is None:
            raise FileError(f"{self.path}: an image is of a kind that is not supported; export it with PNG or JPEG")
        image = self._item("images", source)
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


class _Writer:
    """Collects arrays in one buffer."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []

    def view(self, data: bytes, target: int | None = None) -> int:
        self.data += bytes(-len(self.data) % 4)
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)}
        self.views.append(view if target is None else view | {"target": target})
        self.data += data
        return len(self.views) - 1

    def array(self, values: NDArray[Any], kind: str, bounds: bool = False) -> int:
        index = kind == "SCALAR"
        values = np.ascontiguousarray(values, dtype="<u4" if index else "<f4")
        accessor = {"bufferView": self.view(values.tobytes(), _ELEMENT_BUFFER if index else _ARRAY_BUFFER)}
        accessor |= {"componentType": _UNSIGNED if index else _FLOAT, "count": len(values)}
        more: dict[str, Any] = {"type": kind}
        if bounds:
            more |= {"min": values.min(0).tolist(), "max": values.max(0).tolist()}
        self.accessors.append(accessor | more)
        return len(self.accessors) - 1


def glb(
    name: str,
    corners: NDArray[np.float64],
    triangles: list[NDArray[np.int32]],
    uv: NDArray[np.float64],
    normals: NDArray[np.float64],
    tangents: NDArray[np.float64],
    shown: list[gltf_layers.Shown],
) -> bytes:
    """A file with one mesh: everything by corner, v upward. triangles, shown: of each material."""
    writer = _Writer()
    middle = (corners.min(0) + corners.max(0)) / 2
    size = float(np.linalg.norm(np.ptp(corners, axis=0)))
    shift = np.where(np.abs(middle) > _FAR * size, np.round(middle), 0.0)
    attributes = {"POSITION": writer.array(corners - shift, "VEC3", bounds=True)}
    attributes["NORMAL"] = writer.array(normals, "VEC3")
    if any(one.normal is not None for one in shown):  # (x, y, z, 1): the third direction is normal x tangent
        attributes["TANGENT"] = writer.array(np.hstack([tangents, np.ones((len(tangents), 1))]), "VEC4")
    attributes["TEXCOORD_0"] = writer.array(np.stack([uv[:, 0], 1 - uv[:, 1]], axis=1), "VEC2")
    primitives: list[dict[str, Any]] = []
    materials: list[dict[str, Any]] = []
    pictures: list[tuple[str, bytes]] = []
    for faces, one in zip(triangles, shown, strict=True):
        if not len(faces):
            continue
        index = writer.array(faces.ravel(), "SCALAR")
        primitives.append({"attributes": attributes, "indices": index, "material": len(materials)})
        material, own = one.material(len(pictures))
        materials.append({"name": one.name} | material)
        pictures += [(one.name + suffix, data) for suffix, data in own]
    node: dict[str, Any] = {"mesh": 0, "name": name}
    if shift.any():
        node["translation"] = shift.tolist()
    document = {
        "asset": {"version": "2.0", "generator": "isimp"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [node],
        "meshes": [{"name": name, "primitives": primitives}],
        "materials": materials,
        "textures": [{"source": i, "sampler": 0} for i in range(len(pictures))],
        "samplers": [{"magFilter": 9729, "minFilter": 9987, "wrapS": 33071, "wrapT": 33071}],
        "images": [
            {"bufferView": writer.view(data), "mimeType": "image/png", "name": title} for title, data in pictures
        ],
        "accessors": writer.accessors,
        "bufferViews": writer.views,
    }
    extensions = {word for material in materials for word in material.get("extensions", ())}
    if extensions:
        document["extensionsUsed"] = sorted(extensions)
    writer.data += bytes(-len(writer.data) % 4)
    document["buffers"] = [{"byteLength": len(writer.data)}]
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), _JSON) + text + struct.pack("<II", len(writer.data), _BINARY) + writer.data
    return _MAGIC + struct.pack("<II", 2, 12 + len(chunks)) + chunks
