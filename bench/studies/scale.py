"""Measures batches, merging and clusters beyond one scan and one machine.

    python -m bench.studies.scale ARGUMENTS
      batch                  `isimp batch` on 1,000 small scans, some of which fail, with a driver that is
                              killed twice; minutes
      batch --scans 100
      overhead               time a scan compared with `isimp simplify`
      hub                    merging where a region has most of the others around it, at 1, 4 and 16 times
                              the size
      cluster --faces 10000000 --proxies 10500
                              `isimp tiles` on this machine alone, and on a Dask cluster of two workers of
                              which one is killed half-way: whether the bits are the same. With --apart
                              the workers share nothing but files

The tiles against one piece, and their peaks: bench/studies/tiles.py.

Run it with a Python that has isimp_engine: installed, or by PYTHONPATH=build-dev/python. The peaks are the kernel's.
"""

from __future__ import annotations

import argparse
import collections
import contextlib
import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

import isimp_engine as engine
from bench.studies.tiles import make_city
from isimp_engine import batch, tiles
from isimp_engine.batch import work
from isimp_engine.tiles import steps
from isimp_engine.tiles.run import State

ODD = {  # name of a scan: expected text of its row
    "crash": "ended by signal 11",
    "hang": "over the time limit of 10 s",
    "large": "over the memory limit of 500 MB",
    "torn": "the PLY header has no end_header; the file is cut short or damaged",
}
LIMITS = {"time_limit": 10.0, "memory_limit": 500.0}


def odd(task: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The work of a child: the name of the scan selects it, else the real one."""
    name = Path(task["input"]).stem
    with open(os.environ["SCALE_LOG"], "a", encoding="utf-8") as file:  # noqa: PTH123
        file.write(f"{name}\n")
    if name == "crash":
        os.kill(os.getpid(), signal.SIGSEGV)
    if name == "hang":
        time.sleep(3600)
    if name == "large":
        return {"faces": len([bytearray(b"x" * (16 << 20)) for _ in range(1000)])}
    return work.simplify(task, folder)


def box(path: Path, n: int, seed: int) -> None:
    """A noisy, open heightfield of 2 n^2 faces."""
    random = np.random.default_rng(seed)
    y, x = np.mgrid[0 : n + 1, 0 : n + 1] / n
    z = 0.3 * (x > 0.5) * (y > 0.5) + 0.2 * np.maximum(0, x - y) + random.normal(0, 0.002, x.shape)
    a = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    faces = np.concatenate([np.stack([a, a + 1, a + n + 2], 1), np.stack([a, a + n + 2, a + n + 1], 1)])
    rows = np.zeros(len(faces), dtype=[("n", "u1"), ("v", "<i4", 3)])
    rows["n"], rows["v"] = 3, faces
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {x.size}\nproperty float x\nproperty float y\n"
    head += f"property float z\nelement face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    points = np.stack([x, y, z], axis=2).astype("<f4")
    path.write_bytes(head.encode() + points.tobytes() + rows.tobytes())


def make(folder: Path, count: int) -> None:
    for number in range(count - len(ODD)):
        place = folder / f"site{number % 10}"
        place.mkdir(parents=True, exist_ok=True)
        box(place / f"scan{number:05}.ply", 20 + number % 30, number)
    for name in ODD:
        box(folder / f"{name}.ply", 10, 0)
    (folder / "torn.ply").write_text("ply\nformat binary_little_endian 1.0\n")


def drive(scans: str, out: str) -> None:
    batch.run(scans, out, options={"proxies": 20}, work="bench.studies.scale:odd", **LIMITS)


def killed_twice(scans: Path, out: Path, count: int, environment: dict[str, str]) -> None:
    """Start the batch, and kill -9 it after a third and after two thirds of the scans."""
    rows = out / "results.jsonl"
    for share in (1 / 3, 2 / 3):
        command = [sys.executable, "-m", "bench.studies.scale", "drive", str(scans), str(out)]
        with subprocess.Popen(command, env=environment) as driver:
            while driver.poll() is None and (not rows.exists() or rows.read_bytes().count(b"\n") < share * count):
                time.sleep(0.02)
            driver.kill()


def run_batch(count: int) -> int:
    with tempfile.TemporaryDirectory() as place:
        scans, out, log = (Path(place) / name for name in ("in", "out", "log"))
        make(scans, count)
        os.environ["SCALE_LOG"] = str(log)
        begun = time.perf_counter()
        killed_twice(scans, out, count, dict(os.environ))
        outcome = batch.run(scans, out, options={"proxies": 20}, work="bench.studies.scale:odd", **LIMITS)
        seconds = time.perf_counter() - begun
        starts = collections.Counter(log.read_text(encoding="utf-8").split())
        twice = {name: number for name, number in starts.items() if number > 1}
        good = [row for row in outcome.rows if row["status"] == "ok"]
        whys = {row["name"].removesuffix(".ply"): row["why"] for row in outcome.failed}
        print(
            f"scans {count}, ok {len(good)}, failed {len(whys)}; {seconds:.1f} s, {60 * count / seconds:.0f} a minute"
        )
        for name, why in sorted(whys.items()):
            print(f"  {name}: {why}")
        print(f"begun {starts.total()}; more than once, as they were running when the driver was killed: {twice}")
        print(f"peak of a child: {max(row['peak_mb'] for row in good):.0f} MB")
        print(
            f"page {(out / 'results.html').stat().st_size / 1e6:.1f} MB, rows {(out / 'results.jsonl').stat().st_size}"
        )
        at_once = os.cpu_count() or 1
        return int(whys != ODD or len(good) != count - len(ODD) or sum(twice.values()) - len(twice) > 2 * at_once)


def run_overhead(count: int) -> int:
    with tempfile.TemporaryDirectory() as place:
        scans = Path(place) / "in"
        scans.mkdir()
        for number in range(count):
            box(scans / f"{number}.ply", 50, number)
        options = ["--proxies", "20", "--threads", "1", "--quiet"]
        command = [sys.executable, "-m", "isimp_engine"]
        times = {}
        with timed(times, "isimp simplify, one after the other"):
            for number in range(count):
                where = [str(scans / f"{number}.ply"), str(Path(place) / f"{number}.obj")]
                subprocess.run([*command, "simplify", *where, *options], check=True)
        for name, more in (("", []), (", no pictures", ["--no-pictures"])):
            with timed(times, f"isimp batch --jobs 1{name}"):
                out = str(Path(place) / f"out{len(more)}")
                subprocess.run([*command, "batch", str(scans), out, "--jobs", "1", *options, *more], check=True)
        for name, seconds in times.items():
            print(f"{1000 * seconds / count:6.0f} ms a scan  {name}")
        rows = batch.table.read_rows(Path(place) / "out1")
        inside = sum(sum(row["step_seconds"].values()) for row in rows) / len(rows)
        print(f"{1000 * inside:6.0f} ms a scan  in the engine")
        return 0


def graph_of(faces: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Patches of a city in one piece: sums, pairs and lengths."""
    n = max(2, round((faces / 2) ** 0.5))
    with tempfile.TemporaryDirectory() as place:
        make_city(Path(place) / "city", 2 * n * n, 2 * n * n)
        mesh = engine.Mesh(*engine.read(next((Path(place) / "city").iterdir())))
    found = steps.patches(mesh, 100)
    return found.sums, found.pairs, found.lengths


def run_hub(faces: int) -> int:
    before: dict[str, float] = {}
    for times in (1, 4, 16):
        sums, pairs, lengths = graph_of(times * faces)
        count = len(sums)
        around = int(np.bincount(pairs.ravel()).max())
        found = steps.find_components(sums, pairs, lengths, np.ones(count, np.uint8), count // 10, 0.0)
        none = np.zeros(count, np.uint8)
        print(f"{count:,} patches to {count // 10:,}; at first the largest has {around} around it")
        for name, smooth in (("without borders", 0.0), ("with borders", 0.5)):
            begun = time.process_time()
            price = {"smooth": smooth, "error": 0.05, "proxies": count // 10, "area": sums[:, 3].sum() / 2}
            steps.merge_inside(sums, pairs, lengths, found, none, count // 10, **price)
            seconds = time.process_time() - begun
            ratio = f", {seconds / before[name]:.1f} times the one before" if name in before else ""
            print(f"  {name}: {seconds:.3f} s, {1e6 * seconds / count:.1f} us a patch{ratio}", flush=True)
            before[name] = seconds
    return 0


NETWORK, BRIDGE = "10.93.7", "isimpbr"


@contextlib.contextmanager
def namespaces(count: int):
    """For each worker the command that puts it into namespaces of its own, and its host; the scheduler's host is .1."""

    def ip(words: str) -> None:
        subprocess.run(["ip", *words.split()], check=True)

    ip(f"link add {BRIDGE} type bridge")
    try:
        ip(f"addr add {NETWORK}.1/24 dev {BRIDGE}")
        ip(f"link set {BRIDGE} up")
        places = []
        for k in range(count):
            ip(f"netns add {BRIDGE}{k}")
            ip(f"link add {BRIDGE}a{k} type veth peer name {BRIDGE}b{k}")
            ip(f"link set {BRIDGE}a{k} master {BRIDGE} up")
            ip(f"link set {BRIDGE}b{k} netns {BRIDGE}{k}")
            ip(f"-n {BRIDGE}{k} addr add {NETWORK}.{10 + k}/24 dev {BRIDGE}b{k}")
            ip(f"-n {BRIDGE}{k} link set {BRIDGE}b{k} up")
            enter = f"ip netns exec {BRIDGE}{k} unshare --ipc --pid --fork --kill-child --mount-proc"
            places.append((enter.split(), f"{NETWORK}.{10 + k}"))
        yield places
    finally:
        for k in range(count):
            subprocess.run(["ip", "netns", "delete", f"{BRIDGE}{k}"], check=False)
        ip(f"link delete {BRIDGE}")


@contextlib.contextmanager
def cluster_of(workers: int, place: Path, apart: bool):
    """The address of a Dask scheduler, and its workers; all are processes.

    apart: each worker has a network, shared memory and process numbers of its own; only files are shared.
    """
    file = place / "scheduler.json"
    options = ["--scheduler-file", str(file), "--no-dashboard"]
    here = {**os.environ, "PYTHONPATH": str(Path(engine.__file__).parents[1])}
    processes = []
    with namespaces(workers) if apart else contextlib.nullcontext([([], "127.0.0.1")] * workers) as places:
        own = f"{NETWORK}.1" if apart else "127.0.0.1"
        lines = [([], ["dask_scheduler", "--port", "0", "--host", own])]
        for enter, host in places:
            lines.append((enter, ["dask_worker", "--no-nanny", "--nthreads", "1", "--host", host]))
            lines[-1][1].extend(["--local-directory", str(place)])
        try:
            for enter, (name, *more) in lines:
                command = [*enter, sys.executable, "-m", f"distributed.cli.{name}", *more, *options]
                processes.append(subprocess.Popen(command, env=here, stderr=subprocess.DEVNULL))
                while not file.exists():
                    time.sleep(0.05)
            yield json.loads(file.read_text(encoding="utf-8"))["address"], processes[1:]
        finally:
            for process in processes:
                process.kill()
                process.wait()


def processor_seconds() -> float:
    """The processor time of all child processes that have ended."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def run_cluster(faces: int, proxies: int, apart: bool) -> int:
    """Compares the results of this machine and of two workers of a cluster, one of which is killed half-way."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        count = make_city(place / "city", faces)
        begun, used = time.perf_counter(), processor_seconds()
        report = tiles.run(place / "city", place / "a.ply", proxies=proxies, children=batch.Children(jobs=2)).report
        seconds, used = time.perf_counter() - begun, processor_seconds() - used
        peaks = report["peak_mb"]
        print(f"{count:,} faces in {report['tiles']} tiles, {report['groups']} groups: {report['regions']:,} regions")
        print(f"  {seconds:.0f} s, {used:.0f} s of processor, {1e6 * used / count:.1f} us a face", flush=True)
        print(f"  peaks, MB: {', '.join(f'{step} {peak:.0f}' for step, peak in peaks.items())}")
        print(f"  seconds: {report['seconds']}")
        defects = {name: report["output"][name] for name in ("crossing", "flipped", "bent", "intersecting")}
        print(f"  {report['output']['polygons']:,} polygons, {defects}", flush=True)
        with cluster_of(2, place, apart) as (address, workers):
            done = []

            def kill(state: State) -> None:
                if not done and (place / "work" / "join").exists():
                    workers[1].kill()
                    done.append(state)

            begun = time.perf_counter()
            children = batch.Children(dask=address)
            run = {"proxies": proxies, "children": children, "work": place / "work", "watch": kill}
            tiles.run(place / "city", place / "b.ply", **run)
            print(f"  two workers, one killed after `join`: {time.perf_counter() - begun:.0f} s")
        same = (place / "a.ply").read_bytes() == (place / "b.ply").read_bytes()
        print(f"  killed: {bool(done)}, same bits: {same}")
        return int(not (done and same))


@contextlib.contextmanager
def timed(times: dict[str, float], name: str):
    begun = time.perf_counter()
    yield
    times[name] = time.perf_counter() - begun


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("what", choices=["batch", "overhead", "hub", "cluster", "drive"])
    parser.add_argument("places", nargs="*", help=argparse.SUPPRESS)
    parser.add_argument("--scans", type=int, help="default 1,000; 40 for overhead")
    parser.add_argument("--faces", type=int, help="default 720,000 for hub, 10,000,000 for cluster")
    parser.add_argument("--proxies", type=int, help="of a cluster; default: one for 1,000 faces")
    parser.add_argument("--apart", action="store_true", help="workers of a cluster in namespaces of their own; as root")
    arguments = parser.parse_args()
    if arguments.what == "hub":
        return run_hub(arguments.faces or 720_000)
    if arguments.what == "cluster":
        faces = arguments.faces or 10_000_000
        return run_cluster(faces, arguments.proxies or faces // 1000, arguments.apart)
    if arguments.what == "drive":
        drive(*arguments.places)
        return 0
    if arguments.what == "overhead":
        return run_overhead(arguments.scans or 40)
    return run_batch(arguments.scans or 1000)


if __name__ == "__main__":
    sys.exit(main())
