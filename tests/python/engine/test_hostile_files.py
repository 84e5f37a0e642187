"""Files that need much, run programs, lead elsewhere or hold nonsense: each is read, or refused in a line."""

import gzip
import json
import math
import re
import struct
import subprocess
import sys
import zlib

import numpy as np
import pytest
from PIL import Image

import isimp_engine as engine
import meshfiles
import shapes
from commands import ENVIRONMENT, called
from isimp_engine import machine, reading
from isimp_engine.texturing import images
from isimp_engine.texturing.gltf_file import GltfFile
from isimp_engine.texturing.images import decode
from isimp_engine.tiles import tileset
from test_texture import write_plane_obj
from test_tileset import glb, tile, write


def png(width, height, depth=8):
    """A PNG file of zeros in grey, of few bytes."""
    row = bytes(1 + (width * depth + 7) // 8)
    packer = zlib.compressobj(9)
    body = b"".join(packer.compress(row) for _ in range(height)) + packer.flush()
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))  # noqa: E731
    head = struct.pack(">IIBBBBB", width, height, depth, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", body) + chunk(b"IEND", b"")


# Images


@pytest.mark.parametrize("name", ["a.png", "a.eps"])
def test_an_image_is_no_program(tmp_path, monkeypatch, name):
    """PostScript is run by Pillow, in any file that begins so."""
    ran = []
    monkeypatch.setattr("subprocess.check_call", lambda *a, **k: ran.append(a))
    monkeypatch.setattr("subprocess.Popen", lambda *a, **k: ran.append(a))
    box = b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 16 16\n%%EndComments\n{} loop\n"
    (tmp_path / name).write_bytes(box)
    for source in (tmp_path / name, box):
        with pytest.raises(engine.FileError, match="is not an image that can be read"):
            decode(source, "a")
    assert not ran


@pytest.mark.parametrize(
    ("error", "said"),
    [("ModuleNotFoundError('PIL')", "install it: pip"), ("ImportError('no memory')", r"can't be loaded \(no memory\)")],
)
def test_a_pillow_that_can_not_be_loaded_is_named(tmp_path, monkeypatch, error, said):
    (tmp_path / "PIL").mkdir()
    (tmp_path / "PIL" / "__init__.py").write_text(f"raise {error}\n")
    monkeypatch.syspath_prepend(tmp_path)
    for name in [name for name in sys.modules if name.split(".")[0] == "PIL"]:
        monkeypatch.delitem(sys.modules, name)
    with pytest.raises(engine.FileError, match=rf"^a: reading and writing images needs Pillow.*{said}"):
        decode(png(4, 4), "a")


def test_all_kinds_that_are_named_are_read(tmp_path):
    Image.init()
    for kind in images.FORMATS:
        if kind in Image.SAVE:
            path = tmp_path / f"a.{kind}"
            Image.fromarray(np.full((8, 6, 3), 200, np.uint8)).save(path, kind)
            assert decode(path, "a").shape == (8, 6, 4)


def test_large_images_are_read_without_a_warning(tmp_path, capfd):
    limit = Image.MAX_IMAGE_PIXELS
    side = math.isqrt(2 * limit) + 8  # above it Pillow refuses, and above the root of the half it warns
    pixels = decode(png(side, 16, 1), "a")
    assert pixels.shape == (16, side, 4)
    old, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, 64
    try:
        assert decode(png(64, 64), "a").shape == (64, 64, 4)
    finally:
        Image.MAX_IMAGE_PIXELS = old
    assert capfd.readouterr() == ("", "")


def test_an_image_that_memory_has_no_room_for_is_refused_by_its_header(monkeypatch):
    data = png(64, 4)
    head = data[:16] + struct.pack(">II", 60_000, 60_000) + data[24:29]
    data = head + struct.pack(">I", zlib.crc32(head[12:])) + data[33:]
    monkeypatch.setattr(machine, "memory_mb", lambda: 20_000.0)
    with pytest.raises(
        engine.FileError, match="has 60,000 x 60,000 pixels, which take 27,466 MB of memory, and 20,000"
    ):
        decode(data, "a")


def test_an_image_that_ends_in_a_lack_of_memory_is_named(monkeypatch):
    def lacking(image):
        raise MemoryError

    monkeypatch.setattr(images, "_pixels", lacking)
    with pytest.raises(engine.FileError, match=r"^a\.png: there is not enough memory for this image, or it is damaged"):
        decode(png(4, 4), "a.png")


def test_nothing_that_pillow_logs_is_on_stderr():
    code = """
import logging
from isimp_engine.texturing import images
images.pillow("a")
logging.getLogger("PIL.TiffImagePlugin").error("More samples per pixel than can be decoded")
"""
    done = subprocess.run([sys.executable, "-c", code], env=ENVIRONMENT, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (0, "")


def test_each_file_is_decoded_once_and_held_once(tmp_path, monkeypatch):
    path = write_plane_obj(tmp_path, lambda p: p)
    (tmp_path / "t.png").write_bytes(png(8, 8))
    text = path.read_text().replace("usemtl m\n", "")
    rows = [row for row in text.splitlines() if not row.startswith("f ")]
    for k, face in enumerate(row for row in text.splitlines() if row.startswith("f ")):
        rows += [f"usemtl m{k % 20}", face]
    path.write_text("\n".join(rows) + "\n")
    maps = "map_Kd t.png\nmap_Pr ./t.png\nnorm t.png"
    (tmp_path / "t.mtl").write_text("".join(f"newmtl m{k}\n{maps}\n" for k in range(20)))
    decoded = []
    monkeypatch.setattr(images, "decode", lambda source, name: decoded.append(name) or decode(source, name))
    soup = engine.read_textured(path)
    assert len(decoded) == 1
    shown = [*soup.images, *soup.layers["roughness"].images, *soup.layers["normal"].images]
    assert len(shown) == 60
    assert len({id(image) for image in shown}) == 2
    assert len(set(soup.material.tolist())) == 20


# Compressed files


def test_decompressed_data_has_a_limit(tmp_path, monkeypatch):
    monkeypatch.setattr(reading, "_ANY", 1 << 20)
    path = tmp_path / "a.obj.gz"
    path.write_bytes(gzip.compress(bytes(1 << 22)))
    with pytest.raises(engine.FileError, match=r"a\.obj\.gz: becomes more than 200 times its size"):
        engine.read(path)
    if (module := reading._zstd()) is not None:
        path = tmp_path / "a.obj.zst"
        path.write_bytes(module.compress(bytes(1 << 28)))
        sizes = [len(block) for block in reading._blocks(path)]
        assert sum(sizes) == 1 << 28
        assert max(sizes) <= 64 << 20
        with pytest.raises(engine.FileError, match=r"a\.obj\.zst: becomes more than 200 times its size"):
            engine.read(path)


def test_a_disk_that_is_nearly_full_is_left_alone(tmp_path, monkeypatch):
    monkeypatch.setattr(reading, "_BLOCK", 1 << 10)
    monkeypatch.setattr("shutil.disk_usage", lambda place: type("Usage", (), {"free": 4, "total": 100}))
    (tmp_path / "a.obj.gz").write_bytes(gzip.compress(bytes(1 << 18)))
    with pytest.raises(
        engine.FileError, match=r"a\.obj\.gz: can't be decompressed, since the disk of .* is nearly full"
    ):
        engine.read(tmp_path / "a.obj.gz")


# glTF


@pytest.fixture
def cube_glb(tmp_path):
    """Writes a GLB of a cube after a change of its JSON, and gives its path."""

    def made(change, body=None):
        text, own = meshfiles.of_glb(glb(*shapes.cube(1)))
        change(text)
        (tmp_path / "a.glb").write_bytes(meshfiles.glb(text, own if body is None else body))
        return tmp_path / "a.glb"

    return made


def without_view(count):
    def change(text):
        del text["accessors"][0]["bufferView"]
        text["accessors"][0]["count"] = count

    return change


def children(depth):
    def change(text):
        text["nodes"] = [{"children": [k + 1, k + 1]} for k in range(depth)] + [{"mesh": 0}]

    return change


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (without_view(10**8), "accessors 0: has no data for its 100,000,000 elements"),
        (children(60), r"nodes 60 is named twice, by other nodes or the scene"),
        (lambda text: text["scenes"][0].update(nodes=[0, 0]), r"nodes 0 is named twice"),
        (lambda text: text["nodes"][0].update(children=[0]), r"nodes 0 is named twice"),
        (lambda text: text["bufferViews"][0].update(byteStride=3), "its elements of 12 bytes are 3 bytes apart"),
        (lambda text: text.update(extensionsRequired=["EXT_meshopt_compression"]), "needs the extension EXT_meshopt_c"),
        (lambda text: text.update(extensionsRequired=["EXT_mesh_gpu_instancing"]), "needs the extension EXT_mesh_gpu_"),
        (lambda text: text.update(extensionsRequired=[5]), "needs the extension 5, which is not supported"),
        (lambda text: text["nodes"][0].update(extensions={"EXT_mesh_gpu_instancing": {}}), "nodes 0 has EXT_mesh_gpu"),
        (lambda text: text["nodes"][0].update(scale=[1, 1, 10**400]), "nodes 0: scale must be 3 finite numbers, got "),
        (lambda text: text["nodes"][0].update(mesh="x"), "nodes 0: mesh must be a whole number, at least 0, got 'x'"),
        (lambda text: text["nodes"][0].update(mesh=0.5), "nodes 0: mesh must be a whole number, at least 0, got 0.5"),
        (lambda text: text["meshes"].insert(0, 5), "meshes 0 must be an object, got 5"),
        (
            lambda text: text["meshes"][0]["primitives"].append([]),
            r"meshes 0: primitives 1 must be an object, got \[\]",
        ),
        (lambda text: text["accessors"][1].update(componentType=5126), "indices must be unsigned whole numbers"),
        (lambda text: text["accessors"][0].pop("type"), "accessors 0 lacks type"),
    ],
)
def test_wrong_values_of_gltf_are_named_with_their_place(cube_glb, change, said):
    with pytest.raises(engine.FileError, match=said) as caught:
        engine.read_textured(path := cube_glb(change))
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)


def test_extensions_without_influence_on_the_shape_may_be_required(cube_glb):
    names = ["KHR_mesh_quantization", "KHR_texture_transform", "KHR_materials_unlit", "EXT_mesh_features"]
    path = cube_glb(lambda text: text.update(extensionsRequired=names))
    assert len(engine.read_textured(path).triangles) == 12
    path = cube_glb(lambda text: text.update(extensionsRequired=["KHR_texture_basisu"]))
    with pytest.raises(engine.FileError, match="needs the extension KHR_texture_basisu"):
        engine.read_textured(path)
    assert len(tileset.glb.geometry(path, path.read_bytes())[1]) == 12, "tiles have no texture"


@pytest.mark.parametrize(("kind", "component"), [("<i2", 5122), ("<i1", 5120), ("<u2", 5123)])
def test_quantized_positions_are_shares_of_the_largest_number(cube_glb, kind, component):
    vertices, triangles = shapes.cube(1)
    most = np.iinfo(kind).max
    points = np.zeros((len(vertices), 4), kind)
    low = 0 if kind == "<u2" else -most
    points[:, :3] = np.where(vertices > 0.5, most, low)
    if low:
        points[0, 0] = low - 1  # counts as -1 too
    body = points.tobytes() + np.asarray(triangles, "<u4").tobytes()

    def change(text):
        text["accessors"][0].update(componentType=component, normalized=True)
        text["bufferViews"][0].update(byteLength=points.nbytes, byteStride=points.itemsize * 4)
        text["bufferViews"][1].update(byteOffset=points.nbytes)
        text["buffers"][0].update(byteLength=len(body))

    soup = engine.read_textured(cube_glb(change, body))
    np.testing.assert_allclose(soup.vertices, np.where(vertices > 0.5, 1.0, 0.0 if kind == "<u2" else -1.0), atol=1e-7)


def test_a_mesh_of_many_nodes_is_read_once_and_its_places_need_memory(cube_glb, monkeypatch):
    def change(text):
        text["nodes"] = [{"mesh": 0, "translation": [k, 0, 0]} for k in range(300)]
        text["scenes"] = [{"nodes": list(range(300))}]

    path, read = cube_glb(change), []
    accessor = GltfFile._accessor
    monkeypatch.setattr(GltfFile, "_accessor", lambda self, item: read.append(item.place) or accessor(self, item))
    soup = engine.read_textured(path)
    assert (len(soup.triangles), len(read)) == (3600, 2)
    assert soup.vertices[:, 0].max() == 300
    monkeypatch.setattr(machine, "memory_mb", lambda: 0.1)
    with pytest.raises(engine.FileError, match="its nodes have so many triangles"):
        engine.read_textured(path)


# Files that may be named


@pytest.mark.parametrize(
    ("name", "reads"),
    [
        ("t.png", True),
        ("../textures/t.png", True),
        ("sub/../t.png", True),
        ("/elsewhere/t.png", True),  # from another machine: it lies next to the file that names it
        ("C:\\scans\\t.png", True),
        ("../../secret.png", False),
        ("/etc/secret.png", False),
        ("sub/../../../secret.png", False),
        ("http://host/secret.png", False),
        ("//host/secret.png", False),
        ("file:///etc/secret.png", False),
    ],
)
def test_images_are_read_from_the_folder_of_the_scan_and_its_sisters(tmp_path, name, reads):
    folder = tmp_path / "scans" / "a"
    for place in (folder / "t.png", folder / "sub" / "t.png", tmp_path / "scans" / "textures" / "t.png"):
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_bytes(png(4, 4))
    (tmp_path / "secret.png").write_bytes(png(4, 4))
    path = write_plane_obj(folder, lambda p: p, name)
    x, y, z = shapes.plane(2)[0].T.astype(np.float32)
    vertex, faces = {"x": x, "y": y, "z": z, "s": x, "t": y}, [(t,) for t in shapes.plane(2)[1]]
    meshfiles.ply_columns(folder / "plane.ply", vertex, faces, [name])
    for scan in (path, folder / "plane.ply"):
        if reads:
            assert engine.read_textured(scan).images[0].shape == (4, 4, 4)
        else:
            with pytest.raises(engine.FileError, match=r"is outside of|is not a file of this machine"):
                engine.read_textured(scan)


@pytest.mark.parametrize(("uri", "reads"), [("a%20b.bin", True), ("../a b.bin", False), ("/dev/zero", False)])
def test_buffers_are_read_from_the_folder_of_the_file(tmp_path, uri, reads):
    text, body = meshfiles.of_glb(glb(*shapes.cube(1)))
    (tmp_path / "a").mkdir()
    for folder in (tmp_path, tmp_path / "a"):
        (folder / "a b.bin").write_bytes(body)
    text["buffers"][0]["uri"] = uri
    path = tmp_path / "a" / "s.gltf"
    path.write_text(json.dumps(text))
    if reads:
        assert len(engine.read_textured(path).triangles) == 12
    else:
        with pytest.raises(engine.FileError, match=r"s\.gltf: buffers 0: .* is outside of"):
            engine.read_textured(path)


@pytest.mark.parametrize("uri", ["//host/a.glb", "../../a.glb", "/etc/a.glb", "http://host/a.glb"])
def test_tiles_are_read_from_the_folder_of_the_tileset(tmp_path, uri):
    with pytest.raises(engine.FileError, match=r"tileset\.json: .*(is outside of|is not a file of this machine)"):
        tileset.leaves(write(tmp_path / "t", tile(uri)))


# Tilesets


def test_tilesets_that_name_each_other_twice_end(tmp_path):
    for k in range(40):
        more = [tile(f"t{k + 1}.json" if k < 39 else "a.glb")] * 2
        (write(tmp_path / "t", {"children": more, "refine": "ADD"})).rename(tmp_path / "t" / f"t{k}.json")
    (tmp_path / "t" / "a.glb").write_bytes(glb(*shapes.cube(1)))
    with pytest.raises(engine.FileError, match="is named so often that 100,000 tiles come again"):
        tileset.leaves(write(tmp_path / "t", tile("t0.json")))
    assert len(tileset.leaves(tmp_path / "t" / "t30.json")) == 1 << 10


@pytest.mark.parametrize("value", [[10**400] * 16, [1e308] * 16, ["1"] * 16, [math.nan] * 16, None, {}])
def test_wrong_transforms_are_named_with_the_tileset(tmp_path, value):
    root = {"children": [tile("a.glb", transform=value)], "transform": [1e308] * 16 if value == [1e308] * 16 else None}
    if root["transform"] is None:
        del root["transform"]
    (tmp_path / "t").mkdir()
    (tmp_path / "t" / "a.glb").write_bytes(glb(*shapes.cube(1)))
    with pytest.raises(
        engine.FileError, match=r"tileset\.json: (a tile: transform must be 16 finite|the transforms of)"
    ):
        tileset.leaves(write(tmp_path / "t", root))


# PLY


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("0.5 7\n3 1", "0.5 x\n3 1", 'line 17: expected a number for face 0 (the first is 0), got "x"'),
        ("6 0 0 1", "5 0 0 1", "face 0 has 5 numbers in texcoord, not two for each corner"),
        ("0 9\n", "0\n", "it ends within face 1 (the first is 0) of 2; it is cut short or damaged"),
        ("element face 2", "element face 3", "it ends within face 2 (the first is 0) of 3; it is cut short or damaged"),
        ("texnumber\n", "count\n", None),
        ("0.5 7\n3 1", "0.5 1\n3 1", "a face has texnumber 9, but it names 1 texture files"),
        ("0.5 7\n3 1 3 2 0 9", "0.5 -5\n3 1 3 2 0 0", "a face has texnumber -5, but it names 1 texture files"),
    ],
)
def test_wrong_columns_of_ply_files_are_named(tmp_path, old, new, said):
    (tmp_path / "t.png").write_bytes(png(4, 4))
    head = "ply\nformat ascii 1.0\ncomment TextureFile t.png\nelement vertex 4\n"
    head += "".join(f"property float {axis}\n" for axis in "xyz") + "element face 2\n"
    head += "property list uchar int vertex_indices\nproperty list uchar float texcoord\nproperty int texnumber\n"
    rows = "end_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2 6 0 0 1 0 0 0.5 7\n3 1 3 2 0 9\n"
    text = head + rows
    assert old in text
    (tmp_path / "a.ply").write_text(text.replace(old, new))
    if said is None:
        soup = engine.read_textured(tmp_path / "a.ply")
        np.testing.assert_array_equal(soup.uv, [[[0, 0], [1, 0], [0, 0.5]], np.zeros((3, 2))])
        return
    with pytest.raises(engine.FileError, match=re.escape(said)):
        engine.read_textured(tmp_path / "a.ply")


# OBJ


def test_only_line_ends_end_lines(tmp_path):
    (tmp_path / "t.png").write_bytes(png(4, 4))
    path = write_plane_obj(tmp_path, lambda p: p)
    text = path.read_bytes()
    whole = engine.read_textured(path)
    for mark in ("\x0b", "\x0c", "\x1c", "\x85", "\u2028"):
        path.write_bytes(f"# a{mark}f 1 2 3\n".encode() + text)
        soup = engine.read_textured(path)
        np.testing.assert_array_equal(soup.triangles, whole.triangles)
        assert len(soup.images) == 1
    for end in (b"\r\n", b"\r"):
        path.write_bytes(b"\xef\xbb\xbf" + text.replace(b"\n", end))
        (tmp_path / "t.mtl").write_bytes(b"\xef\xbb\xbf" + (b"newmtl m\nmap_Kd t.png\n").replace(b"\n", end))
        soup = engine.read_textured(path)
        np.testing.assert_array_equal(soup.uv, whole.uv)
        assert len(soup.images) == 1


def test_a_material_before_each_face_takes_no_square_of_time(tmp_path, monkeypatch):
    count = 2_000
    lines = [f"usemtl m{k % 3}\nf 1 2 3" for k in range(count)]
    (tmp_path / "a.obj").write_text("\n".join(["v 0 0 0", "v 1 0 0", "v 0 1 0", *lines]))
    full = np.full
    written = [0]

    class Counted(np.ndarray):
        def __setitem__(self, at, value):
            written[0] += np.size(self[at])
            super().__setitem__(at, value)

    monkeypatch.setattr(np, "full", lambda *given, **named: full(*given, **named).view(Counted))
    np.testing.assert_array_equal(engine.read_textured(tmp_path / "a.obj").material, np.arange(count) % 3)
    assert written[0] <= count


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("f 1/1 ", "f 1/99999999999999999999 ", 'line {}: expected the number of a texture coordinate, got "1/999'),
        ("f 1/1 ", "f 1/-99999999999999999999 ", 'line {}: expected the number of a texture coordinate, got "1/-999'),
        ("f 1/1 ", "f 1/x ", 'line {}: expected the number of a texture coordinate, got "1/x"'),
        ("f 1/1 ", "f 1/-99 ", 'line {}: expected the number of a texture coordinate, got "1/-99"'),
        ("f 1/1 ", "f 1/99 ", "a face uses texture coordinate 99, but there are 49"),
        ("vt 0.0 0.0", "vt a b", 'line {}: expected two numbers after "vt", got "vt a b"'),
    ],
)
def test_wrong_numbers_of_obj_files_are_named(tmp_path, old, new, said):
    (tmp_path / "t.png").write_bytes(png(4, 4))
    path = write_plane_obj(tmp_path, lambda p: p)
    text = path.read_text()
    path.write_text(text.replace(old, new))
    with pytest.raises(engine.FileError, match=said.format(1 + text[: text.index(old)].count("\n"))):
        engine.read_textured(path)


@pytest.mark.parametrize("values", ["nan nan nan", "inf 0 0", "1e308 1 1", "a b c"])
def test_wrong_numbers_of_materials_are_named_with_the_line(tmp_path, values):
    path = write_plane_obj(tmp_path, lambda p: p)
    for word in ("Kd", "Ke", "Pr", "Pm"):
        (tmp_path / "t.mtl").write_text(f"newmtl m\n{word} {values}\n")
        with pytest.raises(engine.FileError, match=rf"t\.mtl, line 2: expected three numbers after {word}, got"):
            engine.read_textured(path)


@pytest.mark.parametrize("value", ["nan nan", "inf -inf", "1e308 -1e308", "1e400 0"])
def test_a_face_with_uvs_that_are_no_numbers_shows_no_image(tmp_path, value):
    (tmp_path / "t.png").write_bytes(png(4, 4))
    path = write_plane_obj(tmp_path, lambda p: p)
    path.write_text(path.read_text().replace("vt 0.0 0.0", f"vt {value}"))
    soup = engine.read_textured(path)
    bad = (soup.triangles == 0).any(axis=1)
    assert bad.any()
    np.testing.assert_array_equal(soup.material, np.where(bad, -1, 0))
    assert np.isfinite(soup.uv).all()
    pixel = np.full((1, 1, 4), 9, np.uint8)
    layer = engine.TextureLayer([pixel], np.full_like(soup.uv, float(value.split()[0])))
    soup = engine.TexturedSoup(soup.vertices, soup.triangles, soup.uv, images=[pixel], layers={"emission": layer})
    assert np.isfinite(soup.layers["emission"].uv.astype(np.float32)).all()
    done = called("simplify", path, tmp_path / "o.obj", "--proxies", 1, "--texture", 32, "--quiet")
    assert (done.returncode, done.stderr) == (0, "")
