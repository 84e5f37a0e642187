"""The jobs for each mesh, and the code that runs them: each is one process that prints JSON, or CGAL's program."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bench.files import ROOT

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
    """Cases of one mesh, or CGAL's method on it. The table finds the result by `name`."""

    name: str
    mesh: str  # a path below the data folder, or made:KIND:FACES
    proxies: int
    options: tuple[str, ...] = ()
    seeding: str = ""  # for CGAL


def cases(name: str, mesh: str, proxies: int, rounds: int, *options: str) -> Job:
    return Job(f"{name}/{proxies}", mesh, proxies, ("--rounds", str(rounds), *options))


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
    plan += [Job(f"whole-way/{name}/500", SCANS[name], 500, ("--whole-way",)) for name in ("dragon", "armadillo")]
    plan.append(Job("whole-way/dragon-loop/2000", SCANS["dragon"], 2000, ("--whole-way", "--loop", "1")))
    plan += [
        Job(f"cgal/{name}/500/random", SCANS[name], 500, (), "random") for name in ("bunny", "armadillo", "dragon")
    ]
    plan.append(Job("cgal/armadillo/500/hierarchical", SCANS["armadillo"], 500, (), "hierarchical"))
    return plan


def growth(*, quick: bool) -> list[Job]:
    """Time and error over the number of faces, each region having as many, and over the number of regions."""
    faces = (1000, 2000, 4000) if quick else (10_000, 30_000, 100_000, 300_000, 1_000_000, 3_000_000, 10_000_000)
    counts = (5, 20, 80) if quick else (10, 30, 100, 300, 1000, 3000, 10_000)
    plan = []
    for n in faces:
        names = "mesh,reference,lloyd,default" if n <= 1_000_000 else "mesh,lloyd,default"  # REF would take minutes
        options = ("--rounds", "3" if n < 500_000 else "1", "--cases", names)
        plan.append(Job(f"faces/{n}", f"made:torus:{n}", n // FACES_A_REGION, options))
    mesh = "made:torus:4000" if quick else "made:torus:1000000"
    few = ("--rounds", "1", "--cases", "reference,lloyd,default")
    return plan + [Job(f"regions/{p}", mesh, p, few) for p in counts]


def quick() -> list[Job]:
    """The same kinds of jobs, small enough for a test. CGAL's program takes half a minute to compile."""
    small = ("--inner", "2", "--edits", "6")
    return [
        cases("torus", "made:torus:4000", 40, 2, *small),
        cases("components", "made:boxes:240", 80, 1, *small),
        cases("slivers", "made:slivers:2000", 20, 1, *small),
        cases("coplanar", "made:plane:800", 8, 1, *small),
        cases("one-region", "made:plane:800", 1, 1, *small),
        Job("whole-way/torus-loop/40", "made:torus:2000", 40, ("--whole-way", "--loop", "1")),
    ]


def timed_cases(mesh: str, proxies: int, options: tuple[str, ...], package: Path | None = None) -> Any:
    """package: the folder of another engine than this process has."""
    command = [sys.executable, "-m", "bench.timer.cases", mesh, str(proxies), *options]
    environment = os.environ | ({"PYTHONPATH": str(package)} if package else {})
    return json.loads(subprocess.run(command, cwd=ROOT, env=environment, check=True, stdout=subprocess.PIPE).stdout)


def timed_cgal(name: str, proxies: int, seeding: str) -> dict[str, Any]:
    """CGAL's figures and score, and the times of rounds of the plain method before and after it."""
    import isimp_engine as engine
    from bench.peers.peers import cgal
    from bench.timer import meshes
    from bench.timer.reference import Surface

    arrays = meshes.load(name)
    surface, rounds = Surface(*arrays), []
    rounds += surface.reference(proxies, rounds=3)[2].tolist()
    with tempfile.TemporaryDirectory() as folder:
        found, labels, _, _ = cgal(engine.Mesh(*arrays), proxies, seeding, Path(folder))
    rounds += surface.reference(proxies, rounds=3)[2].tolist()
    return found | {"reference_round_ms": rounds, "result": surface.score(labels)}


class Runner:
    """Runs jobs one after another, and reports the progress on stderr."""

    def __init__(self, data: Path | None) -> None:
        self.data, self.failed = data, list[str]()

    def run(self, plan: list[Job]) -> dict[str, Any]:
        results: dict[str, Any] = {}
        for job in plan:
            mesh = job.mesh if job.mesh.startswith("made:") else str((self.data or Path()) / job.mesh)
            if mesh != job.mesh and not Path(mesh).exists():
                print(f"{job.name}: left out, for want of {mesh}", file=sys.stderr)
                continue
            start = time.monotonic()
            try:
                if job.seeding:
                    results[job.name] = timed_cgal(mesh, job.proxies, job.seeding)
                else:
                    results[job.name] = timed_cases(mesh, job.proxies, job.options)
            except (RuntimeError, subprocess.CalledProcessError) as error:
                self.failed.append(job.name)
                print(f"{job.name}: {error}", file=sys.stderr)
            print(f"{job.name}: {time.monotonic() - start:.1f} s", file=sys.stderr)
        return results
