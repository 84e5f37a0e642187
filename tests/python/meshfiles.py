"""Mesh files of every kind the engine reads, written the plain way. `polygons` is a list of lists of vertices."""

import json
import struct

import numpy as np

import isimp_engine as engine


def ply_ascii(path, vertices, polygons):
    head = (
        f"ply\nformat ascii 1.0\ncomment made by a test\nelement vertex {len(vertices)}\nproperty double x\n"
        f"property double y\nproperty double z\nelement face {len(polygons)}\nproperty list uchar int vertex_indices\n"
        "end_header\n"
    )
    rows = [" ".join(repr(float(x)) for x in v) for v in vertices]
    rows += [" ".join(map(str, [len(p), *p])) for p in polygons]
    path.write_text(head + "\n".join(rows) + "\n")


def ply_binary(path, vertices, polygons, order="little", extra=False):
    mark = "<" if order == "little" else ">"
    head = f"ply\nformat binary_{order}_endian 1.0\nelement vertex {len(vertices)}\n"
    head += "property float x\nproperty float y\nproperty float z\n"
    if extra:
        head += "property uchar red\nproperty list uchar short tags\n"
    head += f"element face {len(polygons)}\nproperty list uchar uint vertex_index\nend_header\n"
    body = bytearray(head.encode())
    for v in vertices:
        body += struct.pack(mark + "3f", *v)
        if extra:
            body += struct.pack(mark + "BB2h", 200, 2, 7, 8)
    for p in polygons:
        body += struct.pack(f"{mark}B{len(p)}I", len(p), *p)
    path.write_bytes(body)


def ply_columns(path, vertex, faces, textures=(), binary=True, order="<"):
    """A PLY file of columns of vertices and rows of faces: lists of (kind, values) or numbers."""
    kinds = {"f4": "float", "u1": "uchar", "i4": "int"}
    head = ["ply", f"format {'binary_little_endian' if order == '<' else 'binary_big_endian'} 1.0"]
    if not binary:
        head[1] = "format ascii 1.0"
    head += [f"comment TextureFile {name}" for name in textures]
    head += [f"element vertex {len(next(iter(vertex.values())))}"]
    head += [f"property {kinds[v.dtype.str[1:]]} {k}" for k, v in vertex.items()]
    head += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
    wide = len(faces[0]) > 1
    head += ["property list uchar float texcoord"] * wide + ["end_header\n"]
    body = []
    for row in zip(*vertex.values(), strict=True):
        cells = [(v.dtype.str[1:], v) for v in row]
        body.append(b"".join(np.array(v, order + k).tobytes() for k, v in cells) if binary else " ".join(map(str, row)))
    for row in faces:
        cells = [(order + kind, np.asarray(list_)) for kind, list_ in zip(("i4", "f4"), row, strict=False)]
        if binary:
            body.append(b"".join(struct.pack("B", len(v)) + v.astype(k).tobytes() for k, v in cells))
        else:
            body.append(" ".join(f"{len(v)} " + " ".join(map(str, v)) for _, v in cells))
    data = b"".join(body) if binary else ("\n".join(body) + "\n").encode()
    path.write_bytes("\n".join(head).encode() + data)


def ply_big(path, vertices, polygons):
    ply_binary(path, vertices, polygons, "big")


def ply_extra(path, vertices, polygons):
    ply_binary(path, vertices, polygons, extra=True)


def obj(path, vertices, polygons):
    lines = ["# a test", "o thing", *("v " + " ".join(repr(float(x)) for x in v) for v in vertices)]
    lines += ["f " + " ".join(f"{v + 1}//{v + 1}" for v in p) for p in polygons]
    path.write_text("\n".join(lines) + "\n")


def gltf(path, vertices, triangles):
    """A .gltf file with its numbers in a .bin file of the same name."""
    points, corners = np.asarray(vertices, "<f4"), np.asarray(triangles, "<u4")
    path.with_suffix(".bin").write_bytes(points.tobytes() + corners.tobytes())
    document = {
        "asset": {"version": "2.0"},
        "buffers": [{"uri": path.with_suffix(".bin").name, "byteLength": points.nbytes + corners.nbytes}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": points.nbytes},
            {"buffer": 0, "byteOffset": points.nbytes, "byteLength": corners.nbytes},
        ],
        "accessors": [
            {"bufferView": 0, "type": "VEC3", "count": len(points), "componentType": 5126},
            {"bufferView": 1, "type": "SCALAR", "count": corners.size, "componentType": 5125},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    }
    path.write_text(json.dumps(document))


def glb(document, body):
    """A GLB file of a JSON document and bytes."""
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    body += bytes(-len(body) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(body), b"BIN\0") + body
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def of_glb(data):
    """The document and the bytes of a GLB file."""
    size = int.from_bytes(data[12:16], "little")
    return json.loads(data[20 : 20 + size]), data[28 + size :]


def off(path, vertices, polygons):
    lines = ["OFF", f"{len(vertices)} {len(polygons)} 0", *(" ".join(repr(float(x)) for x in v) for v in vertices)]
    lines += [" ".join(map(str, [len(p), *p])) for p in polygons]
    path.write_text("\n".join(lines) + "\n")


def stl_ascii(path, vertices, polygons):
    lines = ["solid thing"]
    for p in polygons:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex " + " ".join(repr(float(x)) for x in vertices[v]) for v in p]
        lines += ["endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid thing"]) + "\n")


def stl_binary(path, vertices, polygons):
    body = bytearray(b"made by a test".ljust(80) + struct.pack("<I", len(polygons)))
    for p in polygons:
        body += struct.pack("<12fH", 0, 0, 0, *np.asarray(vertices)[list(p)].ravel(), 0)
    path.write_bytes(body)


POLYGONS = {
    "ascii.ply": ply_ascii,
    "binary.ply": ply_binary,
    "big.ply": ply_big,
    "extra.ply": ply_extra,
    "mesh.obj": obj,
    "mesh.off": off,
}
TRIANGLES = {**POLYGONS, "ascii.stl": stl_ascii, "binary.stl": stl_binary}


def read_rows(path, rows):
    """The engine's result for a file of these lines."""
    path.write_bytes("\n".join(rows).encode())
    return engine.reading.read_polygons(path)


def assert_same(found, wanted):
    for one, other in zip(found, wanted, strict=True):
        np.testing.assert_array_equal(one, other)
