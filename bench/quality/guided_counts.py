"""Bounds, adaptivity and painted weights on scans: tables of the numbers and places of their regions.

    python -m bench.quality.guided_counts ARGUMENTS
      bounds       regions for a bound of .25, .5 and 1 % of the diagonal, how it is kept, and how
                    far the scan is from the polygons (at most 1.5 bounds)
      planes       the same without the polygons, which take much longer
      adaptivity   share of the regions in the roughest fifth of the area
      weights      regions in a painted zone, and in the rest

Counts are compared with the wanted ones; processor time is given as a multiple of the default method's time for as many
regions, in the same process.
"""

from __future__ import annotations

import sys
import time
from functools import partial

import numpy as np

import isimp_engine as engine
from bench.timer.run import data_folder

WANTED = {  # regions for bounds of .25, .5 and 1 % of the diagonal
    "scan/bunny_69k": (657, 261, 106),
    "scan/armadillo_346k_loop": (913, 379, 155),
    "building/openmvs_castle_175k": (589, 195, 75),
    "building/fandisk_13k": (64, 44, 32),
    "known/sphere": (280, 142, 65),
}
BOUNDS = (0.25, 0.5, 1.0)


def load(folder, name):
    return engine.clean(*engine.read(folder / f"{name}.ply"))


def split(mesh, **fields):
    weights = fields.pop("weights", None)
    return engine.partition(mesh, engine.PartitionOptions(threads=1, **fields), weights=weights)


def farthest(mesh, part):
    """The largest distance of a face's corner from the plane of the face's region."""
    kept = part.face_region >= 0
    region = part.face_region[kept]
    height = np.einsum("fkd,fd->fk", mesh.vertices[mesh.triangles[kept]], part.region_normal[region])
    return np.abs(height - part.region_offset[region][:, None]).max()


def seconds(call):
    start = time.process_time()
    result = call()
    return time.process_time() - start, result


def bounds(folder, names, *, polygons):
    """Returns whether every run kept its bound, by the regions' planes and, if they are wanted, by the polygons."""
    kept_all = True
    for name in names:
        mesh = load(folder, name)
        for k, percent in enumerate(BOUNDS):
            bound = percent / 100 * mesh.report["diagonal"]
            options = engine.PartitionOptions(bound=bound, noise=0.0, threads=1)
            took, part = seconds(partial(engine.partition, mesh, options))
            plain, _ = seconds(partial(split, load(folder, name), proxies=part.region_count))
            wanted = f"wanted {WANTED[name][k]:4}" if name in WANTED else ""
            kept, speed = farthest(mesh, part) / bound, took / len(mesh.triangles) * 1e6
            print(f"{name:32} {percent:4} %  {part.region_count:5} regions {wanted}  kept to {kept:.4f}", end="")
            print(f"  {speed:.2f} s a million faces, x{took / plain:.1f}", end="", flush=True)
            sound, told = kept <= 1 + 1e-9, ""
            if polygons:
                made = engine.within.Made(options)
                took, found = seconds(partial(engine.within.polygonize_within, mesh, part, made=made))
                sound &= found.distance <= found.allowed
                told = f"  scan to polygons {found.distance / bound:.3f} bounds"
                told += f" with {found.partition.region_count} regions, {took:.1f} s"
            print(told + ("" if sound else "  NOT KEPT"), flush=True)
            kept_all &= sound
    return kept_all


def neighbours(mesh):
    """(F, 3) the face across each edge, the face itself where there is none."""
    f = mesh.triangles
    ends = np.sort(np.stack([f, np.roll(f, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    order = np.lexsort(ends.T)
    same = (ends[order[1:]] == ends[order[:-1]]).all(axis=1)
    across = np.repeat(np.arange(len(f)), 3)
    a, b = order[:-1][same], order[1:][same]
    across[a], across[b] = b // 3, a // 3
    return across.reshape(-1, 3)


def normals_and_areas(mesh):
    corners = mesh.vertices[mesh.triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(cross, axis=1)
    return cross / np.maximum(length, 1e-300)[:, None], length / 2


def roughest_fifth(mesh):
    """Whether each face is in the fifth of the area where normals, averaged over 1 % of the diagonal, stray most."""
    normals, areas = normals_and_areas(mesh)
    across = neighbours(mesh)
    edge = np.sqrt(areas.sum() / len(areas) * 4 / np.sqrt(3))
    steps = int(np.clip((0.01 * mesh.report["diagonal"] / edge) ** 2 * 6, 3, 400))
    total = areas + areas[across].sum(axis=1)
    for _ in range(steps):
        weighted = normals * areas[:, None]
        normals = (weighted + weighted[across].sum(axis=1)) / np.maximum(total, 1e-300)[:, None]
    order = np.argsort(np.linalg.norm(normals, axis=1), kind="stable")
    zone = np.zeros(len(areas), bool)
    zone[order[np.cumsum(areas[order]) <= 0.2 * areas.sum()]] = True
    return zone, areas


def inside(part, zone, areas):
    """Regions most of whose area is in the zone."""
    region = np.maximum(part.face_region, 0)
    whole = np.bincount(region, areas, part.region_count)
    return int((np.bincount(region, areas * zone, part.region_count) > whole / 2).sum())


def adaptivity(folder, names):
    for name in names:
        mesh = load(folder, name)
        zone, areas = roughest_fifth(mesh)
        shares, counts = [], []
        for a in (0, 0.25, 0.5, 1):
            part = split(mesh, proxies=500, adaptivity=a)
            shares.append(inside(part, zone, areas) / part.region_count)
            counts.append(split(mesh, detail=0.005, adaptivity=a).region_count)
        print(
            f"{name:32} share in the roughest fifth at 0, .25, .5, 1: " + " ".join(f"{s:.0%}" for s in shares), end=""
        )
        print("   count at detail .005: " + " ".join(map(str, counts)), flush=True)


def weights(folder, names):
    for name, proxies in names:
        mesh = load(folder, name)
        _, areas = normals_and_areas(mesh)
        top = mesh.vertices[mesh.vertices[:, 1].argmax()]
        middle = mesh.vertices[mesh.triangles].mean(axis=1)
        zone = np.linalg.norm(middle - top, axis=1) < 0.2 * mesh.report["diagonal"]
        rows = {"given": [], "found, in the zone": [], "found, the rest": [], "flooding": []}
        for w in (0.25, 0.5, 1, 2, 4, 8, 16):
            painted = np.where(zone, w, 1.0)
            rows["given"].append(inside(split(mesh, proxies=proxies, weights=painted), zone, areas))
            part = split(mesh, detail=0.005, weights=painted)
            rows["found, in the zone"].append(inside(part, zone, areas))
            rows["found, the rest"].append(part.region_count - rows["found, in the zone"][-1])
            flood = [
                split(mesh, proxies=proxies, weights=painted, method="lloyd", iterations=8, seed=s) for s in (1, 2, 3)
            ]
            rows["flooding"].append(round(np.mean([inside(f, zone, areas) for f in flood])))
        print(f"{name}: regions in the zone at weights .25, .5, 1, 2, 4, 8, 16")
        for row, counts in rows.items():
            print(f"  {row:20} " + " ".join(f"{n:4}" for n in counts), flush=True)


def main():
    folder = data_folder(None)
    if folder is None or len(sys.argv) != 2 or sys.argv[1] not in ("bounds", "planes", "adaptivity", "weights"):
        sys.exit(__doc__)
    if sys.argv[1] in ("bounds", "planes"):
        rest = sorted(str(p.relative_to(folder))[:-4] for p in folder.glob("*/*.ply"))
        skipped = ("known/empty", "known/one_triangle")
        kept = bounds(
            folder,
            [*WANTED, *(n for n in rest if n not in WANTED and n not in skipped)],
            polygons=sys.argv[1] == "bounds",
        )
        print("every bound kept" if kept else "NOT every bound kept")
        sys.exit(not kept)
    elif sys.argv[1] == "adaptivity":
        adaptivity(folder, ["scan/bunny_69k", "scan/armadillo_86k", "nasty/lionstatue_63k_misoriented"])
    else:
        weights(folder, [("scan/bunny_69k", 300), ("scan/armadillo_86k", 500)])


if __name__ == "__main__":
    main()
