"""Four users: a designer, a game artist, an urban modeller, a pipeline engineer, from scans to their results.

Partition, Mesh and all other buttons of the panel are pressed there.
"""

import csv
import os
import re
import shutil
import subprocess
from pathlib import Path

import bmesh
import bpy
import numpy as np
import scans
from scenario_main import make_scan, regions, same, scan
from scenario_steps import settings, settled
from scenario_tools import drag, place, steps, tool, view

import isimp

BATCH = Path(__file__).parents[4] / "examples" / "batch.py"
#: The command of the manual; the text before --python makes it find the engine of these tests.
OVERNIGHT = """
for scan in *.off; do
  blender -b --factory-startup --python-expr "import sys; sys.path[:0] = {folders}" --python "$1" -- \\
    "$scan" "${{scan%.off}}.obj" --recipe recipe.json --table results.csv || echo "$scan" >> failed.txt
done
""".format(folders=[folder for folder in os.environ.get("ISIMP_SITE", "").split(os.pathsep) if folder])


def label():
    return scans.regions(scan())


def face_at(x, z):
    """The scan's face at a place of its front."""
    found, _, _, face = scan().ray_cast((1.5 * x, -9, 1.5 * z), (0, 1, 0))
    assert found
    return face


def press(hand, name):
    """Presses the button in the panel, and waits until it is done."""
    hand.region("UI").tag_redraw()  # settings that were not typed may have moved the rows below them
    yield 0.3
    yield from hand.press(f"isimp.{name}")
    yield from hand.settle(120)


def polygon_flatness(mesh):
    points = scans.coordinates(mesh)
    corners = (points[list(polygon.vertices)] for polygon in mesh.polygons)
    return max(np.abs((c - c.mean(axis=0)) @ np.linalg.svd(c - c.mean(axis=0))[2][2]).max() for c in corners)


def designer(hand):
    """Two presses; before the second a merge, a removed island and a missed facet."""
    make_scan()
    yield 0.3
    yield from press(hand, "partition")
    same("the number is found", (settings().partition.count_by, regions() > 6), ("detail", True))
    yield from view(hand)
    yield from tool(hand, "isimp.region_tool.object")
    before = regions()
    yield from drag(hand, (0.0, 0.0), (0.0, 0.97))
    same("merged", regions(), before - 1)
    yield from hand.undo()
    yield from hand.click(*place(hand, -0.5, 0.9), ctrl=True)
    yield from hand.settle()
    same("gone", regions(), before - 1)
    yield from hand.click(*place(hand, -0.3, 0.3))
    yield from hand.settle()
    same("and one more", regions(), before)
    yield from hand.shot("people-1-designer")
    yield from press(hand, "mesh")
    made = bpy.context.object
    same("the scan is hidden", scan().hide_get(), True)
    count = len(made.data.polygons)
    yield from tool(hand, "builtin.select_box")
    yield from hand.into_view()
    yield from hand.key("TAB")
    yield 0.3
    bpy.context.scene.tool_settings.mesh_select_mode = (False, False, True)
    edit = bmesh.from_edit_mesh(made.data)
    front = min(edit.faces, key=lambda face: face.normal.y)
    corners = len(front.verts)
    for face in edit.faces:
        face.select_set(False)
    front.select_set(True)
    bmesh.update_edit_mesh(made.data)
    yield from hand.into_view()
    yield from hand.key("E")
    yield from hand.move(hand.at[0] + 20, hand.at[1] + 60)
    yield from hand.key("RET")
    yield 0.3
    yield from hand.key("TAB")
    yield 0.3
    same("one polygon extruded", len(made.data.polygons), count + corners)
    yield from hand.shot("people-1-extruded")
    yield from bevelled(hand, made)


def bevelled(hand, made):
    """All edges of the result bevelled by hand; Mesh pressed again does not change it, and makes another one."""
    before = len(made.data.polygons)
    yield from hand.into_view()
    yield from hand.key("TAB")
    with bpy.context.temp_override(window=hand.window, area=hand.area, region=hand.region("WINDOW")):
        bpy.ops.mesh.select_all("EXEC_DEFAULT", True, action="SELECT")
        bpy.ops.mesh.bevel("EXEC_DEFAULT", True, offset=0.02)
    yield 0.3
    yield from hand.key("TAB")
    yield 0.3
    count, places = len(made.data.polygons), scans.coordinates(made.data)
    assert count > before, (count, before)
    yield from press(hand, "mesh")
    same("kept as it is", np.array_equal(scans.coordinates(made.data), places), True)
    other = bpy.context.object
    same("another one", (other.name, len(made.data.polygons)), ("Scan.simplified.001", count))
    same("as polygons were before the edits", len(other.data.polygons), regions())
    same("shown in its place", (made.hide_get(), other.hide_get()), (True, False))
    yield from hand.shot("people-1-bevelled")
    yield from hand.undo()
    made = bpy.data.objects["Scan.simplified"]
    same("undone", ("Scan.simplified.001" in bpy.data.objects, len(made.data.polygons)), (False, count))
    same("and shown", made.visible_get(), True)


def artist(hand):
    """A preset, a number, more regions where it was painted, one locked; the rest again."""
    make_scan()
    yield 0.3
    yield from view(hand)
    bpy.ops.isimp.preset(name="figure")
    settings().partition.count_by, settings().partition.proxies = "proxies", 60
    yield from press(hand, "partition")
    same("as many as asked", regions(), 60)
    obj = scan()
    upper = np.array([polygon.center.z > 0.4 for polygon in obj.data.polygons])
    before = len(set(label()[upper]))
    group = obj.vertex_groups.new(name="Face")
    group.add([v.index for v in obj.data.vertices if v.co.z > 0.4], 1.0, "REPLACE")
    settings().partition.weights = "Face"
    yield from settled()
    same("painted", (regions(), len(set(label()[upper])) > before), (60, True))
    yield from hand.undo()
    same("not painted", (len(set(label()[upper])), settings().partition.weights), (before, ""))
    yield from hand.redo()
    yield from tool(hand, "isimp.region_tool.object")
    hands = face_at(0.0, -0.2)
    yield from hand.move(*place(hand, 0.0, -0.2))
    yield from hand.key("L")
    yield from hand.settle()
    same("locked", type(steps()[-1]).__name__, "LockRegions")
    kept = np.flatnonzero(label() == label()[hands])
    settings().partition.proxies = 90
    yield from press(hand, "partition")
    same("anew", regions(), 90)
    same("but what is locked", np.array_equal(np.flatnonzero(label() == label()[hands]), kept), True)
    yield from hand.shot("people-2-artist")
    yield from press(hand, "mesh")
    target = hand.out / "people.glb"
    bpy.ops.export_scene.gltf(filepath=str(target), use_selection=True)
    assert target.stat().st_size > 1000
    target.unlink()


def modeller(hand):
    """A block of houses in metres, open below: a tolerance, facades as single polygons, the text of the report."""
    points, faces = [], []
    for number, height in enumerate((9, 14, 7)):
        bpy.ops.mesh.primitive_cube_add(size=1)
        cube = bpy.context.object
        edit = bmesh.new()
        edit.from_mesh(cube.data)
        bmesh.ops.delete(edit, geom=[face for face in edit.faces if face.normal.z < -0.5], context="FACES")
        bmesh.ops.subdivide_edges(edit, edges=edit.edges, cuts=12, use_grid_fill=True)
        bmesh.ops.triangulate(edit, faces=edit.faces)
        edit.verts.index_update()
        base = len(points)
        points += [(v.co.x * 10 + 14 * number, v.co.y * 8, (v.co.z + 0.5) * height) for v in edit.verts]
        faces += [[base + v.index for v in face.verts] for face in edit.faces]
        edit.free()
        bpy.data.objects.remove(cube)
    scans.add("Scan", points, faces)
    bpy.ops.ed.undo_push(message="scan")
    yield 0.3
    with bpy.context.temp_override(window=hand.window, area=hand.area, region=hand.region("WINDOW")):
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_selected()
    bpy.ops.isimp.preset(name="building")
    settings().partition.count_by, settings().partition.tolerance = "tolerance", 0.2
    yield from press(hand, "partition")
    same("five planes a house", regions(), 15)
    yield from press(hand, "mesh")
    made = bpy.context.object
    same("facades are single polygons", len(made.data.polygons), 15)
    assert polygon_flatness(made.data) < 1e-4

    from isimp.blender.scene import store
    from isimp.blender.texts import text

    lines = text.report_lines(store.numbers(scan()), "METRIC", 1.0)
    same("as the scan", [line for line, amiss in lines if "Open" in line and not amiss], ["Open, like the scan"])
    yield from hand.shot("people-3-modeller")


def engineer(hand):
    """A recipe made once by hand and exported; then scan after scan overnight, and a table in the morning."""
    make_scan()
    yield 0.3
    yield from view(hand)
    settings().partition.count_by, settings().partition.proxies = "proxies", 14
    yield from press(hand, "partition")
    yield from tool(hand, "isimp.region_tool.object")
    yield from hand.click(*place(hand, 0.4, 0.4))
    yield from hand.settle()
    same("the recipe", [type(step).__name__ for step in steps()], ["Partition", "AddProxy"])
    folder = hand.out / "overnight"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    bpy.ops.isimp.recipe_export(filepath=str(folder / "recipe.json"))
    points, faces = scans.coordinates(scan().data), [tuple(face.vertices) for face in scan().data.polygons]
    for name, scale in (("a", 1.0), ("c", 0.5), ("e", 2.0)):
        write_off(folder / f"{name}.off", points * scale, faces)
    (folder / "b.off").write_text((folder / "a.off").read_text()[:-200] + "\n3 1 2 99999999\n")  # damaged
    write_off(folder / "d.off", points * (1.0, 2.0, 1.0), faces)  # no face is at the step's place, so it is off
    script = folder / "overnight.sh"
    script.write_text(OVERNIGHT)
    script.chmod(0o755)
    with (folder / "log.txt").open("w") as log:
        night = subprocess.Popen(["sh", str(script), str(BATCH)], cwd=folder, stdout=log, stderr=log)
    while night.poll() is None:
        yield 0.5
    with (folder / "results.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    same("a row each", [row["scan"] for row in rows], [f"{name}.off" for name in "abcde"])
    same("polygons", [int(row["polygons"] or 0) >= 14 for row in rows], [True, False, True, True, True])
    same("failed", (folder / "failed.txt").read_text().split(), ["b.off"])
    (damaged,) = (row["problem"] for row in rows if row["problem"])
    assert re.search(r"b\.off: line \d+: expected 3 vertices", damaged), damaged
    assert "1 step is off: this scan has no face at its place" in (folder / "log.txt").read_text()
    same("the others are there", sorted(path.stem for path in folder.glob("*.obj")), ["a", "c", "d", "e"])


def write_off(path, points, faces):
    lines = ["OFF", f"{len(points)} {len(faces)} 0"]
    lines += [" ".join(map(str, point)) for point in points]
    lines += [" ".join(map(str, (len(face), *face))) for face in faces]
    path.write_text("\n".join(lines) + "\n")


def run(hand):
    isimp.register()
    yield 0.5
    yield from hand.open_tab()
    for person in (designer, artist, modeller, engineer):
        print(person.__name__, flush=True)
        for obj in list(bpy.data.objects):  # hidden ones too
            bpy.data.objects.remove(obj)
        yield 0.5
        yield from person(hand)
