"""An imported scan is in the middle of the view, with its texture, from the file to the polygons."""

import bpy
import numpy as np
from scenario_main import same

import isimp

SIZE, AT, HALF = 24, np.array([4.0, 3.0, -2.0]), 1.5


def write_box(folder):
    """A box beside the origin, with Y up and an image of two colours, as OBJ."""
    image = bpy.data.images.new("made", 16, 16)
    colours = np.tile(np.array([[0.8, 0.1, 0.1, 1.0]], np.float32), (256, 1))
    colours[128:] = (0.1, 0.6, 0.3, 1.0)
    image.pixels.foreach_set(colours.ravel())
    image.filepath_raw, image.file_format = str(folder / "box.png"), "PNG"
    image.save()
    bpy.data.images.remove(image)
    (folder / "box.mtl").write_text("newmtl paint\nmap_Kd box.png\n")
    lines, share, count = ["mtllib box.mtl", "usemtl paint"], np.linspace(-HALF, HALF, SIZE), 0
    for axis in range(3):
        for side in (-HALF, HALF):
            for u in share:
                for v in share:
                    point = np.roll((side, u, v) if side > 0 else (side, v, u), axis) + AT
                    lines += ["v {} {} {}".format(*point), f"vt {(u / HALF + 1) / 2} {(v / HALF + 1) / 2}"]
            for i in range(SIZE - 1):
                for j in range(SIZE - 1):
                    a = count + i * SIZE + j + 1
                    lines.append("f " + " ".join(f"{k}/{k}" for k in (a, a + SIZE, a + SIZE + 1, a + 1)))
            count += SIZE * SIZE
    (folder / "box.obj").write_text("\n".join(lines) + "\n")
    return folder / "box.obj"


def run(hand):
    isimp.register()
    path = write_box(hand.out)
    bpy.data.objects.remove(bpy.data.objects["Cube"])
    with bpy.context.temp_override(window=hand.window, area=hand.area, region=hand.region("WINDOW")):
        bpy.ops.isimp.import_scan("EXEC_DEFAULT", True, filepath=str(path))
    yield 1.0
    yield from hand.shot("imports-framed")
    view = hand.area.spaces.active.region_3d
    middle = np.array([AT[0], -AT[2], AT[1]])  # turned: Z is up
    same("in the middle", np.abs(np.array(view.view_location) - middle).max() < 0.1, True)
    same("as large as the view", 3 * HALF < view.view_distance < 6 * HALF, True)
    yield from hand.open_tab()
    yield from hand.press("isimp.partition")
    yield from hand.press("isimp.mesh")
    with bpy.context.temp_override(window=hand.window, area=hand.area, region=hand.region("UI")):
        same("section Texture", bpy.types.ISIMP_PT_texture.poll(bpy.context), True)
    hand.area.spaces.active.shading.color_type = "TEXTURE"
    yield from hand.shot("imports")
    result = bpy.context.object
    same("polygons", len(result.data.polygons), 6)
    shader = next(node for node in result.data.materials[0].node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    image = shader.inputs["Base Color"].links[0].from_node.image
    values = np.empty(4 * image.size[0] * image.size[1], np.float32)
    image.pixels.foreach_get(values)
    greens = values.reshape(-1, 4)[:, 1] > 0.4
    same("two colours", 0.2 < greens.mean() < 0.8, True)
