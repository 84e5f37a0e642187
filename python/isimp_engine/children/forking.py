"""The process that forks children: `python -m isimp_engine.children.forking MODULE:FUNCTION`; see nursery.py.

It reads requests from stdin and writes endings to stdout, as JSON lines. When stdin ends, it kills its children and
ends.
"""

import contextlib
import ctypes
import errno
import gc
import importlib
import json
import os
import resource
import select
import signal
import sys
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy.ma  # noqa: F401  (numpy.unique loads it, which takes longer in each child than most steps of a tile)

from .. import machine
from .nursery import _RESULT, _SAID, NO_RESULT, NO_SPACE

Work = Callable[[dict[str, Any], Path], dict[str, Any]]

_POLL = 0.05  # seconds between two checks of the memory of children
_DIE_WITH_PARENT = 1  # PR_SET_PDEATHSIG of Linux
_NAME = 15  # PR_SET_NAME of Linux
_STACK_MB = 8.5  # address space of a thread's stack, most of which is never used


@dataclass
class Child:
    """A running child."""

    number: int
    begun: float
    deadline: float | None
    mb: float | None
    stopped: str | None = None  #: why it was killed: "seconds", "mb" or "stop"


class Server:
    """Forks, watches and kills children. It has one thread only, so that forking is safe."""

    def __init__(self, work: Work, requests: int, answers: int) -> None:
        self._work, self._requests, self._answers = work, requests, answers
        self._children: dict[int, Child] = {}
        self._rest = b""
        self._wake, wakes = os.pipe()
        for end in (self._wake, wakes):
            os.set_blocking(end, False)
        signal.set_wakeup_fd(wakes, warn_on_full_buffer=False)
        signal.signal(signal.SIGCHLD, lambda *_: None)

    def serve(self) -> None:
        try:
            while self._read():
                self._collect()
                self._watch()
        finally:
            for pid in self._children:
                _kill(pid)

    def _read(self) -> bool:
        """Wait for a request, the end of a child or the next check; returns False at the end of the requests."""
        ready = select.select([self._requests, self._wake], [], [], self._pause())[0]
        if self._wake in ready:
            os.read(self._wake, 4096)
        if self._requests in ready:
            data = os.read(self._requests, 1 << 16)
            if not data:
                return False
            *lines, self._rest = (self._rest + data).split(b"\n")
            for line in lines:
                request = json.loads(line)
                if request["do"] == "start":
                    self._start(request)
                else:
                    self._stop(request["number"])
        return True

    def _pause(self) -> float | None:
        now = time.monotonic()
        times = [child.deadline - now for child in self._children.values() if child.deadline is not None]
        times += [_POLL] if any(child.mb is not None for child in self._children.values()) else []
        return max(0.0, min(times)) if times else None

    def _start(self, request: dict[str, Any]) -> None:
        begun, parent = time.monotonic(), os.getpid()
        try:
            pid = os.fork()
        except OSError as error:  # the limit of processes is reached, or memory is short
            self._answer({"number": request["number"], "error": f"no process can be started: {error.strerror}"})
            return
        if pid == 0:
            try:
                _be_child(request, parent, self._work, (self._requests, self._answers, self._wake))
            finally:
                if sys.exc_info()[0] is not None:
                    traceback.print_exc()
                os._exit(70)
        limit = request["seconds"]
        deadline = None if limit is None else begun + limit
        self._children[pid] = Child(request["number"], begun, deadline, request["mb"])

    def _stop(self, number: int) -> None:
        for pid, child in self._children.items():
            if child.number == number:
                child.stopped = child.stopped or "stop"
                _kill(pid)

    def _collect(self) -> None:
        """Report how each ended child ended, with the kernel's peak of its memory."""
        for pid in list(self._children):
            ended, status, usage = os.wait4(pid, os.WNOHANG)
            if not ended:
                continue
            child = self._children.pop(pid)
            code = os.waitstatus_to_exitcode(status)
            peak = usage.ru_maxrss / (2**20 if sys.platform == "darwin" else 2**10)
            self._answer(
                {
                    "number": child.number,
                    "code": max(code, 0),
                    "signal": -min(code, 0),
                    "stopped": child.stopped,
                    "seconds": round(time.monotonic() - child.begun, 6),
                    "peak_mb": round(peak, 1),
                }
            )

    def _answer(self, values: dict[str, Any]) -> None:
        os.write(self._answers, json.dumps(values).encode() + b"\n")

    def _watch(self) -> None:
        """Kill children that exceed their limits."""
        now = time.monotonic()
        for pid, child in self._children.items():
            if child.stopped is not None:
                continue
            if child.deadline is not None and now >= child.deadline:
                child.stopped = "seconds"
            elif child.mb is not None and _memory(pid).get("VmHWM", 0.0) > child.mb:
                child.stopped = "mb"
            if child.stopped is not None:
                _kill(pid)


def _kill(pid: int) -> None:
    for kill in (os.killpg, os.kill):  # the group first: the work may have started other processes
        with contextlib.suppress(ProcessLookupError, PermissionError):
            kill(pid, signal.SIGKILL)


def _memory(pid: int | str) -> dict[str, float]:
    """Return the MB of each kind of memory of a process; empty if the system does not provide them."""
    try:
        lines = Path(f"/proc/{pid}/status").read_text(errors="replace").splitlines()
    except OSError:
        return {}
    return {line.split(":")[0]: int(line.split()[1]) / 1024 for line in lines if line.endswith(" kB")}


def _be_child(request: dict[str, Any], parent: int, work: Work, handles: tuple[int, ...]) -> None:
    """Run the work, write its result to the folder, and end the process."""
    _end_with(parent)
    _be_called(Path(str(request["task"].get("input", ""))).name)
    os.setpgid(0, 0)
    signal.set_wakeup_fd(-1)
    for number in (signal.SIGCHLD, signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_DFL)
    for handle in handles:
        os.close(handle)
    folder = Path(request["folder"])
    said = os.open(folder / _SAID, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o666)
    os.dup2(said, 2)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    limit_memory(request["mb"])
    try:
        values = work(request["task"], folder)
    except MemoryError:
        values = {"why": "MemoryError"}
    limit_memory(None)
    part = folder / f"{_RESULT}.part"
    try:
        part.write_text(json.dumps(values, allow_nan=False), encoding="utf-8")
        part.replace(folder / _RESULT)
    except OSError as error:  # no file can be written, so the exit status carries the reason
        os._exit(NO_SPACE if error.errno in (errno.ENOSPC, errno.EDQUOT) else NO_RESULT)
    os._exit(0)  # skips the release of the engine's memory, piece by piece


def _end_with(parent: int) -> None:
    """Make the system kill this process when its parent ends, even by kill -9."""
    if _LIBC is not None:
        _LIBC.prctl(_DIE_WITH_PARENT, signal.SIGKILL, 0, 0, 0)
    if os.getppid() != parent:
        os._exit(70)


def _be_called(name: str) -> None:
    """Set the name of the scan as the name of this process, for lists of processes."""
    if _LIBC is not None and name:
        _LIBC.prctl(_NAME, os.fsencode(name)[:15], 0, 0, 0)


def limit_memory(mb: float | None) -> None:
    """Limit this process to `mb` MB, including the memory that it uses now; None: only the hard limit applies.

    RLIMIT_DATA counts writable memory. Linux does not count address space that is only reserved, as by threads. Beyond
    the limit the engine raises MemoryError. Memory that is reserved and not used yet is added to the limit.
    """
    hard = resource.getrlimit(resource.RLIMIT_DATA)[1]
    if mb is None:
        resource.setrlimit(resource.RLIMIT_DATA, (hard, hard))
        return
    now = _memory("self")
    if "VmData" not in now:  # other systems do not enforce this limit
        return
    most = int(max(mb - now["VmRSS"], 1.0) + now["VmData"] + (machine.cores() + 4) * _STACK_MB) << 20
    resource.setrlimit(resource.RLIMIT_DATA, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))


def main() -> None:
    module, _, function = sys.argv[1].partition(":")
    work: Work = getattr(importlib.import_module(module), function)
    requests, answers = os.dup(0), os.dup(1)
    nothing = os.open(os.devnull, os.O_RDWR)
    os.dup2(nothing, 0)
    os.dup2(nothing, 1)
    gc.collect()
    gc.freeze()  # children share these pages
    with contextlib.suppress(BrokenPipeError):  # the reader of the answers has ended
        os.write(answers, b'{"ready": true}\n')
        Server(work, requests, answers).serve()


_LIBC = ctypes.CDLL(None, use_errno=True) if sys.platform == "linux" else None

if __name__ == "__main__":
    main()
