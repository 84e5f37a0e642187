"""The texture of a scan: read, put on the n-gons, written; and the command's --texture."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import isimp_engine as engine
import meshfiles
import shapes
from commands import called
from isimp_engine.texturing import glb

SIX = np.array([[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 0], [0, 255, 255], [255, 0, 255]], np.uint8)


def result(soup, regions, **options):
    """Polygons of these regions of the soup's faces, and their texture."""
    mesh = engine.clean(soup.vertices, soup.triangles)
    part = engine.partition_from(mesh, np.asarray(regions, np.int32)[np.maximum(mesh.source_face, 0)])
    poly = engine.polygonize(mesh, part)
    return mesh, part, poly, engine.texture(mesh, part, poly, soup, engine.TextureOptions(**options))


def inside(poly, made, q, shrink=0.9):
    """Pixels of polygon q, a convex one: (n, 4) colours on lines from its middle to its corners and edges."""
    ends = np.append(poly.loop_start, len(poly.loops))
    uv = made.uv[ends[q] : ends[q + 1]]
    rim = np.concatenate([uv + t * (np.roll(uv, -1, axis=0) - uv) for t in np.linspace(0, 1, 8)])
    middle = uv.mean(0)
    points = np.concatenate([middle + s * (rim - middle) for s in np.linspace(0, shrink, 12)])
    return sample(made.image, points)


def sample(image, uv):
    height, width = image.shape[:2]
    x = np.clip((uv[:, 0] * width).astype(int), 0, width - 1)
    y = np.clip(((1 - uv[:, 1]) * height).astype(int), 0, height - 1)
    return image[y, x]


def painted_cube(n=4):
    vertices, triangles = shapes.cube(n)
    side = np.arange(len(triangles)) // (2 * n * n)
    return vertices, triangles, side


def write_cube_obj(folder, n=3):
    """A cube with a material for each side, and one corner list for all texture coordinates."""
    vertices, triangles, side = painted_cube(n)
    lines = ["mtllib cube.mtl", *(f"v {x} {y} {z}" for x, y, z in vertices), "vt 0.5 0.5"]
    for s in range(6):
        lines.append(f"usemtl side{s}")
        lines += [f"f {a + 1}/1 {b + 1}/1 {c + 1}/1" for a, b, c in triangles[side == s]]
    (folder / "cube.obj").write_text("\n".join(lines) + "\n")
    mtl = [f"newmtl side{s}\nKd {r / 255} {g / 255} {b / 255}" for s, (r, g, b) in enumerate(SIX)]
    (folder / "cube.mtl").write_text("\n".join(mtl) + "\n")
    return folder / "cube.obj", np.concatenate([np.flatnonzero(side == s) for s in range(6)])


def test_a_cube_with_six_colours_shows_only_them(tmp_path):
    path, _ = write_cube_obj(tmp_path)
    soup = engine.read_textured(path)
    assert soup.uv.shape == (54 * 2, 3, 2)
    assert len(soup.images) == 6
    _, _, poly, made = result(soup, soup.material, size=128)
    assert made.uv.shape == (len(poly.loops), 2)
    assert made.image.shape == (128, 128, 4)
    assert made.image.dtype == np.uint8
    for q, region in enumerate(poly.polygon_region):
        assert (inside(poly, made, q, 0.98)[:, :3] == SIX[region]).all()
    uv, image = made
    assert uv is made.uv
    assert image is made.image
    assert made.report["unknown"] == 0
    # No pixel at all is black or of a mixed colour, gutters and the rest included, except for means of two sides.
    assert made.image[:, :, :3].max(axis=2).min() > 60


def picture(folder, name, pixels):
    Image.fromarray(pixels).save(folder / name)


def ramp(width=64, height=32):
    """Red grows to the right, green upward."""
    x, y = np.meshgrid(np.arange(width), np.arange(height))
    return np.stack([x * 4, (height - 1 - y) * 8, np.full_like(x, 50)], axis=2).astype(np.uint8)


def write_plane_obj(folder, uv, image="t.png", n=6):
    vertices, triangles = shapes.plane(n)
    lines = ["mtllib t.mtl", "usemtl m", *(f"v {x} {y} {z}" for x, y, z in vertices)]
    lines += [f"vt {u} {v}" for u, v in uv(vertices[:, :2])]
    lines += ["f " + " ".join(f"{v + 1}/{v + 1}" for v in t) for t in triangles]
    (folder / "plane.obj").write_text("\n".join(lines) + "\n")
    (folder / "t.mtl").write_text(f"newmtl m\nmap_Kd {image}\n")
    return folder / "plane.obj"


@pytest.mark.parametrize(
    ("name", "uv"),
    [
        ("plain", lambda p: p),
        ("mirrored", lambda p: [1, 0] + p * [-1, 1]),
        ("outside", lambda p: p + [3, -2]),
        ("turned", lambda p: p[:, ::-1]),
    ],
)
def test_a_plane_shows_the_image_at_its_uvs(tmp_path, name, uv):
    picture(tmp_path, "t.png", ramp())
    soup = engine.read_textured(write_plane_obj(tmp_path, uv))
    _, _, poly, made = result(soup, np.zeros(len(soup.triangles)), size=256)
    # The place of the plane at each pixel: from the corners' UVs, which are affine in a polygon.
    corners = poly.vertices[poly.loops][:, :2]
    affine, *_ = np.linalg.lstsq(np.c_[made.uv, np.ones(len(made.uv))], corners, rcond=None)
    points = corners.mean(0) + (np.random.default_rng(0).random((500, 2)) - 0.5) * 0.85
    at = np.linalg.solve(affine[:2].T, (points - affine[2]).T).T
    wanted = uv(points) % 1
    away = np.abs(wanted - 0.5).max(axis=1) < 0.45  # the ramp jumps where the image repeats
    shown = sample(made.image, at)[:, :3].astype(int)
    assert np.abs(shown[:, 0] - wanted[:, 0] * 254)[away].max() < 8, name
    assert np.abs(shown[:, 1] - wanted[:, 1] * 250)[away].max() < 12, name


def test_two_materials_keep_their_images(tmp_path):
    picture(tmp_path, "red one.png", np.full((8, 8, 3), [200, 10, 10], np.uint8))
    picture(tmp_path, "blue.png", np.full((16, 4, 3), [10, 10, 200], np.uint8))
    vertices, triangles = shapes.plane(4)
    left = vertices[triangles].mean(1)[:, 0] < 0.5
    lines = ["mtllib two.mtl", *(f"v {x} {y} {z}" for x, y, z in vertices), *(f"vt {x} {y}" for x, y, _ in vertices)]
    for name, chosen in (("red", left), ("blue", ~left)):
        lines += [f"usemtl {name}", *("f " + " ".join(f"{v + 1}/{v + 1}" for v in t) for t in triangles[chosen])]
    (tmp_path / "two.obj").write_text("\n".join(lines) + "\n")
    (tmp_path / "two.mtl").write_text("newmtl red\nmap_Kd -s 1 1 1 red one.png\n\nnewmtl blue\nmap_Kd .\\blue.png\n")
    soup = engine.read_textured(tmp_path / "two.obj")
    assert [image.shape for image in soup.images] == [(8, 8, 4), (16, 4, 4)]
    _, _, poly, made = result(soup, soup.material, size=64)
    for q, region in enumerate(poly.polygon_region):
        assert (inside(poly, made, q)[:, :3] == ([200, 10, 10], [10, 10, 200])[region]).all()


def test_sixteen_bit_and_grey_images_are_read(tmp_path):
    for name, pixels, wanted in (
        ("grey.png", np.full((4, 4), 77, np.uint8), 77),
        ("deep.png", np.full((4, 4), 77 * 257, np.uint16), 77),
    ):
        picture(tmp_path, name, pixels)
        soup = engine.read_textured(write_plane_obj(tmp_path, lambda p: p, name))
        _, _, poly, made = result(soup, np.zeros(len(soup.triangles)), size=32)
        assert (inside(poly, made, 0)[:, :3] == wanted).all()


@pytest.mark.parametrize("what", ["image", "library", "material"])
def test_missing_files_are_named(tmp_path, what):
    path = write_plane_obj(tmp_path, lambda p: p)
    name = "t.png"
    if what == "library":
        (tmp_path / "t.mtl").unlink()
        name = "t.mtl"
    elif what == "material":
        (tmp_path / "t.mtl").write_text("newmtl other\n")
        name = "'m'"
    with pytest.raises(engine.FileError, match=name):
        engine.read_textured(path)


def test_a_file_that_is_no_image_is_named(tmp_path):
    (tmp_path / "t.png").write_bytes(b"no image")
    with pytest.raises(engine.FileError, match=r"t\.png: is not an image"):
        engine.read_textured(write_plane_obj(tmp_path, lambda p: p))


def test_a_scan_without_a_texture_is_refused(cube):
    vertices, triangles = shapes.cube(2)
    with pytest.raises(engine.InvalidInput, match="neither an image nor colours"):
        result(engine.TexturedSoup(vertices, triangles), np.zeros(len(triangles)))


@pytest.mark.parametrize(("binary", "order"), [(True, "<"), (True, ">"), (False, "<")])
@pytest.mark.parametrize("by_face", [False, True])
def test_ply_with_texture_coordinates(tmp_path, binary, order, by_face):
    vertices, triangles = shapes.plane(3)
    picture(tmp_path, "a.png", ramp())
    x, y, z = vertices.T.astype(np.float32)
    vertex = {"x": x, "y": y, "z": z}
    uv = (vertices[:, :2] * [0.5, 0.25]).astype(np.float32)
    if by_face:
        faces = [(t, uv[t].ravel()) for t in triangles]
    else:
        vertex |= {"texture_u": uv[:, 0], "texture_v": uv[:, 1]}
        faces = [(t,) for t in triangles]
    meshfiles.ply_columns(tmp_path / "s.ply", vertex, faces, ["a.png"], binary, order)
    soup = engine.read_textured(tmp_path / "s.ply")
    assert np.allclose(soup.uv, uv[soup.triangles])
    assert (soup.material == 0).all()
    assert soup.images[0].shape == (32, 64, 4)


def test_ply_of_quads_with_texcoords_of_each_corner(tmp_path):
    vertices = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0]], np.float32)
    uv = vertices[:, :2] / 2
    picture(tmp_path, "a.png", ramp())
    x, y, z = vertices.T
    faces = [([0, 1, 2, 3], uv[[0, 1, 2, 3]].ravel()), ([1, 4, 2], uv[[1, 4, 2]].ravel())]
    meshfiles.ply_columns(tmp_path / "s.ply", {"x": x, "y": y, "z": z}, faces, ["a.png"])
    soup = engine.read_textured(tmp_path / "s.ply")
    assert len(soup.triangles) == 3
    assert np.allclose(soup.uv, uv[soup.triangles])


def test_colours_of_vertices_become_a_texture(tmp_path):
    vertices, triangles, side = painted_cube()
    soup = engine.TexturedSoup(*shapes.cube(4), colors=SIX[side])
    assert soup.colors.shape == (len(triangles), 3, 4)
    _, _, poly, made = result(soup, side, size=96)
    for q, region in enumerate(poly.polygon_region):
        assert (inside(poly, made, q, 0.98)[:, :3] == SIX[region]).all()
    x, y, z = vertices.T.astype(np.float32)
    red, green, blue = (vertices.T * 200).astype(np.uint8)
    vertex = {"x": x, "y": y, "z": z, "red": red, "green": green, "blue": blue}
    meshfiles.ply_columns(tmp_path / "c.ply", vertex, [(t,) for t in triangles])
    soup = engine.read_textured(tmp_path / "c.ply")
    assert np.array_equal(soup.colors[:, :, :3], np.stack([red, green, blue], axis=1)[soup.triangles])


def test_repairs_keep_the_texture():
    """Reversed faces, a doubled one, a hole that is filled: each side keeps its colour."""
    vertices, triangles, side = painted_cube(6)
    triangles = triangles.copy()
    triangles[::7] = triangles[::7, ::-1]
    hole = 80  # inside a side
    kept = np.delete(np.arange(len(triangles)), hole)
    soup = engine.TexturedSoup(vertices, triangles[kept], colors=SIX[side[kept]])
    mesh = engine.clean(soup.vertices, soup.triangles, engine.CleanOptions(fill_holes=2))
    assert mesh.report["filled_holes"] == 1
    regions = np.where(mesh.source_face < 0, side[hole], side[kept][np.maximum(mesh.source_face, 0)])
    part = engine.partition_from(mesh, regions.astype(np.int32))
    poly = engine.polygonize(mesh, part)
    made = engine.texture(mesh, part, poly, soup, engine.TextureOptions(size=128))
    for q, region in enumerate(poly.polygon_region):
        face = np.flatnonzero(part.face_region == region)[0]
        assert (inside(poly, made, q, 0.98)[:, :3] == SIX[regions[face]]).all()
    assert made.report["unknown"] == 0


def test_map_coordinates_change_nothing():
    vertices, triangles = shapes.bumpy(16)
    uv = vertices[:, :2]
    soups = [
        engine.TexturedSoup(vertices + shift, triangles, uv=uv, images=[ramp()])
        for shift in ([0, 0, 0], [2.0**19, -(2.0**21), 2.0**10])
    ]
    images = []
    for soup in soups:
        mesh = engine.clean(soup.vertices, soup.triangles)
        part = engine.partition(mesh, engine.PartitionOptions(proxies=12))
        poly = engine.polygonize(mesh, part)
        images.append(engine.texture(mesh, part, poly, soup, engine.TextureOptions(size=128)).image.astype(int))
    assert (np.abs(images[0] - images[1]).max(axis=2) > 6).mean() < 0.01


def test_the_source_must_be_the_meshs():
    vertices, triangles = shapes.cube(3)
    mesh = engine.clean(*shapes.bumpy(20))
    part = engine.partition(mesh, engine.PartitionOptions(proxies=6))
    poly = engine.polygonize(mesh, part)
    soup = engine.TexturedSoup(vertices, triangles, colors=np.zeros((len(vertices), 3), np.uint8))
    with pytest.raises(engine.InvalidInput, match="source"):
        engine.texture(mesh, part, poly, soup)


def test_normals_of_a_flat_side_point_up_and_those_of_a_slope_lean():
    vertices, triangles = shapes.plane(8)
    bent = vertices + np.outer(np.abs(vertices[:, 0] - 0.5) * 0.2, [0, 0, 1])
    for points, lean in ((vertices, 0.0), (bent, 0.19)):
        soup = engine.TexturedSoup(points, triangles, colors=np.full((len(points), 3), 99, np.uint8))
        _, _, poly, made = result(soup, np.zeros(len(triangles)), size=64)
        corners = poly.loops[np.abs(poly.vertices[poly.loops][:, 0] - 0.5) > 0.4]
        uv = made.uv.mean(0)
        chosen = made.uv[np.isin(poly.loops, corners)]
        normals = sample(made.normal, uv + (chosen - uv) * 0.5)[:, :3] / 127.5 - 1
        assert np.allclose(np.hypot(normals[:, 0], normals[:, 1]), lean, atol=0.05)
        assert (normals[:, 2] > 0.9).all()


@pytest.fixture
def made_plane(tmp_path):
    picture(tmp_path, "t.png", np.dstack([ramp(), ramp()[:, :, 0]]))
    soup = engine.read_textured(write_plane_obj(tmp_path, lambda p: p))
    middle = soup.vertices[soup.triangles].mean(1)
    _, _, poly, made = result(soup, (middle[:, 0] > 0.5).astype(int), size=64)
    return tmp_path, poly, made


def test_obj_glb_and_gltf_are_read_back_the_same(made_plane):
    folder, poly, made = made_plane
    files = engine.write_textured(folder / "out.obj", poly, made)
    assert sorted(f.name for f in files) == ["out.mtl", "out.obj", "out.png", "out_normal.png"]
    _, loops, starts = engine.reading.read_polygons(folder / "out.obj")
    assert np.array_equal(loops, poly.loops)
    assert np.array_equal(starts, poly.loop_start)
    assert engine.write_textured(folder / "out.glb", poly, made) == [folder / "out.glb"]
    files = engine.write_textured(folder / "o t.gltf", poly, made)
    assert [f.name for f in files] == ["o t.gltf", "o t.png", "o t_normal.png"]
    for name in ("out.obj", "out.glb", "o t.gltf"):
        soup = engine.read_textured(folder / name)
        assert np.array_equal(soup.images[0], made.image)
        corners = np.concatenate([poly.vertices[poly.loops], made.uv], axis=1)
        back = np.concatenate([soup.vertices[soup.triangles], soup.uv], axis=2).reshape(-1, 5)
        distance = np.abs(back[:, None] - corners[None]).max(axis=2).min(axis=1)
        assert distance.max() < 1e-6


def test_a_glb_file_that_is_too_large_is_refused_in_words(made_plane, monkeypatch):
    folder, poly, made = made_plane
    writers = (lambda path: engine.write_textured(path, poly, made), lambda path: engine.write(path, poly))
    for name, write in zip(("one.glb", "two.glb"), writers, strict=True):
        monkeypatch.undo()
        write(folder / name)
        size = (folder / name).stat().st_size
        monkeypatch.setattr(glb, "_LARGEST", size)
        write(folder / name)
        (folder / name).unlink()
        monkeypatch.setattr(glb, "_LARGEST", size - 1)
        with pytest.raises(engine.FileError, match=rf"/{name}: is larger than 4 GiB, .* choose \.gltf"):
            write(folder / name)
        assert not (folder / name).exists()


def test_gltf_that_can_not_be_written_leaves_nothing(made_plane, monkeypatch):
    folder, poly, made = made_plane
    before = sorted(path.name for path in folder.iterdir())
    write = Path.write_bytes

    def full(path, data):
        if path.name.endswith(".png") and "normal" in path.name:
            raise OSError(28, "full")
        return write(path, data)

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(engine.FileError, match=r"out\.gltf: can't be written: full"):
        engine.write_textured(folder / "out.gltf", poly, made)
    assert sorted(path.name for path in folder.iterdir()) == before


@pytest.mark.parametrize("name", ["out.glb", "out.gltf"])
def test_gltf_is_read_by_another_library(made_plane, name):
    trimesh = pytest.importorskip("trimesh")
    folder, poly, made = made_plane
    engine.write_textured(folder / name, poly, made)
    (mesh,) = trimesh.load(folder / name).geometry.values()
    assert len(mesh.vertices) == len(poly.loops)
    assert np.allclose(mesh.visual.uv, made.uv, atol=1e-6)
    assert np.array_equal(np.asarray(mesh.visual.material.baseColorTexture.convert("RGBA")), made.image)
    normals = np.repeat(made.polygon_normal, np.diff(np.append(poly.loop_start, len(poly.loops))), axis=0)
    assert np.allclose(mesh.vertex_normals, normals, atol=1e-6)


def test_the_command_does_not_overwrite_the_scans_own_image(tmp_path):
    picture(tmp_path, "t.png", ramp())
    path = write_plane_obj(tmp_path, lambda p: p)
    before = (tmp_path / "t.png").read_bytes()
    ran = called("simplify", path, tmp_path / "t.obj", "--proxies", "1", "--texture")
    assert ran.returncode == 2
    assert "would be overwritten" in ran.stderr
    assert (tmp_path / "t.png").read_bytes() == before
    assert not (tmp_path / "t.obj").exists()
    assert called("simplify", path, tmp_path / "t.gltf", "--proxies", "1", "--texture").returncode == 2
    assert (tmp_path / "t.png").read_bytes() == before


def test_a_batch_keeps_textures(tmp_path):
    (tmp_path / "in").mkdir()
    write_cube_obj(tmp_path / "in")
    options = ["--proxies", "6", "--texture", "64", "--format", "glb", "--jobs", "1"]
    ran = called("batch", tmp_path / "in", tmp_path / "out", *options)
    assert ran.returncode == 0, ran.stderr
    soup = engine.read_textured(tmp_path / "out" / "cube.glb")
    assert soup.images[0].shape == (64, 64, 4)
