"""Processes that end, or have to, while the engine works."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import isimp_engine as engine

PACKAGES = str(Path(engine.__file__).parents[1])
ENVIRONMENT = {**os.environ, "PYTHONPATH": os.pathsep.join([PACKAGES, str(Path(__file__).parents[2] / "shared")])}

WORK = """
import sys, threading, time
import isimp_engine as engine, shapes
sheet = shapes.plane(300)
mesh = engine.Mesh(*shapes.bumpy(60))
part = engine.partition(mesh, engine.PartitionOptions(proxies=50))
long = engine.PartitionOptions(proxies=300, method="lloyd", iterations=2000)
def again(work):
    while True:
        try: work()
        except engine.Cancelled: pass
works = [lambda: engine.Mesh(*sheet), lambda: engine.partition(mesh, long), lambda: engine.add_proxy(mesh, part, 5)]
for work in works:
    threading.Thread(target=again, args=(work,), daemon=True).start()
time.sleep(float(sys.argv[1]))
print("done")
"""


def run(code, *arguments):
    command = [sys.executable, "-c", code, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, env=ENVIRONMENT, timeout=60)


@pytest.mark.parametrize("seconds", [0.0, 0.03, 0.1, 0.17])
def test_the_interpreter_may_end_while_daemon_threads_are_in_the_engine(seconds):
    done = run(WORK, seconds)
    assert (done.returncode, done.stdout, done.stderr) == (0, "done\n", "")


def test_functions_at_the_end_may_use_the_engine():
    """A function that was registered before the engine was loaded runs after the engine has stopped its calls."""
    code = """
import atexit
@atexit.register
def last():
    print(engine.Mesh([[0., 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]).report["faces"])
import isimp_engine as engine
"""
    done = run(code)
    assert (done.returncode, done.stdout, done.stderr) == (0, "1\n", "")


def test_more_threads_than_memory_has_room_for_do_not_end_the_process():
    if sys.platform != "linux":
        pytest.skip("needs a limit on address space")
    code = """
import resource
import isimp_engine as engine, shapes
mesh = engine.Mesh(*shapes.bumpy(100))
engine.partition(mesh, engine.PartitionOptions(proxies=40))
size = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (size + 400 * 2**20,) * 2)
one = engine.partition(mesh, engine.PartitionOptions(proxies=40, method="queued", threads=1))
for threads in (250, 100_000, 2**31 - 1):
    many = engine.partition(mesh, engine.PartitionOptions(proxies=40, method="queued", threads=threads))
    assert (many.face_region == one.face_region).all()
print("done")
"""
    done = run(code)
    assert (done.returncode, done.stdout, done.stderr) == (0, "done\n", "")


posix = pytest.mark.skipif(sys.platform == "win32", reason="needs signals and pipes as POSIX has them")


@pytest.fixture
def pipe(tmp_path):
    path = tmp_path / "scan.ply"
    os.mkfifo(path)
    return path


COMMANDS = {
    "module": ["-m", "isimp_engine"],
    "installed": ["-c", "import sys; from isimp_command import main; sys.argv[0] = 'isimp'; sys.exit(main())"],
}


@posix
@pytest.mark.parametrize("command", COMMANDS)
def test_ctrl_c_while_it_waits_for_a_pipe_is_130(pipe, command):
    with subprocess.Popen(
        [sys.executable, *COMMANDS[command], "info", pipe], stderr=subprocess.PIPE, text=True, env=ENVIRONMENT
    ) as process:
        with pipe.open("wb"):  # opens once the command reads
            process.send_signal(signal.SIGINT)
            assert process.wait(timeout=30) == 130
        assert process.stderr.read() == "isimp: interrupted, nothing was written\n"


@posix
@pytest.mark.parametrize("command", COMMANDS)
def test_ctrl_c_while_it_loads_is_130_without_a_traceback(tmp_path, command):
    """A numpy that loads slowly, and prints a line when it is loaded."""
    (tmp_path / "numpy.py").write_text("import time\nprint('loading', flush=True)\ntime.sleep(30)\n")
    environment = {**ENVIRONMENT, "PYTHONPATH": os.pathsep.join([str(tmp_path), ENVIRONMENT["PYTHONPATH"]])}
    with subprocess.Popen(
        [sys.executable, *COMMANDS[command], "info", "scan.ply"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment,
    ) as process:
        assert process.stdout.readline() == "loading\n"
        process.send_signal(signal.SIGINT)
        begun = time.monotonic()
        assert process.wait(timeout=20) == 130
        assert time.monotonic() - begun < 10, "it did not wait for the end of loading"
        assert process.stderr.read() == "isimp: interrupted, nothing was written\n"


@posix
def test_a_process_that_imports_the_engine_keeps_its_signals():
    code = "import signal, isimp_engine; print(signal.getsignal(signal.SIGINT) is signal.default_int_handler)"
    assert run(code).stdout == "True\n"
