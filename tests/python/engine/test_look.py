"""The look that a file describes: materials and images by name, and what can't be used or is not read."""

import gzip

import numpy as np
import pytest

import isimp_engine as engine

read_look = engine.texturing.reading.read_look
SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
UVS = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"


def obj(folder, mtl, faces="usemtl wood\nf 1/1 2/2 3/3 4/4\n"):
    (folder / "a.mtl").write_text(mtl)
    path = folder / "a.obj"
    path.write_text(f"mtllib a.mtl\n{SQUARE}{UVS}{faces}")
    return path


def test_materials_name_their_images_and_no_image_is_read(tmp_path):
    mtl = "newmtl stone\nKd 1 .5 0\nnewmtl wood\nKd .2 .4 .6\nmap_Kd wood.png\nPr .3\nnorm bumps.png\n"
    mtl += "map_Bump old.png\nd .5\n"
    faces = "f 1/1 2/2 3/3\nusemtl wood\nf 1/1 2/2 3/3 4/4\nusemtl stone\nf 1/1 3/3 4/4\nvn 0 0 1\nl 1 2\n"
    look = read_look(obj(tmp_path, mtl, faces))
    assert look.loop_start.tolist() == [0, 3, 7]
    assert look.uv[3:7].tolist() == [[0, 0], [1, 0], [1, 1], [0, 1]]
    assert look.material.tolist() == [-1, 0, 1]
    wood, stone = look.materials
    assert (wood.name, wood.color, stone.color) == ("wood", (0.2, 0.4, 0.6), (1, 0.5, 0))
    assert {layer: path.name for layer, (path, _) in wood.maps.items()} == {"color": "wood.png", "normal": "bumps.png"}
    assert wood.numbers["roughness"][0] == 0.3
    assert not stone.maps
    assert not look.faults
    assert look.skipped == ["vn", "l", "map_Bump", "d"]


@pytest.mark.parametrize(
    ("mtl", "fault"),
    [
        ("newmtl other\n", "uses the material 'wood'"),
        ("newmtl wood\nKd red\n", "line 2: expected three numbers after Kd"),
        ("newmtl wood\nmap_Kd http://x.org/wood.png\n", "is not a file of this machine"),
        ("newmtl wood\nmap_Kd ../../../wood.png\n", "is outside of"),
    ],
)
def test_what_can_not_be_used_is_told_and_the_polygons_are_read(tmp_path, mtl, fault):
    folder = tmp_path / "scans" / "a"
    folder.mkdir(parents=True)
    path = obj(folder, mtl)
    look = read_look(path)
    assert len(look.faults) == 1
    assert fault in look.faults[0]
    assert len(look.loops) == 4
    assert look.uv.any()
    with pytest.raises(engine.FileError, match=fault):
        engine.read_textured(path)


def test_a_missing_library_and_damaged_uvs_are_told_too(tmp_path):
    path = obj(tmp_path, "newmtl wood\n")
    (tmp_path / "a.mtl").unlink()
    assert "material file" in read_look(path).faults[0]
    path = obj(tmp_path, "newmtl wood\n", "f 1/9 2/2 3/3\n")
    look = read_look(path)
    assert "texture coordinate 9" in look.faults[0]
    assert look.uv is None
    path.write_text("f 1 2 3\n")
    with pytest.raises(engine.FileError, match="uses vertex 1, but there are 0"):
        read_look(path)


PLY = (
    "ply\nformat ascii 1.0\ncomment TextureFile a.jpg\nelement vertex 3\nproperty float x\nproperty float y\n"
    "property float z\nproperty float nx\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
    "property float s\nproperty float t\nproperty float u\nproperty float v\nproperty float quality\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0 1 255 0 0 0 0 .5 .5 9\n1 0 0 1 0 255 0 1 0 .5 .5 9\n0 1 0 1 0 0 255 0 1 .5 .5 9\n3 0 1 2\n"
)


@pytest.mark.parametrize("packed", [False, True])
def test_ply_has_colours_of_vertices_and_its_texture(tmp_path, packed):
    path = tmp_path / ("a.ply.gz" if packed else "a.ply")
    path.write_bytes(gzip.compress(PLY.encode()) if packed else PLY.encode())
    look = read_look(path)
    assert look.colors.tolist() == [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255]]
    assert not look.colors_of_faces
    assert look.uv.tolist() == [[0, 0], [1, 0], [0, 1]]
    (material,) = look.materials
    assert material.maps["color"][0] == tmp_path / "a.jpg", "next to the packed file"
    assert look.material.tolist() == [0]
    assert look.skipped == ["nx", "quality", "u", "v"]


def test_colours_of_faces_are_told_apart(tmp_path):
    head = PLY.replace("property uchar red\nproperty uchar green\nproperty uchar blue\n", "").split("0 0 0 1")[0]
    head = head.replace(
        "vertex_indices\n", "vertex_indices\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
    )
    (tmp_path / "a.ply").write_text(
        f"{head}0 0 0 1 0 0 .5 .5 9\n1 0 0 1 1 0 .5 .5 9\n0 1 0 1 0 1 .5 .5 9\n3 0 1 2 9 8 7\n"
    )
    look = read_look(tmp_path / "a.ply")
    assert look.colors_of_faces
    assert look.colors.tolist() == [[9, 8, 7, 255]]


def test_stl_and_off_have_polygons_alone(tmp_path):
    (tmp_path / "a.off").write_text("COFF\n3 1 0\n0 0 0 1 0 0\n1 0 0 1 0 0\n0 1 0 1 0 0\n3 0 1 2\n")
    look = read_look(tmp_path / "a.off")
    assert look.skipped == ["C"]
    assert np.array_equal(look.material, [-1])
    assert look.uv is None
