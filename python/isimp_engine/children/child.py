"""A child process: `python -m isimp_engine.children.child MODULE:FUNCTION PARENT`; see process.py.

It reads pieces of work from stdin as JSON lines, and writes a byte to stdout when it is ready and after each piece.
"""

import contextlib
import ctypes
import errno
import importlib
import json
import os
import resource
import signal
import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

from .. import machine
from .process import FAILED, NO_RESULT, NO_SPACE, NO_WORK, RESULT, SAID

_DIE_WITH_PARENT = 1  # PR_SET_PDEATHSIG of Linux
_NAME = 15  # PR_SET_NAME of Linux
_STACK_MB = 8.5  # address space of a thread's stack, most of which is never used
_LIBC = ctypes.CDLL(None, use_errno=True) if sys.platform == "linux" else None

Work = Callable[[dict[str, Any], Path], dict[str, Any]]


def main() -> None:
    _end_with(int(sys.argv[2]))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    requests, answers, nothing = os.dup(0), os.dup(1), os.open(os.devnull, os.O_RDWR)
    for handle in (0, 1):
        os.dup2(nothing, handle)
    code = NO_WORK
    try:
        module, _, function = sys.argv[1].partition(":")
        work: Work = getattr(importlib.import_module(module), function)
        code = FAILED
        with os.fdopen(requests, "rb") as lines:
            os.write(answers, b"\n")
            for line in lines:
                _do(work, json.loads(line))
                os.write(answers, b"\n")
        code = 0
    finally:
        if code:
            traceback.print_exc()
        os._exit(code)  # skips the release of the engine's memory, piece by piece


def _do(work: Work, request: dict[str, Any]) -> None:
    """Do a piece of work, and write its result to its folder."""
    folder, task = Path(request["folder"]), request["task"]
    _be_called(Path(str(task.get("input", ""))).name)
    said = os.open(folder / SAID, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o666)
    os.dup2(said, 2)
    os.close(said)
    with contextlib.suppress(OSError):  # some systems can't reset the peak
        Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
    limit_memory(request["mb"])
    try:
        values = work(task, folder)
    except MemoryError:
        values = {"why": "MemoryError"}
    limit_memory(None)
    text, part = (
        json.dumps({"values": values, "peak_mb": machine.peak_mb()}, allow_nan=False),
        folder / f"{RESULT}.part",
    )
    try:
        part.write_text(text, encoding="utf-8")
        part.replace(folder / RESULT)
    except OSError as error:  # no file can be written, so the exit status has the reason
        os._exit(NO_SPACE if error.errno in (errno.ENOSPC, errno.EDQUOT) else NO_RESULT)


def _end_with(parent: int) -> None:
    """Make the system kill this process when its parent ends, even by kill -9."""
    if _LIBC is not None:
        _LIBC.prctl(_DIE_WITH_PARENT, signal.SIGKILL, 0, 0, 0)
    if os.getppid() != parent:
        os._exit(FAILED)


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
    now = machine.memory_of("self")
    if "VmData" not in now:  # other systems do not enforce this limit
        return
    most = int(max(mb - now["VmRSS"], 1.0) + now["VmData"] + (machine.cores() + 4) * _STACK_MB) << 20
    resource.setrlimit(resource.RLIMIT_DATA, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))


if __name__ == "__main__":
    main()
