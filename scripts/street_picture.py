"""Makes the picture of docs/buildings.md: a scanned street of ten houses and its exactly planar polygons.

    blender -b --python-use-system-env --python-exit-code 1 --python scripts/street_picture.py

`isimp_engine` must be on PYTHONPATH. The houses come from bench/generators/houses.py. The picture is
written to docs/images.
"""

import sys
from pathlib import Path

import bpy
import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "examples"), str(ROOT)]

import picture  # noqa: E402

import isimp_engine as engine  # noqa: E402
from bench.generators import houses  # noqa: E402

DETAIL = 0.0005  # share of the whole street: windows are a two-hundredth of it deep
REACH = 0.001  # share of the whole street
HEIGHT = 34.0  # degrees of the view from above
PAPER, EDGE = (0.86, 0.86, 0.84), 0.00025
SIZE = 1500, 800


def look():
    """As picture.look_from, from higher up."""
    right, _, toward = picture.look_from("Z", 24)
    level = np.cross(right, [0.0, 0.0, 1.0])
    level *= np.sign(level @ toward)
    angle = np.radians(HEIGHT)
    toward = np.cos(angle) * level / np.linalg.norm(level) + np.sin(angle) * np.array([0.0, 0.0, 1.0])
    return np.array([right, np.cross(toward, right), toward])


def direction_colors(regular):
    """A colour for each region by the direction of its plane, opposite ones alike; grey where that is level."""
    normal = np.asarray(regular.region_normal)
    hue = np.arctan2(normal[:, 1], normal[:, 0]) % np.pi / np.pi
    wheel = 0.5 + 0.5 * np.cos(2 * np.pi * (hue[:, None] - np.array([0.0, 1 / 3, 2 / 3])))
    share = np.linalg.norm(normal[:, :2], axis=1)[:, None]
    color = share * (0.35 + 0.55 * wheel) + (1 - share) * 0.8
    return np.concatenate([color, np.ones((len(color), 1))], axis=1)


def main():
    street = houses.street()
    mesh = engine.Mesh(street.vertices, street.triangles)
    regular = engine.regularise(mesh, engine.partition(mesh, engine.PartitionOptions(detail=DETAIL)))
    made = engine.polygonize(mesh, regular, engine.MeshingOptions(planar=True, planar_reach=REACH))
    print(f"{len(mesh.triangles)} faces, {len(regular.region_seed)} regions, {len(made.loop_start)} polygons:", end=" ")
    print({key: made.report[key] for key in ("planar", "whole")}, regular.report, flush=True)
    view = look()
    middle = np.asarray(mesh.vertices).mean(axis=0)
    points = np.asarray(mesh.vertices) - middle
    shift = 1.03 * np.ptp(points @ view[0]) * view[0]
    corners = np.asarray(mesh.triangles).ravel()
    scan = picture.arrays_of(points, corners, np.arange(0, len(corners), 3))
    result = picture.arrays_of(np.asarray(made.vertices) - middle, made.loops, made.loop_start)
    grey = np.tile(np.array([*PAPER, 1.0]), (len(scan["start"]), 1))
    color = direction_colors(regular)[np.asarray(made.polygon_region)]
    radius = EDGE * np.linalg.norm(np.ptp(points, axis=0))
    normals = [np.repeat(picture.area_vectors(a), a["total"], axis=0) for a in (scan, result)]
    scene = bpy.data.scenes.new("Picture")
    for part in (
        picture.surface("Scan", scan, grey, normals[0], view, 0 * shift),
        picture.surface("Polygons", result, color, normals[1], view, shift),
        picture.tubes("Edges", result["points"], picture.edges_of(result), radius, shift),
    ):
        scene.collection.objects.link(part)
    picture.frame(scene, np.vstack([points, points + shift]), view, *SIZE)
    picture.set_up(scene, ROOT / "docs" / "images" / "buildings-street.jpg", "JPEG")
    bpy.ops.render.render(write_still=True, scene=scene.name)


main()
