"""Children on this machine. Its cores and its free memory limit their number."""

import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

from .. import machine
from .nursery import Ending, Limits, Nursery, NurseryEnded

_SHARE = 0.9  # share of the free memory


@dataclass(frozen=True)
class Job:
    """A piece of work that is running."""

    task: dict[str, Any]
    folder: Path
    limits: Limits
    mb: float  #: estimated need
    tries: int = 1


class Local:
    """Runs pieces of work on this machine.

    parts: a folder for the folders of the pieces.
    jobs: the largest number of pieces at once; None: as many as keep the cores busy.
    threads: number of threads of each piece; None: the method `threads` chooses it.
    """

    def __init__(self, parts: Path, jobs: int | None, limits: Limits, work: str, threads: int | None = None) -> None:
        self._parts, self._cores = parts, machine.cores()
        self._jobs = jobs or max(1, self._cores // (threads or 1))
        self._mb = _SHARE * machine.memory_mb()
        self._limits = Limits(limits.seconds, self._mb if limits.mb is None else limits.mb)
        self._most = limits.mb  # limit of a child as given; None: the free memory
        self._scale = 1.0  # factor by which estimates have been too low
        self._running: dict[int, Job] = {}
        self._nursery = Nursery(work)

    def __enter__(self) -> "Local":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._nursery.close()

    def refuses(self, mb: float) -> str:
        """Return "": no piece of work is refused here, because the limit of the child applies."""
        return ""

    def threads(self, mb: float, waiting: int) -> int:
        """Return the number of threads for the next piece; 0: no room now.

        waiting: how many pieces have not started, this one included.
        """
        need = self._need(mb)
        free = self._mb - sum(self._need(job.mb) for job in self._running.values())
        if self._running and (len(self._running) >= self._jobs or need > free):
            return 0
        beside = max(1, int(self._mb // max(need, 1.0)))  # number of pieces of this size that fit into memory together
        return max(1, self._cores // min(self._jobs, len(self._running) + waiting, beside))

    def start(self, number: int, task: dict[str, Any], mb: float) -> None:
        self._begin(number, Job(task, self._folder(), self._limits, mb))

    def endings(self, seconds: float) -> list[tuple[int, Path, Ending]]:
        """Return the pieces that have ended, with their folders. Waits at most `seconds` for the first."""
        try:
            ended = self._nursery.endings(seconds)
        except NurseryEnded:
            return self._begin_again()
        found = []
        for number, ending in ended:
            job = self._running.pop(number)
            if not ending.why and ending.peak_mb is not None:
                self._scale = max(self._scale, ending.peak_mb / max(job.mb, 1.0))
            found.append((number, job.folder, ending))
        return found

    def _need(self, mb: float) -> float:
        need = mb * self._scale
        return need if self._most is None else min(need, self._most)

    def _folder(self) -> Path:
        return Path(tempfile.mkdtemp(dir=self._parts))

    def _begin(self, number: int, job: Job) -> None:
        self._running[number] = job
        self._nursery.start(number, job.task, job.folder, job.limits)

    def _begin_again(self) -> list[tuple[int, Path, Ending]]:
        """Start all pieces again, once each, after the process that forks and its children were killed."""
        lost, self._running = self._running, {}
        found = []
        for number, job in lost.items():
            if job.tries > 1:
                found.append((number, job.folder, Ending("the process that runs scans was ended twice meanwhile", {})))
                continue
            shutil.rmtree(job.folder, ignore_errors=True)
            self._begin(number, Job(job.task, self._folder(), job.limits, job.mb, job.tries + 1))
        return found
