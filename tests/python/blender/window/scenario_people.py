"""Three who use it: a designer, a game artist, an urban modeller, each from a scan to what they wanted."""

import bmesh
import bpy
import numpy as np
import scans
from scenario_main import make_scan, regions, same, scan
from scenario_steps import settings, settled
from scenario_tools import drag, place, steps, tool, view

import isimp
from isimp import recipe as rcp


def label():
    return scans.regions(scan())


def face_at(x, z):
    """The scan's face at a place of its front."""
    found, _, _, face = scan().ray_cast((1.5 * x, -9, 1.5 * z), (0, 1, 0))
    assert found
    return face


def press(hand, name, step):
    """What the button in the panel does, with the settings that it shows."""
    from isimp.blender import settings as properties

    group = properties.group(bpy.context, step)
    values = {name: getattr(group, name) for name in properties.names(step)}
    with bpy.context.temp_override(window=hand.window, area=hand.area, region=hand.region("WINDOW")):
        getattr(bpy.ops.isimp, name)("INVOKE_DEFAULT", True, **values)
    yield from hand.settle(120)


def polygon_flatness(mesh):
    points = scans.coordinates(mesh)
    corners = (points[list(polygon.vertices)] for polygon in mesh.polygons)
    return max(np.abs((c - c.mean(axis=0)) @ np.linalg.svd(c - c.mean(axis=0))[2][2]).max() for c in corners)


def designer(hand):
    """Two presses; before the second a merge, an island gone and a missed facet."""
    make_scan()
    yield 0.3
    yield from press(hand, "partition", rcp.Partition)
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
    yield from press(hand, "mesh", rcp.Mesh)
    made = bpy.context.object
    same("the scan is hidden", scan().hide_get(), True)
    count = len(made.data.polygons)
    yield from tool(hand, "builtin.select_box")
    yield from hand.into_view()
    yield from hand.key("TAB")
    yield 0.3
    bpy.context.tool_settings.mesh_select_mode = (False, False, True)
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


def artist(hand):
    """A preset, a number, more regions where it was painted, one locked; the rest anew."""
    make_scan()
    yield 0.3
    yield from view(hand)
    bpy.ops.isimp.preset(name="figure")
    settings().partition.count_by, settings().partition.proxies = "proxies", 60
    yield from press(hand, "partition", rcp.Partition)
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
    yield from press(hand, "partition", rcp.Partition)
    same("anew", regions(), 90)
    same("but what is locked", np.array_equal(np.flatnonzero(label() == label()[hands]), kept), True)
    yield from hand.shot("people-2-artist")
    yield from press(hand, "mesh", rcp.Mesh)
    target = hand.out / "people.glb"
    bpy.ops.export_scene.gltf(filepath=str(target), use_selection=True)
    assert target.stat().st_size > 1000
    target.unlink()


def modeller(hand):
    """A block of houses in metres, open below: a tolerance, facades as single polygons, what the report says."""
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
    yield from press(hand, "partition", rcp.Partition)
    same("five planes a house", regions(), 15)
    yield from press(hand, "mesh", rcp.Mesh)
    made = bpy.context.object
    same("facades are single polygons", len(made.data.polygons), 15)
    assert polygon_flatness(made.data) < 1e-4

    from isimp.blender import store, text

    lines = text.report_lines(store.numbers(scan()), "METRIC", 1.0)
    same("as the scan", [line for line, amiss in lines if "Open" in line and not amiss], ["Open, as the scan is"])
    yield from hand.shot("people-3-modeller")


def run(hand):
    isimp.register()
    yield 0.5
    yield from hand.open_tab()
    for person in (designer, artist, modeller):
        print(person.__name__, flush=True)
        for obj in list(bpy.data.objects):  # hidden ones too
            bpy.data.objects.remove(obj)
        yield 0.5
        yield from person(hand)
