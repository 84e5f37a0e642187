"""`isimp batch` and isimp_engine.batch: each scan has a row, also if its process fails."""

import errno
import hashlib
import json
import os
import signal
import subprocess
import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

import isimp_engine as engine
import meshfiles
import shapes
from batches import ODD, rows_by_name, scan, wait_for, whys
from commands import ENVIRONMENT, called, isimp
from isimp_engine import batch
from isimp_engine.batch import table
from isimp_engine.children import local, process
from isimp_engine.cli.batch import Terminated, deferrable

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="a batch needs fork")


# The output of a run


def test_results_equal_simplify_in_the_folders_of_the_scans(scans, tmp_path):
    out = tmp_path / "out"
    done = isimp("batch", scans, out, "--proxies", 6, "--labels", "--reports")
    assert (done.returncode, done.stderr) == (0, "")
    assert "3 of 3 scans ok" in done.stdout
    alone = tmp_path / "alone.obj"
    assert called("simplify", scans / "sub" / "c.ply", alone, "--proxies", 6).returncode == 0
    assert (out / "sub" / "c.obj").read_bytes() == alone.read_bytes()
    assert len(np.load(out / "sub" / "c.labels.npy")) == 108
    assert json.loads((out / "sub" / "c.report.json").read_text())["options"]["proxies"] == 6
    names = {str(path.relative_to(out)) for path in out.rglob("*") if path.is_file()}
    made = {f"{name}{end}" for name in ("a", "b", "sub/c") for end in (".obj", ".labels.npy", ".report.json")}
    assert {name for name in names if not name.startswith(".isimp-batch/")} == made | {"results.jsonl", "results.html"}

    row = rows_by_name(out)["sub/c.ply"]
    assert row["input"] == str(scans / "sub" / "c.ply")
    assert (row["status"], row["why"], row["output"]) == ("ok", None, str(out / "sub" / "c.obj"))
    assert (row["faces"], row["regions"], row["polygons"], row["closed"], row["manifold"]) == (108, 6, 6, True, True)
    assert row["seconds"] > 0
    assert 5 < row["peak_mb"] < 5000


def test_other_options_leave_no_files_of_the_old_ones(scans, tmp_path):
    out = tmp_path / "out"
    assert not batch.run(scans, out, format="ply", options={"proxies": 6}, labels=True, reports=True).failed
    own = out / "sub" / "c.txt"
    own.write_text("precious")
    again = batch.run(scans, out, options={"proxies": 6})
    assert not again.failed
    names = {str(path.relative_to(out)) for path in out.rglob("*") if path.is_file()}
    made = {"a.obj", "b.obj", "sub/c.obj", "results.jsonl", "results.html", "sub/c.txt"}
    assert {name for name in names if not name.startswith(".isimp-batch/")} == made
    assert [row["files"] for row in again.rows] == [["a.obj"], ["b.obj"], ["c.obj"]]


def test_a_read_only_result_is_not_replaced(scans, tmp_path):
    out = tmp_path / "out"
    assert not batch.run(scans, out, options={"proxies": 6}).failed
    (out / "a.obj").write_text("precious")
    (out / "a.obj").chmod(0o444)
    (failed,) = batch.run(scans, out, format="ply", options={"proxies": 7}).failed
    assert (failed["name"], failed["files"]) == ("a.ply", ["a.obj"])
    assert "a.obj: is read-only" in failed["why"]
    assert (out / "a.obj").read_text() == "precious"
    assert (out / "b.ply").exists()


def test_a_row_names_no_other_files(scans, tmp_path):
    out = tmp_path / "out"
    assert not batch.run(scans, out, options={"proxies": 6}).failed
    table_file = out / table.NAME
    rows = [json.loads(line) for line in table_file.read_text().splitlines()]
    for row, files in zip(rows, (["b.txt", "../a.txt"], ["..", 5], ["/"]), strict=True):
        row["files"] = files
    table_file.write_text("".join(json.dumps(row) + "\n" for row in rows))
    for place in (out / "b.txt", tmp_path / "a.txt"):
        place.write_text("precious")
    assert not batch.run(scans, out, options={"proxies": 7}).failed
    assert (out / "b.txt").exists()
    assert (tmp_path / "a.txt").exists()


def test_a_second_run_does_only_missing_scans(scans, tmp_path, log):
    out = tmp_path / "out"

    def run(**keywords):
        before = len(log())
        outcome = batch.run(scans, out, work=ODD, **keywords)
        assert not outcome.failed
        assert len(outcome.rows) == 3
        assert outcome.before == 3 - (len(log()) - before)
        return len(log()) - before

    assert run() == 3
    assert run() == 0
    scan(scans / "b.ply", 4)
    assert run() == 1
    (out / "sub" / "c.obj").unlink()
    assert run() == 1
    assert run(options={"threads": 2}) == 0, "the number of threads changes no result"
    assert run(options={"proxies": 7}) == 3
    assert rows_by_name(out)["a.ply"]["regions"] == 7
    assert run(options={"proxies": 7}, format="ply") == 3
    assert run(options={"proxies": 7}, format="ply") == 0


def test_a_scan_is_done_again_after_a_change_of_a_file_that_it_names(tmp_path, log):
    folder, out = tmp_path / "in", tmp_path / "out"
    folder.mkdir()
    scan(folder / "alone.ply")
    meshfiles.gltf(folder / "g.gltf", *shapes.cube(3))
    meshfiles.obj(folder / "o.obj", *shapes.cube(3))
    text = (folder / "o.obj").read_text()
    (folder / "o.obj").write_text(f"mtllib wood.mtl\n{text.replace('f ', 'usemtl wood' + chr(10) + 'f ', 1)}")
    (folder / "wood.mtl").write_text("newmtl wood\nmap_Kd wood.png\n")

    def begun():
        before = log()
        assert not batch.run(folder, out, work=ODD).failed
        return sorted((Counter(log()) - Counter(before)).elements())

    assert begun() == ["alone", "g", "o"]
    assert begun() == []
    vertices, triangles = shapes.cube(3)
    meshfiles.gltf(tmp_path / "g.gltf", 2 * vertices, triangles)
    (tmp_path / "g.bin").replace(folder / "g.bin")
    assert begun() == ["g"]
    (folder / "wood.png").write_bytes(b"x")
    assert begun() == ["o"]
    with (folder / "wood.mtl").open("a") as file:
        file.write("Kd 1 0 0\n")
    assert begun() == ["o"]
    assert begun() == []


def test_a_scan_that_names_no_file_has_the_key_of_batches_before(scans):
    found = batch.scans.find_scans(scans / "a.ply")[0]
    values = [found.name, found.size, found.changed, found.output, {"a": 1}, engine.__version__]
    assert found.key({"a": 1}) == hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()[:32]


def test_more_scans_are_added_to_earlier_ones(scans, tmp_path, log):
    batch.run(scans / "a.ply", tmp_path / "out", work=ODD)
    outcome = batch.run(scans, tmp_path / "out", work=ODD)
    assert log() == ["a", "b", "c"]
    assert [row["name"] for row in outcome.rows] == ["a.ply", "b.ply", "sub/c.ply"]


# Scans that fail


def test_what_one_scan_does_is_its_row_alone(tmp_path, log):
    for name in ("crash", "exit", "good", "large", "raise", "slow"):
        scan(tmp_path / "in" / f"{name}.ply")
    (tmp_path / "in" / "broken.ply").symlink_to(tmp_path / "nowhere")
    (tmp_path / "in" / "torn.ply").write_text("ply\nformat ascii 1.0\n")
    limits = batch.Children(jobs=4, memory_limit=400)
    outcome = batch.run(tmp_path / "in", tmp_path / "out", work=ODD, children=limits)
    assert {row["name"] for row in outcome.rows if row["status"] == "ok"} == {"good.ply", "slow.ply"}
    assert whys(outcome) == {
        "broken.ply": "there is no such file",
        "crash.ply": "ended by signal 11",
        "exit.ply": "ended with exit status 9: no licence for this machine",
        "large.ply": "over the memory limit of 400 MB",
        "raise.ply": "ended with exit status 70: KeyError: 'a mistake in the work'",
        "torn.ply": "the PLY header has no end_header; the file is cut short or damaged",
    }
    assert all(row["output"] is None for row in outcome.failed)
    assert rows_by_name(tmp_path / "out")["large.ply"]["peak_mb"] < 500
    assert sorted(path.name for path in (tmp_path / "out").glob("*.obj")) == ["good.obj", "slow.obj"]


def test_scans_without_an_end_are_ended(tmp_path):
    scan(tmp_path / "in" / "hang.ply")
    os.mkfifo(tmp_path / "in" / "pipe.ply")
    outcome = batch.run(tmp_path / "in", tmp_path / "out", work=ODD, children=batch.Children(jobs=2, time_limit=0.5))
    assert whys(outcome) == dict.fromkeys(("hang.ply", "pipe.ply"), "over the time limit of 0.5 s")
    assert rows_by_name(tmp_path / "out")["hang.ply"]["seconds"] >= 0.5


def test_memory_of_the_engine_is_limited_too(tmp_path):
    vertices, triangles = shapes.bumpy(300)  # 180,000 faces, some 40 MB
    meshfiles.ply_binary(tmp_path / "wide.ply", vertices, triangles.tolist())
    scan(tmp_path / "small.ply")
    inputs, out = [tmp_path / "wide.ply", tmp_path / "small.ply"], tmp_path / "out"
    outcome = batch.run(inputs, out, children=batch.Children(memory_limit=60), pictures=False)
    assert whys(outcome) == {"wide.ply": "over the memory limit of 60 MB"}


def test_failed_scans_are_repeated_only_on_request(scans, tmp_path, log):
    scan(scans / "crash.ply")
    out = tmp_path / "out"
    assert whys(batch.run(scans, out, work=ODD)) == {"crash.ply": "ended by signal 11"}
    assert whys(batch.run(scans, out, work=ODD)) == {"crash.ply": "ended by signal 11"}
    assert log() == ["a", "b", "c", "crash"]
    outcome = batch.run(scans, out, retry_failed=True)
    assert not outcome.failed
    assert log() == ["a", "b", "c", "crash"], "the others are not done again"
    assert rows_by_name(out)["crash.ply"]["status"] == "ok"


def test_the_command_ends_with_4_and_shows_failed_scans(scans, tmp_path):
    (scans / "bad.obj").write_text("v 0 0 0\nf 1 2 9\n")
    done = called("batch", scans, tmp_path / "out", "--proxies", 6)
    assert done.returncode == 4
    assert done.stdout.splitlines()[0].startswith("failed  bad.obj: ")
    assert "3 of 4 scans ok, 1 failed" in done.stdout
    assert called("batch", scans, tmp_path / "out", "--proxies", 6, "--quiet").returncode == 4
    (scans / "bad.obj").unlink()
    done = called("batch", scans, tmp_path / "out", "--proxies", 6)
    assert done.returncode == 0, "a row of a scan that is gone does not count"
    assert "bad.obj" in rows_by_name(tmp_path / "out"), "and is kept"


def test_an_option_that_does_not_suit_a_scan_is_its_row(scans, tmp_path):
    scan(scans / "tiny.ply", 1)
    outcome = batch.run(scans, tmp_path / "out", options={"proxies": 50})
    assert list(whys(outcome)) == ["tiny.ply"]
    assert "[1, 12], got 50" in whys(outcome)["tiny.ply"]
    assert str(tmp_path) not in whys(outcome)["tiny.ply"]


# Unplanned ends

DRIVER = """
import sys
from isimp_engine import batch
batch.run(sys.argv[1], sys.argv[2], work="odd_work:run", children=batch.Children(jobs=2), pictures=False)
"""


def is_running(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.skipif(sys.platform != "linux", reason="looks at processes in /proc")
def test_a_driver_that_is_killed_twice_loses_only_running_scans(tmp_path, monkeypatch):
    starts = tmp_path / "log"
    for number in range(8):
        scan(tmp_path / "in" / f"slow{number}.ply")
    out = tmp_path / "out"
    environment = {**ENVIRONMENT, "ODD_WORK_LOG": str(starts)}
    rows = out / "results.jsonl"
    for enough in (2, 4):
        command = [sys.executable, "-c", DRIVER, tmp_path / "in", out]
        with subprocess.Popen(command, env=environment) as driver:
            wait_for(lambda: rows.exists() and rows.read_bytes().count(b"\n") >= enough)  # noqa: B023
            driver.kill()
        pids = [int(line.split()[1]) for line in starts.read_text().splitlines()]
        wait_for(lambda: not any(map(is_running, pids)), 5)  # noqa: B023
        for made in out.glob("*.obj"):
            assert len(engine.reading.read_polygons(made)[2]) == 6, "no file is half-written"
    monkeypatch.setenv("ODD_WORK_LOG", str(starts))
    outcome = batch.run(tmp_path / "in", out, work=ODD)
    assert len(outcome.rows) == 8
    assert not outcome.failed
    assert outcome.before >= 4
    assert set(rows_by_name(out)) == {f"slow{number}.ply" for number in range(8)}
    assert len(starts.read_text().splitlines()) <= 8 + 2 * 2, "only what was running was done again"
    assert not list((out / ".isimp-batch").glob("parts*"))


def test_work_that_can_not_be_loaded_is_said_once(scans, tmp_path, capfd):
    said = "no child process can be started for no_such_module:run: .*No module named 'no_such_module'"
    with pytest.raises(batch.BatchError, match=said):
        batch.run(scans, tmp_path / "out", work="no_such_module:run")
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_an_interrupted_command_keeps_its_rows_and_can_continue(scans, tmp_path, number, status):
    """The command waits for a scan that is a pipe until the signal comes."""
    os.mkfifo(tmp_path / "pipe.ply")
    (tmp_path / "list.txt").write_text("# some scans\nin/a.ply\n\npipe.ply\n")
    out = tmp_path / "out"
    command = [sys.executable, "-m", "isimp_engine", "batch", tmp_path / "list.txt", out, "--jobs", "2"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=ENVIRONMENT, text=True) as run:
        with (tmp_path / "pipe.ply").open("wb"):  # opens once the child reads
            wait_for(lambda: (out / "results.jsonl").exists() and (out / "results.jsonl").stat().st_size)
            run.send_signal(number)
            found = run.wait(timeout=30)
            assert found == status, run.stderr.read()
        assert run.stderr.read() == "isimp: interrupted, 1 of 2 scans are done; the same command does the others\n"
    assert list(rows_by_name(out)) == ["in/a.ply"]
    assert "1 of 1 scan ok" in (out / "results.html").read_text()
    assert sorted(path.name for path in out.iterdir()) == [".isimp-batch", "in", "results.html", "results.jsonl"]


@pytest.mark.parametrize(("number", "kind"), [(signal.SIGINT, KeyboardInterrupt), (signal.SIGTERM, Terminated)])
def test_interrupts_wait_for_the_loop_once_it_runs(number, kind):
    before = signal.getsignal(number)
    with deferrable(), pytest.raises(kind):
        signal.raise_signal(number)
    with deferrable() as interrupts:
        interrupts.check()
        signal.raise_signal(number)
        with pytest.raises(kind):
            interrupts.check()
    with deferrable() as interrupts:
        interrupts.check()
        signal.raise_signal(number)
        with pytest.raises(kind):  # a second one
            signal.raise_signal(number)
    assert signal.getsignal(number) is before


@pytest.mark.parametrize("whole", [False, True])
def test_a_last_line_that_was_cut_short_is_done_again(scans, tmp_path, log, whole):
    out = tmp_path / "out"
    batch.run(scans, out, work=ODD)
    rows = out / "results.jsonl"
    text = rows.read_text()
    rows.write_text(text[:-1] if whole else text[:-40])
    outcome = batch.run(scans, out, work=ODD)
    assert outcome.cut_short == (not whole)
    assert len(log()) == (3 if whole else 4)
    assert set(rows_by_name(out)) == {"a.ply", "b.ply", "sub/c.ply"}


def test_lines_that_are_no_rows_are_left_out(scans, tmp_path, log):
    out = tmp_path / "out"
    batch.run(scans, out, work=ODD)
    rows = out / "results.jsonl"
    rows.write_text("\x00\x00\n[1]\n{}\n" + rows.read_text())
    assert len(batch.table.read_rows(out)) == 3
    assert len(batch.run(scans, out, work=ODD).rows) == 3
    assert len(log()) == 3
    assert len(rows_by_name(out)) == 3
    assert batch.table.read_rows(tmp_path / "nowhere") == []


def test_one_driver_a_folder(scans, tmp_path):
    out = tmp_path / "out"
    with table.Lock(out):
        done = isimp("batch", scans, out)
    assert done.returncode == 2
    assert done.stderr == (
        f"isimp: {out}: process {os.getpid()} on {os.uname().nodename} works on it; "
        "wait for its end or give another folder\n"
    )
    assert called("batch", scans, out, "--proxies", 6, "--quiet").returncode == 0


# The functions


def test_a_pipeline_of_ones_own_may_use_the_children(tmp_path):
    (tmp_path / "part").mkdir()
    running = tmp_path / "running"
    running.touch()

    def why(name, limits=process.Limits()):  # noqa: B008
        return process.run(ODD, {"input": name}, tmp_path / "part", limits, str(running)).why

    assert why("crash.ply", process.Limits(seconds=60)) == "ended by signal 11"
    assert why("hang.ply", process.Limits(seconds=0.1)) == "over the time limit of 0.1 s"
    running.unlink()
    assert why("hang.ply") == "stopped"


def test_children_end_silently_with_their_run(tmp_path, log, capfd):
    (tmp_path / "parts").mkdir()
    with local.Local(tmp_path / "parts", 2, process.Limits(), ODD) as workers:
        workers.start(0, {"input": "hang.ply"}, 1)
    with local.Local(tmp_path / "parts", 2, process.Limits(), ODD) as workers:
        workers.start(0, {"input": "hang.ply"}, 1)
        wait_for(log)
        workers.start(1, {"input": "crash.ply"}, 1)
    assert not list(tmp_path.glob("running-*"))
    assert capfd.readouterr().err == ""


def test_a_broken_disk_is_a_row_of_the_scan(scans, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "sub").write_text("in the way")
    outcome = batch.run(scans, tmp_path / "out")
    assert list(whys(outcome)) == ["sub/c.ply"]
    assert whys(outcome)["sub/c.ply"].startswith("can't be written to sub/c.obj: ")
    assert (tmp_path / "out" / "sub").read_text() == "in the way"


def test_a_system_without_room_for_processes_is_a_row(scans, tmp_path, monkeypatch):
    """The batch continues after a process that could not be started."""
    start, left = subprocess.Popen, [1]

    def few(*arguments, **keywords):
        if left and left.pop():
            raise OSError(errno.EAGAIN, "too many processes")
        return start(*arguments, **keywords)

    monkeypatch.setattr(process.subprocess, "Popen", few)
    outcome = batch.run(scans, tmp_path / "out", children=batch.Children(jobs=1))
    assert list(whys(outcome).values()) == ["no process can be started: too many processes"]
    assert len(outcome.rows) == 3
