"""Finds the number of regions of the known shapes and of scans, and prints tables of the found and the wanted numbers.

    python -m bench.quality.found_counts ARGUMENTS
                     the known shapes: how many of them come out exactly, class by class
      --scans        bunny and armadillo over resolution, noise and subdivision, and the slider
      --missed       also name the shapes that come out wrong

Counts, not times: the machine does not matter. The known shapes are made, the scans come from the data folder.
"""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict

import numpy as np

import isimp_engine as engine
from bench.files import data_folder
from bench.generators.collapse import decimated
from bench.generators.known_shapes import Shape, all_meshes, rotation, smoothed, upsampled

DETAILS = (0.02, 0.01, 0.005, 0.0025, 0.00125)
WANTED = {"all": 114, "clean": 18}
BAND = 0.08


def count(vertices, faces, **fields):
    return engine.partition(engine.clean(vertices, faces), engine.PartitionOptions(**fields)).region_count


def is_thin(kind, name):
    """The upsampled variants of the two thin shapes: they are shown, but are not among the 128."""
    return kind == "upsampled" and name.startswith("thin")


def known(missed):
    """How many of each class come out exactly, at two details. Returns whether the bars hold at the default."""
    hit, total, wrong = defaultdict(int), defaultdict(int), []
    for kind, name, shape in all_meshes():
        found = count(shape.vertices, shape.faces)
        groups = ["thin, upsampled"] if is_thin(kind, name) else [kind, "all"]
        for group in groups:
            total[group] += 1
            hit[group] += found == shape.planes
        if found != shape.planes:
            wrong.append(f"  {name}: {found} for {shape.planes}")
    for group in total:
        bar = f"   wanted: {WANTED[group]}" if group in WANTED else ""
        print(f"{group:16} {hit[group]:4} of {total[group]}{bar}")
    if missed:
        print("\n".join(wrong))
    return all(hit[group] >= bar for group, bar in WANTED.items())


def scan_variants(shape):
    """Name and shape of the variants of a scan. Noise in percent of the diagonal."""
    diagonal = np.linalg.norm(np.ptp(shape.vertices, axis=0))
    rng = np.random.default_rng(5)
    yield "as it is", shape
    yield "half the faces", Shape(*decimated(shape.vertices, shape.faces, 0.5), 0)
    yield "a quarter", Shape(*decimated(shape.vertices, shape.faces, 0.25), 0)
    if len(shape.faces) < 200_000:
        yield "subdivided", upsampled(shape)
    for percent in (0.01, 0.03, 0.1):
        yield (
            f"noise {percent} %",
            shape.moved(shape.vertices + rng.normal(scale=percent / 100 * diagonal, size=shape.vertices.shape)),
        )
    yield "smoothed", smoothed(shape, 2)
    order = rng.permutation(len(shape.faces))
    yield "turned, faces shuffled", Shape(shape.vertices @ rotation(rng).T, shape.faces[order], 0)


def scans(folder, slider):
    worst = 0.0
    for name in ("bunny_69k", "armadillo_86k"):
        shape = Shape(*engine.read(folder / "scan" / f"{name}.ply"), 0)
        base = None
        for variant, changed in scan_variants(shape):
            found = count(changed.vertices, changed.faces)
            base = base or found
            worst = max(worst, abs(found / base - 1))
            print(f"{name:14} {variant:24} {found:6}  {found / base:.3f}", flush=True)
    print(f"farthest from the plain scan: {worst:.3f}   wanted: {BAND}")
    if slider:
        print("detail: " + "  ".join(f"{d:8}" for d in DETAILS))
        for path in sorted((folder / "scan").glob("*.ply")) + sorted((folder / "building").glob("*.ply")):
            mesh = engine.clean(*engine.read(path))
            row = [engine.partition(mesh, engine.PartitionOptions(detail=d)).region_count for d in DETAILS]
            print(f"{path.stem:28}" + "  ".join(f"{n:8}" for n in row), flush=True)
    return worst <= BAND


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scans", action="store_true")
    parser.add_argument("--slider", action="store_true", help="with --scans: counts at every detail of all scans")
    parser.add_argument("--missed", action="store_true")
    parser.add_argument("--data", help="where the meshes lie")
    arguments = parser.parse_args()
    if not arguments.scans:
        return 0 if known(arguments.missed) else 1
    folder = data_folder(arguments.data)
    if folder is None:
        sys.exit("there is no data folder: give one with --data")
    return 0 if scans(folder, arguments.slider) else 1


if __name__ == "__main__":
    sys.exit(main())
