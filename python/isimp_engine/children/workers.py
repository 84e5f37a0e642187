"""The interface of workers: pieces of work run in children at the same time, and their endings arrive one by one."""

import queue
import tempfile
import uuid
from pathlib import Path
from types import TracebackType
from typing import Any

from .process import Ending, Limits


class Workers:
    """Runs pieces of work by `process.run_in_folder`. Use it in a `with` block; its children end with the block."""

    def __init__(self, parts: Path, limits: Limits, work: str) -> None:
        """parts: a folder for the folders of the pieces. work: see `process.run`."""
        self._parts, self._limits, self._work = parts, limits, work
        self._running = parts.parent / f"running-{uuid.uuid4().hex}"  # children are killed when this file is missing
        self._done: queue.SimpleQueue[int] = queue.SimpleQueue()
        self._futures: dict[int, Any] = {}
        self._needs: dict[int, float] = {}

    def __enter__(self) -> "Workers":
        self._running.touch()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._running.unlink(missing_ok=True)
        self._close()

    def refuses(self, mb: float) -> str:
        """Return why a piece of work with this need is refused; empty: it is not."""
        return ""

    def threads(self, mb: float, waiting: int) -> int:
        """Return the number of threads for the next piece; 0: no room now.

        waiting: how many pieces have not started, this one included.
        """
        raise NotImplementedError

    def start(self, number: int, task: dict[str, Any], mb: float) -> None:
        """Start a piece. number: its identifier. mb: its estimated need of memory."""
        arguments = task, str(self._parts), str(self._running), self._limits, self._work
        self._needs[number], future = mb, self._submit(number, mb, arguments)
        self._futures[number] = future
        future.add_done_callback(lambda _: self._done.put(number))

    def endings(self, seconds: float) -> list[tuple[int, Path, Ending]]:
        """Return a piece that has ended, with its folder. Waits at most `seconds` for it."""
        try:
            number = self._done.get(timeout=seconds)
        except queue.Empty:
            return []
        future = self._futures.pop(number)
        why = self._lost(future)
        folder, ending = (tempfile.mkdtemp(dir=self._parts), Ending(why, {})) if why else future.result()
        self._ended(self._needs.pop(number), ending)
        return [(number, Path(folder), ending)]

    def _submit(self, number: int, mb: float, arguments: tuple[Any, ...]) -> Any:
        """Return the future of `process.run_in_folder`."""
        raise NotImplementedError

    def _ended(self, mb: float, ending: Ending) -> None:
        """Compare the memory of an ended piece with its estimate `mb`."""

    def _lost(self, future: Any) -> str:
        """Return why a piece has no ending; empty: it has one."""
        return ""

    def _close(self) -> None:
        """Wait for the end of all children of this machine, or leave them to their workers."""
