"""Times the engine's phases on one mesh, in one process and in turn, so that their ratios hold on a busy machine.

    python -m bench.timer.cases MESH PROXIES [--rounds 3] [--inner 3] [--edits 200] [--loop 0] [--cases A,B]
        [--whole-way]

MESH is a file, or made:KIND:FACES (bench/timer/meshes.py). Prints JSON, which run.py makes tables and plots of.
--inner: runs of a short case in each round. --cases: the beginnings of their names. --whole-way: in place of cases
one pass from file to file, with its peak of memory.
"""

from __future__ import annotations

import argparse
import ctypes
import json
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import isimp_engine as engine
from bench.files import write_ply
from bench.quality.fingerprints import fingerprint
from bench.timer import meshes
from bench.timer.reference import Surface

SCORED = 20  # edits that are judged: judging takes longer than editing
DETAIL, FINEST = 0.005, 0.00125
ONCE = ("reference", "teleport", "bound", "add", "delete", "polygonize", "write")  # run once a round


def timed(work: Callable[[], Any]) -> tuple[Any, list[float]]:
    """The result, and milliseconds: of the processor, of it for the calling thread alone, and elapsed."""
    clocks = (time.process_time, time.thread_time, time.perf_counter)
    begun = [clock() for clock in clocks]
    result = work()
    return result, [1e3 * (clock() - at) for clock, at in zip(clocks, begun, strict=True)]


class Cases:
    """The cases by name: functions of a round, which return times and facts."""

    def __init__(self, file: str, arrays: tuple, proxies: int, edits: int) -> None:
        self.file, self.arrays, self.mesh = file, arrays, engine.Mesh(*arrays)
        self.surface, self.edits = Surface(*arrays), edits
        self.proxies = min(proxies, len(arrays[1]))
        self.made: dict[str, Any] = {}
        rest = {"proxies": None}
        bounds = {"fine": 0.0025, "mid": 0.005, "coarse": 0.01}
        size = self.mesh.report["diagonal"]
        fewer = lambda k: {"proxies": max(self.proxies - self.proxies // 5 - k, 1)}  # noqa: E731
        self.all: dict[str, Callable[[int], tuple[list, dict]]] = {
            "read": lambda k: self.plain(lambda: engine.read(file)),
            "mesh": lambda k: self.plain(lambda: engine.Mesh(*arrays)),
            "clean": lambda k: self.plain(lambda: engine.clean(*arrays)),
            "close": lambda k: self.plain(lambda: engine.openings.closed_for(self.mesh, self.proxies)),
            "reference": self.reference,
            "lloyd": lambda k: self.partition(k, method="lloyd"),
            "default": self.partition,
            "default_two_threads": lambda k: self.partition(k, threads=2),
            "teleport": lambda k: self.partition(k, method="teleport"),
            "new_count": lambda k: self.kept("count", k, fewer),
            "new_count_two_threads": lambda k: self.kept("count 2", k, fewer, threads=2),
            "new_detail": lambda k: self.kept("detail", k, self.detail(DETAIL)),
            "new_detail_two_threads": lambda k: self.kept("detail 2", k, self.detail(DETAIL), threads=2),
            "new_detail_finest": lambda k: self.kept("finest", k, self.detail(FINEST)),
            "new_detail_adapted": lambda k: self.kept("adapted", k, self.detail(DETAIL), adaptivity=0.25),
            **{
                f"bound_{name}": lambda k, share=share: self.partition(k, **rest, bound=share * size, noise=0.0)
                for name, share in bounds.items()
            },
            "add": lambda k: self.edit(k, engine.add_proxy),
            "delete": lambda k: self.edit(k, engine.delete_proxy),
            "polygonize": lambda k: self.polygonize(),
            "polygonize_two_threads": lambda k: self.polygonize(threads=2),
            "polygonize_planar": lambda k: self.polygonize(planar=True),
            "write": self.write,
        }
        if file.startswith("made:"):
            del self.all["read"]

    def options(self, seed: int, **more: Any) -> engine.PartitionOptions:
        return engine.PartitionOptions(**{"proxies": self.proxies, "seed": seed, "threads": 1} | more)

    def base(self) -> engine.Partition:
        """A converged partition to edit and to make polygons of, made at its first use."""
        if "base" not in self.made:
            self.made["base"] = engine.partition(self.mesh, self.options(1))
        return self.made["base"]

    @staticmethod
    def detail(value: float) -> Callable[[int], dict]:
        """Another detail, as by the slider of the panel."""
        return lambda round_: {"proxies": None, "detail": value * (1 + 0.01 * round_)}

    @staticmethod
    def plain(work: Callable[[], Any]) -> tuple[list, dict]:
        return [timed(work)[1]], {}

    def scored(self, part: engine.Partition, lap: list) -> tuple[list, dict]:
        return [lap], self.surface.score(np.asarray(part.face_region)) | {"rounds": len(part.history)}

    def reference(self, round_: int) -> tuple[list, dict]:
        (label, _, spent), lap = timed(lambda: self.surface.reference(self.proxies, round_))
        return [lap], self.surface.score(label) | {"round_ms": spent.tolist()}

    def partition(self, round_: int, **more: Any) -> tuple[list, dict]:
        mesh, options = engine.Mesh(*self.arrays), self.options(round_, **more)  # nothing is kept from before
        return self.scored(*timed(lambda: engine.partition(mesh, options)))

    def kept(self, name: str, round_: int, more: Callable[[int], dict], **always: Any) -> tuple[list, dict]:
        """Another number of regions of a mesh that has been partitioned: a moved slider."""
        if name not in self.made:
            self.made[name] = engine.Mesh(*self.arrays)
            first = {} if name.startswith("count") else more(0)
            engine.partition(self.made[name], self.options(0, **first | always))
        options = self.options(round_, **more(round_) | always)
        return self.scored(*timed(lambda: engine.partition(self.made[name], options)))

    def edit(self, round_: int, edit: Callable[..., engine.Partition]) -> tuple[list, dict]:
        """An edit at random faces of one partition, its labels included; its error against a full run for as many."""
        laps, errors, last, refused, base = [], [], None, 0, self.base()

        def work(face: int) -> tuple[engine.Partition, np.ndarray]:
            after = edit(self.mesh, base, face)
            return after, np.array(after.face_region)

        for face in np.random.default_rng(round_).integers(0, len(self.arrays[1]), self.edits).tolist():
            try:
                (after, label), lap = timed(lambda face=face: work(face))
            except engine.InvalidInput:
                refused += 1  # a region of one face, or the last one of its part
                continue
            laps.append(lap)
            if len(errors) < SCORED:
                errors.append(self.surface.score(label)["error"])
            last = after
        if last is None:
            return laps, {"refused": refused}
        full = engine.partition(self.mesh, self.options(round_, proxies=last.region_count))
        whole = self.surface.score(np.asarray(full.face_region))["error"]
        return laps, {"refused": refused, "errors": errors, "error_of_full_run": whole}

    def polygonize(self, **more: Any) -> tuple[list, dict]:
        part, options = self.base(), engine.MeshingOptions(**{"threads": 1} | more)
        poly, lap = timed(lambda: engine.polygonize(self.mesh, part, options))
        facts = {name: poly.report[name] for name in ("polygons", "regions", "corners", "closed", "manifold")}
        return [lap], facts | {"fingerprint": fingerprint(poly.vertices, poly.loops, poly.loop_start)}

    def write(self, round_: int) -> tuple[list, dict]:
        poly = engine.polygonize(self.mesh, self.base())
        with tempfile.TemporaryDirectory() as folder:
            return self.plain(lambda: engine.write(Path(folder) / "polygons.ply", poly))

    def run(self, wanted: list[str], rounds: int, inner: int) -> dict[str, list]:
        """By case and round: each run with its facts and a list of each clock."""
        names = [name for name in self.all if not wanted or name.startswith(tuple(wanted))]
        runs: dict[str, list] = {name: [] for name in names}
        for number in range(1, rounds + 1):
            for name in names:
                runs[name].append([])
                for _ in range(1 if name.startswith(ONCE) else inner):
                    laps, facts = self.all[name](number)
                    clocks = dict(zip(("cpu_ms", "own_ms", "wall_ms"), zip(*laps, strict=True), strict=False))
                    runs[name][-1].append(facts | clocks)
        return runs


def memory(key: str) -> int:
    """Bytes of a line such as "VmHWM: 1234 kB" of the kernel's figures for this process."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return 1024 * next(int(line.split()[1]) for line in lines if line.startswith(key))


def begin_of_phase() -> int:
    """Returns free memory to the system, resets the kernel's peak, and gives the resident bytes."""
    ctypes.CDLL(None).malloc_trim(0)
    Path("/proc/self/clear_refs").write_text("5\n")
    return memory("VmRSS")


def whole_way(name: str, loop: int, proxies: int) -> dict[str, Any]:
    """One pass from a file, or arrays, to polygons in a file: the time of each phase, and the peak of memory."""
    first, peak, phases = begin_of_phase(), 0, {}

    def phase(title: str, work: Callable[[], Any]) -> Any:
        nonlocal peak
        begin_of_phase()
        result, (cpu, _, wall) = timed(work)
        peak = max(peak, memory("VmHWM") - first)
        phases[title] = {"cpu_ms": cpu, "wall_ms": wall}
        return result

    arrays = [phase("read", lambda: meshes.load(name, loop))]
    array_bytes = sum(array.nbytes for array in arrays[0])
    mesh = phase("mesh", lambda: engine.Mesh(*arrays.pop()))
    options = engine.PartitionOptions(proxies=min(proxies, len(mesh.triangles)), threads=1)
    part = phase("partition", lambda: engine.partition(mesh, options))
    poly = phase("polygonize", lambda: engine.polygonize(mesh, part, engine.MeshingOptions(threads=1)))
    with tempfile.TemporaryDirectory() as folder:
        phase("write", lambda: engine.write(Path(folder) / "polygons.ply", poly))
        path, least = Path(folder) / "scan.ply", {}
        write_ply(path, mesh.vertices, mesh.triangles)
        for _ in range(5):  # binary PLY by one thread and by two, in turn
            for title, threads in (("one", 1), ("two", 2)):
                _, (cpu, _, wall) = timed(lambda threads=threads: engine.read(path, threads=threads))
                known = least.get(title, {"cpu_ms": cpu, "wall_ms": wall})
                least[title] = {"cpu_ms": min(cpu, known["cpu_ms"]), "wall_ms": min(wall, known["wall_ms"])}
    return {"phases": phases, "array_bytes": array_bytes, "peak_bytes": peak, "read_on_threads": least}


def main(words: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh")
    parser.add_argument("proxies", type=int)
    for name, default in (("rounds", 3), ("inner", 3), ("edits", 200), ("loop", 0)):
        parser.add_argument(f"--{name}", type=int, default=default)
    parser.add_argument("--cases", default="")
    parser.add_argument("--whole-way", action="store_true")
    given = parser.parse_args(words)
    found: dict[str, Any] = {"proxies": given.proxies}
    if given.whole_way:
        found["whole_way"] = whole_way(given.mesh, given.loop, given.proxies)
    else:
        cases = Cases(given.mesh, meshes.load(given.mesh, given.loop), given.proxies, given.edits)
        found["mesh"] = {name: cases.mesh.report[name] for name in ("faces", "vertices", "area", "diagonal")}
        found["cases"] = cases.run([name for name in given.cases.split(",") if name], given.rounds, given.inner)
    print(json.dumps(found))


if __name__ == "__main__":
    main()
