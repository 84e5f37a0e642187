"""Cycles as a peer of the texture: both bake the same UVs, in one process, with one thread.

    PYTHONPATH=build-dev/python python -m bench.peers.texture_peer -- SCAN PROXIES SIZE
        [--up z] [--views 8] [--site FOLDER ...]

Python has Blender as a module (bpy), or `blender -b --factory-startup --python bench/peers/texture_peer.py --` runs it.
Debian's Blender 3.4 baked black images where this was tried; bpy 4.5 does not.

Cycles bakes emission from the scan to the polygons with 4 samples, at extrusions of 0.5, 1 and 2 % of the diagonal.
Views are the same as in `quality/texture.py`; a close-up of each shows a quarter of the width, around the point of the
scan nearest to the eye. Seconds are processor time: of `engine.texture` without a normal map, and of Cycles' bake
operator. `--site` names folders with numpy and Pillow where Blender's Python lacks them.
"""

import argparse
import json
import sys
import time
from dataclasses import replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))  # Blender runs a file, not a module


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scan", type=Path)
    parser.add_argument("proxies", type=int)
    parser.add_argument("size", type=int)
    parser.add_argument("--up", choices="xyz", default="z")
    parser.add_argument("--views", type=int, default=8)
    parser.add_argument("--site", action="append", default=[])
    return parser.parse_args(sys.argv[sys.argv.index("--") + 1 :])


ASKED = arguments()
sys.path[:0] = ASKED.site

import bpy  # noqa: E402  (numpy and Pillow are found in the folders above)
import numpy as np  # noqa: E402

import isimp_engine as engine  # noqa: E402
from bench.quality import texture as bench  # noqa: E402


def add_object(name, points, loops, starts, uv):
    """An object of polygons with the UVs of their corners."""
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(points))
    mesh.vertices.foreach_set("co", points.astype(np.float32).ravel())
    mesh.loops.add(len(loops))
    mesh.loops.foreach_set("vertex_index", loops.astype(np.int32))
    mesh.polygons.add(len(starts))
    mesh.polygons.foreach_set("loop_start", starts.astype(np.int32))
    mesh.polygons.foreach_set("loop_total", np.diff(np.append(starts, len(loops))).astype(np.int32))
    mesh.update(calc_edges=True)
    mesh.uv_layers.new().data.foreach_set("uv", uv.astype(np.float32).ravel())
    made = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(made)
    return made


def add_image(name, pixels):
    height, width = pixels.shape[:2]
    image = bpy.data.images.new(name, width, height)
    image.colorspace_settings.name = "Non-Color"
    scale = np.float32(np.iinfo(pixels.dtype).max)
    image.pixels.foreach_set((pixels[::-1].astype(np.float32) / scale).ravel())
    return image


def add_material(obj, image):
    """Emits the image; its node is the target of the bake."""
    material = bpy.data.materials.new(image.name)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output, shader, node = (
        tree.nodes.new(kind) for kind in ("ShaderNodeOutputMaterial", "ShaderNodeEmission", "ShaderNodeTexImage")
    )
    node.image = image
    tree.links.new(node.outputs[0], shader.inputs[0])
    tree.links.new(shader.outputs[0], output.inputs[0])
    tree.nodes.active = node
    obj.data.materials.append(material)


def set_scene(soup, poly, uv, size):
    """The scan selected, the polygons active; returns the image that Cycles bakes to."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    centre = soup.vertices.mean(axis=0)  # float32 is coarse far from zero
    flat = soup.triangles.ravel()
    scan = add_object("scan", soup.vertices - centre, flat, np.arange(0, len(flat), 3), soup.uv.reshape(-1, 2))
    for i, image in enumerate(soup.images):
        add_material(scan, add_image(f"scan{i}", image))
    scan.data.polygons.foreach_set("material_index", soup.material.astype(np.int32))
    result = add_object("result", poly.vertices - centre, poly.loops, poly.loop_start, uv)
    target = add_image("result", np.zeros((size, size, 4), np.uint8))
    add_material(result, target)
    scan.select_set(True)
    result.select_set(True)
    bpy.context.view_layer.objects.active = result
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 4
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    return target


def cycles(target, extrusion, size):
    """(H, W, 4) uint8 that Cycles bakes, and its seconds."""
    start = time.process_time()
    bpy.ops.object.bake(
        type="EMIT",
        use_selected_to_active=True,
        cage_extrusion=extrusion,
        max_ray_distance=2 * extrusion,
        margin=4,
        margin_type="EXTEND",
        use_clear=True,
    )
    seconds = time.process_time() - start
    values = np.empty(4 * size * size, np.float32)
    target.pixels.foreach_get(values)
    return np.round(np.clip(values, 0, 1) * 255).astype(np.uint8).reshape(size, size, 4)[::-1], seconds


def near(points, camera, box):
    """A box of a quarter of the size around the point nearest to the eye."""
    inside = points[np.abs((points - box.mean(axis=0)) @ camera[0]) < 0.2 * np.linalg.norm(box[1] - box[0])]
    middle = inside[(inside @ camera[2]).argmax()]
    return middle + (box - box.mean(axis=0)) / 4


def judge(soup, poly, made, befores, cameras, boxes):
    """PSNR and SSIM of the views and of the close-ups, and the seams."""
    results, _ = bench.views_of_result(poly, made, cameras, boxes)
    found = [bench.likeness(before, after) for before, after in zip(befores, results, strict=True)]
    half = len(found) // 2
    (psnr, ssim), (near_psnr, near_ssim) = np.mean(found[:half], axis=0), np.mean(found[half:], axis=0)
    row = {"psnr": psnr, "ssim": ssim, "near_psnr": near_psnr, "near_ssim": near_ssim}
    return row | {"seam": bench.seam(poly, made)}


def tell(name, row):
    print(json.dumps({"by": name} | {key: round(float(value), 4) for key, value in row.items()}), flush=True)


def main():
    soup = engine.read_textured(ASKED.scan)
    mesh = engine.clean(soup.vertices, soup.triangles)
    part = engine.partition(mesh, engine.PartitionOptions(proxies=ASKED.proxies))
    poly = engine.polygonize(mesh, part)
    start = time.process_time()
    made = engine.texture(mesh, part, poly, soup, engine.TextureOptions(size=ASKED.size, threads=1, normals=False))
    seconds = time.process_time() - start
    used = soup.vertices[np.unique(soup.triangles)]
    box = np.stack([used.min(axis=0), used.max(axis=0)])
    cameras = list(bench.cameras(ASKED.views, "xyz".index(ASKED.up)))
    boxes = [box] * len(cameras) + [near(used, camera, box) for camera in cameras]
    cameras *= 2
    befores = bench.views_of_scan(soup, cameras, boxes)
    print(f"{ASKED.scan.name}: {len(soup.triangles):,} faces, {len(poly.loop_start):,} polygons, {ASKED.size} pixels")
    tell("isimp", judge(soup, poly, made, befores, cameras, boxes) | {"seconds": seconds})
    target = set_scene(soup, poly, made.uv, ASKED.size)
    diagonal = float(np.linalg.norm(box[1] - box[0]))
    for share in (0.005, 0.01, 0.02):
        image, seconds = cycles(target, share * diagonal, ASKED.size)
        row = judge(soup, poly, replace(made, image=image), befores, cameras, boxes)
        tell(f"cycles {share:.1%}", row | {"seconds": seconds})


main()
