"""Whole jobs by the words of the manual: a game artist, a surveyor, a retopology artist. Counts actions and redraws.

The fourth, a student, installs the zip first: student.py. An action is done only if the manual has its words.
"""

import json

import bpy
import numpy as np
from scans import material_of
from scenario_main import make_scan, regions, same
from scenario_tools import place, sketched, tool
from student import Student, words

import isimp

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

    def begins(self):
        """A new file without the default cube; the caller imports the scan."""
        for obj in list(bpy.data.objects):
            bpy.data.objects.remove(obj)
        self.does("Delete the default cube.")
        yield 0.3

    def looks(self):
        self.does("click it, and press *Numpad .* in the 3D view")
        yield from self.hand.into_view()
        yield from self.hand.key("NUMPAD_PERIOD")
        yield 0.5
        self.does("Press N and choose the tab **iSimp**.")

    def ends(self, most):
        bpy.types.SpaceView3D.draw_handler_remove(self._counting, "WINDOW")
        print(f"{self.name}: {len(self.done)} actions, {self.redraws} redraws", flush=True)
        assert len(self.done) <= most, self.done


def artist(hand):
    """Three levels of detail with textures."""
    user = User(hand, "artist")
    yield from user.begins()
    user.does("Import a scan (File > Import)")
    make_scan()
    scan = bpy.context.object
    image = bpy.data.images.new("Paint", 64, 64)
    image.pixels.foreach_set(np.tile([0.8, 0.3, 0.1, 1.0], 64 * 64).astype(np.float32))
    image.pack()
    scan.data.materials.append(material_of("Scan", image))
    yield from user.looks()
    yield from user.presses("Partition")
    before = regions()
    yield from user.presses("Mesh")
    same("the texture is seen at once", hand.area.spaces.active.shading.color_type, "TEXTURE")
    yield from hand.shot("jobs-1-artist")
    for _ in range(2):
        user.does("**Keep as LOD** (keeps the result as `<scan>_LOD0`, `_LOD1` ..., and sets a third")
        with bpy.context.temp_override(window=hand.window, area=hand.area, region=hand.region("WINDOW")):
            bpy.ops.isimp.keep_lod("INVOKE_DEFAULT", True)
        yield 0.3
        yield from user.presses("Partition")
        yield from user.presses("Mesh")
    from isimp.blender.texturing import texture

    levels = [bpy.data.objects[name] for name in ("Scan_LOD0", "Scan_LOD1", "Scan.simplified")]
    counts = [len(level.data.polygons) for level in levels]
    same("a third each time", (counts[0] >= before, counts[1] < counts[0], counts[2] < counts[1]), (True, True, True))
    same("each has its texture", [texture.image_width(level) > 0 for level in levels], [True, True, True])
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
    user.does("**File > Import > Scan (iSimp)** reads PLY, OBJ, STL, OFF and 3MF")
    bpy.ops.isimp.import_scan(filepath=str(hand.out / "house.ply"), epsg=25832)
    yield from user.looks()
    user.does("**Statue**, **Building**, **Room**, **Machine Part**, **City**")
    bpy.ops.isimp.preset("EXEC_DEFAULT", True, name="building")
    yield 0.3
    yield from user.presses("Partition")
    yield from user.presses("Mesh")
    yield from hand.shot("jobs-2-surveyor")
    for name in ("house.ifc", "house.dxf", "house.city.json"):
        user.does("**File > Export > Building (.ifc, .dxf, .city.json)** writes the result")
        with bpy.context.temp_override(window=hand.window, area=hand.area, region=hand.region("WINDOW")):
            bpy.ops.isimp.export_building("EXEC_DEFAULT", filepath=str(hand.out / name), epsg=25832)
        assert (hand.out / name).stat().st_size > 500, name
        print(f"written: {name}", flush=True)
        yield 0.1
    city = json.loads((hand.out / "house.city.json").read_text())
    at = np.array(city["vertices"]) * city["transform"]["scale"] + city["transform"]["translate"]
    same("in map coordinates", np.abs(at.min(axis=0) - PLACE).max() < 0.01, True)
    same("as large as the house", np.abs(np.ptp(at, axis=0) - (10, 8, 8)).max() < 0.01, True)
    same("EPSG", "25832" in city["metadata"]["referenceSystem"], True)
    user.ends(12)


def retopologist(hand):
    """A click a region, which is there after one redraw, and its lines after two."""
    user = User(hand, "retopology artist")
    yield from user.begins()
    user.does("Import a scan (File > Import)")
    make_scan()
    yield from user.looks()
    yield from user.presses("Partition")
    with bpy.context.temp_override(window=hand.window, area=hand.area, region=hand.region("WINDOW")):
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
    user.ends(8)


def run(hand):
    isimp.register()
    yield 0.5
    yield from hand.open_tab()
    for person in (artist, surveyor, retopologist):
        yield from person(hand)
