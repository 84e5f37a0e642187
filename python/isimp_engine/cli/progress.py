"""Progress of a job on a terminal."""

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


class Progress:
    """Shows what `job` is doing on one line of a terminal, and clears the line at the end.

    The line is redrawn by a thread of its own, since the engine's calls wait on the main thread, where Ctrl-C arrives.
    """

    def __init__(self, name: str, job: Job, stream: TextIO) -> None:
        self._name, self._job, self._stream = name, job, stream
        self._done = threading.Event()
        self._thread = threading.Thread(target=self._redraw, daemon=True)

    def __enter__(self) -> None:
        try:
            self._thread.start()
        except KeyboardInterrupt:  # waiting for the thread, which may have drawn already
            self._stop()
            raise

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stop()

    def _stop(self) -> None:
        self._done.set()
        if self._thread.is_alive():
            self._thread.join()
        self._stream.write("\r\x1b[K")
        self._stream.flush()

    def _redraw(self) -> None:
        while True:
            self._stream.write("\r\x1b[K" + line(self._name, self._job))
            self._stream.flush()
            if self._done.wait(_REDRAW):
                return


def line(name: str, job: Job) -> str:
    """Stage and bar, no wider than the terminal: `partition  [######------]  50 %  flooding`."""
    done = round(job.progress * _BAR)
    text = f"{name:<9} [{'#' * done}{'-' * (_BAR - done)}] {job.progress:4.0%}  {job.stage}"
    return text[: shutil.get_terminal_size().columns - 1]


class Screen:
    """One line on stderr that is drawn anew some times a second."""

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
