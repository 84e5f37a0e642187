"""Progress of a job on a terminal."""

import _thread
import shutil
import sys
import threading
import time
from collections.abc import Callable
from types import TracebackType
from typing import TextIO

from .. import Job

_BAR = 30
_REDRAW = 0.1  # seconds


class Steps:
    """The steps of one run, each with a job of its own, shown while it lasts, and the seconds each took."""

    def __init__(self, show: bool) -> None:
        self.seconds: dict[str, float] = {}
        self._show = show

    def __call__(self, name: str) -> "_Step":
        return _Step(name, self.seconds, sys.stderr if self._show else None)

    def say(self, line: str) -> None:
        """A line between two steps, where they are shown."""
        if self._show:
            print(line, file=sys.stderr)


class _Step:
    """A context that returns a job, shows its progress on one line of a terminal, and clears the line at the end.

    The line is redrawn by a thread of its own, since the engine's calls wait on the main thread, where Ctrl-C arrives.
    This is a class because a Ctrl-C that arrives as a generator's context is entered would leave the context open. It
    uses a lock only, which is written in C: a Ctrl-C inside Thread.start or an Event leaves their locks as they are.
    """

    def __init__(self, name: str, seconds: dict[str, float], stream: TextIO | None) -> None:
        self._name, self._seconds, self._stream = name, seconds, stream
        self._job, self._start = Job(), time.perf_counter()
        self._done, self._drawing = False, threading.Lock()

    def __enter__(self) -> Job:
        if self._stream is not None:
            try:
                self._draw(self._stream)
                _thread.start_new_thread(self._redraw, (self._stream,))
            except KeyboardInterrupt:
                self._clear(self._stream)
                raise
        return self._job

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._stream is not None:
            try:
                self._clear(self._stream)
            except KeyboardInterrupt:
                self._clear(self._stream)
                raise
        if kind is None:
            spent = time.perf_counter() - self._start
            self._seconds[self._name] = round(self._seconds.get(self._name, 0.0) + spent, 6)

    def _clear(self, stream: TextIO) -> None:
        """Clear the line; nothing is drawn after that."""
        self._done = True
        with self._drawing:
            stream.write("\r\x1b[K")
            stream.flush()

    def _draw(self, stream: TextIO) -> None:
        with self._drawing:
            if not self._done:
                stream.write("\r\x1b[K" + line(self._name, self._job))
                stream.flush()

    def _redraw(self, stream: TextIO) -> None:
        while not self._done:
            time.sleep(_REDRAW)
            self._draw(stream)


def line(name: str, job: Job) -> str:
    """Stage and bar, no wider than the terminal: `partition  [######------]  50 %  flooding`."""
    done = round(job.progress * _BAR)
    text = f"{name:<9} [{'#' * done}{'-' * (_BAR - done)}] {job.progress:4.0%}  {job.stage}"
    return text[: shutil.get_terminal_size().columns - 1]


class Screen:
    """One line on stderr that is redrawn several times a second."""

    def __init__(self) -> None:
        self._drawn = 0.0

    def draw(self, text: Callable[[], str]) -> None:
        """Show a line, no wider than the terminal, unless the last one is too young; names may be any bytes."""
        now = time.monotonic()
        if now - self._drawn < _REDRAW:
            return
        self._drawn = now
        shown = text()[: shutil.get_terminal_size().columns - 1]
        sys.stderr.write("\r\x1b[K" + shown.encode(errors="replace").decode())
        sys.stderr.flush()

    def clear(self) -> None:
        sys.stderr.write("\r\x1b[K")
        sys.stderr.flush()


def wanted(quiet: bool) -> bool:
    return not quiet and sys.stderr is not None and sys.stderr.isatty()
