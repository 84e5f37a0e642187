"""`isimp colliders`: files of convex parts, names by program, and refusals."""

import re

import numpy as np
import pytest

import isimp_engine as engine
import meshfiles
import shapes
from bench.generators import hollow_solids
from commands import called, check_line, ran


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    path = tmp_path_factory.mktemp("colliders") / "table.ply"
    meshfiles.ply_binary(path, *hollow_solids.twin(hollow_solids.table()))
    return path


def names_of_obj(path):
    return [line[2:] for line in path.read_text().splitlines() if line.startswith("o ")]


@pytest.mark.parametrize(
    ("names", "first"),
    [("unreal", "UCX_desk_00"), ("unity", "desk_collider_00"), ("godot", "desk_00-convcol"), ("plain", "desk_00")],
)
def test_an_object_for_each_part_with_the_names_of_a_program(table, tmp_path, names, first):
    done = ran("colliders", table, tmp_path / "desk.obj", "--names", names)
    assert "5 convex parts, 60 triangles" in done.stdout
    found = names_of_obj(tmp_path / "desk.obj")
    assert (len(found), found[0]) == (5, first)
    vertices, faces = engine.read(tmp_path / "desk.obj")
    assert len(faces) == 60
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    assert (np.cross(a, b) * c).sum() / 6 == pytest.approx(hollow_solids.table().volume, rel=0.03)


def test_a_node_for_each_part(table, tmp_path):
    assert called("colliders", table, tmp_path / "desk.glb", "--quiet").returncode == 0
    document, _ = meshfiles.of_glb((tmp_path / "desk.glb").read_bytes())
    assert [node["name"] for node in document["nodes"]] == [f"desk_{i:02}" for i in range(5)]
    assert document["scenes"][0]["nodes"] == list(range(5))
    assert len(engine.read_textured(tmp_path / "desk.glb").triangles) == 60


def test_a_geom_for_each_part(table, tmp_path):
    assert called("colliders", table, tmp_path / "desk.xml", "--enclose", "--quiet").returncode == 0
    text = (tmp_path / "desk.xml").read_text()
    assert re.findall(r'<mesh name="(\w+)"', text) == [f"desk_{i:02}" for i in range(5)]
    assert re.findall(r'type="mesh" mesh="(\w+)"', text) == [f"desk_{i:02}" for i in range(5)]
    mujoco = pytest.importorskip("mujoco")
    assert mujoco.MjModel.from_xml_path(str(tmp_path / "desk.xml")).ngeom == 5


def test_a_prim_for_each_part(table, tmp_path):
    assert called("colliders", table, tmp_path / "7 desk.usda", "--names", "godot", "--quiet").returncode == 0
    text = (tmp_path / "7 desk.usda").read_text()
    assert re.findall(r'def (\w+) "(\w+)"', text)[:2] == [("Xform", "_7_desk"), ("Mesh", "_7_desk_00_convcol")]
    assert text.count("PhysicsCollisionAPI") == text.count("convexHull") == 5
    usd = pytest.importorskip("pxr.Usd")
    stage = usd.Stage.Open(str(tmp_path / "7 desk.usda"))
    points = [prim.GetAttribute("points").Get() for prim in stage.GetDefaultPrim().GetChildren()]
    assert [len(of_part) for of_part in points] == [8] * 5


def test_polygons_are_taken_as_they_are(tmp_path):
    solid = hollow_solids.Solid([((0, 0, 0), (2, 1, 1)), ((0, 1, 0), (1, 2, 1))], [])
    poly, _ = engine.merge_flat(engine.clean(*hollow_solids.surface(solid)))
    engine.write(tmp_path / "ell.obj", poly)
    assert called("colliders", tmp_path / "ell.obj", tmp_path / "parts.obj").returncode == 0
    vertices, _ = engine.read(tmp_path / "parts.obj")
    assert vertices.round(9).tolist() == vertices.round().tolist()


def test_limits_and_refusals(table, tmp_path):
    assert "1 convex part," in called("colliders", table, tmp_path / "a.obj", "--parts", 1).stdout
    assert "1 convex part," in called("colliders", table, tmp_path / "a.obj", "--tolerance", 1).stdout
    done = called("colliders", table, tmp_path / "a.fbx")
    check_line(done, 2, "OUTPUT must end in one of .obj, .glb, .xml, .usda")
    done = called("colliders", table, tmp_path / "a.obj", "--max-vertices", 3)
    check_line(done, 2, "--max-vertices must be at least 8, got 3")
    meshfiles.ply_binary(tmp_path / "open.ply", *shapes.plane(8))
    done = called("colliders", tmp_path / "open.ply", tmp_path / "b.obj")
    check_line(done, 3, "open.ply: the surface is open: it does not say whether (")
    assert not (tmp_path / "b.obj").exists()
    assert (
        "1 convex part, 12 triangles"
        in called("colliders", tmp_path / "open.ply", tmp_path / "b.obj", "--thickness", 0.1, "--enclose").stdout
    )
    assert "1 convex part," in called("colliders", tmp_path / "open.ply", tmp_path / "b.obj", "--thickness").stdout
