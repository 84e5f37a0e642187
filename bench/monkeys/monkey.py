r"""Tries the Python module at random and judges each result: scans, damage, options and edits, all drawn.

    python -m bench.monkeys.monkey --minutes 60 [--seed 1] [--jobs 2] [--most FACES] [--made]
    python -m bench.monkeys.monkey --seed 3 --case 239        repeats one case

A case is a scan (a file of $ISIMP_DATA, else of ../shared/data, or a made shape), cleaned, partitioned, changed by up
to eight edits and meshed. draws.py draws all that, judging.py judges each step. Then the case is
done once more in one of several ways, which must give the same: on 2 and 8 threads, 2^k times as large, cancelled at a
random moment, pickled, or through a file.

Each case runs in a process of its own with limits on time and memory, so that a crash or endless work is a finding too.
A finding is one line, with the command that repeats it. The exit status is 1 if there are any. The same seed and case
draw the same.

With the sanitizers, in a build of them (GCC; Python itself leaks):

    cmake -S . -B build-asan-python -G Ninja -DISIMP_SANITIZE=ON -DISIMP_ASSERTIONS=ON -DISIMP_PYTHON=ON
    cmake --build build-asan-python --target isimp_python
    LD_PRELOAD=$(gcc -print-file-name=libasan.so):$(gcc -print-file-name=libubsan.so) ASAN_OPTIONS=detect_leaks=0 \
      PYTHONPATH=build-asan-python/python python -m bench.monkeys.monkey --minutes 10 --slower 10
"""

import argparse
import faulthandler
import json
import multiprocessing
import os
import pickle
import resource
import sys
import tempfile
import threading
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import isimp_engine as engine
from bench.monkeys import draws, judging
from bench.monkeys.draws import Edit

SECONDS = 60  #: time of the processor that a case may take
WALL = 20  #: times as long it may take on a busy machine, or while it waits
MEMORY = 4 << 30  #: bytes that a case may add
MOST_FACES = 3000
EVERY_EDIT = 0.15  #: share of the cases in which every edit is tried
FACES_OF_EDIT = 3  #: faces at which it is tried then
WAYS = ("threads", "scaled", "cancelled", "pickled", "file")

Say = Callable[[str], None]


@dataclass
class Case:
    """The drawn values. Edits are drawn one after another, since each names faces of the regions before it."""

    name: str
    vertices: np.ndarray
    triangles: np.ndarray
    clean: engine.CleanOptions
    partition: engine.PartitionOptions
    meshing: engine.MeshingOptions
    guides: engine.guided.Guides = field(default_factory=engine.guided.Guides)
    edits: list[Edit] = field(default_factory=list)

    @property
    def guided(self) -> list[str]:
        """The names of the guides."""
        return [name for name, each in vars(self.guides).items() if each is not None]

    @property
    def text(self) -> str:
        """All that was drawn, on one line."""
        given = (self.clean, self.partition, self.meshing)
        told = [str({k: v for k, v in o.as_dict().items() if v != type(o)().as_dict()[k]}) for o in given]
        edits = ", ".join(edit.name for edit in self.edits)
        return f"{self.name}; {len(self.triangles)} faces; {'; '.join(told)}; {self.guided}; {edits}"


@dataclass
class Result:
    """The result of a case."""

    mesh: engine.Mesh
    stages: list[tuple[str, engine.Partition]]
    polygons: engine.PolygonMesh | None
    refused: list[str]


def bits(result: Result, factor: float = 1.0) -> Iterator[tuple[str, bytes]]:
    """The names and bytes that two runs of a case must share. factor: the scale of the case."""
    yield "mesh", np.asarray(result.mesh.triangles).tobytes()
    yield "mesh places", (np.asarray(result.mesh.vertices) / factor).tobytes()
    yield "refused", json.dumps([text.split(",")[0] if factor == 1 else "" for text in result.refused]).encode()
    for name, part in result.stages:
        yield f"{name}: labels", np.asarray(part.face_region).tobytes()
        yield f"{name}: seeds", np.asarray(part.region_seed).tobytes()
        yield f"{name}: normals", np.asarray(part.region_normal).tobytes()
        yield f"{name}: planes", (np.asarray(part.region_offset) / factor).tobytes()
        cells = [[patch["kind"], patch["segments"], patch["rings"], patch["regions"]] for patch in part.curved]
        yield f"{name}: round parts", json.dumps(cells).encode()
    if result.polygons is not None:
        for each in ("loops", "loop_start", "polygon_region", "source_vertex"):
            yield f"polygons: {each}", np.asarray(getattr(result.polygons, each)).tobytes()
        yield "polygons: corners", (np.asarray(result.polygons.vertices) / factor).tobytes()


def difference(one: Result, other: Result, factor: float = 1.0) -> str:
    """The first thing in which two runs differ; empty: none."""
    ours, theirs = dict(bits(one)), dict(bits(other, factor))
    if factor != 1:
        ours["refused"] = theirs["refused"]  # their texts have lengths
    if list(ours) != list(theirs):
        return f"steps: {len(ours)} and {len(theirs)}"
    return next((name for name in ours if ours[name] != theirs[name]), "")


class Monkey:
    """One case: plays it, and finds its faults."""

    def __init__(self, seed: int, number: int, most: int, with_files: bool, say: Say) -> None:
        self.rng = np.random.default_rng([seed, number])
        self.say, self.findings = say, list[str]()
        self.most, self.with_files = most, with_files
        self.done: Counter[str] = Counter()
        self.case: Case | None = None

    def find(self, what: str) -> None:
        if what not in self.findings and len(self.findings) < 20:
            self.findings.append(what)

    def check(self, after: str, found: Iterator[str]) -> None:
        for text in found:
            self.find(f"after {after}: {text}")

    def run(self) -> None:
        name, vertices, triangles = draws.scan(self.rng, self.most, self.with_files)
        size = draws.size_of(vertices)
        drawn = [
            draws.options(kind, self.rng, size, max(1, len(triangles)))
            for kind in (engine.CleanOptions, engine.PartitionOptions, engine.MeshingOptions)
        ]
        self.case = Case(name, vertices, triangles, *drawn)
        try:
            result = self.first()
        except engine.InvalidInput as error:
            self.done["refused"] += 1
            if len(str(error)) < 10:
                self.find(f"refused without a reason: {error}")
            return
        self.done["meshed" if result.polygons is not None else "not meshed"] += 1
        again = str(self.rng.choice(WAYS))
        self.done[again] += 1
        self.say(f"again, {again}")
        getattr(self, again)(result)

    def first(self) -> Result:
        """Play the case, draw its edits, and check each step."""
        case, edits = self.case, int(self.rng.integers(0, draws.MOST_EDITS + 1))
        self.say("clean")
        mesh = engine.clean(case.vertices, case.triangles, case.clean)
        surface = judging.Surface(mesh)
        self.check("clean", judging.mesh_findings(surface))
        case.guides = draws.guides(mesh, self.rng)
        self.say("partition")
        part = engine.guided.partition_guided(mesh, case.partition, None, case.guides)
        self.check("partition", judging.partition_findings(surface, part))
        self.check("partition", judging.first_findings(surface, part, case.partition, bool(case.guided)))
        result = Result(mesh, [("partition", part)], None, [])
        every = int(self.rng.integers(edits)) if edits and self.rng.random() < EVERY_EDIT else -1
        for number in range(edits):
            if number == every:  # each edit at a few faces, none of which counts
                for name in [*draws.functions(), draws.PARTITION] * FACES_OF_EDIT:
                    edit = draws.edit(mesh, part, self.rng, name)
                    self._judged(Result(mesh, [], None, []), surface, edit, part, f"{name} alone")
            case.edits.append(draws.edit(mesh, part, self.rng))
            part = self._judged(result, surface, case.edits[-1], part, case.edits[-1].name)
        self._mesh(result, surface, part)
        return result

    def _judged(
        self, result: Result, surface: judging.Surface, edit: Edit, part: engine.Partition, title: str
    ) -> engine.Partition:
        """The partition after an edit, or the one before where it is refused."""
        self.say(title)
        after = self._edited(result, edit, part)
        if after is None:
            return part
        self.check(title, judging.edit_findings(edit, part, after))
        self.check(title, judging.partition_findings(surface, after))
        return after

    def _edited(self, result: Result, edit: Edit, part: engine.Partition, factor: float = 1.0) -> Any:
        try:
            after = edit.run(result.mesh, part, factor)
        except engine.InvalidInput as error:
            if "several pieces" in str(error):
                self.find(f"{edit.name}: {error}")
            result.refused.append(f"{edit.name}: {error}")
            self.done[f"{edit.name} refused"] += 1
            return None
        self.done[edit.name] += 1
        result.stages.append((edit.name, after))
        return after

    def _mesh(self, result: Result, surface: judging.Surface, part: engine.Partition) -> None:
        case, edits = self.case, ", ".join(dict.fromkeys(edit.name for edit in self.case.edits))
        self.say(f"polygonize after {edits or 'partition'}")
        if not self._polygonized(result, part, case.meshing):
            return
        self.say("judging of polygons")
        self.check(f"polygonize, {edits}", judging.polygon_findings(surface, part, result.polygons, case.meshing))
        if part.bound is not None and self.rng.random() < 0.3:
            self.say("polygonize_within")
            within = engine.within.polygonize_within(result.mesh, part, case.meshing)
            self.check("polygonize_within", judging.scan_distance_findings(surface, within))

    def replayed(self, threads: int = 1, factor: float = 1.0) -> Result:
        """Play the case that was drawn."""
        case = self.case
        clean, partition, meshing = (draws.scaled(each, factor) for each in (case.clean, case.partition, case.meshing))
        for each in (clean, partition, meshing):
            each.threads = threads
        mesh = engine.clean(case.vertices * factor, case.triangles, clean)
        part = engine.guided.partition_guided(mesh, partition, None, case.guides)
        result = Result(mesh, [("partition", part)], None, [])
        for edit in case.edits:
            part = self._edited(result, edit, part, factor) or part
        self._polygonized(result, part, meshing)
        return result

    @staticmethod
    def _polygonized(result: Result, part: engine.Partition, options: engine.MeshingOptions) -> bool:
        try:
            result.polygons = engine.polygonize(result.mesh, part, options)
        except engine.InvalidInput as error:
            result.refused.append(f"polygonize: {error}")
        return result.polygons is not None

    # How a case is done again

    def threads(self, first: Result) -> None:
        for threads in (2, 8):
            if what := difference(first, self.replayed(threads)):
                self.find(f"on {threads} threads: {what} differ")

    def scaled(self, first: Result) -> None:
        """Times a power of two is exact, so that all decisions are equal. Very large and small scans would overflow."""
        if not 1e-3 < first.mesh.report["diagonal"] < 1e3:
            return
        power = int(self.rng.integers(1, 21)) * int(self.rng.choice([-1, 1]))
        try:
            other = self.replayed(factor=2.0**power)
        except engine.InvalidInput as error:
            self.find(f"times 2^{power}: {error}")
            return
        if what := difference(first, other, 2.0**power):
            self.find(f"times 2^{power}: {what} differ")

    def pickled(self, first: Result) -> None:
        mesh, part = pickle.loads(pickle.dumps((first.mesh, first.stages[-1][1])))  # noqa: S301  (our own)
        if first.polygons is not None:
            polygons = engine.polygonize(mesh, part, self.case.meshing)
            polygons = pickle.loads(pickle.dumps(polygons))  # noqa: S301
            if what := difference(first, Result(first.mesh, first.stages, polygons, first.refused)):
                self.find(f"pickled: {what} differ")

    def cancelled(self, first: Result) -> None:
        """A cancelled call raises Cancelled, or is done; and the next one gives the same as if it had not been."""
        mesh, part, case = first.mesh, first.stages[-1][1], self.case
        calls: dict[str, tuple[Callable[[engine.Job], Any], Any]] = {
            "triangles": (lambda job: engine.clean(case.vertices, case.triangles, case.clean, job=job), mesh),
            "face_region": (
                lambda job: engine.guided.partition_guided(mesh, case.partition, job, case.guides),
                first.stages[0][1],
            ),
        }
        if first.polygons is not None:
            calls["loops"] = lambda job: engine.polygonize(mesh, part, case.meshing, job=job), first.polygons
        for name, (call, known) in calls.items():
            began = time.perf_counter()
            call(engine.Job())
            job = engine.Job()
            timer = threading.Timer((time.perf_counter() - began) * self.rng.random(), job.cancel)
            timer.start()
            try:
                call(job)
            except engine.Cancelled:
                self.done["stopped"] += 1
            timer.join()
            made = call(engine.Job())
            if not np.array_equal(getattr(made, name), getattr(known, name)):
                self.find(f"{name} differ after a cancelled call")

    def file(self, first: Result) -> None:
        """Written files are read back, and a cancelled call writes nothing."""
        if first.polygons is None:
            return
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f"a{self.rng.choice(['.obj', '.ply'])}"
            engine.write(path, first.polygons)
            vertices, loops, start = engine.reading.read_polygons(path)
            for name, ours, theirs in (
                ("vertices", first.polygons.vertices, vertices),
                ("loops", first.polygons.loops, loops),
                ("loop_start", first.polygons.loop_start, start),
            ):
                if not np.array_equal(ours, theirs):
                    self.find(f"read back from {path.suffix}: {name} differ")
            path.unlink()
            job = engine.Job()
            job.cancel()
            try:
                engine.write(path, first.polygons, job=job)
                self.find("write: not cancelled")
            except engine.Cancelled:
                if os.listdir(folder):
                    self.find(f"a cancelled write leaves {os.listdir(folder)}")


# Processes


def play(seed: int, number: int, most: int, with_files: bool, pipe: Any, limits: tuple[float, int]) -> None:
    """The work of a process: sends ("at", step) at each step, and at the end ("done", findings, counts, text)."""
    seconds, memory = limits
    resource.setrlimit(resource.RLIMIT_CPU, (int(seconds) + 1, int(seconds) + 5))
    if memory:
        resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    np.seterr(all="ignore")
    faulthandler.disable()  # pytest's
    monkey = Monkey(seed, number, most, with_files, lambda step: pipe.send(("at", step)))
    try:
        monkey.run()
    except engine.Cancelled:
        monkey.find("Cancelled by nobody")
    except BaseException as error:  # noqa: BLE001  (all that is no refusal is a finding)
        place = traceback.extract_tb(error.__traceback__)[-1]
        monkey.find(f"{type(error).__name__}: {error} (in {place.name}, {Path(place.filename).name}:{place.lineno})")
    pipe.send(("done", monkey.findings, monkey.done, monkey.case.text if monkey.case else ""))


@dataclass
class Running:
    """A process with a case."""

    number: int
    process: Any
    pipe: Any
    began: float = field(default_factory=time.monotonic)
    step: str = "start"
    ended: tuple[list[str], Counter[str], str] | None = None

    def look(self, seconds: float) -> bool:
        """Read its messages; returns whether it has ended. seconds: of wall clock that it may take."""
        try:
            while self.pipe.poll():
                kind, *sent = self.pipe.recv()
                if kind == "at":
                    self.step = sent[0]
                else:
                    self.ended = tuple(sent)
        except (EOFError, OSError):
            pass
        if self.process.is_alive() and self.ended is None:
            if time.monotonic() - self.began < seconds:
                return False
            self.process.kill()
            self.process.join()
            self.ended = [f"no end within {seconds:.0f} s, at {self.step}"], Counter(), ""
        self.process.join()
        if self.ended is None:
            code = self.process.exitcode
            how = f"signal {-code}" if code and code < 0 else f"status {code}"
            self.ended = [f"ended by {how}, at {self.step}"], Counter(), ""
        return True


def run(
    seed: int,
    cases: Iterator[int],
    *,
    until: float = float("inf"),
    jobs: int = 1,
    most: int = MOST_FACES,
    with_files: bool = True,
    slower: float = 1.0,
    tell: Callable[[int, list[str], str], None] = lambda number, findings, text: None,
) -> tuple[list[tuple[int, str]], Counter[str]]:
    """Run cases, each in a process; returns (case, finding) and the count of each action.

    until: value of time.monotonic() after which no case begins. slower: how many times as slow the build is.
    tell: called after each case with its number, its findings and the drawn values.
    """
    context = multiprocessing.get_context("fork")  # the engine is loaded once
    limits = SECONDS * slower, 0 if slower > 1 else MEMORY + resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    findings, done, running = [], Counter[str](), list[Running]()
    numbers = iter(cases)
    while True:
        while len(running) < jobs and time.monotonic() < until and (number := next(numbers, None)) is not None:
            ours, theirs = context.Pipe(duplex=False)
            process = context.Process(target=play, args=(seed, number, most, with_files, theirs, limits), daemon=True)
            process.start()
            theirs.close()
            running.append(Running(number, process, ours))
        if not running:
            return findings, done
        for each in [each for each in running if each.look(WALL * limits[0])]:
            running.remove(each)
            found, counts, text = each.ended
            findings += [(each.number, finding) for finding in found]
            done.update(counts)
            done["cases"] += 1
            tell(each.number, found, text)
        if running:
            multiprocessing.connection.wait([each.process.sentinel for each in running] + [e.pipe for e in running], 1)


def main(words: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--minutes", type=float, default=1)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--case", type=int, help="repeat this case alone, in this process")
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--jobs", type=int, default=1, help="cases at once")
    parser.add_argument("--most", type=int, default=MOST_FACES, help="faces of a scan; larger ones are cut")
    parser.add_argument("--made", action="store_true", help="made scans only")
    parser.add_argument("--slower", type=float, default=1, help="how many times as slow the build is")
    given = parser.parse_args(words)
    command = f"python -m bench.monkeys.monkey --seed {given.seed}" + (" --made" if given.made else "")
    command += f" --most {given.most}" if given.most != MOST_FACES else ""

    def tell(number: int, findings: list[str], text: str) -> None:
        for finding in findings:
            print(f"{finding} | {command} --case {number}", flush=True)

    until = float("inf") if given.case is not None else time.monotonic() + 60 * given.minutes
    cases = iter([given.case]) if given.case is not None else iter(range(given.first, 1 << 40))
    findings, done = run(
        given.seed, cases, until=until, jobs=given.jobs, most=given.most, with_files=not given.made,
        slower=given.slower, tell=tell,
    )  # fmt: skip
    print(", ".join(f"{name} {count}" for name, count in sorted(done.items())))
    print(f"{done['cases']} cases, {len({number for number, _ in findings})} with findings")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
