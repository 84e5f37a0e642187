"""Child processes with limits. Each is a new Python (`child.py`), so the state of the calling process does not matter.

A crash, a hang or a lack of memory ends one child only. A child that has done little work does the next piece too,
since the start of a new one takes as long as the work on a small scan.
"""

import contextlib
import json
import os
import select
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .. import machine
from .errors import BatchError

SIMPLIFY = f"{__package__.removesuffix('.children')}.batch.work:simplify"  #: the default work of a batch
RESULT, SAID = "result.json", "stderr.txt"
FAILED, NO_WORK, NO_RESULT, NO_SPACE = 70, 72, 73, 74  # exit statuses of a child; NO_SPACE: its disk is full
_CHECK = 0.05  # seconds between two checks of a child
_LOOK = 0.25  # seconds between two checks that the run has not ended
_WORTH = 5.0  # seconds of work after which a child is not used again; the start of one takes .2 s
# Large arrays return to the system when they are freed, and use pages of 2 MB. By default glibc keeps freed arrays of
# up to 32 MB, and the peak of a child is a tenth higher. Other C libraries do not read this variable.
_ALLOCATOR = "glibc.malloc.mmap_threshold=4194304:glibc.malloc.hugetlb=1"


@dataclass(frozen=True)
class Limits:
    """The limits of a piece of work; None: no limit."""

    seconds: float | None = None  #: wall time
    mb: float | None = None  #: memory, MB of 2^20 bytes


@dataclass(frozen=True)
class Ending:
    """How a piece of work ended."""

    why: str  #: the reason of a failure; empty: success
    values: dict[str, Any]  #: the values that the work returned
    seconds: float = 0.0  #: from its start to its end
    peak_mb: float | None = None  #: peak of memory, from the kernel; of a killed child the last one that was seen


def run_in_folder(task: dict[str, Any], parts: str, running: str, limits: Limits, work: str) -> tuple[str, Ending]:
    """Run a piece of work in a new folder of `parts`; returns the folder with its files, and its ending.

    running: see `run`.
    """
    if not os.path.exists(running):  # noqa: PTH110
        raise BatchError(f"{running}: is not seen from here: OUTPUT_FOLDER must be a folder that all workers share")
    folder = tempfile.mkdtemp(dir=parts)
    return folder, run(work, task, Path(folder), limits, running)


def run(work: str, task: dict[str, Any], folder: Path, limits: Limits, running: str) -> Ending:
    """Run a piece of work in a child, and wait for its end.

    work: "module:function". The function gets the task, a dict of JSON values, and a folder of its own. It returns a
          dict of JSON values, or {"why": ...} if it fails.
    running: a file; the child is killed when it is missing. The system kills a child when the thread that started it
             ends.

    Raises BatchError if the work can't be loaded.
    """
    try:
        child = _idle_child(work) or Child(work, folder / SAID)
    except OSError as error:  # the limit of processes is reached, or memory is short
        return Ending(f"no process can be started: {error.strerror}", {})
    try:
        ending = child.run(task, folder, limits, running)
    except BaseException:
        child.end()
        raise
    if child.is_alive and child.worked < _WORTH:
        _idle.append(child)
    else:
        child.end()
    return ending


_idle: list["Child"] = []


def _idle_child(work: str) -> "Child | None":
    with contextlib.suppress(IndexError):
        while True:
            child = _idle.pop()
            if child.work == work and child.is_alive:
                return child
            child.end()
    return None


def end_idle_children() -> None:
    with contextlib.suppress(IndexError):
        while True:
            _idle.pop().end()


class Child:
    """A process that does pieces of work, one after another."""

    def __init__(self, work: str, messages: Path) -> None:
        """Start the process. messages: a file for them while it loads the work. Raises OSError."""
        self.work = work
        self.worked = 0.0  # seconds
        paths = os.pathsep.join(os.path.abspath(path) for path in sys.path)  # noqa: PTH100
        defaults = {"GLIBC_TUNABLES": _ALLOCATOR, "OPENBLAS_NUM_THREADS": "1"}  # otherwise numpy starts threads
        with messages.open("wb") as file:
            # Ctrl-C in a terminal must reach the calling process alone. The current folder must not contain modules.
            self._process = subprocess.Popen(
                [sys.executable, "-m", f"{__package__}.child", work, str(os.getpid())],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=file,
                env={**defaults, **os.environ, "PYTHONPATH": paths},
                cwd=os.sep,
                start_new_session=True,
            )
        self._is_ready = False  # it has loaded the work

    @property
    def is_alive(self) -> bool:
        return self._process.poll() is None

    def end(self) -> None:
        """End the process and the processes that its work has started."""
        if self.is_alive:
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(self._process.pid, signal.SIGKILL)
            self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                with contextlib.suppress(OSError):
                    pipe.close()

    def run(self, task: dict[str, Any], folder: Path, limits: Limits, running: str) -> Ending:
        """Do a piece of work; see `run` of this module."""
        request = {"task": task, "folder": str(folder), "mb": limits.mb}
        begun, peak = time.monotonic(), None
        stopped = "" if self._is_ready else self._watched(Limits(), running)[0]
        if not stopped and self.is_alive:
            self._is_ready, begun = True, time.monotonic()
            with contextlib.suppress(OSError):  # the process may have ended
                assert self._process.stdin is not None
                self._process.stdin.write(json.dumps(request).encode() + b"\n")
                self._process.stdin.flush()
            stopped, peak = self._watched(limits, running)
        if stopped:
            self.end()
        seconds = time.monotonic() - begun
        self.worked += seconds
        made: dict[str, Any] = {}
        with contextlib.suppress(OSError, ValueError):  # the process may have ended before it wrote the file
            made = json.loads((folder / RESULT).read_bytes())
        values, peak = made.get("values", {}), made.get("peak_mb", peak)
        code = self._process.poll() or 0
        if code == NO_WORK:
            raise BatchError(f"no child process can be started for {self.work}: {_last_line(folder / SAID)}")
        why = stopped or _why(code, values, folder, limits)
        values.pop("why", None)
        return Ending(why, {} if why else values, round(seconds, 6), peak and round(peak, 1))

    def _watched(self, limits: Limits, running: str) -> tuple[str, float | None]:
        """Wait until the process answers or ends; returns the reason to kill it, or nothing, and its peak."""
        assert self._process.stdout is not None
        begun = looked = time.monotonic()
        peak = None
        while not select.select([self._process.stdout], [], [], _CHECK)[0] and self.is_alive:
            peak = machine.memory_of(self._process.pid).get("VmHWM", peak)
            now = time.monotonic()
            if limits.seconds is not None and now - begun >= limits.seconds:
                return f"over the time limit of {limits.seconds:g} s", peak
            if limits.mb is not None and peak is not None and peak > limits.mb:
                return _over(limits.mb), peak
            if now - looked >= _LOOK:
                if not os.path.exists(running):  # noqa: PTH110
                    return "stopped", peak
                looked = now
        if not os.read(self._process.stdout.fileno(), 1):
            self._process.wait()
        return "", peak


def _over(mb: float) -> str:
    return f"over the memory limit of {mb:,.0f} MB"


def _why(code: int, values: dict[str, Any], folder: Path, limits: Limits) -> str:
    """Return the reason of a failure; empty: success. code: exit status, or -1 times the number of a signal."""
    why, last_line = values.get("why", ""), _last_line(folder / SAID)
    if why == "MemoryError" or (code and "bad_alloc" in last_line):
        return "there is not enough memory for it" if limits.mb is None else _over(limits.mb)
    more = f": {last_line}" if last_line else ""
    if code == NO_SPACE and not values:
        return f"no space is left on the disk of {folder.parent}"
    if code == NO_RESULT and not values:
        return f"its result can't be written to {folder.parent}"
    if code == -signal.SIGKILL:
        return "ended by signal 9, as the system does when memory runs out"
    if code < 0:
        return f"ended by signal {-code}" + more
    if code:
        return f"ended with exit status {code}" + more
    if not values:
        return "ended without a result" + more
    return str(why)


def _last_line(path: Path) -> str:
    try:
        with path.open("rb") as file:
            file.seek(max(0, path.stat().st_size - 2000))
            lines = file.read().decode(errors="replace").split("\n")
    except OSError:
        return ""
    return next((line.strip()[:300] for line in reversed(lines) if line.strip()), "")
