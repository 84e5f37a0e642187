"""Measures `isimp tiles`: how good its results are, how much time and memory it takes, and how fast files are read.

    python -m bench.studies.tiles ARGUMENTS
      pieces SCAN PROXIES [1 4 16 64]    compares tiles with one piece: error, borders, distance, defects;
                                          SCAN is a file, city:FACES, or fine:FILE: with the midpoints of edges
                                          as additional vertices and noise of a tenth of an edge (fine:fine: twice)
      detail SCAN DETAIL [1 4 16 64]     compares the numbers of regions that are found
      city FACES PROXIES                 runs a generated city and prints time and memory of each step
      city FACES PROXIES --kill          kills the command twice, and compares the results bit by bit
      read [FACES]                       reads a binary PLY, a text PLY and an OBJ file

Run it with a Python that has isimp_engine. The peaks of memory are the kernel's.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

import isimp_engine as engine
from bench.files import write_ply
from bench.generators.known_shapes import split_in_four
from bench.quality.fit import Surface
from isimp_engine import batch, tiles
from isimp_engine.guides import shared_edges
from isimp_engine.tiles.splitting import Boxes

SAMPLES = 50_000  # vertices whose distance is measured
BLOCK = 20.0  # metres, of the city
Mesh = tuple[np.ndarray, np.ndarray]


def cut(mesh: Mesh, count: int, folder: Path) -> list[np.ndarray]:
    """Writes a mesh as `count` tiles; returns the faces of each."""
    vertices, triangles = mesh
    middles = vertices[triangles].mean(1)
    tile = Boxes(middles, count).find(middles)
    folder.mkdir(parents=True)
    parts = []
    for k in range(int(tile.max()) + 1):
        faces = np.flatnonzero(tile == k)
        used, local = np.unique(triangles[faces], return_inverse=True)
        write_ply(folder / f"{k:03d}.ply", vertices[used], local.reshape(-1, 3))
        parts.append(faces)
    return parts


def labels_of(parts: list[np.ndarray], folder: Path) -> np.ndarray:
    """The regions of the faces of `cut`, from the files of each tile."""
    label = np.empty(sum(map(len, parts)), np.int32)
    for k, faces in enumerate(parts):
        label[faces] = np.load(folder.with_suffix(".labels") / f"{k:03d}.npy")
    return label


def judge(mesh: engine.Mesh, label: np.ndarray) -> tuple[float, float, int]:
    """Error, length of the borders, and number of the regions."""
    vertices, triangles = mesh.vertices, mesh.triangles
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a) / 2
    kept = label >= 0
    count = int(label.max()) + 1
    sums = np.stack([np.bincount(label[kept], normal[kept, k], count) for k in range(3)], 1)
    error = 2 * (np.linalg.norm(normal[kept], axis=1).sum() - np.linalg.norm(sums, axis=1).sum())
    faces, ends = shared_edges(triangles)
    ends = ends[label[faces[:, 0]] != label[faces[:, 1]]]
    length = np.linalg.norm(vertices[ends[:, 0]] - vertices[ends[:, 1]], axis=1).sum()
    return error, float(length), len(np.unique(label[kept]))


def distances(scan: np.ndarray, path: Path) -> tuple[float, float]:
    """Mean and 99th percentile of the distance from vertices of the scan to the polygons of a file."""
    vertices, triangles = engine.read(path)
    chosen = scan[np.random.default_rng(1).permutation(len(scan))[:SAMPLES]]
    found = Surface(vertices[triangles]).distances(chosen)
    return float(found.mean()), float(np.quantile(found, 0.99))


def defects(report: dict[str, Any]) -> str:
    names = ("crossing", "flipped", "bent", "intersecting")
    return " ".join(f"{report[name]} {name}" for name in names if report[name]) or "sound"


def scan_of(path: Path) -> engine.Mesh:
    """The mesh of a file, a finer one (fine:FILE), or that of a generated city (city:FACES)."""
    if str(path).startswith("fine:"):
        vertices, triangles = engine.read(str(path).replace("fine:", ""))
        for _ in range(str(path).count("fine:")):
            vertices, triangles = split_in_four(vertices, triangles)
        edge = np.linalg.norm(vertices[triangles[:, 1]] - vertices[triangles[:, 0]], axis=1).mean()
        noise = np.random.default_rng(1).normal(0, edge / 10, vertices.shape)
        return engine.clean(vertices + noise, triangles.astype(np.int32))
    if not path.name.startswith("city:"):
        return engine.clean(*engine.read(path))
    faces = int(path.name.removeprefix("city:"))
    with tempfile.TemporaryDirectory() as place:
        make_city(Path(place) / "city", faces, faces)
        return engine.clean(*engine.read(next((Path(place) / "city").iterdir())))


def pieces(path: Path, proxies: int, counts: list[int]) -> None:
    mesh = scan_of(path)
    triangles, vertices = mesh.triangles, mesh.vertices
    begun = time.process_time()
    part = engine.partition(mesh, engine.PartitionOptions(proxies=proxies, threads=1))
    poly = engine.polygonize(mesh, part, engine.MeshingOptions(threads=1))
    seconds = time.process_time() - begun
    whole = judge(mesh, part.face_region)
    with tempfile.TemporaryDirectory() as place:
        engine.write(Path(place) / "one.ply", poly)
        mean, most = distances(vertices, Path(place) / "one.ply")
        print(f"{path.stem}: {len(triangles):,} faces, {whole[2]} regions, one piece: {seconds:.1f} s of processor")
        print(f"  error {whole[0]:.5g}, borders {whole[1]:.5g}, mean distance {mean:.4g}, 99 % {most:.4g}", end="")
        print(f", {poly.report['polygons']} polygons, {defects(poly.report)}")
        for count in counts:
            folder, out = Path(place) / f"in{count}", Path(place) / f"{count}.ply"
            parts = cut((vertices, triangles), count, folder)
            begun = time.perf_counter()
            report = tiles.run(folder, out, proxies=proxies, labels=folder.with_suffix(".labels")).report
            seconds = time.perf_counter() - begun
            found = judge(mesh, labels_of(parts, folder))
            own = distances(vertices, out)
            print(
                f"  {count:3d} tiles: error {found[0] / whole[0] - 1:+.1%}, "
                f"borders {found[1] / whole[1] - 1:+.1%}, {found[2]} regions, "
                f"mean distance {own[0] / mean - 1:+.1%}, 99 % {own[1] / most - 1:+.1%}, "
                f"{report['output']['polygons']} polygons, {defects(report['output'])}, "
                f"{len(triangles) / report['thinned_faces']:.1f} x thinned, {seconds:.1f} s"
            )


def detail(path: Path, share: float, counts: list[int]) -> None:
    mesh = scan_of(path)
    triangles, vertices = mesh.triangles, mesh.vertices
    part = engine.partition(mesh, engine.PartitionOptions(detail=share))
    whole = judge(mesh, part.face_region)
    print(
        f"{path.stem}: {len(triangles):,} faces, one piece: {part.region_count} regions, "
        f"noise {part.report['noise']:.3g}"
    )
    with tempfile.TemporaryDirectory() as place:
        for count in counts:
            folder = Path(place) / f"in{count}"
            parts = cut((vertices, triangles), count, folder)
            options, labels = {"detail": share}, folder.with_suffix(".labels")
            report = tiles.run(folder, Path(place) / "o.ply", options=options, labels=labels).report
            found = judge(mesh, labels_of(parts, folder))
            print(
                f"  {count:3d} tiles: {report['regions']} regions, noise {report['noise']:.3g}, "
                f"error {found[0] / whole[0] - 1:+.1%}, borders {found[1] / whole[1] - 1:+.1%}"
            )


READ = """
import os, sys, time
import isimp_engine as engine
peak = lambda: 1024 * int(next(line for line in open("/proc/self/status") if line.startswith("VmHWM")).split()[1])
path, threads = sys.argv[1], int(sys.argv[2])
before, wall, cpu = peak(), time.perf_counter(), time.process_time()
arrays = engine.reading.read_polygons(path, threads=threads)
wall, cpu, faces = time.perf_counter() - wall, time.process_time() - cpu, len(arrays[2])
over = peak() - before - sum(array.nbytes for array in arrays)
size = os.path.getsize(path)
print(f"  {threads} threads: {size / wall / 1e6:5.0f} MB/s, {size / cpu / 1e6:5.0f} MB a second of processor, "
      f"{over / faces:5.1f} B a face above the arrays")
"""


def read(faces: int) -> None:
    n = max(2, round((faces / 2) ** 0.5))
    with tempfile.TemporaryDirectory() as place:
        make_city(Path(place) / "city", 2 * n * n, 2 * n * n)
        binary = next((Path(place) / "city").iterdir())
        vertices, triangles = engine.read(binary)
        rows = [" ".join(f"{x:.6f}" for x in row) for row in (vertices - vertices[0]).tolist()]
        corners = triangles.tolist()
        obj, text = Path(place) / "city.obj", Path(place) / "city.ply"
        obj.write_text(
            "".join(f"v {row}\n" for row in rows) + "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in corners)
        )
        head = f"ply\nformat ascii 1.0\nelement vertex {len(rows)}\n" + "".join(f"property double {k}\n" for k in "xyz")
        head += f"element face {len(corners)}\nproperty list uchar int vertex_indices\nend_header\n"
        text.write_text(head + "\n".join(rows) + "\n" + "".join(f"3 {a} {b} {c}\n" for a, b, c in corners))
        environment = {**os.environ, "PYTHONPATH": str(Path(engine.__file__).parents[1])}
        for name, path in (("PLY, binary", binary), ("PLY, text", text), ("OBJ", obj)):
            print(f"{name}: {len(corners):,} faces, {path.stat().st_size / len(corners):.1f} B a face", flush=True)
            for threads in (1, os.cpu_count() or 1):
                subprocess.run([sys.executable, "-c", READ, str(path), str(threads)], env=environment, check=True)


def block(i: int, j: int, n: int, step: float) -> np.ndarray:
    """Heights of a tile of n by n squares: streets, houses with gables, and noise that depends on the place alone."""
    x, y = np.meshgrid((i * n + np.arange(n + 1)) * step, (j * n + np.arange(n + 1)) * step, indexing="ij")
    cell_x, cell_y = np.floor(x / BLOCK).astype(np.int64), np.floor(y / BLOCK).astype(np.int64)
    key = (cell_x * 73856093 ^ cell_y * 19349663) & 0xFFFF
    u, v = x - cell_x * BLOCK, y - cell_y * BLOCK
    inside = (u > 4) & (u < 16) & (v > 3) & (v < 17)
    roof = 5 + key % 7 + np.where(key % 3 == 0, 0.0, 0.6 * (6 - np.abs(u - 10)))
    noise = np.sin(x * 12.9898 + y * 78.233) * 43758.5453
    return np.where(inside, roof, 0.02 * x) + 0.02 * (noise - np.floor(noise) - 0.5)


def make_city(folder: Path, faces: int, tile_faces: int = 720_000) -> int:
    """A heightfield in map coordinates, as tiles that share their borders bit for bit; returns the number of faces."""
    side = max(1, round((faces / tile_faces) ** 0.5))
    n = round((faces / 2) ** 0.5 / side)
    folder.mkdir(parents=True)
    a = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    triangles = np.concatenate([np.stack([a, a + n + 1, a + n + 2], 1), np.stack([a, a + n + 2, a + 1], 1)])
    for i in range(side):
        for j in range(side):
            x, y = np.meshgrid((i * n + np.arange(n + 1)) * 0.5, (j * n + np.arange(n + 1)) * 0.5, indexing="ij")
            place = np.stack([500_000 + x, 5_000_000 + y, block(i, j, n, 0.5)], -1).reshape(-1, 3)
            write_ply(folder / f"{i:02d}_{j:02d}.ply", place, triangles)
    return side * side * len(triangles)


def city(faces: int, proxies: int, kill: bool, jobs: int) -> None:
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "city"
        faces = make_city(folder, faces)
        command = [sys.executable, "-m", "isimp_engine", "tiles", str(folder)]
        options = ["--proxies", str(proxies), "--jobs", str(jobs), "--quiet"]
        environment = {**os.environ, "PYTHONPATH": str(Path(engine.__file__).parents[1])}
        begun = time.perf_counter()
        report = tiles.run(folder, Path(place) / "a.ply", proxies=proxies, children=batch.Children(jobs)).report
        seconds = time.perf_counter() - begun
        tile = report["largest_tile"]
        print(f"{faces:,} faces in {report['tiles']} tiles, {report['regions']:,} regions: {seconds:.0f} s with {jobs}")
        print(f"  error {report['error']:.6g}, {report['output']['polygons']:,} polygons, {defects(report['output'])}")
        print(f"  borders: {report['border_edges']:,} edges, {report['unmatched_edges']:,} without a partner")
        print(f"  {report['thinned_faces']:,} faces meshed")
        for step, peak in report["peak_mb"].items():
            print(f"  {step:8} peak {peak:6.0f} MB, {peak * 2**20 / tile:5.0f} B a face of a tile")
        print("  seconds:", report["seconds"])
        if not kill:
            return
        for step in ("mend", "thin"):
            process = subprocess.Popen([*command, str(Path(place) / "b.ply"), *options], env=environment)
            while not (Path(place) / ".b.ply.tiles" / step).exists() and process.poll() is None:
                time.sleep(0.02)
            process.kill()
            process.wait()
            print(f"  killed after {step}")
        subprocess.run([*command, str(Path(place) / "b.ply"), *options], env=environment, check=True)
        same = (Path(place) / "a.ply").read_bytes() == (Path(place) / "b.ply").read_bytes()
        print(f"  same bits: {same}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    what = parser.add_subparsers(required=True, dest="what")
    command = what.add_parser("pieces")
    command.add_argument("scan", type=Path)
    command.add_argument("proxies", type=int)
    command.add_argument("counts", type=int, nargs="*", default=[1, 4, 16, 64])
    command = what.add_parser("detail")
    command.add_argument("scan", type=Path)
    command.add_argument("share", type=float)
    command.add_argument("counts", type=int, nargs="*", default=[1, 4, 16, 64])
    command = what.add_parser("read")
    command.add_argument("faces", type=int, nargs="?", default=2_000_000)
    command = what.add_parser("city")
    command.add_argument("faces", type=int)
    command.add_argument("proxies", type=int)
    command.add_argument("--kill", action="store_true")
    command.add_argument("--jobs", type=int, default=2)
    arguments = parser.parse_args()
    if arguments.what == "pieces":
        pieces(arguments.scan, arguments.proxies, arguments.counts)
    elif arguments.what == "detail":
        detail(arguments.scan, arguments.share, arguments.counts)
    elif arguments.what == "read":
        read(arguments.faces)
    else:
        city(*(getattr(arguments, name) for name in ("faces", "proxies", "kill", "jobs")))


if __name__ == "__main__":
    main()
