"""Long work on a thread of its own, with progress and cancel. Standard library only.

A `Watch` is the line between whoever waits and whoever works: progress and stage one way, the wish to stop the other
way. It spans several calls of the engine, each with a Job of its own, since a Job's progress never falls.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from enum import Enum
from itertools import accumulate
from typing import Any, Protocol

from .language import own, said


class Stopped(Exception):
    """The work was stopped from outside. Nothing was changed."""


def shares(times: list[float]) -> list[float]:
    """How far work is after each of its parts, which take about such times."""
    return [done / sum(times) for done in accumulate(times)]


class _Job(Protocol):
    """The members of the engine's Job that a Watch uses."""

    @property
    def progress(self) -> float: ...
    @property
    def stage(self) -> str: ...
    def cancel(self) -> None: ...


class Watch:
    """Progress, stage and cancel of some work, from any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._job: _Job | None = None
        self._from, self._to = 0.0, 1.0
        self._share = (0.0, 1.0)
        self._stage = ""
        self._cancelled = False

    def cancel(self) -> None:
        with self._lock:
            self._cancelled = True
            if self._job is not None:
                self._job.cancel()

    @property
    def cancelled(self) -> bool:
        return self._cancelled

    @property
    def progress(self) -> float:
        """How much is done, in [0, 1]."""
        with self._lock:
            inner = self._job.progress if self._job is not None else 0.0
            return self._from + (self._to - self._from) * inner

    @property
    def stage(self) -> str:
        with self._lock:
            return (self._job.stage if self._job is not None else "") or self._stage

    def poll(self) -> None:
        if self._cancelled:
            raise Stopped

    @contextmanager
    def share(self, begin: float, end: float) -> Iterator[None]:
        """Until its end, parts take the progress from `begin` to `end` and no further."""
        self._share = (begin, end)
        try:
            yield
        finally:
            self._share = (0.0, 1.0)

    @contextmanager
    def part(self, stage: str, begin: float, end: float, job: Any = None) -> Iterator[Any]:
        """Names a stage that takes the progress from `begin` to `end`; `job` is the engine's, if it works."""
        low, high = self._share
        begin, end = low + (high - low) * begin, low + (high - low) * end
        with self._lock:
            self._stage, self._from, self._to, self._job = stage, begin, end, job
            if self._cancelled:
                raise Stopped
        try:
            yield job
        finally:
            with self._lock:
                self._job, self._from = None, end


class Status(Enum):
    RUNNING = "running"
    DONE = "done"
    STOPPED = "stopped"
    FAILED = "failed"


class Task:
    """Runs `work(watch)` on a thread of its own and keeps its result or error."""

    def __init__(self, work: Callable[[Watch], Any], clock: Callable[[], float] = time.monotonic):
        self.watch = Watch()
        self.result: Any = None
        self.error: Exception | None = None
        self._clock = clock
        self._begun = clock()
        self._thread = threading.Thread(target=self._run, args=(work,), name="isimp", daemon=True)
        self._thread.start()

    def _run(self, work: Callable[[Watch], Any]) -> None:
        try:
            self.result = work(self.watch)
        except Exception as error:  # noqa: BLE001  (whatever it is, it is shown by the thread that waits)
            self.error = error

    def wait(self, seconds: float | None = None) -> Status:
        """Waits until the work ends, at most `seconds`, and says how it stands."""
        self._thread.join(seconds)
        return self.status

    @property
    def status(self) -> Status:
        if self._thread.is_alive():
            return Status.RUNNING
        if isinstance(self.error, Stopped):
            return Status.STOPPED
        return Status.FAILED if self.error is not None else Status.DONE

    def seconds_left(self) -> float | None:
        """An estimate from the progress so far; None while there is too little to tell."""
        progress, elapsed = self.watch.progress, self._clock() - self._begun
        if progress < 0.05 or elapsed < 0.5:
            return None
        return elapsed * (1.0 - progress) / progress

    def describe(self) -> str:
        """One line for people: the stage, how much is done, how long it will take."""
        left = self.seconds_left()
        stage = said(self.watch.stage.capitalize() or own("Working"))
        text = f"{stage} {self.watch.progress:.0%}"
        return (
            text if left is None else said("{progress}, {seconds} s left", progress=text, seconds=max(1, round(left)))
        )
