"""Two commits against each other: both are built in folders of their own, and run in turn on the same meshes."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from statistics import mean, median
from typing import Any

from bench.timer.jobs import SCANS
from bench.timer.table import Row, fact, per_round, percent, reference_round, relative, text


def run(
    root: Path,
    base: str,
    head: str,
    data: Path | None,
    rounds: int,
    build: Callable[[Path, Path], Path],
    quick: bool,
) -> int:
    """Prints how each case's time and error changed from base to head."""
    meshes = {"bunny": SCANS["bunny"], "armadillo": SCANS["armadillo"]} if data and not quick else {}
    inputs = {name: str(data / mesh) for name, mesh in meshes.items() if data} or {"torus": "made:torus:20000"}
    with tempfile.TemporaryDirectory(prefix="isimp-bench-") as folder:
        checkouts = {name: Path(folder) / name for name in (base, head)}
        try:
            programs = {}
            for revision, checkout in checkouts.items():
                git(root, "worktree", "add", "--detach", str(checkout), revision)
                programs[revision] = build(checkout, checkout / "build-bench") / "isimp_bench"
            table = [row for name, mesh in inputs.items() for row in compare(name, mesh, programs, base, head, rounds)]
        finally:
            for checkout in checkouts.values():
                if checkout.exists():
                    git(root, "worktree", "remove", "--force", str(checkout))
    print(text(table, judge=False))
    return 0


def git(root: Path, *words: str) -> None:
    done = subprocess.run(["git", "-C", str(root), *words], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"git {' '.join(words)} failed: {done.stderr}")


def compare(name: str, mesh: str, programs: dict[str, Path], base: str, head: str, rounds: int) -> list[Row]:
    """Times are divided by that of one pass of the plain reference in the same process, which cancels the machine."""
    runs: dict[str, list[Any]] = {base: [], head: []}
    for _ in range(rounds):
        for revision, program in programs.items():
            command = [str(program), mesh, "--rounds", "1", "--edits", "50"]
            done = subprocess.run(command, capture_output=True, text=True, cwd=program.parent)
            if done.returncode:
                sys.exit(f"{revision}: {done.stderr}")
            runs[revision].append(json.loads(done.stdout))
    table = []
    for case in runs[head][0]["cases"]:
        if case not in runs[base][0]["cases"] or case == "reference":
            continue
        took = {r: median(per_round(run, case)[0] / reference_round(run) for run in runs[r]) for r in (base, head)}
        measured = f"{took[base]:.3f} -> {took[head]:.3f} REF rounds ({percent(took[head] / took[base])})"
        if "error" in runs[head][0]["cases"][case][0][0]:
            error = {r: mean(fact(run, case, "error") for run in runs[r]) for r in (base, head)}
            measured += f", D {percent(relative(error[head], error[base]))}"
        table.append(Row(case, name, "", measured, None))
    return table
