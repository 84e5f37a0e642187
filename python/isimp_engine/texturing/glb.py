"""glTF 2.0, binary and as text: the layout of the format's specification, as far as scans and our results need it."""

import base64
import json
import os
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
from numpy.typing import NDArray

from .. import machine
from .._core import FileError, Job, PolygonMesh, triangulate
from ..file_faces import joined
from ..surfaces import far_from_zero
from . import gltf_layers, ngons
from .gltf_file import BINARY, JSON, MAGIC, GltfFile
from .gltf_values import Item
from .layers import to_srgb
from .soup import TexturedSoup

_FLOAT, _UNSIGNED, _ARRAY_BUFFER, _ELEMENT_BUFFER = 5126, 5125, 34962, 34963
_LARGEST = 0xFFFFFFFF  # bytes of a binary file, which has its size in 32 bits


def read(path: Path, shape_only: bool = False) -> TexturedSoup:
    """The triangles of the default scene of a .glb or .gltf, placed by their nodes.

    shape_only: without images and colours, so that these do not matter.
    """
    file = GltfFile(path, shape_only=shape_only)
    parts = [part for part in _parts(file) if len(part.triangles)]
    if not parts:
        raise FileError(f"{path}: has no triangles")
    vertices, faces = joined([(part.vertices, part.triangles) for part in parts])
    vertices += _y_up(file.center())
    soup = TexturedSoup(vertices, faces) if shape_only else _shown(file, parts, vertices, faces)
    counts = np.cumsum([0] + [int(part.shape.polygon[-1]) + 1 for part in parts])
    polygon = np.concatenate([part.shape.polygon + base for part, base in zip(parts, counts, strict=False)])
    object.__setattr__(soup, "polygon", polygon.astype(np.int32))
    return soup


def _shown(
    file: GltfFile, parts: list["_Part"], vertices: NDArray[np.float64], faces: NDArray[np.int32]
) -> TexturedSoup:
    """The triangles of all parts with their materials."""
    used = list(dict.fromkeys(part.shape.material for part in parts if part.shape.material >= 0))
    number = {m: i for i, m in enumerate(used)} | {-1: -1}
    has_colors = any(part.shape.colors is not None for part in parts)
    pictures = [file.base_color(m, plain=not has_colors) for m in used]
    uv = np.concatenate([part.shape.uv for part in parts])
    material = np.concatenate([np.full(len(part.triangles), number[part.shape.material], np.int32) for part in parts])
    names = [file.item("materials", m).text("name", str(m)) for m in used]
    corner_colors = np.concatenate([part.colors for part in parts])[faces] if has_colors else None
    layers = gltf_layers.read(file, used, [(part.shape.primitive, part.triangles) for part in parts])
    return TexturedSoup(vertices, faces, uv[faces], material, pictures, corner_colors, names, file.linked, layers)


def geometry(path: Path, data: bytes) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.float64]]:
    """Vertices (V, 3) and triangles (F, 3) of a tile's glTF file, and the centre that they are relative to, z up."""
    file = GltfFile(path, data, shape_only=True)
    return *joined([(part.vertices, part.triangles) for part in _parts(file)]), file.center()


def shape(path: Path) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Vertices (V, 3) and triangles (F, 3) of a .glb or .gltf. There may be none."""
    vertices, faces, center = geometry(path, path.read_bytes())
    return vertices + _y_up(center), faces


def _y_up(place: NDArray[np.float64]) -> NDArray[np.float64]:
    """A place of a tileset in the axes of its glTF files."""
    return np.asarray(place[[0, 2, 1]] * [1.0, 1.0, -1.0])


@dataclass(frozen=True, eq=False)
class _Shape:
    """The data of a primitive, independent of its place."""

    primitive: Item
    points: NDArray[np.float64]  # (V, 3)
    triangles: NDArray[np.int32]  # (F, 3)
    uv: NDArray[np.float64]  # (V, 2), v upward
    colors: NDArray[np.uint8] | None  # (V, 4), with the factor of its material
    factor: NDArray[np.float64]  # (4,) linear: the colour of its material where that shows no image
    material: int  # -1: none
    polygon: NDArray[np.int32]  # (F,) of which polygon each triangle is a part


@dataclass(frozen=True, eq=False)
class _Part:
    """A primitive at one of its places."""

    shape: _Shape
    matrix: NDArray[np.float64]

    @property
    def vertices(self) -> NDArray[np.float64]:
        return np.asarray(self.shape.points @ self.matrix[:3, :3].T + self.matrix[:3, 3])

    @property
    def triangles(self) -> NDArray[np.int32]:
        """Triangles of a mirrored object are turned to look outward."""
        mirrored = np.linalg.det(self.matrix[:3, :3]) < 0
        return self.shape.triangles[:, ::-1] if mirrored else self.shape.triangles

    @property
    def colors(self) -> NDArray[np.uint8]:
        """The colour of its material where it has none."""
        found = self.shape.colors
        return _stored_colors(np.tile(self.shape.factor, (len(self.shape.points), 1))) if found is None else found


_BYTES = 24, 120  # bytes of memory for a vertex, and for a triangle with its corners


def _parts(file: GltfFile) -> list[_Part]:
    """The primitives of the scene, each read once. Raises FileError where memory has no room for all their places."""
    shapes: dict[str, list[_Shape]] = {}
    parts, need, free = list[_Part](), 0.0, machine.memory_mb()
    for mesh, matrix in file.instances():
        if mesh.place not in shapes:
            shapes[mesh.place] = [_shape(file, primitive) for primitive in mesh.items("primitives")]
        for shape in shapes[mesh.place]:
            parts.append(_Part(shape, matrix))
            need += (_BYTES[0] * len(shape.points) + _BYTES[1] * len(shape.triangles)) / 2**20
        if need > free:
            raise FileError(f"{file.path}: its nodes have so many triangles that they need more than {free:,.0f} MB")
    return parts


def _shape(file: GltfFile, primitive: Item) -> _Shape:
    if "KHR_draco_mesh_compression" in primitive.item("extensions"):
        raise FileError(f"{file.path}: is compressed by Draco, which is not supported; export it without compression")
    attributes = primitive.item("attributes")
    points = np.zeros((0, 3))
    if "POSITION" in attributes:
        points = file.accessor(attributes.whole("POSITION")).astype(np.float64)
        if points.shape[1] != 3:
            raise FileError(f"{primitive.place}: POSITION must be of type VEC3")
    if "indices" in primitive:
        index = file.accessor(primitive.whole("indices")).ravel()
        if index.dtype.kind != "u":
            raise FileError(f"{primitive.place}: indices must be unsigned whole numbers")
    else:
        index = np.arange(len(points), dtype=np.uint32)
    triangles = _triangles(index, primitive.whole("mode", 4))
    if len(triangles) and triangles.max() >= len(points):
        raise FileError(f"{primitive.place}: a triangle uses vertex {triangles.max()}, but there are {len(points)}")
    material = primitive.whole("material") if "material" in primitive else -1
    uv = file.uv(primitive, file.color_texture(material))
    factor = file.factor(material)
    colors = _stored_colors(file.accessor(attributes.whole("COLOR_0")), factor) if "COLOR_0" in attributes else None
    for name, values in (("TEXCOORD", uv), ("COLOR_0", points if colors is None else colors)):
        if len(values) != len(points):
            raise FileError(f"{primitive.place}: {name} has {len(values)} elements, but POSITION {len(points)}")
    triangles = triangles.astype(np.int32)
    grouped = ngons.NAME in primitive.item("extensions")
    polygon = ngons.decoded(triangles) if grouped else np.arange(len(triangles), dtype=np.int32)
    return _Shape(primitive, points, triangles, uv, colors, factor, material, polygon)


def _triangles(index: NDArray[Any], mode: int) -> NDArray[Any]:
    if mode == 4:
        return index[: len(index) // 3 * 3].reshape(-1, 3)
    if mode in (5, 6) and len(index) >= 3:
        first = index[:-2] if mode == 5 else np.full(len(index) - 2, index[0])  # a strip or a fan
        found = np.stack([first, index[1:-1], index[2:]], axis=1)
        if mode == 5:  # every second one is wound the other way
            found[1::2] = found[1::2, [1, 0, 2]]
        return found
    return np.zeros((0, 3), dtype=index.dtype)  # points and lines


def _stored_colors(linear: NDArray[Any], factor: NDArray[np.float64] | None = None) -> NDArray[np.uint8]:
    """glTF's colours of vertices are linear; stored ones are sRGB, as in images. factor: (4,) linear."""
    if linear.dtype.kind == "u":
        linear = linear / np.iinfo(linear.dtype).max
    linear = np.clip(np.nan_to_num(linear.astype(np.float64)), 0, 1)
    if linear.shape[1] not in (3, 4):
        raise ValueError("colours must be of type VEC3 or VEC4")
    if linear.shape[1] == 3:
        linear = np.hstack([linear, np.ones((len(linear), 1))])
    if factor is not None:
        linear = linear * np.clip(factor, 0, 1)
    linear[:, :3] = to_srgb(linear[:, :3])
    return np.round(linear * 255).astype(np.uint8)


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


def filled(poly: PolygonMesh, job: Job | None) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.int32]]:
    """The corners of polygons, (L, 3), triangles of corners that fill them, as fans, and the polygon of each triangle.

    Every corner is a vertex of its own, since the two sides of an edge have their own normals and UVs.
    """
    corners = poly.vertices[poly.loops]
    each = np.arange(len(poly.loops), dtype=np.int32)
    return corners, *ngons.fans(corners, poly.loop_start, *triangulate(corners, each, poly.loop_start, job=job))


@dataclass(frozen=True, eq=False)
class Contents:
    """A glTF file, with its images, which may become files next to it."""

    document: dict[str, Any]
    writer: _Writer
    pictures: list[tuple[str, bytes]]  # PNG files and their names without .png

    def glb(self, path: Path) -> bytes:
        """A binary file. path: its name, for the error."""
        writer = self.writer
        images = [{"bufferView": writer.view(data), "mimeType": "image/png", "name": n} for n, data in self.pictures]
        writer.data += bytes(-len(writer.data) % 4)
        text = self._text(images, {})
        text += b" " * (-len(text) % 4)
        if 28 + len(text) + len(writer.data) > _LARGEST:
            raise FileError(f"{path}: is larger than 4 GiB, which GLB can't be; choose .gltf or smaller images")
        chunks = struct.pack("<II", len(text), JSON) + text + struct.pack("<II", len(writer.data), BINARY) + writer.data
        return MAGIC + struct.pack("<II", 2, 12 + len(chunks)) + chunks

    def gltf(self) -> bytes:
        """A file of text that contains its arrays, and names its images: NAME.png."""
        images = [{"uri": quote(os.fsencode(n + ".png")), "name": n} for n, _ in self.pictures]
        data = base64.b64encode(self.writer.data).decode()
        return self._text(images, {"uri": "data:application/octet-stream;base64," + data})

    def _text(self, images: list[dict[str, Any]], buffer: dict[str, str]) -> bytes:
        writer = self.writer
        more: dict[str, Any] = {"images": images} if images else {}
        more |= {"accessors": writer.accessors, "bufferViews": writer.views}
        more["buffers"] = [{"byteLength": len(writer.data)} | buffer]
        return json.dumps(self.document | more, separators=(",", ":")).encode()


def plain(name: str, poly: PolygonMesh, job: Job | None = None) -> Contents:
    """A file of polygons without a texture, shaded flat."""
    corners, triangles, _ = filled(poly, job)
    start = poly.loop_start.astype(np.int64)
    count = np.diff(np.append(start, len(corners)))
    first = np.repeat(corners[start], count, axis=0)
    following = np.arange(1, len(corners) + 1)
    following[start + count - 1] = start
    normal = np.add.reduceat(np.cross(corners - first, corners[following] - first), start, axis=0)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    unit = np.divide(normal, length, out=np.tile([0.0, 0.0, 1.0], (len(normal), 1)), where=length > 0)
    return contents(name, corners, [triangles], np.repeat(unit, count, axis=0))


def contents(
    name: str,
    corners: NDArray[np.float64],
    triangles: list[NDArray[np.int32]],
    normals: NDArray[np.float64],
    uv: NDArray[np.float64] | None = None,
    tangents: NDArray[np.float64] | None = None,
    shown: Sequence[gltf_layers.Shown | None] = (None,),
) -> Contents:
    """One mesh: everything by corner, v upward. triangles, shown: of each material; None: without one."""
    writer = _Writer()
    shift = far_from_zero(corners)  # the node has it, in double precision
    attributes = {"POSITION": writer.array(corners - shift, "VEC3", bounds=True)}
    attributes["NORMAL"] = writer.array(normals, "VEC3")
    if tangents is not None and any(one and one.normal for one in shown):  # the third direction is normal x tangent
        attributes["TANGENT"] = writer.array(np.hstack([tangents, np.ones((len(tangents), 1))]), "VEC4")
    if uv is not None:
        attributes["TEXCOORD_0"] = writer.array(np.stack([uv[:, 0], 1 - uv[:, 1]], axis=1), "VEC2")
    primitives: list[dict[str, Any]] = []
    materials: list[dict[str, Any]] = []
    pictures: list[tuple[str, bytes]] = []
    for faces, one in zip(triangles, shown, strict=True):
        if not len(faces):
            continue
        index = writer.array(faces.ravel(), "SCALAR")
        primitive = {"attributes": attributes, "indices": index, "extensions": {ngons.NAME: {}}}
        primitives.append(primitive)
        if one is None:
            continue
        primitive["material"] = len(materials)
        material, own = one.material(len(pictures))
        materials.append({"name": one.name} | material)
        pictures += [(one.name + suffix, data) for suffix, data in own]
    node: dict[str, Any] = {"mesh": 0, "name": name}
    if shift.any():
        node["translation"] = shift.tolist()
    document: dict[str, Any] = {
        "asset": {"version": "2.0", "generator": "isimp"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [node],
        "meshes": [{"name": name, "primitives": primitives}],
    }
    if materials:
        document["materials"] = materials
    if pictures:
        document["textures"] = [{"source": i, "sampler": 0} for i in range(len(pictures))]
        document["samplers"] = [{"magFilter": 9729, "minFilter": 9987, "wrapS": 33071, "wrapT": 33071}]
    extensions = {word for material in materials for word in material.get("extensions", ())}
    document["extensionsUsed"] = sorted(extensions | {ngons.NAME})
    return Contents(document, writer, pictures)


def nodes(path: Path, solids: Sequence[tuple[str, NDArray[np.float64], NDArray[np.int32]]]) -> bytes:
    """A file with a node for each of some named triangle meshes. path: its name, for errors."""
    writer = _Writer()
    points = np.concatenate([vertices for _, vertices, _ in solids])
    shift = far_from_zero(points)
    meshes = []
    for name, vertices, triangles in solids:
        position = writer.array(vertices - shift, "VEC3", bounds=True)
        index = writer.array(triangles.ravel(), "SCALAR")
        meshes.append({"name": name, "primitives": [{"attributes": {"POSITION": position}, "indices": index}]})
    place = {"translation": shift.tolist()} if shift.any() else {}
    document: dict[str, Any] = {
        "asset": {"version": "2.0", "generator": "isimp"},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(meshes)))}],
        "nodes": [{"mesh": i, "name": mesh["name"]} | place for i, mesh in enumerate(meshes)],
        "meshes": meshes,
    }
    return Contents(document, writer, []).glb(path)
