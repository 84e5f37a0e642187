"""The batch example: files in, files and a picture out."""

import csv
import json
import sys
from pathlib import Path

import bpy
import numpy as np
import pytest
import scans

sys.path.insert(0, str(Path(__file__).parents[3] / "examples"))
import batch

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")  # warnings of Blender's own importers


def export(kind, path, name="Scan"):
    """Writes a cube in some format, off centre so that axes differ."""
    scan = scans.cube(name=name, cells=5)
    scan.location = (3, 0, 0.5)
    bpy.context.view_layer.update()
    if kind == ".blend":
        bpy.ops.wm.save_as_mainfile(filepath=str(path))
    elif kind == ".glb":
        bpy.ops.export_scene.gltf(filepath=str(path), export_format="GLB", use_selection=True)
    elif kind == ".fbx":
        bpy.ops.export_scene.fbx(filepath=str(path), use_selection=True)
    elif kind == ".obj":
        bpy.ops.wm.obj_export(filepath=str(path), export_selected_objects=True, export_materials=False)
    else:
        write_text(kind, path, scans.world(scan), [tuple(face.vertices) for face in scan.data.polygons])


def write_text(kind, path, points, faces):
    lines = ["OFF", f"{len(points)} {len(faces)} 0"]
    if kind == ".ply":
        properties = [f"property float {axis}" for axis in "xyz"]
        lines = ["ply", "format ascii 1.0", f"element vertex {len(points)}", *properties]
        lines += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    if kind == ".stl":
        lines = ["solid scan"]
        for face in faces:
            corners = [f"vertex {' '.join(map(str, points[v]))}" for v in face]
            lines += ["facet normal 0 0 0", "outer loop", *corners, "endloop", "endfacet"]
        path.write_text("\n".join([*lines, "endsolid"]))
        return
    lines += [" ".join(map(str, point)) for point in points]
    lines += [" ".join(map(str, (len(face), *face))) for face in faces]
    path.write_text("\n".join(lines) + "\n")


def run(*arguments):
    return batch.main([str(argument) for argument in arguments])


@pytest.mark.parametrize("kind", [".blend", ".obj", ".ply", ".stl", ".off", ".glb", ".fbx"])
def test_every_format_can_be_read(kind, tmp_path):
    scan, out = tmp_path / f"cube{kind}", tmp_path / "out.blend"
    export(kind, scan)
    assert run(scan, out, "--proxies", 6) == 0
    bpy.ops.wm.open_mainfile(filepath=str(out))
    result = bpy.context.view_layer.objects.active
    assert len(result.data.polygons) == 6
    low, high = scans.world(result).min(axis=0), scans.world(result).max(axis=0)
    assert low == pytest.approx([2, -1, -0.5], abs=1e-3)
    assert high == pytest.approx([4, 1, 1.5], abs=1e-3)
    source = next(obj for obj in bpy.data.objects if "isimp_color" in obj.data.attributes)
    assert source.hide_get()
    assert np.unique(scans.regions(source)).tolist() == list(range(6))


def obj_points(path):
    return np.array([line.split()[1:4] for line in path.read_text().splitlines() if line.startswith("v ")], float)


def ply_points(path):
    """Return the points of a file without rotation, read by the engine of the add-on."""
    session = next(module for name, module in sys.modules.items() if name.split(".")[-2:] == ["isimp", "session"])
    return np.asarray(session.engine.read(str(path))[0])


def corners(points):
    return [*points.min(axis=0), *points.max(axis=0)]


@pytest.mark.parametrize("kind", [".obj", ".ply"])
def test_meshes_keep_the_axes_of_the_input(kind, tmp_path):
    scan = tmp_path / f"cube{kind}"
    export(kind, scan)
    assert run(scan, tmp_path / "out.obj", tmp_path / "out.ply", "--proxies", 6) == 0
    wanted = corners(obj_points(scan) if kind == ".obj" else ply_points(scan))
    assert corners(obj_points(tmp_path / "out.obj")) == pytest.approx(wanted, abs=1e-3)
    assert corners(ply_points(tmp_path / "out.ply")) == pytest.approx(wanted, abs=1e-3)
    faces = [line for line in (tmp_path / "out.obj").read_text().splitlines() if line.startswith("f ")]
    assert sorted(len(line.split()) - 1 for line in faces) == [4] * 6


UTM = np.array([5e5, 4.6e6, 100.0])


def test_map_coordinates_come_out_where_they_were(tmp_path, capfd):
    """A cube of two metres, where float32 has steps of half a metre."""
    cube = scans.cube(cells=5)
    faces = [tuple(face.vertices) for face in cube.data.polygons]
    write_text(".off", tmp_path / "cube.off", scans.world(cube) + UTM, faces)
    outputs = [tmp_path / name for name in ("out.obj", "out.ply", "out.glb", "out.blend")]
    assert run(tmp_path / "cube.off", *outputs, "--proxies", 6) == 0
    assert "Blender's coordinates have steps" not in capfd.readouterr().out
    wanted = [*(UTM - 1), *(UTM + 1)]
    for path in outputs[:2]:
        points, triangles = batch.of_addon("isimp.session").engine.read(str(path))
        assert corners(points) == pytest.approx(wanted, abs=1e-6, rel=0)
        assert len(triangles) == 12
        a, b, c = (points[triangles[:, k]] - UTM for k in range(3))
        assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6 == pytest.approx(8, rel=1e-4)  # it is turned outwards
    assert sorted(len(line.split()) for line in outputs[0].read_text().splitlines() if line[0] == "f") == [5] * 6
    head = outputs[2].read_bytes()
    scene = json.loads(head[20 : 20 + int.from_bytes(head[12:16], "little")])
    (node,), (low,) = scene["nodes"], [each["min"] for each in scene["accessors"] if "min" in each]
    assert np.add(node["translation"], low) == pytest.approx([UTM[0] - 1, UTM[2] - 1, -UTM[1] - 1], abs=1e-5, rel=0)
    bpy.ops.wm.open_mainfile(filepath=str(outputs[3]))
    assert corners(scans.world(bpy.context.view_layer.objects.active)) == pytest.approx(wanted, abs=1e-5, rel=0)


@pytest.mark.parametrize("mirrored", [False, True])
def test_what_blender_holds_far_from_zero_keeps_its_axes_and_sides(mirrored, tmp_path):
    scan = scans.cube(cells=4)
    points = 32 * scans.coordinates(scan.data) + (2.0**20, 0, 0)
    scan.data.vertices.foreach_set("co", points.astype(np.float32).ravel())
    scan.scale.x = -1 if mirrored else 1
    scan.location.z = 8
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "cube.blend"))
    assert run(tmp_path / "cube.blend", tmp_path / "out.obj", "--proxies", 6) == 0
    x = -(2.0**20) if mirrored else 2.0**20
    points, triangles = batch.of_addon("isimp.session").engine.read(str(tmp_path / "out.obj"))
    assert corners(points) == pytest.approx([x - 32, -24, -32, x + 32, 40, 32], abs=1e-4, rel=0)
    a, b, c = (points[triangles[:, k]] - points.mean(axis=0) for k in range(3))
    assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6 == pytest.approx(64**3, rel=1e-4)


def test_a_picture_shows_colours_and_lines_of_a_scan_far_away_too(tmp_path):
    scan, files = scans.cube(cells=5), [tmp_path / f"cube{kind}" for kind in (".off", ".blend", ".png")]
    write_text(".off", files[0], scans.world(scan) + UTM, [tuple(face.vertices) for face in scan.data.polygons])
    assert run(*files[:2], "--proxies", 6, "--picture", files[2]) == 0
    image = bpy.data.images.load(str(files[2]))
    pixels = np.array(image.pixels[:]).reshape(image.size[1], image.size[0], 4)[..., :3]
    assert min(image.size) > 400
    left, right = np.split(pixels, [image.size[0] // 2], axis=1)
    for part in (left, right):
        assert (part.min(axis=2) > 0.99).mean() > 0.2  # paper
        assert (part.max(axis=2) < 0.5).mean() > 0.001  # lines
    assert (np.ptp(left, axis=2) > 0.15).mean() > 0.1  # colours
    assert pixels[0].min() > 0.99
    assert pixels[:, -1].min() > 0.99  # nothing is cut off
    bpy.ops.wm.open_mainfile(filepath=str(files[1]))
    assert [scene.name for scene in bpy.data.scenes] == ["Scene"]


RECIPE = {"isimp_recipe": 1, "steps": [{"step": "partition", "proxies": 6}, {"step": "add_proxy", "face": 3}]}


def test_a_recipe_defines_the_steps(tmp_path):
    export(".ply", tmp_path / "cube.ply")
    (tmp_path / "r.json").write_text(json.dumps(RECIPE))
    assert run(tmp_path / "cube.ply", tmp_path / "out.blend", "--recipe", tmp_path / "r.json") == 0
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "out.blend"))
    assert len(bpy.context.view_layer.objects.active.data.polygons) == 7


def test_a_click_without_a_face_at_its_place_is_left_out(tmp_path, capfd):
    export(".ply", tmp_path / "cube.ply")
    places = {"size": 3.5, "count": 12, "faces": [3], "points": [[9, 9, 9]], "normals": [[0, 0, 1]], "widths": [0.5]}
    (tmp_path / "r.json").write_text(json.dumps(RECIPE | {"places": places}))
    assert run(tmp_path / "cube.ply", tmp_path / "out.blend", "--recipe", tmp_path / "r.json") == 0
    assert "1 step is off: this scan has no face at its place" in "".join(capfd.readouterr())
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "out.blend"))
    assert len(bpy.context.view_layer.objects.active.data.polygons) == 6


@pytest.mark.parametrize(
    ("change", "more", "message"),
    [
        ({"face": 99999}, [], "there is no face 99999"),
        ({"step": "magic"}, [], "'magic' is not a step"),
        ({}, ["--proxies", "9"], "leave out --proxies"),
        (None, [], "the recipe 'r.json' can't be read: No such file"),
        (b"[" * 200_000, [], "the recipe 'r.json' can't be used: not a recipe: its brackets are nested too deeply"),
        (b'{"isimp_recipe": "\xe9"}', [], "the recipe 'r.json' can't be read: it is not UTF-8 text"),
    ],
)
def test_a_recipe_that_cannot_be_done_writes_nothing(change, more, message, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    export(".ply", tmp_path / "cube.ply")
    if isinstance(change, bytes):
        (tmp_path / "r.json").write_bytes(change)
    elif change is not None:
        steps = [RECIPE["steps"][0], RECIPE["steps"][1] | change]
        (tmp_path / "r.json").write_text(json.dumps(RECIPE | {"steps": steps}))
    assert run("cube.ply", "out.obj", "--recipe", "r.json", *more) == 3
    said = capsys.readouterr().err
    assert message in said
    assert "Traceback" not in said
    assert not (tmp_path / "out.obj").exists()


@pytest.mark.parametrize("way", [("--tolerance", 0.5), ("--detail", 0.1)])
def test_a_tolerance_or_a_detail_finds_the_number(way, tmp_path):
    export(".ply", tmp_path / "cube.ply")
    assert run(tmp_path / "cube.ply", tmp_path / "out.obj", *way) == 0
    faces = [line for line in (tmp_path / "out.obj").read_text().splitlines() if line.startswith("f ")]
    assert len(faces) == 6


def test_two_settings_of_the_number_are_refused(tmp_path, capsys):
    export(".ply", tmp_path / "cube.ply")
    assert run(tmp_path / "cube.ply", tmp_path / "out.obj", "--proxies", 6, "--detail", 0.1) == 3
    assert "--proxies and --detail each set the number of" in capsys.readouterr().err


def test_a_table_has_a_row_for_each_scan_with_the_reason_of_a_failure(tmp_path):
    export(".ply", tmp_path / "cube.ply")
    (tmp_path / "points.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n")
    table, more = tmp_path / "made" / "table.csv", ("--proxies", 6, "--table")
    names = ("cube.ply", "points.obj", "none.ply", "cube.ply")
    assert [run(tmp_path / name, tmp_path / "out.obj", *more, table) for name in names] == [0, 3, 3, 0]
    with table.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [Path(row["scan"]).name for row in rows] == list(names)
    for row in (rows[0], rows[3]):
        came = [row[name] for name in ("faces", "regions", "polygons", "closed", "problem")]
        assert came == ["300", "6", "6", "yes", ""]
        assert float(row["worst flatness"]) < 1e-5
        assert float(row["seconds"]) >= 0
    assert "no mesh with faces" in rows[1]["problem"]
    assert "there is no file" in rows[2]["problem"]
    assert rows[1]["polygons"] == rows[2]["polygons"] == ""


@pytest.mark.parametrize("name", ["out.obj", "out.ply", "out.glb", "out.blend", "p.png"])
def test_what_cannot_be_written_is_said_in_one_line(name, tmp_path, capfd):
    """If a folder has the name, not even root can write a file."""
    export(".ply", tmp_path / "cube.ply")
    there = tmp_path / name
    there.mkdir()
    outputs = [tmp_path / "fine.obj", "--picture", there] if name == "p.png" else [there]
    capfd.readouterr()
    assert run(tmp_path / "cube.ply", *outputs, "--proxies", 6) == 3
    said = capfd.readouterr().err.strip().splitlines()
    assert said[-1].endswith(f"'{there}' can't be written: Is a directory")
    assert not any("Traceback" in line for line in said)


def test_an_error_of_a_writer_in_python_is_one_line():
    message = 'Error: Python: Traceback (most recent call last):\n  File "a.py", line 1, in b\nOSError: full\n'
    assert batch.said(message + "Location: a.py:3\n") == "OSError: full"
    assert batch.said("Error: one thing\n and another\n") == "one thing and another"


def test_a_file_of_several_objects_is_one_scan(tmp_path):
    export(".ply", tmp_path / "unused.ply", name="One")
    two = scans.cube(name="Two", cells=3)
    two.location.x = -5
    for obj in bpy.context.scene.objects:
        obj.select_set(True)
    bpy.ops.export_scene.gltf(filepath=str(tmp_path / "two.glb"), export_format="GLB", use_selection=True)
    assert run(tmp_path / "two.glb", tmp_path / "out.obj", "--proxies", 12) == 0
    points = obj_points(tmp_path / "out.obj")
    assert len(points) == 16
    assert corners(points)[::3] == pytest.approx([-6, 4], abs=1e-3)


def test_which_object_of_a_blend_is_said(tmp_path, capsys):
    scans.cube(name="One")
    scans.cube(name="Two", cells=2)
    bpy.context.view_layer.objects.active = None
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "two.blend"))
    assert run(tmp_path / "two.blend", tmp_path / "out.obj") == 3
    assert "--object NAME: One, Two" in capsys.readouterr().err
    assert run(tmp_path / "two.blend", tmp_path / "out.obj", "--object", "Two", "--proxies", 6) == 0
    assert run(tmp_path / "two.blend", tmp_path / "out.obj", "--object", "Three") == 3
    assert "there is no object 'Three'; there are: One, Two" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["none.ply", "out.obj"], "there is no file"),
        (["cube.ply", "out.obj", "--proxies", "0"], "--proxies must be at least 1, got 0"),
        (["cube.ply", "out.obj", "--proxies", "999999"], "At most 300 regions"),
        (["damaged.ply", "out.obj"], "damaged.ply"),
        (["points.obj", "out.obj"], "no mesh with faces"),
    ],
)
def test_what_cannot_be_used_is_said_in_one_line(arguments, message, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    export(".ply", tmp_path / "cube.ply")
    (tmp_path / "damaged.ply").write_bytes(b"ply\nformat ascii 1.0\nelement vertex 5\nproperty fl")
    (tmp_path / "points.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n")
    assert run(*arguments) == 3
    said = capsys.readouterr().err.strip().splitlines()
    assert message in said[-1]
    assert not any("Traceback" in line for line in said)
    assert not (tmp_path / "out.obj").exists()


@pytest.mark.parametrize(
    "arguments",
    [[], ["cube.ply"], ["cube.ply", "out.xyz"], ["cube.xyz", "out.obj"], ["cube.ply", "out.obj", "--method", "magic"]],
)
def test_wrong_usage_ends_with_2(arguments, capsys):
    with pytest.raises(SystemExit) as caught:
        run(*arguments)
    assert caught.value.code == 2
    assert "usage" in capsys.readouterr().err
