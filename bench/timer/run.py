"""Runs the benchmarks and prints the measured and the wanted figures.

    python -m bench.timer.run                          the table, on the meshes of a data folder
    python -m bench.timer.run --only bunny,scan        only the jobs whose names hold one of these words
    python -m bench.timer.run --plots docs/images      also plots of time and error over faces and over regions
    python -m bench.timer.run --base main --head HEAD  two commits against each other
    python -m bench.timer.run --quick                  a minute or less on small made meshes: does everything run?

Times on a machine that others use are worth little; ratios from one process are worth more. So every process runs the
plain reference too, alternating with the compared method, and the table has ratios.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
from pathlib import Path

from bench.timer import compare, jobs, plots, table

ROOT = Path(__file__).resolve().parents[2]


def data_folder(given: str | None) -> Path | None:
    """The folder of the meshes: as given, else ISIMP_DATA, else shared/data next to the checkout; None if nowhere."""
    candidates = [given] if given else [os.environ.get("ISIMP_DATA"), ROOT.parent / "shared" / "data"]
    return next((Path(c) for c in candidates if c and Path(c).is_dir()), None)


def build(source: Path, folder: Path) -> Path:
    """Builds the benchmarks of a checkout, and returns the folder of the programs."""
    options = ["-DISIMP_BENCH=ON", "-DISIMP_CUDA=OFF", "-DCMAKE_BUILD_TYPE=Release"]
    configure = ["cmake", "-S", source, "-B", folder, "-G", "Ninja", *options]
    compiler_cache = {"CCACHE_BASEDIR": str(source), "CCACHE_NOHASHDIR": "1"}  # shared by checkouts of the same sources
    for command in (configure, ["cmake", "--build", folder, "-j2", "--target", "bench_programs"]):
        result = subprocess.run(command, capture_output=True, text=True, env=os.environ | compiler_cache)
        if result.returncode:
            sys.exit(f"{' '.join(map(str, command))} failed:\n{result.stdout[-4000:]}{result.stderr[-4000:]}")
    return folder / "bench"


def machine() -> dict[str, object]:
    model = platform.processor()
    info = Path("/proc/cpuinfo")
    if info.exists():
        fields = (line.split(":", 1) for line in info.read_text().splitlines() if ":" in line)
        model = next((value.strip() for name, value in fields if name.strip() == "model name"), model)
    git = ["git", "-C", str(ROOT), "describe", "--always", "--dirty"]
    revision = subprocess.run(git, capture_output=True, text=True).stdout.strip()
    return {"processor": model, "cores": os.cpu_count(), "system": platform.platform(), "revision": revision}


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", help="folder of the meshes (default: $ISIMP_DATA, else ../shared/data)")
    parser.add_argument("--bin", type=Path, help="folder of programs that are built already (default: builds them)")
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "bench", help="where the JSON and scratch files go")
    parser.add_argument("--rounds", type=int, default=3, help="how often all cases run in turn; also the seeds tried")
    parser.add_argument("--only", default="", help="run only jobs whose names hold one of these words: a,b,c")
    parser.add_argument("--python", help="interpreter that can import isimp_engine, for the edits through Python")
    parser.add_argument("--plots", type=Path, metavar="FOLDER", help="also measure over F and P, and plot")
    parser.add_argument("--quick", action="store_true", help="small made meshes, no judgement of times")
    parser.add_argument("--base", help="a commit to compare with")
    parser.add_argument("--head", help="the commit that is compared (default with --base: HEAD)")
    return parser.parse_args()


def main() -> int:
    args = parse()
    args.out.mkdir(parents=True, exist_ok=True)
    data = data_folder(args.data)
    if args.base or args.head:
        return compare.run(ROOT, args.base or "main", args.head or "HEAD", data, args.rounds, build, args.quick)
    if not args.quick and data is None:
        sys.exit(
            "No meshes to measure on. Give their folder by --data or ISIMP_DATA (the scans of the Stanford 3D "
            "Scanning Repository and others; their names are in bench/timer/jobs.py), or try --quick, which needs none."
        )
    programs = args.bin or build(ROOT, ROOT / "build-bench")
    runner = jobs.Runner(programs, data, args.out, args.python)
    plan = jobs.quick() if args.quick else jobs.full(args.rounds)
    words = [word for word in args.only.split(",") if word]
    results = runner.run([job for job in plan if not words or any(word in job.name for word in words)])
    report = {"machine": machine(), "quick": args.quick, "results": results}
    if args.plots:
        report["growth"] = runner.run(jobs.growth(quick=args.quick))
        args.plots.mkdir(parents=True, exist_ok=True)
        plots.draw(report["growth"], args.plots)
    file = args.out / "bench.json"
    file.write_text(json.dumps(report, indent=1))
    rows = table.rows(results, report.get("growth", {}))
    print(table.text(rows, judge=not args.quick))
    print(f"\nAll figures: {file}" + (f"\nFAILED: {', '.join(runner.failed)}" if runner.failed else ""))
    return 1 if runner.failed or (args.quick and not table.sound(rows, results)) else 0


if __name__ == "__main__":
    sys.exit(main())
