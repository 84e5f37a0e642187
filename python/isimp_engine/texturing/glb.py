"""Binary glTF 2.0: what the format's specification lays out, as far as scans and our results need it."""

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import FileError
from . import gltf_layers
from .gltf_file import BINARY, JSON, MAGIC, GltfFile
from .layers import to_srgb
from .soup import TexturedSoup

_FLOAT, _UNSIGNED, _ARRAY_BUFFER, _ELEMENT_BUFFER = 5126, 5125, 34962, 34963
_FAR = 1e3  # coordinates this many times the size are given by the node, which has double precision


def read(path: Path) -> TexturedSoup:
    """The triangles of the default scene of a .glb or .gltf, placed by their nodes."""
    file = GltfFile(path)
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
    file = GltfFile(path, data)
    parts = [_primitive(file, p, m) for mesh, m in file.instances() for p in mesh.get("primitives", ())]
    first = np.cumsum([0] + [len(part["vertices"]) for part in parts])
    vertices = np.concatenate([np.zeros((0, 3)), *(part["vertices"] for part in parts)])
    rows = [part["triangles"] + base for part, base in zip(parts, first, strict=False)]
    centre = file.json.get("extensions", {}).get("CESIUM_RTC", {}).get("center", (0.0, 0.0, 0.0))
    triangles = np.concatenate([np.zeros((0, 3), np.int64), *rows]).astype(np.int32)
    return vertices, triangles, np.array(centre, dtype=np.float64).reshape(3)


def _primitive(file: GltfFile, primitive: dict[str, Any], matrix: NDArray[np.float64]) -> dict[str, Any]:
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
    chunks = struct.pack("<II", len(text), JSON) + text + struct.pack("<II", len(writer.data), BINARY) + writer.data
    return MAGIC + struct.pack("<II", 2, 12 + len(chunks)) + chunks
