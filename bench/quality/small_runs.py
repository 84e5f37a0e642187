"""Small runs of many kinds, below a second each, whose bits show whether a change of the engine changes a result.

    python -m bench.quality.small_runs          time, polygons, mean distance and fingerprint of each

They cover holes, handles, ragged borders, noise, drawn parts, snapped planes, round parts, grids, bounds, flat faces,
edits, convex parts, textures and extreme inputs. No value of the engine was chosen on them.
"""

import functools
import hashlib
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

import isimp_engine as engine
from bench.files import DATA, around
from bench.generators import hollow_solids, known_shapes, real_scans, round_shapes
from isimp_engine.within import scan_distances
from tests.shared import shapes


@dataclass(frozen=True)
class Outcome:
    """The bits of a result, its polygons, and the mean distance of the scan's vertices, 0 where there are none."""

    bits: str
    polygons: int = 0
    distance: float = 0.0


def outcome(*arrays, polygons: int = 0, distance: float = 0.0) -> Outcome:
    digest = hashlib.sha256()
    for array in arrays:
        digest.update(np.ascontiguousarray(array).tobytes())
    return Outcome(digest.hexdigest(), polygons, distance)


def of(mesh, part, poly, *more) -> Outcome:
    far = np.nan_to_num(scan_distances(mesh, part, poly))
    arrays = (mesh.vertices, part.face_region, part.region_normal, part.region_offset, poly.vertices, poly.loops)
    return outcome(*arrays, poly.loop_start, *more, polygons=len(poly.loop_start), distance=float(far.mean()))


@functools.cache
def crop(name: str, most: int, at: int):
    """The faces of a file of DATA that are nearest to one of them."""
    vertices, triangles = engine.read(DATA / name)
    return around(vertices, triangles, at % len(triangles), most)


@functools.cache
def made(maker: Callable, *args, **options):
    return maker(*args, **options)[:2]


@functools.cache
def known(name: str):
    shape = known_shapes.base_shapes()[name][1]
    return shape.vertices, shape.faces


OPTIONS: dict[str, float] = {}  # for all runs of `simplify`


def simplified(scan, **options) -> Outcome:
    found = engine.simplify(scan, threads=1, **OPTIONS, **options)
    return of(found.mesh, found.partition, found.polygons, found.labels)


def turned_scan(name: str, seed: int, noise: float):
    return round_shapes.turned_shape(name, seed, noise, 26)[1:]


def turned(name: str, seed: int, noise: float) -> Outcome:
    return simplified(made(turned_scan, name, seed, noise), curved=True)


def solids(scan, thickness: bool | float = False, **options) -> Outcome:
    found = engine.simplify(scan, threads=1, planar=True, keep_openings=True, proxies=40)
    parts = engine.convex_parts(found, thickness=thickness, **options)
    return outcome(*(array for part in parts for array in (part.vertices, part.triangles)), polygons=len(parts))


def edited(scan, to: str = "level") -> Outcome:
    """Each kind of edit once."""
    mesh = engine.clean(*scan)
    part = engine.partition(mesh, engine.PartitionOptions(proxies=24, threads=1))
    faces, up = len(mesh.triangles), np.array([0, 0, 1.0])
    for k in range(1, 9):
        part = engine.add_proxy(mesh, part, k * faces // 9)
    part = engine.delete_proxy(mesh, part, faces // 3)
    part = engine.split_region(mesh, part, faces // 4)
    part = engine.grow_region(mesh, part, faces // 5, 1)
    part = engine.shrink_region(mesh, part, faces // 5, 1)
    corner = mesh.vertices[mesh.triangles[faces // 2]]
    part = engine.split_along(mesh, part, faces // 2, corner[:2] * 1.001, up)
    part = engine.improve(mesh, engine.merge_cheapest(mesh, engine.add_worst(mesh, part, 3), 2))
    part = engine.even_borders(mesh, part, 0.7)
    part = engine.align_planes(mesh, part, np.array([faces // 7]), to, up, 1.0)
    part = engine.leave_out_regions(mesh, part, np.array([faces // 8]), True)
    return of(mesh, part, engine.polygonize(mesh, part))


def flattened(scan, angle: float = 1.0) -> Outcome:
    poly, region = engine.merge_flat(engine.clean(*scan), angle)
    return outcome(poly.vertices, poly.loops, poly.loop_start, region, polygons=len(poly.loop_start))


def textured(vertices, triangles) -> Outcome:
    colors = (255 * (vertices - vertices.min(0)) / np.ptp(vertices, axis=0)).astype(np.uint8)
    scan = engine.TexturedSoup(vertices, triangles, colors=colors)
    found = engine.simplify(scan, threads=1, proxies=30, texture=96, ao=0.5)
    return outcome(found.texture.uv, found.texture.image, polygons=len(found.polygons.loop_start))


@functools.cache
def needles():
    """A torus of slivers, a hundred times as long as they are wide."""
    vertices, triangles = shapes.torus(60, 8)
    return vertices * [1, 1, 100], triangles


@functools.cache
def far_soup():
    """Random triangles, among them folded and doubled ones, far from zero."""
    rng = np.random.default_rng(11)
    return rng.integers(0, 9, (60, 3)) / 3 + 4e6, rng.integers(0, 60, (120, 3)).astype(np.int32)


@functools.cache
def sponge(seed: int):
    return shapes.voxels(np.random.default_rng(seed).random((7, 7, 7)) < 0.6)


SHARK = "building/cgal_mech_holes_shark_10k.ply"
TURNED = [
    (800, "pipe", 0.001),
    (801, "soap", 0.0),
    (802, "bracket", 0.003),
    (803, "tin", 0.002),
    (804, "slab", 0.001),
    (805, "bin", 0.002),
    (806, "jar", 0.003),
]
TILE, OFFICE = "building/frankfurt_tile_49k.ply", "real/office_27k.ply"
RUNS: dict[str, Callable[[], Outcome]] = {
    "tile": lambda: simplified(crop(TILE, 3500, 7001), detail=0.005),
    "tile planar": lambda: simplified(crop(TILE, 2500, 31013), proxies=60, planar=True, regularise=True),
    "office": lambda: simplified(crop(OFFICE, 4500, 9001), proxies=50),
    "office planar": lambda: simplified(crop(OFFICE, 3000, 21001), detail=0.01, planar=True, straight_rims=0.1),
    "room": lambda: simplified(made(real_scans.room, 7, 0.15), proxies=60),
    "open building": lambda: simplified(made(real_scans.open_building, 5, 0.5), detail=0.01),
    "open building regular": lambda: simplified(made(real_scans.open_building, 6, 0.5), proxies=20, regularise=True),
    "chunks": lambda: simplified(made(real_scans.chunks, 5, (9.0, 6.0, 3.0), 3.0), stitch=0.3),
    "grid house": lambda: simplified(made(real_scans.grid_house, 6, cells=36)),
    "house": lambda: simplified(made(real_scans.drawn_house, 37, 0.003, 34), planar=True, regularise=True),
    "house sizes": lambda: simplified(made(real_scans.drawn_house, 41, 0.001, 34), snap_sizes=0.5),
    "carton": lambda: simplified(made(real_scans.carton, 7)),
    "mvs house": lambda: simplified(made(shapes.mvs_house, 1), proxies=40),
    "bones": lambda: simplified(crop("nasty/cgal_bones_4k_26comp.ply", 4300, 0), proxies=70, leave_out=0.05),
    "shark": lambda: simplified(crop(SHARK, 6000, 77), proxies=40, keep_openings=True),
    "self meets": lambda: simplified(crop("nasty/self_intersect_17k.ply", 4000, 99), proxies=50),
    "thingi": lambda: simplified(crop("nasty/thingi_88566.ply", 2500, 0), proxies=60, convex=True),
    "scad": lambda: simplified(crop("nasty/openscad_nonmanifold_1k.ply", 1500, 0), proxies=60, planar=True),
    "rocker curved": lambda: simplified(crop("scan/rockerarm_20k.ply", 5000, 7), curved=True),
    "meat can curved": lambda: simplified(crop("real/meat_can_16k.ply", 6000, 11), curved=True, planar=True),
    **{f"{name} curved": functools.partial(turned, name, seed, noise) for seed, name, noise in TURNED},
    "torus bound": lambda: simplified(made(shapes.torus, 48, 30), bound=0.02),
    "figure bound": lambda: simplified(made(shapes.figure, 12), bound=0.04),
    "figure": lambda: simplified(made(shapes.figure, 20), proxies=40, adaptivity=0.5),
    "sheet": lambda: simplified(made(shapes.bumpy, 40), triangles=150),
    "plate": lambda: simplified(sponge(5), proxies=30),
    "sponge": lambda: simplified(sponge(9), detail=0.05, convex=True),
    "holes": lambda: simplified(shapes.voxels(shapes.plate(3, 3, 2), 0.05), proxies=12, planar=True),
    "many holes": lambda: simplified(shapes.voxels(shapes.plate(6, 5, 2), 0.03), proxies=6, keep_openings=True),
    "exact holes": lambda: simplified(shapes.voxels(shapes.plate(6, 5, 2)), proxies=6, keep_openings=True, planar=True),
    "tunnels": lambda: simplified(made(shapes.room, 20), proxies=30),
    "facade": lambda: simplified(made(shapes.facade, 4, 3, 2, 0.1), detail=0.01, planar=True),
    "needles": lambda: simplified(needles(), proxies=20),
    "far soup": lambda: simplified(far_soup(), proxies=30),
    "fin cube": lambda: simplified(known("nm_fin_cube")),
    "wedge": lambda: simplified(known("thin_wedge"), proxies=9),
    "edits": lambda: edited(made(shapes.figure, 14)),
    "edits of a house": lambda: edited(made(real_scans.drawn_house, 44, 0.002, 26), "upright"),
    "flat": lambda: flattened(sponge(13)),
    "flat house": lambda: flattened(made(real_scans.clean_house, 45, 26), 0.2),
    "table": lambda: solids(hollow_solids.twin(hollow_solids.chair(), 0.001, 7)),
    "frame enclosed": lambda: solids(hollow_solids.surface(hollow_solids.frame(), 0.4), enclose=True, parts=3),
    "walls": lambda: solids(hollow_solids.surface(hollow_solids.floor_plan(), 0.8), thickness=True),
    "texture": lambda: textured(*made(shapes.figure, 10)),
}


def main() -> None:
    for name, run in RUNS.items():
        run()
        started = time.process_time()
        found = run()
        seconds = time.process_time() - started
        print(f"{name:24} {seconds:6.2f} s {found.polygons:5} {found.distance:.6g} {found.bits[:12]}", flush=True)


if __name__ == "__main__":
    main()
