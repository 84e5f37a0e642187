"""Children on this machine. Its cores and its free memory limit their number."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from .. import machine
from .process import Ending, Limits, end_idle_children, run_in_folder
from .workers import Workers

_SHARE = 0.9  # share of the free memory


class Local(Workers):
    """Runs pieces of work on this machine; each has a thread that waits for its child.

    jobs: the largest number of pieces at once; None: as many as keep the cores busy.
    threads: number of threads of each piece; None: the method `threads` chooses it.
    """

    def __init__(self, parts: Path, jobs: int | None, limits: Limits, work: str, threads: int | None = None) -> None:
        self._cores = machine.cores()
        self._jobs = jobs or max(1, self._cores // (threads or 1))
        self._mb = _SHARE * machine.memory_mb()
        self._most = limits.mb  # limit of a child as given; None: the free memory
        self._scale = 1.0  # factor by which estimates have been too low
        self._pool = ThreadPoolExecutor(self._jobs)
        super().__init__(parts, Limits(limits.seconds, self._mb if limits.mb is None else limits.mb), work)

    def threads(self, mb: float, waiting: int) -> int:
        need = self._need(mb)
        free = self._mb - sum(map(self._need, self._needs.values()))
        if self._needs and (len(self._needs) >= self._jobs or need > free):
            return 0
        beside = max(1, int(self._mb // max(need, 1.0)))  # number of pieces of this size that fit into memory together
        return max(1, self._cores // min(self._jobs, len(self._needs) + waiting, beside))

    def _need(self, mb: float) -> float:
        need = mb * self._scale
        return need if self._most is None else min(need, self._most)

    def _submit(self, number: int, mb: float, arguments: tuple[Any, ...]) -> Any:
        return self._pool.submit(run_in_folder, *arguments)

    def _ended(self, mb: float, ending: Ending) -> None:
        if not ending.why and ending.peak_mb is not None:
            self._scale = max(self._scale, ending.peak_mb / max(mb, 1.0))

    def _close(self) -> None:
        self._pool.shutdown()
        end_idle_children()
