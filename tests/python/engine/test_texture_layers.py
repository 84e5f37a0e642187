"""Roughness, metallic, emission, occlusion and normal maps of a scan, carried to the n-gons."""

import json

import numpy as np
import pytest
from PIL import Image

import isimp_engine as engine
import meshfiles
import shapes
from commands import called
from test_texture import picture, ramp, result, sample, write_plane_obj

GREY = np.full((8, 8), 255, np.uint8)


def halves(left, right):
    """An image whose left and right halves are of two values or colours."""
    wide = np.empty((16, 16, *np.shape(left)), np.uint8)
    wide[:, :8], wide[:, 8:] = left, right
    return wide


def plane(**layers):
    """A plane that shows the whole image, with these layers."""
    vertices, triangles = shapes.plane(6)
    made = {name: engine.TextureLayer([image]) for name, image in layers.items()}
    return engine.TexturedSoup(vertices, triangles, uv=vertices[:, :2], images=[ramp()], layers=made)


def at(poly, made, image, points):
    """The values of an image of the result at points (x, y) of a plane."""
    corners = poly.vertices[poly.loops][:, :2]
    affine, *_ = np.linalg.lstsq(np.c_[made.uv, np.ones(len(made.uv))], corners, rcond=None)
    return sample(image, np.linalg.solve(affine[:2].T, (np.asarray(points) - affine[2]).T).T)


LEFT, RIGHT = [[0.2, 0.3], [0.3, 0.7]], [[0.7, 0.6], [0.9, 0.2]]


def test_each_layer_lies_where_the_colours_do():
    soup = plane(
        roughness=halves(40, 200),
        metallic=halves(0, 255),
        emission=halves([10, 20, 30], [200, 100, 0]),
        occlusion=halves(90, 160),
    )
    _, _, poly, made = result(soup, np.zeros(len(soup.triangles)), size=128)
    assert made.report["layers"] == list(made.layers) == ["roughness", "metallic", "emission", "occlusion"]
    for name, left, right in (
        ("roughness", 40, 200),
        ("metallic", 0, 255),
        ("emission", [10, 20, 30], [200, 100, 0]),
        ("occlusion", 90, 160),
    ):
        image = made.layers[name]
        assert image.shape == ((128, 128, 3) if name == "emission" else (128, 128))
        assert (at(poly, made, image, LEFT) == left).all(), name
        assert (at(poly, made, image, RIGHT) == right).all(), name
    plain = engine.TexturedSoup(soup.vertices, soup.triangles, soup.uv, images=soup.images)
    _, _, _, without = result(plain, np.zeros(len(soup.triangles)), size=128)
    assert np.array_equal(without.image, made.image)
    assert without.layers == without.factors == {}


def test_a_layer_with_uvs_of_its_own():
    soup = plane()
    own = engine.TextureLayer([halves(40, 200)], uv=1 - soup.uv)
    soup = engine.TexturedSoup(soup.vertices, soup.triangles, soup.uv, images=soup.images, layers={"roughness": own})
    _, _, poly, made = result(soup, np.zeros(len(soup.triangles)), size=64)
    assert (at(poly, made, made.layers["roughness"], LEFT) == 200).all()
    assert (at(poly, made, made.layers["roughness"], RIGHT) == 40).all()


def test_one_number_everywhere_is_a_factor_and_two_are_an_image():
    vertices, triangles = shapes.plane(4)
    left = (vertices[triangles].mean(1)[:, 0] < 0.5).astype(np.int32)
    for numbers, wanted in (([0.25, 0.25], 0.25), ([0.25, 0.75], None), ([0.25, None], None)):
        layers = {"roughness": engine.TextureLayer(numbers), "emission": engine.TextureLayer([None, 0.0])}
        soup = engine.TexturedSoup(vertices, triangles, vertices[:, :2], left, [ramp(), ramp()], layers=layers)
        _, _, _, made = result(soup, left, size=64)
        assert "emission" not in made.layers
        if wanted is not None:
            assert made.factors["roughness"] == wanted
            assert made.layers == {}
            continue
        values = {int(v) for v in np.unique(made.layers["roughness"])}
        assert {64, 191 if numbers[1] else 255} <= values


@pytest.mark.parametrize(
    ("uv", "wanted"),
    [
        (lambda p: p, [0.6, 0.0, 0.8]),
        (lambda p: [1, 0] + p * [-1, 1], [-0.6, 0.0, 0.8]),  # mirrored
        (lambda p: p[:, ::-1], [0.0, 0.6, 0.8]),  # mirrored about the diagonal
        (lambda p: np.stack([p[:, 1], 1 - p[:, 0]], axis=1), [0.0, 0.6, 0.8]),  # turned: u grows along y
    ],
)
@pytest.mark.parametrize("reversed_", [False, True])
def test_the_scans_normal_map_leans_the_way_it_does_there(uv, wanted, reversed_):
    """A normal map that leans to where u grows, everywhere."""
    vertices, triangles = shapes.plane(6)
    if reversed_:
        triangles = triangles.copy()
        triangles[::5] = triangles[::5, ::-1]  # repairs reverse them
    leaning = np.full((4, 4, 3), np.round(np.array([0.6, 0.0, 0.8]) * 127.5 + 127.5), np.uint8)
    soup = engine.TexturedSoup(
        vertices, triangles, uv(vertices[:, :2]), images=[ramp()], layers={"normal": engine.TextureLayer([leaning])}
    )
    _, _, poly, made = result(soup, np.zeros(len(triangles)), size=64)
    local = at(poly, made, made.normal, LEFT + RIGHT) / 127.5 - 1
    frame = np.stack([made.polygon_tangent[0], np.cross(made.polygon_normal[0], made.polygon_tangent[0])])
    frame = np.vstack([frame, made.polygon_normal[0]])
    assert np.allclose(local @ frame, wanted, atol=0.02)


def test_faults_of_layers_are_named():
    soup = plane()
    for layers, match in (
        ({"gloss": engine.TextureLayer([GREY])}, "'gloss'; there are roughness"),
        ({"roughness": engine.TextureLayer([])}, "0 images, but there are 1 materials"),
        ({"roughness": engine.TextureLayer([GREY], uv=np.zeros((2, 2)))}, r"uv of layers\['roughness'\]"),
        ({"emission": engine.TextureLayer([GREY], strength=float("nan"))}, "strength"),
    ):
        with pytest.raises(engine.InvalidInput, match=match):
            engine.TexturedSoup(soup.vertices, soup.triangles, soup.uv, images=[ramp()], layers=layers)


def write_pbr_obj(folder):
    path = write_plane_obj(folder, lambda p: p)
    for name, pixels in (
        ("t.png", ramp()),
        ("rough.png", halves(40, 200)),
        ("metal.png", halves(0, 255)),
        ("glow.png", halves([10, 20, 30], [200, 100, 0])),
        ("bent.png", np.full((4, 4, 3), [204, 128, 230], np.uint8)),
    ):
        picture(folder, name, pixels)
    (folder / "t.mtl").write_text(
        "newmtl m\nPr 0.3\nPm 1\nKe 0 0 0\nmap_Kd t.png\nmap_Pr rough.png\nmap_Pm metal.png\nmap_Ke glow.png\n"
        "norm -bm 1 bent.png\n"
    )
    return path


def test_an_obj_with_maps_is_read_back(tmp_path):
    soup = engine.read_textured(write_pbr_obj(tmp_path))
    assert set(soup.layers) == {"roughness", "metallic", "emission", "normal"}
    assert {file.name for file in soup.files} == {"t.mtl", "t.png", "rough.png", "metal.png", "glow.png", "bent.png"}
    _, _, poly, made = result(soup, np.zeros(len(soup.triangles)), size=64)
    for name in ("out.obj", "out.glb", "out.gltf"):
        files = engine.write_textured(tmp_path / name, poly, made)
        back = engine.read_textured(tmp_path / name)
        assert set(back.layers) == {"roughness", "metallic", "emission", "normal"}
        for layer in ("roughness", "metallic"):
            assert np.array_equal(back.layers[layer].images[0][:, :, 0], made.layers[layer])
        assert np.array_equal(back.layers["emission"].images[0][:, :, :3], made.layers["emission"])
        if name == "out.obj":
            ends = ["mtl", "obj", "png", "emission.png", "metallic.png", "normal.png", "roughness.png"]
            assert sorted(f.name for f in files) == sorted(f"out.{e}" if "." not in e else f"out_{e}" for e in ends)


def test_numbers_of_an_mtl_file_are_kept(tmp_path):
    path = write_plane_obj(tmp_path, lambda p: p)
    picture(tmp_path, "t.png", ramp())
    (tmp_path / "t.mtl").write_text("newmtl m\nPr 0.3\nPm 0.75\nKe 2 4 0\nmap_Kd t.png\n")
    soup = engine.read_textured(path)
    _, _, poly, made = result(soup, np.zeros(len(soup.triangles)), size=64)
    assert made.factors == {"roughness": 0.3, "metallic": 0.75, "emission": 4.0}
    assert list(made.layers) == ["emission"]
    assert at(poly, made, made.layers["emission"], LEFT).tolist() == [[188, 255, 0]] * 2  # .5 and 1, linear
    for name in ("out.obj", "out.glb", "out.gltf"):
        engine.write_textured(tmp_path / name, poly, made)
        back = engine.read_textured(tmp_path / name)
        _, _, _, again = result(back, np.zeros(len(back.triangles)), size=64)
        assert again.factors == made.factors
    (tmp_path / "t.mtl").write_text("newmtl m\nPr rough\n")
    with pytest.raises(engine.FileError, match=r"t\.mtl, line 2: expected three numbers after Pr"):
        engine.read_textured(path)
    (tmp_path / "t.mtl").write_text("newmtl m\nmap_Pr none.png\n")
    with pytest.raises(engine.FileError, match=r"line 2: the image .*none\.png does not exist"):
        engine.read_textured(path)


def write_pbr_gltf(folder, material, images):
    """A quad with two sets of UVs, the second one mirrored, as .gltf with a separate buffer."""
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], "<f4")
    uv = points[:, :2] * [1, -1] + [0, 1]
    arrays = [points, uv.astype("<f4"), (uv * [-1, 1] + [1, 0]).astype("<f4"), np.array([0, 1, 2, 0, 2, 3], "<u4")]
    views, data = [], b""
    for array in arrays:
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": array.nbytes})
        data += array.tobytes()
    (folder / "quad.bin").write_bytes(data)
    for i, image in enumerate(images):
        picture(folder, f"{i}.png", image)
    kinds = [("VEC3", 4, 5126), ("VEC2", 4, 5126), ("VEC2", 4, 5126), ("SCALAR", 6, 5125)]
    document = {
        "asset": {"version": "2.0"},
        "buffers": [{"uri": "quad.bin", "byteLength": len(data)}],
        "bufferViews": views,
        "accessors": [
            {"bufferView": i, "type": t, "count": n, "componentType": c} for i, (t, n, c) in enumerate(kinds)
        ],
        "images": [{"uri": f"{i}.png"} for i in range(len(images))],
        "textures": [{"source": i} for i in range(len(images))],
        "materials": [material],
        "meshes": [
            {
                "primitives": [
                    {"attributes": {"POSITION": 0, "TEXCOORD_0": 1, "TEXCOORD_1": 2}, "indices": 3, "material": 0}
                ]
            }
        ],
    }
    (folder / "quad.gltf").write_text(json.dumps(document))
    return folder / "quad.gltf"


def test_gltf_with_factors_and_uvs_of_its_own(tmp_path):
    surface = np.zeros((16, 16, 3), np.uint8)
    surface[:, :, 0] = 100
    surface[:, :8, 1], surface[:, 8:, 1] = 100, 200
    surface[:, :8, 2], surface[:, 8:, 2] = 250, 50
    material = {
        "pbrMetallicRoughness": {
            "baseColorTexture": {"index": 0},
            "metallicRoughnessTexture": {"index": 1, "texCoord": 1},
            "roughnessFactor": 0.5,
        },
        "occlusionTexture": {"index": 1, "strength": 0.5},
        "emissiveTexture": {"index": 2},
        "emissiveFactor": [1, 1, 0.5],
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 3}},
        "normalTexture": {"index": 3, "scale": 0.5},
    }
    bent = np.full((4, 4, 3), [227, 128, 208], np.uint8)  # leans by .78 to .63
    path = write_pbr_gltf(tmp_path, material, [ramp(), surface, np.full((4, 4, 3), 255, np.uint8), bent])
    soup = engine.read_textured(path)
    _, _, poly, made = result(soup, [0, 0], size=64)
    assert made.factors == {"emission": 3.0}
    shown = {name: at(poly, made, image, LEFT[:1] + RIGHT[:1]).astype(int) for name, image in made.layers.items()}
    assert np.abs(shown["roughness"] - [100, 50]).max() <= 1  # mirrored, half
    assert shown["metallic"].tolist() == [50, 250]
    assert np.abs(shown["occlusion"] - (255 + 100) / 2).max() <= 1
    assert np.abs(shown["emission"] - [255, 255, 188]).max() <= 1  # half of the light, as sRGB stores it
    local = at(poly, made, made.normal, LEFT) / 127.5 - 1
    assert np.allclose(np.hypot(local[:, 0], local[:, 1]) / local[:, 2], 0.5 * 0.78 / 0.63, atol=0.03)


def test_another_library_reads_the_layers(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    soup = engine.read_textured(write_pbr_obj(tmp_path))
    _, _, poly, made = result(soup, np.zeros(len(soup.triangles)), size=64)
    engine.write_textured(tmp_path / "out.glb", poly, made)
    (mesh,) = trimesh.load(tmp_path / "out.glb").geometry.values()
    surface = np.asarray(mesh.visual.material.metallicRoughnessTexture)
    assert np.array_equal(surface[:, :, 1], made.layers["roughness"])
    assert np.array_equal(surface[:, :, 2], made.layers["metallic"])
    assert np.array_equal(np.asarray(mesh.visual.material.emissiveTexture), made.layers["emission"])
    assert np.asarray(mesh.visual.material.emissiveFactor).tolist() == [1, 1, 1]
    document, _ = meshfiles.of_glb((tmp_path / "out.glb").read_bytes())
    assert "occlusionTexture" not in document["materials"][0]
    assert document["extensionsUsed"] == ["FB_ngon_encoding"]
    engine.write_textured(tmp_path / "out.obj", poly, made)
    mtl = (tmp_path / "out.mtl").read_text()
    for word, name in (("map_Pr", "roughness"), ("map_Pm", "metallic"), ("map_Ke", "emission")):
        assert f"{word} out_{name}.png" in mtl
        image = np.asarray(Image.open(tmp_path / f"out_{name}.png"))
        assert np.array_equal(image, made.layers[name])


def test_the_command_writes_the_layers_and_lists_their_files(tmp_path):
    path = write_pbr_obj(tmp_path)
    report = tmp_path / "r.json"
    ran = called("simplify", path, tmp_path / "out.obj", "--proxies", "1", "--texture", "64", "--report", report)
    assert ran.returncode == 0, ran.stderr
    told = json.loads(report.read_text())["texture"]
    assert told["layers"] == ["roughness", "metallic", "emission"]
    assert all((tmp_path / file).is_file() for file in told["files"])
    assert len(told["files"]) == 6
    (tmp_path / "rough.png").rename(tmp_path / "plane_roughness.png")
    (tmp_path / "t.mtl").write_text("newmtl m\nmap_Kd t.png\nmap_Pr plane_roughness.png\n")
    before = (tmp_path / "plane_roughness.png").read_bytes()
    (tmp_path / "plane.obj").rename(tmp_path / "scan.obj")
    ran = called("simplify", tmp_path / "scan.obj", tmp_path / "plane.obj", "--proxies", "1", "--texture", "64")
    assert ran.returncode == 2
    assert "plane_roughness.png: belongs to the scan and would be overwritten" in ran.stderr
    assert (tmp_path / "plane_roughness.png").read_bytes() == before
