"""Runs the benchmarks and prints the measured and the wanted figures.

    python -m bench.timer.run                          the table, on the meshes of a data folder
    python -m bench.timer.run --only bunny,scan        only the jobs whose names hold one of these words
    python -m bench.timer.run --plots docs/images      also plots of time and error over faces and over regions
    python -m bench.timer.run --base main --head HEAD  two commits against each other
    python -m bench.timer.run --quick                  a minute or less on small made meshes: does everything run?

Times on a machine that others use are worth little; ratios from one process are worth more. So every process runs the
plain reference too, alternating with the compared method, and the table has ratios. `isimp_engine` must be importable,
and a C++ compiler be there for the reference; with --base two commits are built.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import mean, median
from typing import Any

from bench.files import ROOT, data_folder
from bench.timer import jobs, table


def build(source: Path) -> Path:
    """Builds the Python module of a checkout, and returns the folder of the package."""
    python = [sys.executable, "-m", "pybind11", "--cmakedir"]
    pybind = subprocess.run(python, check=True, capture_output=True, text=True).stdout.strip()
    options = ["-DISIMP_PYTHON=ON", "-DISIMP_CUDA=OFF", "-DCMAKE_BUILD_TYPE=Release", f"-Dpybind11_DIR={pybind}"]
    folder = source / "build-bench"
    configure = ["cmake", "-S", source, "-B", folder, "-G", "Ninja", f"-DPython_EXECUTABLE={sys.executable}", *options]
    compiler_cache = {"CCACHE_BASEDIR": str(source), "CCACHE_NOHASHDIR": "1"}  # shared by checkouts of the same sources
    for command in (configure, ["ninja", "-C", folder, "-j2", "isimp_python"]):
        result = subprocess.run(command, capture_output=True, text=True, env=os.environ | compiler_cache)
        if result.returncode:
            sys.exit(f"{' '.join(map(str, command))} failed:\n{result.stdout[-4000:]}{result.stderr[-4000:]}")
    return folder / "python"


def git(*words: str) -> str:
    done = subprocess.run(["git", "-C", str(ROOT), *words], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"git {' '.join(words)} failed: {done.stderr}")
    return done.stdout.strip()


def compare(base: str, head: str, data: Path | None, rounds: int) -> list[table.Row]:
    """How each case's time and error changed: both commits in folders of their own, run in turn on the same meshes."""
    meshes = {name: str(data / jobs.SCANS[name]) for name in ("bunny", "armadillo")} if data else {}
    meshes = meshes or {"torus": "made:torus:20000"}
    runs: dict[str, dict[str, list]] = {name: {base: [], head: []} for name in meshes}
    with tempfile.TemporaryDirectory(prefix="isimp-bench-") as folder:
        checkouts = {revision: Path(folder) / str(place) for place, revision in enumerate((base, head))}
        try:
            packages = {}
            for revision, checkout in checkouts.items():
                git("worktree", "add", "--detach", str(checkout), revision)
                packages[revision] = build(checkout)
            for name, mesh in meshes.items():
                for _ in range(rounds):
                    for revision, package in packages.items():
                        options = ("--rounds", "1", "--edits", "50")
                        runs[name][revision].append(jobs.timed_cases(mesh, 500, options, package))
        finally:
            for checkout in checkouts.values():
                if checkout.exists():
                    git("worktree", "remove", "--force", str(checkout))
    return [row for name, pair in runs.items() for row in compared(name, pair[base], pair[head])]


def compared(name: str, base: list[Any], head: list[Any]) -> list[table.Row]:
    """Times are divided by that of one pass of the plain reference in the same process, which cancels the machine."""
    rows = []
    for case in head[0]["cases"]:
        if case == "reference":
            continue
        a, b = (median(table.per_round(r, case)[0] / table.reference_round(r) for r in runs) for runs in (base, head))
        measured = f"{a:.3f} -> {b:.3f} REF rounds ({table.percent(b / a)})"
        if "error" in head[0]["cases"][case][0][0]:
            c, d = (mean(table.fact(run, case, "error") for run in runs) for runs in (base, head))
            measured += f", D {table.percent(table.relative(d, c))}"
        rows.append(table.Row(case, name, "", measured, None))
    return rows


def machine() -> dict[str, object]:
    info = Path("/proc/cpuinfo")
    fields = (line.split(":", 1) for line in (info.read_text() if info.exists() else "").splitlines() if ":" in line)
    model = next((value.strip() for name, value in fields if name.strip() == "model name"), platform.processor())
    revision = git("describe", "--always", "--dirty")
    return {"processor": model, "cores": os.cpu_count(), "system": platform.platform(), "revision": revision}


def main(words: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", help="folder of the meshes (default: $ISIMP_DATA, else ../shared/data)")
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "bench", help="where the JSON file goes")
    parser.add_argument("--rounds", type=int, default=3, help="how often all cases run in turn; also the seeds tried")
    parser.add_argument("--only", default="", help="run only jobs whose names hold one of these words: a,b,c")
    parser.add_argument("--plots", type=Path, metavar="FOLDER", help="also measure over F and P, and plot")
    parser.add_argument("--quick", action="store_true", help="small made meshes, no judgement of times")
    parser.add_argument("--base", help="a commit to compare with")
    parser.add_argument("--head", help="the commit that is compared (default with --base: HEAD)")
    args = parser.parse_args(words)
    data = data_folder(args.data)
    if args.base or args.head:
        rows = compare(args.base or "main", args.head or "HEAD", None if args.quick else data, args.rounds)
        print(table.text(rows, judge=False))
        return 0
    if not args.quick and data is None:
        sys.exit(
            "No meshes to measure on. Give their folder by --data or ISIMP_DATA (the scans of the Stanford 3D "
            "Scanning Repository and others; their names are in bench/timer/jobs.py), or try --quick, which needs none."
        )
    runner = jobs.Runner(data)
    plan = jobs.quick() if args.quick else jobs.full(args.rounds)
    wanted = [word for word in args.only.split(",") if word]
    results = runner.run([job for job in plan if not wanted or any(word in job.name for word in wanted)])
    report = {"machine": machine(), "quick": args.quick, "results": results}
    if args.plots:
        from bench.timer import plots

        report["growth"] = runner.run(jobs.growth(quick=args.quick))
        args.plots.mkdir(parents=True, exist_ok=True)
        plots.draw(report["growth"], args.plots)
    args.out.mkdir(parents=True, exist_ok=True)
    file = args.out / "bench.json"
    file.write_text(json.dumps(report, indent=1))
    rows = table.rows(results, report.get("growth", {}))
    print(table.text(rows, judge=not args.quick))
    print(f"\nAll figures: {file}" + (f"\nFAILED: {', '.join(runner.failed)}" if runner.failed else ""))
    return 1 if runner.failed or (args.quick and not table.sound(rows, results)) else 0


if __name__ == "__main__":
    sys.exit(main())
