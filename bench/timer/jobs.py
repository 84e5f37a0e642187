"""The jobs for each mesh, and the code that runs them: each job is one process that prints JSON."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

SCANS = {
    "dragon": "scan/dragon_871k.ply",
    "armadillo": "scan/armadillo_346k_loop.ply",
    "castle": "building/openmvs_castle_175k.ply",
    "bunny": "scan/bunny_69k.ply",
}
COUNTS = (100, 500, 2000)
FACES_A_REGION = 400  # where the number of faces grows


@dataclass(frozen=True)
class Job:
    """One process: a program with its arguments. The table finds the result by `name`."""

    name: str
    program: str
    mesh: str  # a path below the data folder, or made:KIND:FACES
    proxies: int
    loop: int = 0
    options: tuple[str, ...] = field(default=())


def cases(name: str, mesh: str, proxies: int, rounds: int, *options: str) -> Job:
    return Job(f"{name}/{proxies}", "isimp_bench", mesh, proxies, 0, ("--rounds", str(rounds), *options))


def full(rounds: int) -> list[Job]:
    """All jobs of the table."""
    plan = [cases(name, mesh, count, rounds) for name, mesh in SCANS.items() for count in COUNTS]
    plan += [
        cases("bunny", SCANS["bunny"], 69451 // 20, rounds),
        cases("armadillo", SCANS["armadillo"], 345928 // 20, 1),
        cases("bunny", SCANS["bunny"], 1, 1),
        cases("fandisk", "building/fandisk_13k.ply", 50, rounds),
        cases("fandisk", "building/fandisk_13k.ply", 200, rounds),
        cases("components", "made:boxes:120000", 40000, 1),
        cases("slivers", "made:slivers:200000", 500, rounds),
        cases("coplanar", "made:plane:200000", 100, rounds),
    ]
    for name in ("dragon", "armadillo"):
        plan.append(Job(f"whole-way/{name}/500", "isimp_bench", SCANS[name], 500, 0, ("--whole-way",)))
    plan.append(Job("whole-way/dragon-loop/2000", "isimp_bench", SCANS["dragon"], 2000, 1, ("--whole-way",)))
    for name in ("bunny", "armadillo", "dragon"):
        plan.append(Job(f"cgal/{name}/500/random", "peer_cgal", SCANS[name], 500, 0, ("random",)))
    plan.append(Job("cgal/armadillo/500/hierarchical", "peer_cgal", SCANS["armadillo"], 500, 0, ("hierarchical",)))
    plan.append(Job("python/dragon/500", "python", SCANS["dragon"], 500, 0, ("200",)))
    return plan


def growth(*, quick: bool) -> list[Job]:
    """Time and error over the number of faces, each region having as many, and over the number of regions."""
    faces = (1000, 2000, 4000) if quick else (10_000, 30_000, 100_000, 300_000, 1_000_000, 3_000_000, 10_000_000)
    counts = (5, 20, 80) if quick else (10, 30, 100, 300, 1000, 3000, 10_000)
    plan = []
    for n in faces:
        several = n < 500_000
        names = "mesh,reference,lloyd,default" if n <= 1_000_000 else "mesh,lloyd,default"  # REF would take minutes
        options = ("--rounds", "3" if several else "1", "--inner", "3", "--cases", names)
        plan.append(Job(f"faces/{n}", "isimp_bench", f"made:torus:{n}", n // FACES_A_REGION, 0, options))
    mesh = "made:torus:4000" if quick else "made:torus:1000000"
    few = ("--rounds", "1", "--inner", "3", "--cases", "reference,lloyd,default")
    plan += [Job(f"regions/{p}", "isimp_bench", mesh, p, 0, few) for p in counts]
    return plan


def quick() -> list[Job]:
    """The same kinds of jobs, small enough for a test."""
    small = ("--inner", "2", "--edits", "6")
    return [
        cases("torus", "made:torus:4000", 40, 2, *small),
        cases("components", "made:boxes:240", 80, 1, *small),
        cases("slivers", "made:slivers:2000", 20, 1, *small),
        cases("coplanar", "made:plane:800", 8, 1, *small),
        cases("one-region", "made:plane:800", 1, 1, *small),
        Job("whole-way/torus-loop/40", "isimp_bench", "made:torus:2000", 40, 1, ("--whole-way",)),
        Job("cgal/torus/40/random", "peer_cgal", "made:torus:4000", 40, 0, ("random",)),
        Job("python/torus/40", "python", "made:torus:4000", 40, 0, ("6",)),
    ]


class Runner:
    """Runs jobs one after another, and reports the progress on stderr."""

    def __init__(self, programs: Path, data: Path | None, scratch: Path, python: str | None) -> None:
        self.programs, self.data, self.scratch, self.python = programs, data, scratch, python
        self.failed: list[str] = []

    def command(self, job: Job) -> list[str] | None:
        """Return the command of a job; None if the program or the mesh is missing."""
        made = job.mesh.startswith("made:")
        mesh = job.mesh if made or self.data is None else str(self.data / job.mesh)
        if not made and not Path(mesh).exists():
            return None
        if job.program == "python":
            script = Path(__file__).with_name("python_edits.py")
            return [self.python, str(script), mesh, str(job.proxies), *job.options] if self.python else None
        program = self.programs / job.program
        if not program.exists():
            return None
        if job.program == "peer_cgal":
            return [str(program), mesh, str(job.loop), str(job.proxies), *job.options]
        where = ["--loop", str(job.loop), "--proxies", str(job.proxies), "--scratch", str(self.scratch)]
        return [str(program), mesh, *where, *job.options]

    def run(self, plan: list[Job]) -> dict[str, Any]:
        results: dict[str, Any] = {}
        for job in plan:
            command = self.command(job)
            if command is None:
                print(f"{job.name}: left out, for want of the program or of {job.mesh}", file=sys.stderr)
                continue
            start = time.monotonic()
            done = subprocess.run(command, capture_output=True, text=True)
            print(f"{job.name}: {time.monotonic() - start:.1f} s", file=sys.stderr)
            if done.returncode:
                self.failed.append(job.name)
                print(f"{' '.join(command)} failed ({done.returncode}):\n{done.stderr}", file=sys.stderr)
            else:
                results[job.name] = json.loads(done.stdout)
        return results
