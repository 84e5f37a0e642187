"""Child processes with limits. A process loads the engine once, and forks a child for each piece of work.

A crash, a hang or a lack of memory ends one child only. The process that forks is a new one and never starts a thread.
So the state of the calling process does not matter: children have the engine in its state after loading.
"""

import contextlib
import json
import os
import select
import signal
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

from .errors import BatchError

SIMPLIFY = f"{__package__.removesuffix('.children')}.batch.work:simplify"  #: the default work of a batch
_RESULT, _SAID = "result.json", "stderr.txt"
NO_SPACE, NO_RESULT = 74, 73  # exit statuses of a child that can't write its result: full disk, or another reason
# Large arrays return to the system when they are freed, and use pages of 2 MB. By default glibc keeps freed arrays of
# up to 32 MB, and the peak of a child is a tenth higher. Other C libraries do not read this variable.
_ALLOCATOR = "glibc.malloc.mmap_threshold=4194304:glibc.malloc.hugetlb=1"


@dataclass(frozen=True)
class Limits:
    """The limits of a child; None: no limit."""

    seconds: float | None = None  #: wall time
    mb: float | None = None  #: memory, MB of 2^20 bytes


@dataclass(frozen=True)
class Ending:
    """How a child ended."""

    why: str  #: the reason of a failure; empty: success
    values: dict[str, Any]  #: the values that the work returned
    seconds: float = 0.0  #: from the fork to the end
    peak_mb: float | None = None  #: peak of memory, from the kernel


class NurseryEnded(Exception):
    """The process that forks children has ended, together with its children."""


class Nursery:
    """Runs pieces of work in child processes. Use it in a `with` block, from one thread at a time."""

    def __init__(self, work: str = SIMPLIFY) -> None:
        """Prepare only. The first piece of work starts the process.

        work: "module:function". The function gets the task, a dict of JSON values, and a folder of its own. It returns
              a dict of JSON values, or {"why": ...} if it fails.
        """
        self._work = work
        self._process: subprocess.Popen[bytes] | None = None
        self._rest = b""
        self._ready = False  # the process has loaded the work
        self._running: dict[int, tuple[Path, Limits]] = {}

    def __enter__(self) -> "Nursery":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def start(self, number: int, task: dict[str, Any], folder: Path, limits: Limits) -> None:
        """Start a piece of work. number: its identifier. folder: its own empty folder."""
        self._running[number] = folder, limits
        request = {"do": "start", "number": number, "task": task, "folder": str(folder)}
        self._send(request | {"seconds": limits.seconds, "mb": limits.mb})

    def stop(self, number: int) -> None:
        """Kill a piece of work. `endings` returns its ending, as for others."""
        self._send({"do": "stop", "number": number})

    def endings(self, seconds: float | None) -> list[tuple[int, Ending]]:
        """Return pieces that have ended. Waits for the first at most `seconds`; None: no limit. Raises NurseryEnded."""
        assert self._process is not None
        assert self._process.stdout is not None
        if not select.select([self._process.stdout], [], [], seconds)[0]:
            return []
        data = os.read(self._process.stdout.fileno(), 1 << 16)
        if not data:
            ready = self._ready
            self.close()
            if not ready:
                raise BatchError(f"no child process can be started for {self._work}; see its messages on stderr")
            raise NurseryEnded
        *lines, self._rest = (self._rest + data).split(b"\n")
        answers = [json.loads(line) for line in lines]
        self._ready = self._ready or bool(answers)
        return [self._ended(answer) for answer in answers if "number" in answer]

    def run(self, task: dict[str, Any], folder: Path, limits: Limits) -> Ending:
        """Run a piece of work, and wait for its end."""
        self.start(0, task, folder, limits)
        while True:
            for _, ending in self.endings(None):
                return ending

    def close(self) -> None:
        """End all children and the process that forks them."""
        if self._process is not None:
            for pipe in (self._process.stdin, self._process.stdout):
                if pipe is not None:
                    with contextlib.suppress(OSError):  # the process has ended without reading its last requests
                        pipe.close()
            try:
                self._process.wait(timeout=5)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        self._process, self._rest, self._running, self._ready = None, b"", {}, False

    def _send(self, request: dict[str, Any]) -> None:
        process = self._process or self._begin()
        assert process.stdin is not None
        with contextlib.suppress(OSError):  # the process has ended; `endings` raises the error
            process.stdin.write(json.dumps(request).encode() + b"\n")
            process.stdin.flush()

    def _begin(self) -> subprocess.Popen[bytes]:
        paths = os.pathsep.join(os.path.abspath(path) for path in sys.path)  # noqa: PTH100
        defaults = {"GLIBC_TUNABLES": _ALLOCATOR, "OPENBLAS_NUM_THREADS": "1"}  # otherwise numpy starts threads
        environment = {**defaults, **os.environ, "PYTHONPATH": paths}
        command = [sys.executable, "-m", f"{__package__}.forking", self._work]
        # Ctrl-C in a terminal must reach the calling process alone. The current folder must not contain modules.
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment, cwd=os.sep, start_new_session=True
        )
        return self._process

    def _ended(self, said: dict[str, Any]) -> tuple[int, Ending]:
        number: int = said["number"]
        folder, limits = self._running.pop(number)
        if "error" in said:
            return number, Ending(said["error"], {})
        values: dict[str, Any] = {}
        with contextlib.suppress(OSError, ValueError):  # the child may have ended before it wrote the file
            values = json.loads((folder / _RESULT).read_bytes())
        why = _why(said, values, folder, limits)
        values.pop("why", None)
        return number, Ending(why, {} if why else values, said["seconds"], said["peak_mb"])


def _why(said: dict[str, Any], values: dict[str, Any], folder: Path, limits: Limits) -> str:
    """Return the reason of a child's failure; empty: success."""
    number, why, last_line = said["signal"], values.get("why", ""), _last_line(folder / _SAID)
    lacks = why == "MemoryError" or ((number or said["code"]) and "bad_alloc" in last_line)
    if said["stopped"] == "seconds":
        return f"over the time limit of {limits.seconds:g} s"
    if said["stopped"] == "stop":
        return "stopped"
    if said["stopped"] == "mb" or (lacks and limits.mb is not None):
        return f"over the memory limit of {limits.mb:,.0f} MB"
    if lacks:
        return "there is not enough memory for it"
    more = f": {last_line}" if last_line else ""
    if said["code"] == NO_SPACE and not values:
        return f"no space is left on the disk of {folder.parent}"
    if said["code"] == NO_RESULT and not values:
        return f"its result can't be written to {folder.parent}"
    if number == signal.SIGKILL:
        return "ended by signal 9, as the system does when memory runs out"
    if number:
        return f"ended by signal {number}" + more
    if said["code"]:
        return f"ended with exit status {said['code']}" + more
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
