"""The command on a terminal: progress and Ctrl-C."""

import contextlib
import dis
import io
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import shapes
from batches import scan
from commands import ENVIRONMENT
from isimp_engine.cli import progress

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="needs a terminal and signals as POSIX has them")


@pytest.fixture(scope="module")
def big_scan(tmp_path_factory):
    """A file large enough that the command is working when it is interrupted."""
    path = tmp_path_factory.mktemp("big") / "big.ply"
    vertices, triangles = shapes.bumpy(500)
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\nproperty float x\nproperty float y\n"
    head += f"property float z\nelement face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    faces = np.zeros(len(triangles), dtype=[("n", "u1"), ("corners", "<i4", 3)])
    faces["n"], faces["corners"] = 3, triangles
    path.write_bytes(head.encode() + vertices.astype("<f4").tobytes() + faces.tobytes())
    return path


@contextlib.contextmanager
def on_a_terminal(*arguments):
    """The command with a terminal as its stderr: the process, and the terminal's two ends."""
    import pty

    terminal = pty.openpty()
    command = [sys.executable, "-m", "isimp_engine", *map(str, arguments)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=terminal[1], env=ENVIRONMENT) as process:
        yield process, terminal
    for end in terminal:
        os.close(end)


def read_all(process, terminal):
    """The output of the process: our hold on its end keeps the kernel from dropping unread text when it closes."""
    ours, theirs = terminal
    end = b"\0end\0"
    waiter = threading.Thread(target=lambda: (process.wait(), os.write(theirs, end)))
    waiter.start()
    text = b""
    while not text.endswith(end):
        text += os.read(ours, 4096)
    waiter.join()
    return text.removesuffix(end).decode()


@pytest.mark.parametrize("stage", ["read", "clean", "partition"])
def test_ctrl_c_is_130_with_nothing_half_written(big_scan, tmp_path, stage):
    out, labels, report = tmp_path / "o.ply", tmp_path / "l.npy", tmp_path / "r.json"
    flags = ["--proxies=3000", "--method=lloyd", "--iterations=500", "--labels", labels, "--report", report]
    with on_a_terminal("simplify", big_scan, out, *flags) as (process, terminal):
        text = b""
        while stage.encode() not in text:
            text += os.read(terminal[0], 4096)
        begun = time.monotonic()
        process.send_signal(signal.SIGINT)
        rest = read_all(process, terminal)
        assert process.wait(timeout=60) == 130
        assert time.monotonic() - begun < 10
        assert process.stdout.read() == b""
    assert rest.splitlines()[-1].endswith("isimp: interrupted, nothing was written")
    assert "Traceback" not in rest
    assert list(tmp_path.iterdir()) == []


def interrupting(number):
    """A tracer that raises KeyboardInterrupt after the given call of the code that shows progress, as Ctrl-C does."""
    left, before = number, {}

    def trace(frame, event, argument):
        nonlocal left
        if frame.f_code.co_filename not in (progress.__file__, contextlib.__file__, threading.__file__):
            return None
        frame.f_trace_lines, frame.f_trace_opcodes = False, True
        if event != "opcode":
            return trace
        names = {i.offset: i.opname for i in dis.get_instructions(frame.f_code)}
        was_call = names.get(before.get(frame), "").startswith("CALL")
        before[frame] = frame.f_lasti
        left -= was_call
        if left < 0:
            raise KeyboardInterrupt
        return trace

    return trace


def test_nothing_is_drawn_after_an_interrupt_at_any_time(monkeypatch):
    monkeypatch.setattr(progress, "_REDRAW", 0.001)
    for number in range(1000):
        monkeypatch.setattr(sys, "stderr", io.StringIO())
        sys.settrace(interrupting(number))
        try:
            with progress.Steps(show=True)("read"):
                pass
            break
        except KeyboardInterrupt:
            sys.stderr.write("interrupted")
        finally:
            sys.settrace(None)
        time.sleep(0.01)
        assert sys.stderr.getvalue().endswith("interrupted"), number
    assert number > 5
    assert sys.stderr.getvalue().endswith("\r\x1b[K")


def test_progress_is_shown_and_cleared(tmp_path):
    source = scan(tmp_path / "scan.ply")
    with on_a_terminal("simplify", source, tmp_path / "o.ply", "--proxies=20") as (process, terminal):
        text = read_all(process, terminal)
        assert process.wait(timeout=60) == 0
    for stage in ("read", "clean", "partition", "mesh", "write"):
        assert f"\x1b[K{stage} " in text
    assert text.endswith("\r\x1b[K")
    assert all(len(line) < 100 for line in text.split("\r"))
    with on_a_terminal("simplify", source, tmp_path / "o.ply", "--proxies=20", "--quiet") as (process, terminal):
        assert read_all(process, terminal) == ""
        assert process.wait(timeout=60) == 0
