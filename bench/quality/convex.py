"""Measures convex parts: their number, triangles, volume and free points on hollow solids and scans, against peers.

    python -m bench.quality.convex ARGUMENTS
      --exact             the solids without noise; else their twins with noise of .1 % of the diagonal
      --enclose           parts that enclose every vertex
      --statues           scans of the data folder too, with 16 parts
      --open              scans of rooms alone: open surfaces, whose walls get a thickness
      --peers             CoACD and V-HACD too, where the packages coacd and vhacdx are installed
      --only NAME         one solid or scan

Columns: parts and the true number; triangles of a part; volume of the union over the true one, by 200,000 points;
vertices outside all parts, and the farthest of these in % of the diagonal; free points that are free, of open scans the
share of points in front of the scan; mean distance of the scan from the parts' planes, and of the parts' outer surface
from the scan, in % of the diagonal; seconds of the processor.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

import isimp_engine as engine
from bench.files import data_folder
from bench.generators import hollow_solids, real_scans

SCANS = ("scan/armadillo_86k.ply", "scan/bunny_69k.ply", "scan/rockerarm_20k.ply", "real/tin_16k.ply")
PARTS = 16
POINTS = 200_000
NEAR = 0.002  # share of the diagonal
FRONT = 0.03  # share of the diagonal: points this far in front of an open scan are free, if no other part of it is near


def ours(vertices, faces, count, arguments):
    result = engine.simplify((vertices, faces), planar=True, keep_openings=True)
    found = engine.convex_parts(result, enclose=arguments.enclose, parts=count, thickness=arguments.open)
    return [(part.vertices, part.triangles) for part in found]


def coacd(vertices, faces, count, _):
    import coacd

    coacd.set_log_level("error")
    return coacd.run_coacd(coacd.Mesh(vertices, faces), max_convex_hull=count or -1)


def vhacd(vertices, faces, count, _):
    import vhacdx

    rows = np.hstack([np.full((len(faces), 1), 3), faces]).astype(np.uint32).ravel()
    found = vhacdx.compute_vhacd(vertices, rows, maxConvexHulls=count or 32)
    return [(points, corners.reshape(-1, 4)[:, 1:] if corners.ndim == 1 else corners) for points, corners in found]


def planes_of(vertices, triangles):
    a, b, c = (np.asarray(vertices, float)[np.asarray(triangles)[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    normal = normal[length > 0] / length[length > 0, None]
    return normal, (normal * a[length > 0]).sum(axis=1)


def outside(parts, points):
    """How far each point is outside the nearest part by its planes; below 0: inside."""
    out = np.full(len(points), np.inf)
    for normal, offset in parts:
        for begin in range(0, len(points), 20_000):
            some = slice(begin, begin + 20_000)
            out[some] = np.minimum(out[some], (points[some] @ normal.T - offset).max(axis=1))
    return out


def judge(found, vertices, faces, solid, is_open=False):
    """The columns of the table."""
    parts = [planes_of(*part) for part in found]
    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    rng = np.random.default_rng(0)
    covered = volume(parts, vertices, rng)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    whole = solid.volume if solid else 1.0 if is_open else float((np.cross(a, b) * c).sum() / 6)
    out = outside(parts, vertices)
    triangles = sum(len(corners) for _, corners in found)
    places = np.array(solid.free) if solid else in_front(vertices, faces, size, rng) if is_open else np.zeros((0, 3))
    free = outside(parts, places) > 0
    return {
        "parts": f"{len(found)} / {len(solid.boxes) if solid else '-'}",
        "triangles": f"{triangles / len(found):.1f}",
        "volume": f"{covered / whole:.3f}",
        "outside": f"{(out > 0).mean():.2%}, {100 * max(out.max(), 0) / size:.3f}",
        "free": f"{free.sum()} / {len(free)}",
        "away": f"{100 * np.abs(out).mean() / size:.3f}",
        "added": f"{100 * added(found, parts, vertices, faces, size, rng):.3f}",
    }


def volume(parts, vertices, rng):
    """The volume of the union of the parts of a scan with these vertices."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    size = float(np.linalg.norm(high - low))
    points = rng.uniform(low - 0.02 * size, high + 0.02 * size, (POINTS, 3))
    return (outside(parts, points) <= 0).mean() * np.prod(high - low + 0.04 * size)


def in_front(vertices, faces, size, rng):
    """Points in front of an open scan, whose nearest point of it is behind them."""
    chosen = rng.choice(len(faces), 1_000)
    a, b, c = (vertices[faces[chosen, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    points = ((a + b + c) / 3)[length > 0] + FRONT * size * normal[length > 0] / length[length > 0, None]
    scan = np.concatenate([vertices, on_surface([(vertices, faces)], 100_000, rng)])  # some scans have large triangles
    away = np.array([np.linalg.norm(scan - p, axis=1).min() for p in points])
    return points[away > 0.9 * FRONT * size]


def added(found, parts, vertices, faces, size, rng):
    """The mean distance from the parts' surface, where no other part touches it, to the nearest point of the scan."""
    samples, scan = on_surface(found, 3_000, rng), on_surface([(vertices, faces)], 30_000, rng)
    samples = samples[sum(outside([part], samples) < NEAR * size for part in parts) < 2]
    nearest = [((scan - p) ** 2).sum(axis=1).min() for p in samples]
    return float(np.sqrt(nearest).mean() / size)


def on_surface(meshes, count, rng):
    """Points of triangle meshes, spread by area."""
    corners = np.concatenate([np.asarray(v, float)[np.asarray(t)] for v, t in meshes])
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    chosen = corners[rng.choice(len(corners), count, p=area / area.sum())]
    u, v = rng.uniform(size=(2, count, 1))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    return chosen[:, 0] + u * (chosen[:, 1] - chosen[:, 0]) + v * (chosen[:, 2] - chosen[:, 0])


def main():
    command = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for flag in ("--exact", "--enclose", "--statues", "--open", "--peers"):
        command.add_argument(flag, action="store_true")
    command.add_argument("--only")
    arguments = command.parse_args()
    cases = []
    for name, make in hollow_solids.SOLIDS.items() if not arguments.open else ():
        solid = make()
        cases.append((name, solid, *(hollow_solids.surface if arguments.exact else hollow_solids.twin)(solid), None))
    if arguments.statues:
        for name in SCANS:
            soup = engine.read(data_folder(None) / name)
            cases.append((name, None, *soup, PARTS))
    if arguments.open:
        cases += [(f"room {seed}", None, *real_scans.room(seed), None) for seed in (1, 2, 3)]
        cases.append(("office", None, *engine.read(data_folder(None) / "real/office_27k.ply"), None))
    makers = [ours] + ([coacd, vhacd] if arguments.peers else [])
    for name, solid, vertices, faces, count in cases:
        if arguments.only and arguments.only not in name:
            continue
        for make in makers:
            begun = time.process_time()
            try:
                found = make(vertices, faces, count, arguments)
            except ImportError as error:
                print(f"{name:24} {make.__name__:6} {error}")
                continue
            seconds = time.process_time() - begun
            columns = judge(found, vertices, faces, solid, arguments.open) | {"seconds": f"{seconds:.2f}"}
            print(f"{name:24} {make.__name__:6} " + "  ".join(f"{k} {v}" for k, v in columns.items()), flush=True)


if __name__ == "__main__":
    main()
