"""Runs long work on its own thread, with progress and cancel. Standard library only.

A `Watch` connects the waiting thread and the worker: the worker reports progress and stage, the waiting thread may
cancel. A watch spans several calls of the engine, each with its own Job, since a Job's progress never falls.
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
    """The work was cancelled. Nothing was changed."""


def shares(times: list[float]) -> list[float]:
    """Return the progress after each part of some work, from the estimated times of the parts."""
    return [done / sum(times) for done in accumulate(times)]


class _Job(Protocol):
    """The members of the engine's Job that a Watch uses."""

    @property
    def progress(self) -> float: ...
    @property
    def stage(self) -> str: ...
    def cancel(self) -> None: ...


class Watch:
    """Progress, stage and cancel of some work. Thread-safe."""

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
        """The completed share, in [0, 1]."""
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
        """Maps the progress of all parts inside the context to the range from `begin` to `end`."""
        self._share = (begin, end)
        try:
            yield
        finally:
            self._share = (0.0, 1.0)

    @contextmanager
    def part(self, stage: str, begin: float, end: float, job: Any = None) -> Iterator[Any]:
        """Starts a stage with progress from `begin` to `end`. job: the engine's Job, if the engine does the work."""
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
        except Exception as error:  # noqa: BLE001  (the waiting thread shows any error)
            self.error = error

    def wait(self, seconds: float | None = None) -> Status:
        """Waits until the work ends, at most `seconds`, and returns the status."""
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
        """Return an estimate from the progress; None if the progress is too small for one."""
        progress, elapsed = self.watch.progress, self._clock() - self._begun
        if progress < 0.05 or elapsed < 0.5:
            return None
        return elapsed * (1.0 - progress) / progress

    def describe(self) -> str:
        """Return one line for the user: stage, completed share, remaining time."""
        left = self.seconds_left()
        stage = said(self.watch.stage.capitalize() or own("Working"))
        text = f"{stage} {min(self.watch.progress, 0.99):.0%}"  # 100 % is the end of the work
        return (
            text if left is None else said("{progress}, {seconds} s left", progress=text, seconds=max(1, round(left)))
        )
