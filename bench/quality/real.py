"""Measures the command with its defaults on real objects: cartons, open buildings, rooms, chunks, grids, drawn houses.

    python -m bench.quality.real [--only carton,room] [--data DIR] [--json OUT] [--against OLD] [-- FLAGS]
    python -m bench.quality.real --houses 1:31

A row a scan. Twins of each family are made by real_scans.py; scans of DIR/real follow if the folder is there. FLAGS
go to `isimp simplify`. With --against, the row of an earlier run stands above each.

--houses counts regions at the default detail only: each of these seeds is scanned once, and has noise of .1 and .3 %
of its diagonal. Seeds 1:31 were used to choose constants, 31:61 were not.

Columns:
  P         requested number of regions; - if the command finds the number
  regions   number in the result, and the true number of planes if it is known
  polys     polygons; tris: triangles that they make; corners: mean of a polygon
  rim       corners of polygons at the rim that are on it, mean
  mean 99%  distance of the scan's vertices from the polygons, % of the diagonal
  defects   polygons that cross themselves, are flipped or bent, and pairs that meet where the scan does not
  cpu       seconds of processor, of the command in all
"""

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import isimp_engine as engine
from bench.files import DATA, write_ply
from bench.generators import real_scans
from tests.shared.polygon_judge import distances

COLUMNS = ("P", "regions", "true", "polys", "tris", "corners", "rim", "mean", "99%", "defects", "cpu")
POINTS = 500  # vertices of a scan whose distance is measured


def scans(data: Path | None) -> Iterator[tuple[str, np.ndarray, np.ndarray, int | None, int | None, list[str]]]:
    """Name, vertices, triangles, true number of planes, regions to ask for, options."""
    for seed in (1, 2):
        yield f"carton-{seed}", *real_scans.carton(seed), 6, None, []
    yield "carton-sharp", *real_scans.carton(1), 6, None, ["--detail", "0.0025"]
    for seed in (1, 2):
        yield f"building-{seed}", *real_scans.open_building(seed), None, 12, []
    for seed in (1, 2, 3):
        yield f"room-{seed}", *real_scans.room(seed), None, 100, []
    for seed in (1, 2):
        yield f"chunks-{seed}", *real_scans.chunks(seed), 6, None, []
    for seed in (1, 2, 3, 4, 8, 10):
        for turn in (0.0, 31.0):
            true = real_scans.house_planes(seed)
            yield f"grid-{seed}-{turn:.0f}", *real_scans.grid_house(seed, turn=turn), true, None, []
            yield f"sdf-{seed}-{turn:.0f}", *real_scans.grid_house(seed, binary=False, turn=turn), true, None, []
    for noise in (0.001, 0.003):
        for seed in range(1, 31):
            house = real_scans.drawn_house(seed, noise)
            yield f"house-{noise:.1%}-{seed}", *house, real_scans.house_planes(seed), None, []
    if data is not None:
        for path in sorted((data / "real").glob("*.ply")):
            vertices, triangles = engine.read(str(path))
            wanted = 100 if "office" in path.name else None
            yield path.stem, vertices, triangles, None, wanted, []


def rim_corners(loops: list[np.ndarray]) -> float:
    """Returns the mean number of corners on the rim, over the polygons at the rim."""
    ends = [np.stack([q, np.roll(q, -1)], 1) for q in loops]
    edges = np.sort(np.concatenate(ends), 1)
    _, index, used = np.unique(edges, axis=0, return_inverse=True, return_counts=True)
    lone = used[index.ravel()] == 1
    start = np.cumsum([0, *(len(q) for q in loops)])
    on = [np.unique(ends[k][lone[start[k] : start[k + 1]]]) for k in range(len(loops))]
    count = [len(q) for q in on if len(q)]
    return float(np.mean(count)) if count else 0.0


def row(vertices: np.ndarray, triangles: np.ndarray, true: int | None, wanted: int | None, options: list[str]) -> dict:
    with tempfile.TemporaryDirectory() as folder:
        scan, out, report = (Path(folder) / name for name in ("scan.ply", "out.ply", "report.json"))
        write_ply(scan, vertices, triangles)
        how = ["--proxies", str(wanted)] if wanted and "--triangles" not in options else []
        command = [sys.executable, "-m", "isimp_engine", "simplify", str(scan), str(out), "--report", str(report)]
        before = _children()
        subprocess.run([*command, "--quiet", "--threads", "1", *how, *options], check=True)
        cpu = _children() - before
        told = json.loads(report.read_text())
        points, loops, starts = engine.reading.read_polygons(str(out))
        flat, _ = engine.regions.triangulate(points, loops, starts)
    rng = np.random.default_rng(0)
    used = np.unique(triangles)
    some = vertices[rng.choice(used, min(POINTS, len(used)), replace=False)]
    away = 100 * distances(some, points, flat) / np.linalg.norm(np.ptp(vertices[used], axis=0))
    polygons = np.split(loops, starts[1:])
    result = told["output"]
    return {
        "P": wanted,
        "regions": told["regions"],
        "true": true,
        "polys": len(starts),
        "tris": len(loops) - 2 * len(starts),
        "corners": len(loops) / len(starts),
        "rim": rim_corners(polygons),
        "mean": float(away.mean()),
        "99%": float(np.quantile(away, 0.99)),
        "defects": sum(result[key] for key in ("crossing", "flipped", "bent", "intersecting")),
        "cpu": cpu,
    }


def _children() -> float:
    import resource

    of = resource.getrusage(resource.RUSAGE_CHILDREN)
    return of.ru_utime + of.ru_stime


def line(name: str, values: dict) -> str:
    def text(column: str) -> str:
        value = values.get(column)
        return "-" if value is None else f"{value:.2f}" if isinstance(value, float) else str(value)

    return f"{name:18}" + "".join(f"{text(column):>9}" for column in COLUMNS)


def totals(rows: dict[str, dict]) -> Iterator[str]:
    """By family with a true number: how many are right, and within two."""
    families: dict[str, list[int]] = {}
    for name, values in rows.items():
        if values["true"] is not None:
            families.setdefault(
                name.rsplit("-", 1)[0].split("-")[0] + name[6:10] * name.startswith("house"), []
            ).append(abs(values["regions"] - values["true"]))
    for family, off in families.items():
        yield f"{family}: {off.count(0)} of {len(off)} right, {sum(k <= 2 for k in off)} within two"


def houses(seeds: range) -> None:
    """Prints the found number of regions less the true number of planes, house by house."""
    off: dict[float, list[int]] = {0.001: [], 0.003: []}
    for seed in seeds:
        points, faces = real_scans.clean_house(seed)
        true = real_scans.planes_of(seed, points, faces)
        for noise, found in off.items():
            mesh = engine.clean(*real_scans.noisy(seed, points, faces, noise))
            found.append(engine.partition(mesh, engine.PartitionOptions(threads=1)).region_count - true)
        print(
            f"house {seed:3}: {true:3} planes, " + ", ".join(f"{k:.1%} {v[-1]:+d}" for k, v in off.items()), flush=True
        )
    for noise, found in off.items():
        print(f"{noise:.1%}: {found.count(0)} of {len(found)} right, {sum(abs(k) <= 2 for k in found)} within two")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", help="beginnings of names, separated by commas")
    parser.add_argument("--data", type=Path, default=DATA, help="folder with real/*.ply")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--against", type=Path)
    parser.add_argument("--houses", help="seeds FROM:TO of drawn houses: count their regions and nothing else")
    parser.add_argument("options", nargs="*")
    arguments = parser.parse_args()
    if arguments.houses:
        houses(range(*map(int, arguments.houses.split(":"))))
        return
    before = json.loads(arguments.against.read_text()) if arguments.against else {}
    rows = {}
    print(line("", {column: column for column in COLUMNS}))
    for name, vertices, triangles, true, wanted, options in scans(arguments.data if arguments.data.is_dir() else None):
        if arguments.only and not name.startswith(tuple(arguments.only.split(","))):
            continue
        rows[name] = row(vertices, triangles, true, wanted, [*options, *arguments.options])
        if name in before:
            print(line("  before", before[name]))
        print(line(name, rows[name]), flush=True)
    for text in totals(rows):
        print(text)
    if arguments.json:
        arguments.json.write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
