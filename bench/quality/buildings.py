"""Exactly planar polygons and snapped planes on generated houses and on scans of buildings.

    PYTHONPATH=build-dev/python python -m bench.quality.buildings [--data DIR] [--seeds N] [--turns N]

The houses of houses.py are partitioned by their true planes: a row gives the share of houses with only whole polygons,
and the share with the true directions and planes. Scans (scanned.py's, then DIR/building's) are partitioned by number;
distance is from their vertices to the polygons, mean, 99 % and largest, against `polygonize` without either.
"""

import argparse
import itertools
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import isimp_engine as engine
from bench.generators import houses, scanned
from isimp_engine.within import scan_distances

SCANS = (
    ("openmvs_castle_175k", 300),
    ("openmvs_castle_175k", 1000),
    ("frankfurt_tile_49k", 300),
    ("cgal_mech_holes_shark_10k", 300),
    ("fandisk_13k", 300),
)
GENERATED = 300  # regions of each generated scan
DEFECTS = ("crossing", "flipped", "intersecting")


def true_planes(house: houses.House) -> tuple[int, int]:
    """The numbers of directions, opposite ones counted once, and of planes of a house."""
    a, b, c = (house.clean[house.triangles[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    first = np.unique(house.label, return_index=True)[1]
    lead = np.take_along_axis(normal, np.abs(normal).round(6).argmax(1)[:, None], 1)
    return len(np.unique((normal * np.sign(lead))[first].round(6) + 0.0, axis=0)), len(first)


def timed(call: Callable[..., Any], *args: Any) -> tuple[Any, float]:
    start = time.perf_counter()
    result = call(*args)
    return result, time.perf_counter() - start


def house_rows(noise: float, seeds: int, turns: int) -> None:
    whole, same, share, ratio = [], [], [], []
    for seed, turn in itertools.product(range(1, seeds + 1), range(turns)):
        house = houses.make(noise, seed, turn=17.0 + 31.0 * turn)
        mesh = engine.Mesh(house.vertices, house.triangles)
        part = engine.partition_from(mesh, house.label.astype(np.int32))
        before, t0 = timed(engine.polygonize, mesh, part)
        snapped, t1 = timed(engine.regularise, mesh, part)
        after, t2 = timed(engine.polygonize, mesh, snapped, engine.MeshingOptions(planar=True))
        whole.append(after.report["whole"])
        same.append((snapped.report["directions"], snapped.report["planes"]) == true_planes(house))
        share.append((t1 + t2 - t0) / t0)
        ratio.append(corner_error(house, part, after) / max(corner_error(house, part, before), 1e-9 * house.diagonal))
    whole_all = np.mean(np.array(whole) == 1)
    print(
        f"houses, noise {noise:.1%}: all whole {whole_all:.2f}, whole {np.mean(whole):.3f}, planes are the true ones "
        f"{np.mean(same):.2f}, error of corners after / before {np.mean(ratio):.2f}, added time {np.median(share):.2f}"
    )


def corner_error(house: houses.House, part: engine.Partition, poly: engine.PolygonMesh) -> float:
    """Root mean square distance of the corners of polygons from the true planes of their regions."""
    a, b, c = (house.clean[house.triangles[part.region_seed, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    region = np.repeat(poly.polygon_region, np.diff([*poly.loop_start, len(poly.loops)]))
    off = ((np.asarray(poly.vertices)[poly.loops] - a[region]) * normal[region]).sum(1)
    return float(np.sqrt((off**2).mean()))


def off(mesh: engine.Mesh, part: engine.Partition, poly: engine.PolygonMesh) -> np.ndarray:
    """Distance of the scan's vertices from polygons: mean, of 99 of 100, largest."""
    far = scan_distances(mesh, part, poly)
    far = far[np.isfinite(far)]
    return np.array([far.mean(), np.quantile(far, 0.99), far.max()])


def changes(to: np.ndarray, was: np.ndarray) -> str:
    return " / ".join(f"{change:+.0%}" for change in to / was - 1)


def scan_row(name: str, mesh: engine.Mesh, proxies: int) -> None:
    part = engine.partition(mesh, engine.PartitionOptions(proxies=proxies))
    before, t0 = timed(engine.polygonize, mesh, part)
    after, t1 = timed(engine.polygonize, mesh, part, engine.MeshingOptions(planar=True))
    snapped, t2 = timed(engine.regularise, mesh, part)
    regular = engine.polygonize(mesh, snapped, engine.MeshingOptions(planar=True))
    free = engine.regularise(mesh, part, engine.RegulariseOptions(length=1e-12))
    near, planar, both = off(mesh, part, before), off(mesh, part, after), off(mesh, snapped, regular)
    more = sum(after.report[f] - before.report[f] for f in DEFECTS)
    print(
        f"{name} {proxies}: planar {after.report['planar']}, whole {after.report['whole']:.2f}, faces a polygon "
        f"{len(after.loop_start) / len(before.loop_start):.2f}, new defects {more}, distance {changes(planar, near)}, "
        f"added time {(t1 - t0) / t0:.1f}; "
        f"regularised: directions {free.report['directions']} -> {snapped.report['directions']}, rms "
        f"{snapped.report['rms_added'] / (snapped.report['rms'] - snapped.report['rms_added']):+.1%}, "
        f"whole {regular.report['whole']:.2f}, faces a polygon {len(regular.loop_start) / len(before.loop_start):.2f}, "
        f"planes released {regular.report['planes_let_go']}, new defects "
        f"{sum(regular.report[f] - before.report[f] for f in DEFECTS)}, distance {changes(both, near)}, "
        f"time {t2 / t0:.2f}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, help="folder with building/*.ply")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--turns", type=int, default=3)
    arguments = parser.parse_args()
    for noise in (0.0, 0.001, 0.002, 0.003, 0.004):
        house_rows(noise, arguments.seeds, arguments.turns)
    for seed, noise, rounding in scanned.SCANS:
        scan_row(f"generated scan {seed}", engine.clean(*scanned.make(seed, noise, rounding)), GENERATED)
    for name, proxies in SCANS if arguments.data else ():
        scan_row(name, engine.clean(*engine.read(arguments.data / "building" / f"{name}.ply")), proxies)


if __name__ == "__main__":
    main()
