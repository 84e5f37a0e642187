"""Families of damaged files, each case made from its number alone."""

import copy
import io
import json
import random
import struct
from pathlib import Path

import numpy as np
from PIL import Image

import meshfiles
import shapes
from isimp_engine.texturing import images
from test_tileset import b3dm, glb

VALUES = [None, True, -1, 0, 3, 2**31, 2**63, 10**30, 10**400, 1.5, -1e308, float("nan"), float("inf"), "", "x", "../x"]
VALUES += ["\ud800", "a\0b", [], {}, [[]], [None], {"index": 0}, [10**400] * 3, ["a"] * 3, [float("nan")] * 16]
ROW = {"name": "a.ply", "input": "/in/a.ply", "status": "ok", "why": None, "output": "a.obj", "seconds": 1.5}
ROW |= {"peak_mb": 30.5, "faces": 12, "regions": 6, "polygons": 6, "planarity_mean": 0.1, "diagonal": 2.0}
ROW |= {"key": "0" * 32, "warnings": ["thin"], "manifold": True, "scan_distance": 0.1, "scan_distance_allowed": 0.2}
ROW |= {"bent": 1}
RECIPE = [
    {"step": "partition", "proxies": 12, "smooth": 0.5, "keep_openings": [[0, 0, 1]], "angle": 40}
    | {"close_openings": True},
    {"step": "regularise", "up": "z", "length": 0.1, "direction": [0, 0, 1]},
    {"step": "even_borders", "strength": 0.4},
    {"step": "add_worst", "times": 2},
    {"step": "mesh", "planar": True, "flatten": 2},
    {"step": "texture", "size": 64, "occlusion": True, "occlusion_distance": 0.5},
]
OBJ = ["mtllib s.mtl", "v 0 0 0 1 0 0", "v 1 0 0 0 1 0", "v 0 1 0 0 0 1", "v 1 1 0 1 1 1", "vt 0 0", "vt 1 0", "vt 0 1",
       "vn 0 0 1", "usemtl m", "f 1/1/1 2/2/1 3/3/1", "usemtl n", "f 2/-2 4/3 \\", "3/1 # end"]  # fmt: skip
MTL = ["newmtl m", "Kd 1 0.5 0", "map_Kd -s 1 1 1 x.png", "Pr 0.5", "map_Ke x.png", "Ke 2 2 2"]
MTL += ["newmtl n", "norm x.png"]


def places(value, at=()):
    """All places in a JSON value."""
    yield at
    for key in value if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ():
        yield from places(value[key], (*at, key))


def changed(value, rng):
    """A JSON value with one to three of its parts changed or removed."""
    value = copy.deepcopy(value)
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        at = rng.choice(list(places(value)))
        if not at:
            return rng.choice(VALUES)
        outer = value
        for key in at[:-1]:
            outer = outer[key]
        if rng.random() < 0.15:
            del outer[at[-1]]
        else:
            outer[at[-1]] = copy.deepcopy(rng.choice(VALUES))
    return value


def damaged(data, rng, head=80):
    """Bytes with some changed, mostly near the beginning, inserted, removed or cut off."""
    data = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 5, 10))):
        at = rng.randrange(max(1, min(len(data), head) if rng.random() < 0.6 else len(data)))
        kind = rng.random()
        if kind < 0.7:
            data[at : at + 1] = bytes([rng.choice((0, 10, 32, 127, 255, rng.randrange(256)))])
        elif kind < 0.8:
            del data[at : at + rng.choice((1, 4, 16))]
        elif kind < 0.9:
            data[at:at] = rng.randbytes(rng.choice((1, 4, 16)))
        else:
            del data[at:]
    return bytes(data)


def picture(rng, kind="PNG"):
    out = io.BytesIO()
    pixels = np.frombuffer(rng.randbytes(192), np.uint8).reshape(8, 8, 3)
    mode = rng.choice(("RGB", "L", "P", "RGBA")) if kind in ("PNG", "TIFF") else "RGB"
    Image.fromarray(pixels).convert(mode).save(out, kind)
    return out.getvalue()


def textured_gltf():
    """The JSON and the bytes of a GLB file with all that is read of one."""
    text, body = meshfiles.of_glb(glb(*shapes.cube(1)))
    count = text["accessors"][0]["count"]
    image = picture(random.Random(1))
    uv = np.linspace(0, 1, 2 * count).astype("<f4").tobytes()
    for part in (uv, image):
        text["bufferViews"].append({"buffer": 0, "byteOffset": len(body), "byteLength": len(part)})
        body += part + bytes(-len(part) % 4)
    text["buffers"][0]["byteLength"] = len(body)
    text["bufferViews"][0]["byteStride"] = 12
    text["accessors"].append({"bufferView": 2, "componentType": 5126, "count": count, "type": "VEC2", "byteOffset": 0})
    text["images"] = [{"bufferView": 3, "mimeType": "image/png"}]
    text["textures"] = [{"source": 0}]
    shown = {"index": 0, "texCoord": 0, "extensions": {"KHR_texture_transform": {"scale": [2, 2], "rotation": 1}}}
    base = {"baseColorTexture": shown, "metallicRoughnessTexture": {"index": 0}, "roughnessFactor": 0.5}
    material = {"pbrMetallicRoughness": base, "normalTexture": {"index": 0, "scale": 2}, "emissiveFactor": [1, 1, 1]}
    material |= {"emissiveTexture": {"index": 0}, "occlusionTexture": {"index": 0, "strength": 0.5}, "name": "m"}
    material["extensions"] = {"KHR_materials_emissive_strength": {"emissiveStrength": 2}}
    text["materials"] = [material]
    primitive = text["meshes"][0]["primitives"][0]
    primitive |= {"material": 0, "mode": 4}
    primitive["attributes"]["TEXCOORD_0"] = 2
    text["nodes"] = [{"mesh": 0, "rotation": [0, 0, 0, 1], "scale": [1, 1, 1], "translation": [1, 2, 3]}]
    text["nodes"] += [{"matrix": np.eye(4).ravel().tolist(), "children": [2]}, {"mesh": 0}]
    text["scene"], text["scenes"] = 0, [{"nodes": [0, 1]}]
    text["extensionsRequired"] = ["KHR_texture_transform"]
    return text, body


def gltf(folder: Path, rng: random.Random) -> Path:
    text, body = textured_gltf()
    path = folder / "a.glb"
    whole = meshfiles.glb(changed(text, rng) if rng.random() < 0.7 else text, body)
    path.write_bytes(whole if rng.random() < 0.7 else damaged(whole, rng, 2000))
    return path


def tileset(folder: Path, rng: random.Random) -> Path:
    """A tileset of a B3DM and a composite, one of the three damaged."""
    inside = glb(*shapes.cube(1))
    parts = [b3dm(inside, (1.0, 2.0, 3.0), in_binary=rng.random() < 0.5), b3dm(inside, (1.0, 2.0, 3.0))]
    composite = struct.pack("<4sIII", b"cmpt", 1, 16 + 2 * len(parts[1]), 2) + 2 * parts[1]
    moved = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 3, 0, 0, 1]
    children = [{"content": {"uri": "a.b3dm"}, "transform": moved, "refine": "ADD", "extensions": {}}]
    children.append({"contents": [{"uri": "a.cmpt"}, {"url": "a.b3dm"}], "children": []})
    root = {"children": children, "transform": moved, "refine": "REPLACE", "geometricError": 1}
    said = {"asset": {"version": "1.0", "gltfUpAxis": "Z"}, "root": root}
    which = rng.random()
    text = json.dumps(changed(said, rng) if which < 0.5 else said).encode()
    (folder / "tileset.json").write_bytes(damaged(text, rng) if which < 0.1 else text)
    (folder / "a.b3dm").write_bytes(damaged(parts[0], rng) if 0.5 < which < 0.75 else parts[0])
    (folder / "a.cmpt").write_bytes(damaged(composite, rng) if which > 0.75 else composite)
    return folder / "tileset.json"


def rows(folder: Path, rng: random.Random) -> Path:
    lines = [json.dumps(ROW)] + [json.dumps(changed(ROW, rng)) for _ in range(4)]
    text = "\n".join(lines).encode() + b"\n"
    (folder / "results.jsonl").write_bytes(damaged(text, rng, len(text)) if rng.random() < 0.3 else text)
    return folder


def image(folder: Path, rng: random.Random) -> Path:
    Image.init()
    kinds = [kind for kind in images.FORMATS if kind in Image.SAVE]
    path = folder / "a.img"
    path.write_bytes(damaged(picture(rng, rng.choice(kinds)), rng))
    return path


def obj(folder: Path, rng: random.Random) -> Path:
    """An OBJ file, its MTL file and its image, one of them damaged."""
    found = {"a.obj": "\n".join(OBJ).encode(), "s.mtl": "\n".join(MTL).encode(), "x.png": picture(rng)}
    name = rng.choice(list(found))
    found[name] = damaged(found[name], rng, 10**6)
    for each, data in found.items():
        (folder / each).write_bytes(data)
    return folder / "a.obj"


def ply(folder: Path, rng: random.Random) -> Path:
    vertices, triangles = shapes.cube(1)
    x, y, z = vertices.T.astype(np.float32)
    by_face = rng.random() < 0.5
    vertex = {"x": x, "y": y, "z": z} | ({} if by_face else {"s": x, "t": y, "red": np.full(len(x), 9, np.uint8)})
    faces = [(t, vertices[t][:, :2].ravel()) if by_face else (t,) for t in triangles]
    (folder / "x.png").write_bytes(picture(rng))
    path = folder / "a.ply"
    meshfiles.ply_columns(path, vertex, faces, ["x.png"], binary=rng.random() < 0.5)
    path.write_bytes(damaged(path.read_bytes(), rng, 300))
    return path


def recipe(folder: Path, rng: random.Random) -> Path:
    path = folder / "r.json"
    text = json.dumps(changed({"isimp_recipe": 1, "steps": RECIPE}, rng)).encode()
    path.write_bytes(damaged(text, rng, len(text)) if rng.random() < 0.2 else text)
    return path
