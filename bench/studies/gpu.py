"""A check of a GPU in one command: whether its results are right, and how fast it is.

    python -m bench.studies.gpu --out FOLDER [--tests FOLDER] [--faces 100000,1000000] [--counts 100,1000,10000]
        [--scans FILE...]

First the tests of the parallel parts are run, plainly and under each of compute-sanitizer's tools, where they and it
are found (--tests: the folder with test_parallel and its kin, as stage `cuda` of scripts/test.sh builds them). Then
every parallel method is timed on every back end on generated surfaces of --faces faces and on scans, against `lloyd`
and the default method on one thread of the processor; labels are compared, as they must be the same on all back ends.
Times are wall times: of the first partition of a mesh, which loads the surface, and of a further one, which finds it
there (the least of --repeat). FOLDER gets checks.csv and times.csv; the questions to the device and the answers are
printed. Needs the package, nothing else; without a device it does the same on the processor alone.
"""

from __future__ import annotations

import argparse
import csv
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

import isimp_engine as engine

TESTS = {  # by program: the tests that use a device; under a tool each takes seconds, others take minutes
    "test_parallel": "*",
    "test_thesis": "Flooder.*:DeviceMemory.IsWithin*:ParallelLloyd.ACube*:ParallelLloyd.Barriers*",
}
TOOLS = ("memcheck", "racecheck", "initcheck", "synccheck")
LIMIT = 60  # seconds of a program under a tool
ROUNDS = 20
BASE = {"lloyd": {"method": "lloyd", "threads": 1}, "default": {"method": "hierarchy", "threads": 1}}
PARALLEL = {"queued": {"method": "queued"}, "naive": {"method": "naive"}}
AIM = 20  # times lloyd's speed, of the queued method with a device, at a million faces


def ring(faces: int) -> engine.Mesh:
    """A closed, bumpy ring of about `faces` faces, in random order."""
    around = max(8, round((faces / 4) ** 0.5) * 2)
    across = max(6, faces // (2 * around))
    u, v = np.meshgrid(np.arange(around) / around, np.arange(across) / across, indexing="ij")
    u, v = 2 * np.pi * u, 2 * np.pi * v
    out = 0.35 + 0.04 * np.sin(5 * u + 2 * v) * np.cos(3 * v) + 0.015 * np.sin(23 * u) * np.sin(17 * v)
    place = np.stack([(1 + out * np.cos(v)) * np.cos(u), (1 + out * np.cos(v)) * np.sin(u), out * np.sin(v)], axis=-1)
    i, j = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    at = lambda a, b: (i + a) % around * across + (j + b) % across  # noqa: E731
    corners = [(at(0, 0), at(1, 0), at(1, 1)), (at(0, 0), at(1, 1), at(0, 1))]
    triangles = np.concatenate([np.stack(c, axis=-1).reshape(-1, 3) for c in corners])
    return engine.Mesh(place.reshape(-1, 3), np.random.default_rng(1).permutation(triangles).astype(np.int32))


def timed(mesh: engine.Mesh, **options) -> tuple[float, engine.Partition | None, str]:
    """Seconds, the result, and the error if there was one."""
    start = time.perf_counter()
    try:
        part = engine.partition(mesh, engine.PartitionOptions(iterations=ROUNDS, **options))
    except RuntimeError as error:
        return time.perf_counter() - start, None, str(error)
    return time.perf_counter() - start, part, ""


def measure(arrays: engine.Mesh, name: str, counts: list[int], repeat: int) -> list[dict]:
    rows = []
    for proxies in counts:
        lloyd, labels = None, {}
        ways = [(way, "cpu", options) for way, options in BASE.items()]
        ways += [(way, backend, options) for backend in engine.backends() for way, options in PARALLEL.items()]
        for way, backend, options in ways:
            # A mesh of its own for each, so that nothing is there that another one has made.
            mesh = engine.Mesh(arrays.vertices, arrays.triangles)
            runs = [timed(mesh, proxies=proxies, backend=backend, **options) for _ in range(repeat + 1)]
            first, part, problem = runs[0]
            again = min(seconds for seconds, _, _ in runs[1:])
            lloyd = lloyd or again
            expected = labels.setdefault(way, part)
            row = {"mesh": name, "faces": len(mesh.triangles), "proxies": proxies, "method": way, "backend": backend}
            row |= {"first_s": round(first, 5), "again_s": round(again, 5), "speed_up": round(lloyd / again, 3)}
            row["same_as_cpu"] = None not in (part, expected) and np.array_equal(part.face_region, expected.face_region)
            row |= {"error": part.error if part else "", "problem": problem}
            rows.append(row)
            print(*(f"{value:.4g}" if isinstance(value, float) else value for value in row.values()), file=sys.stderr)
    return rows


def run_within(command: list) -> tuple[bool, str]:
    """Whether a program succeeded within the limit, and the last line that it printed."""
    run = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True)
    try:
        printed = run.communicate(timeout=LIMIT)[0]
    except subprocess.TimeoutExpired:
        os.killpg(run.pid, signal.SIGKILL)  # the program too, which a tool leaves running
        run.communicate()
        return False, f"no end after {LIMIT} s"
    return run.returncode == 0, "".join(printed.strip().splitlines()[-1:])


def has_device() -> bool:
    """Asked in another process, since a tool may wait for one that has opened the device."""
    code = "import isimp_engine; print('cuda' in isimp_engine.backends())"
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "True\n"


def check(tests: Path | None) -> list[dict]:
    """The tests, plain and under the sanitizer's tools."""
    programs = [(tests / name, wanted) for name, wanted in TESTS.items()] if tests else []
    sanitizer = shutil.which("compute-sanitizer", path="/usr/local/cuda/bin") or shutil.which("compute-sanitizer")
    found = sanitizer and has_device()
    ways = {"plain": []} | (
        {tool: [sanitizer, "--tool", tool, "--error-exitcode", "9"] for tool in TOOLS} if found else {}
    )
    rows = []
    for program, wanted in programs:
        for way, before in ways.items():
            passed, last = run_within([*before, program, f"--gtest_filter={wanted}"])
            rows.append({"program": program.name, "under": way, "passed": passed, "last_line": last})
            print(*rows[-1].values(), file=sys.stderr)
    return rows


def table(rows: list[dict]) -> str:
    """Seconds of a further partition, as Markdown: a line for each mesh and count, a column for each way."""
    ways = list(dict.fromkeys((r["method"], r["backend"]) for r in rows))
    lines = ["| mesh | P | " + " | ".join(f"{way}, {backend}" for way, backend in ways) + " |"]
    lines.append("|---" * (2 + len(ways)) + "|")
    for mesh, proxies in dict.fromkeys((r["mesh"], r["proxies"]) for r in rows):
        cell = {(r["method"], r["backend"]): r for r in rows if (r["mesh"], r["proxies"]) == (mesh, proxies)}
        texts = [
            "failed" if cell[w]["problem"] else f"{cell[w]['again_s']:.3g} ({cell[w]['speed_up']:.3g} x)" for w in ways
        ]
        lines.append(f"| {mesh} | {proxies} | " + " | ".join(texts) + " |")
    return "\n".join(lines)


def verdict(rows: list[dict], checks: list[dict]) -> list[str]:
    """The questions to the device, and the answers."""
    lines = [f"{r['program']} under {r['under']} failed: {r['last_line']}" for r in checks if not r["passed"]]
    device = [r for r in rows if r["backend"] == "cuda"]
    if not device:
        return [*lines, "there is no device: figures are of the processor alone"]
    lines += [f"{r['method']}, {r['mesh']}, P {r['proxies']}: {r['problem']}" for r in device if r["problem"]]
    other = [r for r in device if not r["same_as_cpu"] and not r["problem"]]
    lines += [f"{r['method']}, {r['mesh']}, P {r['proxies']}: not the processor's labels" for r in other]
    million = [r["speed_up"] for r in device if r["method"] == "queued" and 5e5 < r["faces"] < 2e6]
    if million:
        lines.append(f"queued at a million faces: {min(million)} to {max(million)} times lloyd; the aim is {AIM}")
    faster = [r for r in device if r["again_s"] < _default_of(rows, r)]
    lines.append(f"faster than the default on one thread in {len(faster)} of {len(device)} cases")
    return lines


def _default_of(rows: list[dict], like: dict) -> float:
    same = ("mesh", "proxies")
    return next(r["again_s"] for r in rows if r["method"] == "default" and all(r[k] == like[k] for k in same))


def write_rows(path: Path, rows: list[dict]) -> None:
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]) if rows else [])
        writer.writeheader()
        writer.writerows(rows)


def main(arguments: list[str] | None = None) -> int:
    """0 if nothing failed."""
    numbers = lambda text: [int(number) for number in text.split(",")]  # noqa: E731
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("out/gpu"))
    parser.add_argument("--tests", type=Path, help="the folder with the test programs")
    parser.add_argument("--faces", type=numbers, default=[100_000, 1_000_000, 10_000_000])
    parser.add_argument("--counts", type=numbers, default=[100, 1000, 10_000])
    parser.add_argument("--scans", type=Path, nargs="*", default=[], help="scans to measure beside the generated ones")
    parser.add_argument("--repeat", type=int, default=2)
    given = parser.parse_args(arguments)
    given.out.mkdir(parents=True, exist_ok=True)
    checks, rows = check(given.tests), []
    write_rows(given.out / "checks.csv", checks)
    meshes = [(f"ring of {faces:,} faces", lambda n=faces: ring(n)) for faces in given.faces]
    meshes += [(scan.stem, lambda path=scan: engine.clean(*engine.read(path))) for scan in given.scans]
    for name, make in meshes:
        rows += measure(make(), name, given.counts, given.repeat)
        write_rows(given.out / "times.csv", rows)
    print(table(rows), *verdict(rows, checks), sep="\n")
    good = all(r["passed"] for r in checks) and all(r["same_as_cpu"] for r in rows)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
