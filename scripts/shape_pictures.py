"""Makes the pictures of docs/performance.md that compare polygons with and without the remedies for their shape.

    blender -b --python-use-system-env --python-exit-code 1 --python scripts/shape_pictures.py [-- NAME...]

`isimp_engine` must be on PYTHONPATH, the scans in $ISIMP_DATA or ../shared/data. NAME: parts of the names in PICTURES.
The pictures are written to docs/images.
"""

import os
import sys
from pathlib import Path

import bpy
import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "examples"))

import picture  # noqa: E402

import isimp_engine as engine  # noqa: E402

DATA = Path(os.environ.get("ISIMP_DATA", ROOT.parent / "shared" / "data"))
IMAGES = ROOT / "docs" / "images"
REGIONS = 300
PLAIN = {"smooth": 0.0}, {"join_junctions": 0.0}
NOTHING = {}, {}
# Scan, upward axis, degrees around it, options at the left and at the right: of the partition, of meshing.
PICTURES = {
    "shape-bunny": ("scan/bunny_69k.ply", "Y", 0, PLAIN, NOTHING),
    "shape-armadillo": ("scan/armadillo_86k.ply", "Y", 15, PLAIN, NOTHING),
    "shape-lion": ("nasty/lionstatue_63k_misoriented.ply", "Y", -60, PLAIN, NOTHING),
    "shape-castle": ("building/openmvs_castle_175k.ply", "Z", 45, PLAIN, NOTHING),
    "shape-dragon": ("scan/dragon_871k.ply", "Y", 0, PLAIN, NOTHING),
}
PAPER, SIZE = (0.86, 0.86, 0.84), (1400, 760)
EDGE = 0.0011  # radius of the lines, as a share of the diagonal


def polygons(mesh, partition_options, meshing_options):
    regions = engine.partition(mesh, engine.PartitionOptions(proxies=REGIONS, **partition_options))
    return engine.polygonize(mesh, regions, engine.MeshingOptions(**meshing_options))


def parts_of(made, name, view, shift):
    """A surface and its lines as objects."""
    arrays = picture.arrays_of(made.vertices, made.loops, made.loop_start)
    points, total = arrays["points"], arrays["total"]
    color = np.tile(np.array([*PAPER, 1.0]), (len(total), 1))
    normal = np.repeat(picture.area_vectors(arrays), total, axis=0)
    radius = EDGE * np.linalg.norm(np.ptp(points, axis=0))
    return [
        picture.surface(name, arrays, color, normal, view, shift),
        picture.tubes(f"{name} edges", points, picture.edges_of(arrays), radius, shift),
    ]


def draw(name, file, up, turn, left, right):
    mesh = engine.openings.closed_for(engine.clean(*engine.read(DATA / file)), REGIONS)
    view = picture.look_from(up, turn)
    before, after = polygons(mesh, *left), polygons(mesh, *right)
    middle = np.asarray(mesh.vertices).mean(axis=0)
    points = np.asarray(mesh.vertices) - middle
    shift = 1.04 * np.ptp(points @ view[0]) * view[0]
    scene = bpy.data.scenes.new("Picture")
    parts = parts_of(before, "Before", view, -middle) + parts_of(after, "After", view, shift - middle)
    for part in parts:
        scene.collection.objects.link(part)
    picture.frame(scene, np.vstack([points, points + shift]), view, *SIZE)
    picture.set_up(scene, IMAGES / f"{name}.jpg", "JPEG")
    bpy.ops.render.render(write_still=True, scene=scene.name)
    bpy.data.scenes.remove(scene)
    print(f"{name}: {len(before.loop_start)} and {len(after.loop_start)} polygons", flush=True)


def main():
    asked = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else [""]
    for name, given in PICTURES.items():
        if any(part in name for part in asked):
            draw(name, *given)


main()
