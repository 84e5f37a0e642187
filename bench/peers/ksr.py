"""Kinetic surface reconstruction of CGAL 6 as a peer of exactly planar polygons: compiled where its headers are.

It closes a scan by volumes, so that an open one gets additional walls; its polygons are planar, and may meet others in
the middle of an edge.
"""

import os
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np

import isimp_engine as engine
from tests.shared.polygon_judge import distances

HERE = Path(__file__).resolve().parent
POINTS, SAMPLES = 50_000, 3000
# Share of the diagonal; degrees; points. Chosen by hand on the castle: a floor for this method, not its best.
DISTANCE, ANGLE, LEAST, LAMBDA = 0.005, 20, 100, 0.3
PATIENCE = 300  # seconds


def headers() -> Path | None:
    """The folder of scripts/headers.py with CGAL, where that is one with this method."""
    cache = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
    kept = Path(os.environ.get("ISIMP_THIRD_PARTY", cache / "isimp" / "third_party"))
    for folder in (HERE.parents[1] / "third_party", kept, Path("/usr")):
        if (folder / "include" / "CGAL" / "Kinetic_surface_reconstruction_3.h").exists():
            return folder / "include"
    return None


def compiled(folder: Path, name: str = "peer_ksr") -> Path | str:
    """The program of a source here; or why there is none. `peer_ksr` takes three gigabytes of memory and 90 seconds."""
    where, compiler = headers(), os.environ.get("CXX") or shutil.which("c++")
    if where is None:
        return "no headers of CGAL 6: scripts/headers.py fetches them"
    if compiler is None:
        return "no C++ compiler"
    only = folder / "include"  # CGAL alone: that folder has not all of Boost
    only.mkdir()
    (only / "CGAL").symlink_to(where / "CGAL")
    program, system = folder / name, ["-I", str(only), "-I", "/usr/include/eigen3"]
    flags = ["-std=c++20", "-O2", "-DNDEBUG", "-w", *system]
    done = subprocess.run(
        [compiler, *flags, str(HERE / f"{name}.cpp"), "-o", str(program), "-lgmp", "-lmpfr"],
        capture_output=True,
        text=True,
    )
    return program if done.returncode == 0 else f"it did not compile: {done.stderr.strip().splitlines()[-1]}"


def sampled(mesh: engine.Mesh, path: Path) -> None:
    """Points distributed by area, with the normals of vertices, as PLY."""
    vertices, triangles = np.asarray(mesh.vertices), np.asarray(mesh.triangles)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    cross = np.cross(b - a, c - a)
    area, rng = np.linalg.norm(cross, axis=1), np.random.default_rng(1)
    normal = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(normal, triangles[:, k], cross)
    face = rng.choice(len(triangles), POINTS, p=area / area.sum())
    s, t = np.sqrt(rng.random(POINTS))[:, None], rng.random(POINTS)[:, None]
    points = a[face] * (1 - s) + b[face] * s * (1 - t) + c[face] * s * t
    along = normal[triangles[face]].sum(1)
    along /= np.maximum(np.linalg.norm(along, axis=1), 1e-300)[:, None]
    names = "".join(f"property double {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz"))
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {POINTS}\n{names}end_header\n"
    path.write_bytes(head.encode() + np.hstack([points, along]).astype("<f8").tobytes())


def row(program: Path, name: str, mesh: engine.Mesh) -> str:
    """The result for a scan, as a line."""
    vertices = np.asarray(mesh.vertices)
    diagonal = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    with tempfile.TemporaryDirectory() as folder:
        points, result = Path(folder) / "points.ply", Path(folder) / "out.obj"
        sampled(mesh, points)
        settings = map(str, (DISTANCE * diagonal, ANGLE, LEAST, LAMBDA))
        start = time.perf_counter()
        try:
            done = subprocess.run(
                [str(program), str(points), str(result), *settings], capture_output=True, text=True, timeout=PATIENCE
            )
        except subprocess.TimeoutExpired:
            return f"{name}, KSR: no result in {PATIENCE} seconds"
        took = time.perf_counter() - start
        if done.returncode or not result.exists():
            return f"{name}, KSR: ended with {done.returncode}"
        lines = [line.split() for line in result.read_text().splitlines()]
    corners = np.array([line[1:] for line in lines if line[0] == "v"], float)
    polygons = [np.array(line[1:], int) - 1 for line in lines if line[0] == "f"]
    if not polygons:
        return f"{name}, KSR: no polygon"
    fans = np.concatenate([np.stack([p[:-2] * 0 + p[0], p[1:-1], p[2:]], 1) for p in polygons])
    seen = np.random.default_rng(2).choice(vertices, min(SAMPLES, len(vertices)), replace=False)
    away = distances(seen, corners, fans) / diagonal
    sides = [np.sort(np.stack([p, np.roll(p, -1)], 1), axis=1) for p in polygons]
    uses = np.unique(np.concatenate(sides), axis=0, return_counts=True)[1]
    back = corners[np.random.default_rng(3).integers(len(corners), size=min(SAMPLES, len(corners)))]
    beyond = distances(back, vertices, np.asarray(mesh.triangles)) / diagonal
    return (
        f"{name}, KSR: {done.stdout.split()[-1]} shapes, {len(polygons)} polygons, scan to result mean "
        f"{away.mean():.2%}, p99 {np.quantile(away, 0.99):.2%}, corners off the scan mean {beyond.mean():.2%}, largest "
        f"{beyond.max():.1%}; edges of one polygon {(uses == 1).sum()}, of more than two {(uses > 2).sum()}; "
        f"{took:.0f} s"
    )
