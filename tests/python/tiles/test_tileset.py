"""3D Tiles as input: leaves of a tileset, at their places, in double precision."""

import json
import os
import struct

import numpy as np
import pytest

import isimp_engine as engine
import meshfiles
import shapes
import tilesets
from commands import called
from isimp_engine import tiles
from isimp_engine.tiles import tileset

EARTH = np.array([4_000_000.0, 600_000.0, 4_900_000.0])


def glb(vertices, triangles, extensions=None):
    """Binary glTF: `vertices` with z upward are turned to glTF's axes."""
    points = np.asarray(vertices)[:, [0, 2, 1]] * [1, 1, -1]
    position, index = points.astype("<f4").tobytes(), np.asarray(triangles, "<u4").tobytes()
    text = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": len(position) + len(index)}],
        "bufferViews": [
            {"buffer": 0, "byteLength": len(position)},
            {"buffer": 0, "byteOffset": len(position), "byteLength": len(index)},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3"},
            {"bufferView": 1, "componentType": 5125, "count": 3 * len(triangles), "type": "SCALAR"},
        ],
    } | ({"extensions": extensions} if extensions else {})
    return meshfiles.glb(text, position + index)


def b3dm(inside, centre=None, in_binary=False):
    table, binary = b"", b""
    if centre is not None:
        binary = struct.pack("<3f", *centre) if in_binary else b""
        table = json.dumps({"RTC_CENTER": {"byteOffset": 0} if in_binary else list(centre)}).encode()
    size = 28 + len(table) + len(binary) + len(inside)
    return struct.pack("<4s6I", b"b3dm", 1, size, len(table), len(binary), 0, 0) + table + binary + inside


def write(folder, root, **asset):
    folder.mkdir(exist_ok=True)
    (folder / "tileset.json").write_text(json.dumps({"asset": {"version": "1.0"} | asset, "root": root}))
    return folder / "tileset.json"


def moved(by):
    matrix = np.eye(4)
    matrix[:3, 3] = by
    return matrix.T.ravel().tolist()  # 3D Tiles have columns first


def tile(name, **more):
    return {"content": {"uri": name}, "geometricError": 0} | more


def test_leaves_alone_are_read_at_the_places_of_their_ancestors(tmp_path):
    square = shapes.grid(1, (0, 0, 0), (1, 0, 0), (0, 1, 0))
    children = [tile("a b.glb", transform=moved((0.5, 0, 0))), {"children": [tile("c.glb")], "geometricError": 1}]
    root = tile("coarse.glb", children=[*children, tile("sub/tileset.json")], transform=moved(EARTH), refine="REPLACE")
    root["children"][0]["content"]["uri"] = "a%20b.glb"
    path = write(tmp_path / "t", root)
    write(tmp_path / "t" / "sub", tile("d.glb", transform=moved((0, 2, 0))))
    for name in ("a b", "c", "coarse", "sub/d"):
        (tmp_path / "t" / f"{name}.glb").write_bytes(glb(*square))
    found = tileset.leaves(path)
    assert [leaf.path.name for leaf in found] == ["a b.glb", "c.glb", "d.glb"]
    for leaf, shift in zip(found, [(0.5, 0, 0), (0, 0, 0), (0, 2, 0)], strict=True):
        vertices, triangles = tileset.read(leaf)
        np.testing.assert_array_equal(vertices, square[0] + EARTH + shift)
        np.testing.assert_array_equal(triangles, square[1])
    root["refine"] = "add"
    write(tmp_path / "t", root)
    assert tileset.leaves(path)[0].path.name == "coarse.glb"


@pytest.mark.parametrize("kind", ["b3dm", "in_binary", "cmpt", "CESIUM_RTC"])
def test_centres_are_added_in_double_precision_after_the_turn_to_z(tmp_path, kind):
    """A centre is in the coordinates of the tile, z upward, and the tile's transform turns it too."""
    square = shapes.grid(2, (0, 0, 0), (1, 0, 0), (0, 1, 0.25))
    centre = (1024.0, -2048.0, 512.0)  # exact as floats
    inside = glb(*square, {"CESIUM_RTC": {"center": centre}} if kind == "CESIUM_RTC" else None)
    packed = inside if kind == "CESIUM_RTC" else b3dm(inside, centre, kind == "in_binary")
    if kind == "cmpt":
        packed = struct.pack("<4sIII", b"cmpt", 1, 16 + 2 * len(packed), 2) + 2 * packed
    turn = np.array([[0, -1, 0, EARTH[0]], [1, 0, 0, EARTH[1]], [0, 0, 1, EARTH[2]], [0, 0, 0, 1.0]])
    name = {"cmpt": "a.cmpt", "CESIUM_RTC": "a.glb"}.get(kind, "a.b3dm")
    path = write(tmp_path / "t", tile(name, transform=turn.T.ravel().tolist()))
    (tmp_path / "t" / name).write_bytes(packed)
    vertices, triangles = tileset.read(tileset.leaves(path)[0])
    wanted = (square[0] + centre) @ turn[:3, :3].T + EARTH
    times = 2 if kind == "cmpt" else 1
    np.testing.assert_array_equal(vertices, np.concatenate([wanted] * times))
    assert len(triangles) == times * len(square[1])
    assert triangles.max() == len(vertices) - 1


def test_a_mirroring_transform_turns_triangles(tmp_path):
    mirror = np.diag([-1.0, 1, 1, 1]).ravel().tolist()
    path = write(tmp_path / "t", tile("a.glb", transform=mirror))
    (tmp_path / "t" / "a.glb").write_bytes(glb(*shapes.cube(2)))
    vertices, triangles = tileset.read(tileset.leaves(path)[0])
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6 == pytest.approx(1)


@pytest.mark.parametrize(
    ("root", "said"),
    [
        (tile("a.glb", implicitTiling={}), "has implicit tiling"),
        (tile("http://host/a.glb"), "http://host/a.glb is not a file of this machine"),
        (tile("not.glb"), "the tile not.glb is not there"),
        (tile("a.pnts"), "a.pnts must end in one of .b3dm"),
        (tile("tileset.json"), "nested more than 64 times"),
        (tile("a.glb", transform=[1, 2]), "a tile: transform must be 16 finite numbers"),
        (["no", "tile"], "is no tileset of 3D Tiles, or damaged"),
    ],
)
def test_what_can_not_be_used_is_said_with_the_tileset(tmp_path, root, said):
    path = write(tmp_path / "t", root)
    with pytest.raises(engine.FileError, match=said) as caught:
        tileset.leaves(path)
    assert str(caught.value).startswith(str(path))


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"pnts" + bytes(40), "holds points, not a mesh"),
        (b3dm(glb(*shapes.cube(1)))[:-40], "is cut short"),
        (struct.pack("<4sIII", b"cmpt", 1, 16, 3), "is damaged"),
        (b"garbage", "is not glTF, or damaged"),
    ],
)
def test_damaged_leaves_are_named(tmp_path, data, said):
    (tmp_path / "a.b3dm").write_bytes(data)
    with pytest.raises(engine.FileError, match=rf"a\.b3dm: {said}"):
        tileset.read(tileset.Leaf(tmp_path / "a.b3dm", np.eye(4).ravel().tolist()))


@pytest.mark.skipif(not hasattr(os, "fork"), reason="tiles need fork")
def test_a_tileset_becomes_one_model_with_labels_for_each_leaf(tmp_path):
    parts = tilesets.cut(*shapes.cube(8), 2, 2)
    root = {"children": [], "transform": moved(EARTH), "geometricError": 9}
    (tmp_path / "t").mkdir()
    for k, (vertices, triangles, _) in enumerate(parts):
        (tmp_path / "t" / f"{k}.b3dm").write_bytes(b3dm(glb(vertices, triangles)))
        root["children"].append(tile(f"{k}.b3dm"))
    write(tmp_path / "t", root)
    report = tiles.run(tmp_path / "t", tmp_path / "a.obj", proxies=6, labels=tmp_path / "l").report
    assert (report["regions"], report["unmatched_edges"], report["output"]["polygons"]) == (6, 0, 6)
    assert sorted(p.name for p in (tmp_path / "l").iterdir()) == [f"{k}.npy" for k in range(4)]
    assert engine.read(tmp_path / "a.obj")[0].min(0) == pytest.approx(EARTH, abs=1e-6)
    (tmp_path / "t" / "2.b3dm").unlink()
    done = called("tiles", tmp_path / "t", tmp_path / "b.obj", "--proxies", 6)
    assert (done.returncode, done.stderr) == (3, f"isimp: {tmp_path}/t/tileset.json: the tile 2.b3dm is not there\n")
