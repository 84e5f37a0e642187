"""The children of a batch on the workers of a Dask cluster: of one in processes of its own, here."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import isimp_engine as engine
import meshfiles
import shapes
from isimp_engine import batch
from isimp_engine.children import on_dask

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="a batch needs fork")

ENVIRONMENT = {
    **os.environ,
    "PYTHONPATH": os.pathsep.join([str(Path(engine.__file__).parents[1]), str(Path(__file__).parents[1])]),
}
ODD = "odd_work:run"


def make_scans(folder, *names):
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        vertices, triangles = shapes.cube(3)
        meshfiles.ply_binary(folder / name, vertices, triangles.tolist())
    return folder


def test_without_the_package_the_message_names_it(tmp_path, monkeypatch):
    scans = make_scans(tmp_path / "in", "a.ply")
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(batch.BatchError, match=r"--dask needs the package distributed: pip install 'isimp\[batch\]'"):
        batch.run(scans, tmp_path / "out", children=batch.Children(dask="tcp://127.0.0.1:1"))


@pytest.fixture
def cluster(tmp_path):
    """Starts a scheduler and workers, as processes; gives its address and the workers."""
    pytest.importorskip("distributed")
    processes = []

    def start(*options, workers=1):
        scheduler = tmp_path / "scheduler.json"
        here = ["--no-dashboard", "--host", "127.0.0.1"]
        commands = [["scheduler", "--scheduler-file", scheduler, "--port", "0", *here]]
        worker = ["--scheduler-file", scheduler, "--no-nanny", "--local-directory", tmp_path, *here, *options]
        commands += [["worker", *worker]] * workers
        for command in commands:
            line = [sys.executable, "-m", "distributed.cli.dask_" + command[0], *command[1:]]
            processes.append(subprocess.Popen(line, env=ENVIRONMENT, stderr=subprocess.DEVNULL))
        end = time.monotonic() + 30
        while not scheduler.exists():
            assert time.monotonic() < end
            time.sleep(0.05)
        import json

        return json.loads(scheduler.read_text())["address"], processes[1:]

    yield start
    for process in processes:
        process.kill()
        process.wait()


def test_rows_are_as_of_this_machine(cluster, tmp_path):
    address, _ = cluster("--nthreads", "2", "--resources", "MB=300")
    scans = make_scans(tmp_path / "in", "good.ply", "sub/good.ply", "crash.ply", "hang.ply", "large.ply")
    with (scans / "giant.ply").open("wb") as file:
        file.write(b"ply\nformat binary_little_endian 1.0\nelement face 4000000\nend_header\n")
        file.truncate(100 << 20)
    outcome = batch.run(scans, tmp_path / "out", work=ODD, children=batch.Children(dask=address, time_limit=2))
    assert {row["name"]: row["why"] for row in outcome.failed} == {
        "crash.ply": "ended by signal 11",
        "giant.ply": "needs about 1,200 MB, and the largest worker has 300 MB",
        "hang.ply": "over the time limit of 2 s",
        "large.ply": "over the memory limit of 300 MB",
    }
    assert len(engine.reading.read_polygons(tmp_path / "out" / "sub" / "good.obj")[2]) == 6
    assert batch.run(scans, tmp_path / "out", work=ODD).before == 6, "another run needs no cluster"


def test_a_worker_that_is_killed_loses_nothing(cluster, tmp_path, monkeypatch):
    address, workers = cluster("--nthreads", "1", workers=2)
    scans = make_scans(tmp_path / "in", *(f"slow{number}.ply" for number in range(5)))
    killed = []

    def kill_one(state):
        if state.done and not killed:
            killed.append(workers[0].pid)
            os.kill(workers[0].pid, signal.SIGKILL)

    outcome = batch.run(scans, tmp_path / "out", work=ODD, children=batch.Children(dask=address), watch=kill_one)
    assert killed
    assert len(outcome.rows) == 5
    assert not outcome.failed


def test_an_interrupt_ends_children_on_the_workers(cluster, tmp_path):
    address, _ = cluster("--nthreads", "1")
    scans = make_scans(tmp_path / "in", "hang.ply", "hang2.ply")

    def interrupt(state):
        if list((tmp_path / "out" / ".isimp-batch" / "parts").glob("*/stderr.txt")):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        batch.run(scans, tmp_path / "out", work=ODD, children=batch.Children(dask=address), watch=interrupt)
    assert batch.table.read_rows(tmp_path / "out") == []
    for name in ("hang.ply", "hang2.ply"):
        (scans / name).rename(scans / name.replace("hang", "good"))
    rows = batch.run(scans, tmp_path / "out", work=ODD, children=batch.Children(dask=address)).rows
    assert len(rows) == 2, "the worker is free again"


def test_an_address_without_a_scheduler(tmp_path, monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr(on_dask, "_CONNECT", 1)
    scans = make_scans(tmp_path / "in", "a.ply")
    with pytest.raises(batch.BatchError, match="nothing:1: there is no scheduler of Dask"):
        batch.run(scans, tmp_path / "out", children=batch.Children(dask="nothing:1"))
