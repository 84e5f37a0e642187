"""Meshes that once took too long, at several sizes: time and work a face, so that a steep growth shows.

    python -m bench.timer.families              builds the benchmarks and prints the table
    python -m bench.timer.families --bin DIR    with programs that are built already
    python -m bench.timer.families --quick      the smallest sizes only

*work* counts faces walked over, corners placed and polygons judged: it is the same on every machine. *growth* is work a
face relative to the smallest size of the family: 1 where it is linear. Times are ratios to one pass of the plain
reference on the same mesh in the same process.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from statistics import median
from typing import Any

from bench.timer import jobs, run

FAMILIES = {  # kind: sizes in faces, regions
    "sheet": ((256, 2304, 16_000, 160_000), 1),
    "plate": ((672, 6048, 16_800, 105_000, 420_000), 6),
    "perforated": ((2560, 23_040, 64_000, 256_000, 1_600_000), 6),
    "sponge": ((144, 2000, 36_000), 200),
    "soup": ((1000, 10_000, 100_000), 0),
}
COLUMNS = ("mesh", "faces", "regions", "polygons", "imperfect", "polygonize, s", "REF rounds", "work a face", "growth")
LINEAR = 3.0  # times the work a face of the smallest size, beyond which a family is named as steep


def plan(*, quick: bool) -> list[jobs.Job]:
    options = ("--rounds", "1", "--inner", "1", "--cases", "reference,polygonize")
    return [
        jobs.Job(f"{kind}/{faces}", "isimp_bench", f"made:{kind}:{faces}", regions or faces, 0, options)
        for kind, (sizes, regions) in FAMILIES.items()
        for faces in (sizes[:2] if quick else sizes)
    ]


def row(name: str, result: dict[str, Any], first: dict[str, float]) -> tuple[list[str], float]:
    mesh, cases = result["mesh"], result["cases"]
    reference, meshing = cases["reference"][0][0], cases["polygonize"][0][0]
    seconds = meshing["cpu_ms"][0] / 1000
    per_round = median(reference["round_ms"]) / 1000
    a_face = meshing["work"] / mesh["faces"]
    growth = a_face / first.setdefault(name.split("/")[0], a_face)
    figures = [mesh["faces"], meshing["regions"], meshing["polygons"], meshing["imperfect"]]
    return [
        name,
        *map(str, figures),
        f"{seconds:.3f}",
        f"{seconds / per_round:.1f}" if per_round else "",
        f"{a_face:.1f}",
        f"{growth:.2f}",
    ], growth


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", type=Path, help="folder of programs that are built already (default: builds them)")
    parser.add_argument("--out", type=Path, default=run.ROOT / "out" / "bench", help="where scratch files go")
    parser.add_argument("--quick", action="store_true", help="the smallest sizes only")
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    runner = jobs.Runner(args.bin or run.build(run.ROOT, run.ROOT / "build-bench"), None, args.out, None)
    results = runner.run(plan(quick=args.quick))
    first: dict[str, float] = {}
    steep = []
    print("| " + " | ".join(COLUMNS) + " |\n" + "|---" * len(COLUMNS) + "|")
    for name, result in results.items():
        cells, growth = row(name, result, first)
        print("| " + " | ".join(cells) + " |")
        if growth > LINEAR:
            steep.append(name)
    if steep:
        print(f"\nMore than {LINEAR:g} times the work a face of the smallest: {', '.join(steep)}")
    return 1 if runner.failed else 0


if __name__ == "__main__":
    sys.exit(main())
