"""Whole jobs by the words of the manual: artist, surveyor, retopologist, decorator. Counts actions and redraws.

The fourth, a student, installs the zip first: student.py. An action is done only if the manual has its words.
"""

import json

import bmesh
import bpy
import numpy as np
import scans
from actions import make_scan, place, regions, same, sketched, tool
from scans import material_of
from student import Student, words

import isimp
from isimp.blender.controls import settings
from isimp.blender.texturing import texture
from isimp.recipe import presets

PLACE = np.array([412_345.0, 5_765_432.0, 61.0])  # place of the surveyor's house, in metres of UTM


class User(Student):
    """A person who reads the manual only."""

    def __init__(self, hand, name):
        super().__init__()
        self.read = words("manual.md")
        self.hand, self.name, self.redraws = hand, name, 0
        add = bpy.types.SpaceView3D.draw_handler_add
        self._counting = add(self._drawn, (), "WINDOW", "POST_PIXEL")

    def _drawn(self):
        self.redraws += 1

    def presses(self, name):
        self.does(f"Press **{name}**.")
        self.hand.region("UI").tag_redraw()
        yield 0.3
        yield from self.hand.press(self.button(name))
        yield from self.hand.settle(120)

    def imports(self):
        """Has the caller's scan imported: three menus, a folder and a file; the import opens the sidebar and frames."""
        self.does("Import a scan (File > Import)", 5)
        yield from self.hand.into_view()
        yield from self.hand.key("NUMPAD_PERIOD")
        yield 0.5
        self.does("choose the tab **iSimp**")

    def chooses(self, kind):
        """Clicks the icon of a kind of scan."""
        kinds = [preset.name for preset in presets.PRESETS if preset.is_kind]
        self.does(f"**{presets.BY_NAME[kind].label}**")
        side = self.hand.region("UI")
        yield from self.hand.find("bpy.ops.isimp.preset")
        share = (kinds.index(kind) + 0.5) / len(kinds)
        yield from self.hand.click(side.x + 10 + (side.width - 40) * share, self.hand.at[1])
        yield 0.3
        same("kind", bpy.context.window_manager.isimp.kind, kind)

    def begins(self):
        """An empty file; the caller imports the scan. The default cube may stay, since the import is active."""
        for obj in list(bpy.data.objects):
            bpy.data.objects.remove(obj)
        settings.show(bpy.context, None)
        yield 0.3

    def ends(self, most):
        bpy.types.SpaceView3D.draw_handler_remove(self._counting, "WINDOW")
        print(f"{self.name}: {len(self.done)} actions, {self.redraws} redraws", flush=True)
        assert len(self.done) <= most, self.done


def artist(hand):
    """Three levels of detail with textures and colliders, as files."""
    user = User(hand, "artist")
    yield from user.begins()
    make_scan()
    yield from user.imports()
    scan = bpy.context.object
    image = bpy.data.images.new("Paint", 256, 256)
    image.pixels.foreach_set(np.tile([0.8, 0.3, 0.1, 1.0], 256 * 256).astype(np.float32))
    image.pack()
    scan.data.materials.append(material_of("Scan", image))
    yield from user.chooses("figure")
    yield from user.presses("Partition")
    user.does("**Make LODs**, under *LODs...*, makes levels of 300, 100 and 33 polygons", 2)
    with hand.within():
        bpy.ops.isimp.make_lods("INVOKE_DEFAULT", True)
    yield from hand.settle(120)
    yield from hand.shot("jobs-1-artist")
    same("the texture is seen at once", hand.area.spaces.active.shading.color_type, "TEXTURE")
    levels = [bpy.data.objects[f"Scan_LOD{number}"] for number in range(3)]
    counts = [len(level.data.polygons) for level in levels]
    same("coarser each time", counts == sorted(set(counts), reverse=True), True)
    same("half the image each time", [texture.image_width(level) for level in levels], [256, 128, 64])
    same("with a collider", levels[0].children[0].name, "UCX_Scan_LOD0_00")
    user.does("**File > Export > LODs (.glb, .obj, .ifc)** writes each level to a file of its own", 3)
    with hand.within():
        bpy.ops.isimp.export_lods("EXEC_DEFAULT", filepath=str(hand.out / "owl.glb"))
    sizes = [(hand.out / f"owl_LOD{number}.glb").stat().st_size for number in range(3)]
    same("smaller files each time", sizes == sorted(sizes, reverse=True), True)
    user.ends(16)


def furnished(name="Room"):
    """A room of 6 x 4 x 2.5 m with a table, a chest and a heap of boxes, as triangles of some decimetres."""
    edit = bmesh.new()
    boxes = [((3, 2, 1.25), (6, 4, 2.5)), ((3, 2, 0.7), (1.6, 0.8, 0.06)), ((5.6, 0.6, 0.5), (0.7, 1.1, 0.9))]
    boxes += [((1 + 0.3 * k, 3, 0.2 + 0.1 * k), (0.25, 0.3, 0.2)) for k in range(4)]
    for number, (middle, sides) in enumerate(boxes):
        made = bmesh.ops.create_cube(edit, size=1)["verts"]
        bmesh.ops.scale(edit, vec=sides, verts=made)
        bmesh.ops.translate(edit, vec=middle, verts=made)
        if number == 0:
            bmesh.ops.reverse_faces(edit, faces=edit.faces[:])
    bmesh.ops.subdivide_edges(edit, edges=edit.edges[:], cuts=7, use_grid_fill=True)
    bmesh.ops.triangulate(edit, faces=edit.faces[:])
    mesh = bpy.data.meshes.new(name)
    edit.to_mesh(mesh)
    edit.free()
    bpy.context.scene.collection.objects.link(bpy.data.objects.new(name, mesh))
    bpy.context.view_layer.objects.active = bpy.data.objects[name]


def decorator(hand):
    """A room without its furniture: polygons of walls, floor and ceiling alone."""
    user = User(hand, "decorator")
    yield from user.begins()
    furnished()
    yield from user.imports()
    yield from user.chooses("room")
    yield from user.presses("Mesh")
    before = len(bpy.context.object.data.polygons)
    user.does("**Leave Out Furniture...** shows in red what is neither wall, floor nor ceiling of a room")
    hand.region("UI").tag_redraw()
    yield 0.3
    yield from hand.press("isimp.show_furniture")
    yield from hand.shot("jobs-4-furniture")
    user.does("a click leaves the red out")
    yield from hand.into_view()
    yield from hand.click(*hand.at)
    yield from hand.settle()
    same("no other mode", bpy.context.mode, "OBJECT")
    yield from user.presses("Mesh")
    same("the room alone", (before > 20, len(bpy.context.object.data.polygons)), (True, 6))
    yield from hand.shot("jobs-4-decorator")
    user.ends(12)


def write_house(path):
    """A house of 10 x 8 m with a gable roof, open below, in map coordinates and double precision."""
    cells, points, faces = 12, [], []
    corners = {"a": (0, 0, 0), "b": (10, 0, 0), "c": (10, 8, 0), "d": (0, 8, 0)}
    corners |= {"e": (0, 0, 5), "f": (10, 0, 5), "g": (10, 8, 5), "h": (0, 8, 5), "i": (0, 4, 8), "j": (10, 4, 8)}
    for side in ("abfe", "bcgf", "cdhg", "daeh", "efji", "hijg", "hei", "fgj"):
        at = [np.array(corners[name], float) for name in side]
        quad = [at[0], at[1], at[2], at[3]] if len(at) == 4 else [at[0], at[1], at[2], at[2]]
        base, share = len(points), np.linspace(0, 1, cells + 1)
        sides = [((1 - u) * quad[0] + u * quad[1], (1 - u) * quad[3] + u * quad[2]) for u in share]
        points += [(1 - v) * low + v * high for low, high in sides for v in share]
        for i in range(cells):
            for j in range(cells):
                k = base + i * (cells + 1) + j
                faces += [(k, k + cells + 1, k + cells + 2), (k, k + cells + 2, k + 1)]
    unique, where = np.unique(np.round(points, 6), axis=0, return_inverse=True)
    triangles = where.ravel()[np.array(faces)]
    triangles = triangles[[len(set(triangle)) == 3 for triangle in triangles.tolist()]]
    lines = ["ply", "format ascii 1.0", f"element vertex {len(unique)}"]
    lines += [f"property double {axis}" for axis in "xyz"]
    lines += [f"element face {len(triangles)}", "property list uchar int vertex_indices", "end_header"]
    lines += [" ".join(f"{value:.3f}" for value in point) for point in unique + PLACE]
    lines += [" ".join(map(str, (3, *triangle))) for triangle in triangles.tolist()]
    path.write_text("\n".join(lines) + "\n")


def surveyor(hand):
    """From a PLY in map coordinates to files of a building in map coordinates."""
    user = User(hand, "surveyor")
    write_house(hand.out / "house.ply")
    yield from user.begins()
    with hand.within():
        bpy.ops.isimp.import_scan(filepath=str(hand.out / "house.ply"), epsg=25832)
    yield 0.5
    corners, view = scans.world(bpy.context.object), hand.area.spaces.active.region_3d
    low, high = corners.min(axis=0), corners.max(axis=0)
    same("in the middle of the view", np.abs(np.array(view.view_location) - (low + high) / 2).max() < 0.1, True)
    same("as large as the view", 0.85 < view.view_distance / np.linalg.norm(high - low) < 1.75, True)
    yield from user.imports()
    yield from user.chooses("building")
    yield from user.presses("Mesh")
    yield from hand.shot("jobs-2-surveyor")
    user.does("**File > Export > Building (.ifc, .dxf, .city.json)** writes the result", 3)
    for name in ("house.ifc", "house.dxf", "house.city.json"):
        with hand.within():
            bpy.ops.isimp.export_building("EXEC_DEFAULT", filepath=str(hand.out / name))
        assert (hand.out / name).stat().st_size > 500, name
        print(f"written: {name}", flush=True)
        yield 0.1
    city = json.loads((hand.out / "house.city.json").read_text())
    at = np.array(city["vertices"]) * city["transform"]["scale"] + city["transform"]["translate"]
    same("in map coordinates", np.abs(at.min(axis=0) - PLACE).max() < 0.01, True)
    same("as large as the house", np.abs(np.ptp(at, axis=0) - (10, 8, 8)).max() < 0.01, True)
    same("EPSG", "25832" in city["metadata"]["referenceSystem"], True)
    user.ends(11)


def retopologist(hand):
    """A click a region, which is there after one redraw, and its lines after two."""
    user = User(hand, "retopology artist")
    yield from user.begins()
    make_scan()
    yield from user.imports()
    yield from user.presses("Partition")
    with hand.within():
        bpy.ops.view3d.view_axis(type="FRONT")
    yield 0.5
    user.does("choose the **Region** tool at the left")
    yield from tool(hand, "isimp.region_tool.object")
    yield from sketched()
    yield from hand.move(*place(hand, -0.3, 0.3))
    yield 1
    user.does("**Click** to add a region.")
    before, user.redraws = regions(), 0
    yield from hand.click(*hand.at)
    yield from hand.settle()
    same("added", regions(), before + 1)
    yield from sketched()
    yield 0.5
    print(f"redraws of a click: {user.redraws}", flush=True)
    assert user.redraws <= 4, user.redraws  # two, and one each for the mouse before the press and after the release
    yield from hand.shot("jobs-3-retopology")
    user.ends(9)


def run(hand):
    isimp.register()
    yield 0.5
    yield from hand.open_tab()
    for person in (artist, surveyor, retopologist, decorator):
        yield from person(hand)
