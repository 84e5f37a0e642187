"""Prints the number of polygons for each number of regions, and whether real openings stay.

    python -m bench.quality.counts [--data DIR]

`isimp_engine` must be importable. Counts, not times: the machine does not matter. Scans come from the data folder, the
other meshes are made. Tables:

  for 300 regions   polygons of scans with many small openings, all kept and by default; distance is the mean of the
                    scan's vertices from the polygons, in % of the diagonal
  by detail         polygons a region, at each detail of the slider
  expected, made    the estimate of `expected_polygons`, and the polygons made
  openings          handles of noisy scans before and after closing, for N regions; the real ones should stay
  rooms             polygons of a room with many tunnels of one cell through a wall, and of the same room without
  houses            two houses with tunnels, pinholes and specks, as multi-view stereo makes them
  coarse meshes     the number found by detail on a mesh of few triangles, and split in four one to three times
  steps             the largest change of polygons for a step of 5 % in regions or detail, beyond that of the step
"""

from __future__ import annotations

import argparse
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np

import isimp_engine as engine
from bench.files import data_folder
from bench.generators.collapse import decimated
from bench.generators.known_shapes import split_in_four
from bench.generators.real_scans import noisy
from isimp_engine.within import scan_distances
from tests.shared import shapes

SCANS = ("scan/dragon_871k", "building/frankfurt_tile_49k", "nasty/ogre_124k_44comp")
DETAILED = ("scan/bunny_69k", "scan/armadillo_86k", "scan/armadillo_346k_loop", "scan/rockerarm_20k",
            "building/openmvs_castle_175k", "building/fandisk_13k", "nasty/lionstatue_63k_misoriented")  # fmt: skip
DETAILS = (0.02, 0.01, 0.005, 0.0025, 0.00125)


def made(mesh, **options):
    part = engine.partition(mesh, engine.PartitionOptions(**options))
    return part, engine.polygonize(mesh, part)


def handles(mesh):
    report = mesh.report
    return (2 * report["components"] - report["border_loops"] - report["euler"]) // 2


def for_regions(data):
    print("| scan | regions | polygons, all openings kept | closed | distance % | closed |\n|---|---|---|---|---|---|")
    for name in SCANS:
        arrays = engine.read(data / f"{name}.ply")
        row = []
        for mesh in (engine.clean(*arrays), engine.openings.closed_for(engine.clean(*arrays), 300)):
            part, poly = made(mesh, proxies=300)
            away = np.nanmean(scan_distances(mesh, part, poly)) / mesh.report["diagonal"]
            row.append((poly.report["polygons"], 100 * away))
        (kept, far), (fewer, near) = row
        print(f"| {name} | 300 | {kept} | {fewer} | {far:.3f} | {near:.3f} |", flush=True)


def by_detail(data):
    print(f"\n| scan | {' | '.join(map(str, DETAILS))} |\n|{'---|' * (1 + len(DETAILS))}")
    for name in DETAILED:
        mesh = engine.clean(*engine.read(data / f"{name}.ply"))
        cells = []
        for detail in DETAILS:
            part, poly = made(mesh, detail=detail)
            cells.append(f"{part.region_count} {poly.report['polygons'] / part.region_count:.2f}")
        print(f"| {name} | {' | '.join(cells)} |", flush=True)


def foreseen(data):
    """The estimate of `expected_polygons`, and the polygons made, of all scans, with openings closed as by default."""
    numbers = (30, 100, 300, 1000)
    print(f"\n| scan | {' | '.join(f'expected, made for {n}' for n in numbers)} |\n|{'---|' * (1 + len(numbers))}")
    errors = []
    for path in sorted(data.glob("[bns]*/*.ply")):
        arrays, cells = engine.read(path), []
        for number in numbers:
            if 4 * number > len(arrays[1]):
                cells.append("")
                continue
            mesh = engine.openings.closed_for(engine.clean(*arrays), number)
            part, poly = made(mesh, proxies=number)
            said, came = engine.regions.expected_polygons(mesh, part)["polygons"], poly.report["polygons"]
            errors.append(abs(said / came - 1))
            cells.append(f"{said}, {came}")
        print(f"| {path.stem} | {' | '.join(cells)} |", flush=True)
    within = sum(error <= 0.1 for error in errors)
    print(f"\nerror: median {np.median(errors):.1%}, {within} of {len(errors)} within 10 %, at most {max(errors):.0%}")


def mug():
    """A solid of voxels with a handle."""
    solid = np.zeros((24, 44, 30), bool)
    x, y = np.mgrid[:24, :24]
    solid[:, :24, :] = ((x - 11.5) ** 2 + (y - 11.5) ** 2 < 144)[:, :, None]
    solid[:, :24, 3:] &= ~((x - 11.5) ** 2 + (y - 11.5) ** 2 < 81)[:, :, None]
    solid[10:14, 22:40, 4:8] = solid[10:14, 22:40, 22:26] = solid[10:14, 36:40, 4:26] = True
    return shapes.voxels(solid)


def fence():
    """Ten slats between two rails."""
    solid = np.zeros((64, 4, 30), bool)
    solid[:, :, 3:6] = solid[:, :, 24:27] = True
    for k in range(10):
        solid[2 + 6 * k : 5 + 6 * k] = True
    return shapes.voxels(solid)


def openings():
    plate = shapes.voxels(shapes.plate(4, 3, 3, 6, 6))
    meshes = {"torus": shapes.torus(120, 60), "mug": mug(), "plate of 12 holes": plate, "fence of 9 gaps": fence()}
    counts = (12, 30, 100, 300)
    print(f"\n| mesh | handles | {' | '.join(f'left for {n}' for n in counts)} |\n|{'---|' * (2 + len(counts))}")
    for name, smooth in meshes.items():
        arrays = noisy(3, *smooth, 0.001)
        left = [handles(engine.openings.closed_for(engine.clean(*arrays), n)) for n in counts]
        print(f"| {name} | {handles(engine.clean(*arrays))} | {' | '.join(map(str, left))} |", flush=True)


def rooms():
    print("\n| tunnels | regions | polygons, kept | closed | without tunnels |\n|---|---|---|---|---|")
    for tunnels in (16, 32):
        for regions in (30, 60, 120):
            arrays, plain = shapes.room(tunnels), shapes.room(0)
            scan = engine.clean(*arrays)
            figures = [
                made(mesh, proxies=regions)[1].report["polygons"]
                for mesh in (scan, engine.openings.closed_for(scan, regions), engine.clean(*plain))
            ]
            print(f"| {tunnels} | {regions} | {' | '.join(map(str, figures))} |", flush=True)


def houses():
    """Regions left out, polygons and closedness, compared with the same house without errors."""
    print("\n| house | requested | regions | polygons | a region | closed | specks left out | without errors |")
    print("|---|---|---|---|---|---|---|---|")
    for scale in (1, 2):
        arrays, plain = shapes.mvs_house(scale), engine.clean(*shapes.mvs_house(scale, errors=False))
        for asked in ({"proxies": 42}, {"proxies": 100}, {"proxies": 300}, {}):
            regions = asked.get("proxies") or made(engine.clean(*arrays))[0].region_count
            part, poly = made(engine.openings.closed_for(engine.clean(*arrays), regions), **asked)
            report, clean = poly.report, made(plain, **asked)[1].report
            each = report["polygons"] / report["regions"]
            row = report["regions"], report["polygons"], f"{each:.2f}", report["closed"], part.parts_left_out
            name = f"of {scale} cell{'s' * (scale > 1)}"
            print(f"| {name} | {regions if asked else 'detail'} | {' | '.join(map(str, row))} | {clean['polygons']} |")


def coarse():
    print("\n| mesh | faces | regions, split 0 to 3 times | distance % |\n|---|---|---|---|")
    for seed in (1, 2):
        for faces in (300, 1000, 2000):
            vertices, triangles = shapes.bumpy(90, seed)
            vertices, triangles = decimated(vertices, triangles, faces / len(triangles))
            counts, away = [], []
            for _ in range(4):
                mesh = engine.clean(vertices, triangles)
                part, poly = made(mesh)
                counts.append(part.region_count)
                away.append(100 * np.nanmean(scan_distances(mesh, part, poly)) / mesh.report["diagonal"])
                vertices, triangles = split_in_four(vertices, triangles)
            shown = " ".join(map(str, counts)), " ".join(f"{x:.2f}" for x in away)
            print(f"| bumps {seed} | {faces} | {shown[0]} | {shown[1]} |", flush=True)


def steps(data):
    print("\n| mesh | of | worst step | from | to |\n|---|---|---|---|---|")
    meshes = {"bumps": engine.clean(*shapes.bumpy(90))}
    if data:
        meshes["bunny"] = engine.clean(*engine.read(data / "scan/bunny_69k.ply"))
    for name, mesh in meshes.items():
        numbers = [{"proxies": round(40 * 1.05**k)} for k in range(50)]
        details = [{"detail": 0.02 / 1.05**k} for k in range(50)]
        for kind, asked in (("regions", numbers), ("detail", details)):
            counts = [made(mesh, **options)[1].report["polygons"] for options in asked]
            changes = [after / before - 1 for before, after in pairwise(counts)]
            worst = int(np.argmax(changes))
            least = min(changes)
            print(
                f"| {name} | {kind} | {changes[worst]:+.0%}, {least:+.0%} | {asked[worst]} | {asked[worst + 1]} |",
                flush=True,
            )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", help="folder of the scans")
    data = data_folder(parser.parse_args().data)
    if data is None:
        print("no data folder: scans are left out", file=sys.stderr)
    else:
        for_regions(Path(data))
        by_detail(Path(data))
        foreseen(Path(data))
    openings()
    rooms()
    houses()
    coarse()
    steps(Path(data) if data else None)


if __name__ == "__main__":
    main()
