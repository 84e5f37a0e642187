"""Makes the scans of the stories in docs, games.md, surveys.md and parts.md, and of points.md.

    python examples/scans.py FOLDER

statue.glb (a figure with a texture), crate.glb (open at the top), house.ply (in map coordinates), plate.stl (in
millimetres, with three holes) have the noise of a scanner; points.ply has the points of a house, without faces.
The files are the same on every run. It needs numpy, Pillow and a clone, whose bench/generators have the shapes.
"""

import io
import json
import struct
import sys
from pathlib import Path

import numpy as np
from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from bench.generators import hollow_solids, houses, painted_scans, round_shapes

PLACE = 450_000.0, 5_420_000.0, 120.0  # UTM zone 32, EPSG 25832
PLATE = 10.0  # millimetres for a unit of the generator: the plate is 40 x 26 x 8
PIXELS = 128  # side of each of the six parts of the statue's image


def glb(path, corners, uv=None, image=None):
    """Triangles (F, 3, 3), and their UVs and image: the layout of glTF 2.0, with y up."""
    x, y, z = corners.reshape(-1, 3).T
    arrays = [np.stack([x, z, -y], axis=1)]
    attributes, more = {"POSITION": 0}, {}
    parts = [arrays[0].astype("<f4").tobytes()]
    if image is not None:
        u, v = uv.reshape(-1, 2).T
        attributes["TEXCOORD_0"] = 1
        arrays.append(np.stack([u, 1 - v], axis=1))
        stored = io.BytesIO()
        Image.fromarray(image).save(stored, "PNG")
        parts += [arrays[1].astype("<f4").tobytes(), stored.getvalue()]
        more = {
            "images": [{"bufferView": 2, "mimeType": "image/png"}],
            "textures": [{"source": 0}],
            "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0}}],
        }
    place = np.cumsum([0] + [len(part) for part in parts]).tolist()
    size = place[-1] + -place[-1] % 4
    scene = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": path.stem}],
        "meshes": [{"primitives": [{"attributes": attributes} | ({"material": 0} if more else {})]}],
        "accessors": [
            {"bufferView": i, "componentType": 5126, "count": len(array), "type": f"VEC{array.shape[1]}"}
            | {"min": array.min(axis=0).tolist(), "max": array.max(axis=0).tolist()}
            for i, array in enumerate(arrays)
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": at, "byteLength": len(part)} for at, part in zip(place, parts, strict=False)
        ],
        "buffers": [{"byteLength": size}],
    } | more
    text = json.dumps(scene).encode()
    text += b" " * (-len(text) % 4)
    with path.open("wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + size))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text)
        file.write(struct.pack("<I4s", size, b"BIN\0") + b"".join(parts).ljust(size, b"\0"))


def ply(path, columns, triangles=()):
    """Binary PLY with double precision. columns: by name."""
    rows = "".join(f"property double {name}\n" for name in columns)
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(columns['x'])}\n{rows}"
    if len(triangles):
        head += f"element face {len(triangles)}\nproperty list uchar int vertex_indices\n"
    faces = np.empty(len(triangles), [("count", "u1"), ("index", "<i4", 3)])
    faces["count"], faces["index"] = 3, np.reshape(triangles, (-1, 3))
    content = np.stack(list(columns.values()), axis=1).astype("<f8").tobytes() + faces.tobytes()
    path.write_bytes(head.encode() + b"end_header\n" + content)


def stl(path, corners):
    """Binary STL."""
    rows = np.zeros(len(corners), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("unused", "<u2")])
    rows["corners"] = corners
    path.write_bytes(bytes(80) + struct.pack("<I", len(rows)) + rows.tobytes())


def axes(vertices):
    return dict(zip("xyz", vertices.T, strict=True))


def statue(path):
    scan = painted_scans.star(painted_scans.owl_surface, painted_scans.owl_colour, 16_000, PIXELS, 0.0015)
    (image,) = scan.images.values()
    glb(path, scan.vertices[scan.triangles], scan.uv, image)


def crate(path):
    vertices, triangles = hollow_solids.twin(hollow_solids.crate())
    glb(path, vertices[triangles])


def house(path):
    made = houses.make(noise=0.0005, at=PLACE)
    ply(path, axes(made.vertices), made.triangles)


def plate(path):
    vertices, triangles = round_shapes.made(round_shapes.shapes()["plate"])
    stl(path, PLATE * round_shapes.with_noise(vertices, 0.0005, 5)[triangles])


def points(path):
    made = houses.make(noise=0.0003)
    a, b, c = made.vertices[made.triangles].swapaxes(0, 1)
    normal = np.zeros_like(made.vertices)
    for corner in made.triangles.T:
        np.add.at(normal, corner, np.cross(b - a, c - a))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    ply(path, axes(made.vertices) | dict(zip(("nx", "ny", "nz"), normal.T, strict=True)))


MADE = {"statue.glb": statue, "crate.glb": crate, "house.ply": house, "plate.stl": plate, "points.ply": points}

if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for name, make in MADE.items():
        make(folder / name)
        print(folder / name)
