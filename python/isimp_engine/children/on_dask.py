"""Children on the workers of a Dask cluster. All machines share a folder for the files.

Each thread of a worker has a process of its own that forks children. A Dask task only waits for a child, so a crash or
a hang of the child does not affect the worker.
"""

import os
import queue
import tempfile
import threading
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any

from .. import __version__
from .clusters import Cluster, started
from .errors import BatchError
from .nursery import Ending, Limits, Nursery, NurseryEnded

_LOOK = 0.5  # seconds between two checks that the batch is still running
_CONNECT = 20  # seconds to wait for a scheduler or a worker
_RESOURCE = "MB"  #: name of the workers' resource for memory, which is optional

_own = threading.local()


def run_one(task: dict[str, Any], parts: str, running: str, limits: Limits, work: str) -> tuple[str, Ending]:
    """Run a piece of work in a worker; returns the folder with its files, and its ending.

    running: a file that exists as long as the batch runs.
    """
    if not os.path.exists(running):  # noqa: PTH110
        raise BatchError(f"{running}: is not seen from here: OUTPUT_FOLDER must be a folder that all workers share")
    if getattr(_own, "work", None) != work:
        _own.work, _own.nursery = work, Nursery(work)
    nursery: Nursery = _own.nursery
    for tries in (1, 2):
        folder = tempfile.mkdtemp(dir=parts)
        try:
            nursery.start(0, task, Path(folder), limits)
            while not (found := nursery.endings(_LOOK)):
                if not os.path.exists(running):  # noqa: PTH110
                    nursery.close()
                    return folder, Ending("stopped", {})
            return folder, found[0][1]
        except NurseryEnded:
            if tries == 2:
                return folder, Ending("the process that runs scans was ended twice meanwhile", {})
    raise AssertionError


def version() -> str:
    return __version__


@contextmanager
def on_cluster(cluster: Cluster, parts: Path, limits: Limits, work: str) -> "Iterator[OnDask]":
    """Start a cluster; yields its workers."""
    with started(cluster) as address, OnDask(address, parts, limits, work, None) as workers:
        yield workers


class OnDask:
    """Runs pieces of work on the workers of a cluster.

    Workers with a resource MB run as many pieces at once as fit into it, by estimated need. Other workers run one piece
    in each thread.
    """

    def __init__(self, address: str, parts: Path, limits: Limits, work: str, patience: float | None = _CONNECT) -> None:
        """patience: seconds to wait for a worker; None: no limit, since jobs may wait in a queue."""
        try:
            import distributed
        except ImportError:
            raise BatchError("--dask needs the package distributed: pip install 'isimp[batch]'") from None
        try:
            self._client: Any = distributed.Client(address, timeout=_CONNECT)
        except (OSError, ValueError) as error:
            raise BatchError(f"--dask {address}: there is no scheduler of Dask ({_line(error)})") from None
        self._parts, self._work = parts, work
        self._running = parts.parent / f"running-{uuid.uuid4().hex}"
        self._done: queue.SimpleQueue[int] = queue.SimpleQueue()
        self._futures: dict[int, Any] = {}
        try:
            self._check(address, patience)
            self._mb, self._resource = self._memory()
        except BaseException:
            self._client.close()
            raise
        self._limits = Limits(limits.seconds, self._mb if limits.mb is None else limits.mb)
        self._running.touch()

    def __enter__(self) -> "OnDask":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._running.unlink(missing_ok=True)  # workers kill their children when this file is missing
        self._client.cancel(list(self._futures.values()))
        self._client.close()

    def refuses(self, mb: float) -> str:
        """Return why a piece of work with this need is refused; empty: it is not."""
        if not self._resource or self._mb is None or mb <= self._mb:
            return ""
        return f"needs about {mb:,.0f} MB, and the largest worker has {self._mb:,.0f} MB"

    def threads(self, mb: float, waiting: int) -> int:
        """Return 1: a worker runs as many children as it has threads."""
        return 1

    def start(self, number: int, task: dict[str, Any], mb: float) -> None:
        need = mb if self._limits.mb is None else min(mb, self._limits.mb)
        arguments = (task, str(self._parts), str(self._running), self._limits, self._work)
        resources = {_RESOURCE: need} if self._resource else None
        future = self._client.submit(run_one, *arguments, pure=False, resources=resources, priority=-number)
        self._futures[number] = future
        future.add_done_callback(self._note(number))

    def endings(self, seconds: float) -> list[tuple[int, Path, Ending]]:
        """Return a piece that has ended, with its folder. Waits at most `seconds` for it."""
        try:
            number = self._done.get(timeout=seconds)
        except queue.Empty:
            return []
        future = self._futures.pop(number)
        if future.status == "finished":
            folder, ending = future.result()
            return [(number, Path(folder), ending)]
        error = future.exception() if future.status == "error" else None
        if isinstance(error, BatchError):
            raise error
        why = f"Dask could not run it: {_line(error)}" if error is not None else "Dask cancelled it"
        return [(number, Path(tempfile.mkdtemp(dir=self._parts)), Ending(why, {}))]

    def _note(self, number: int) -> Callable[[Any], None]:
        return lambda _: self._done.put(number)

    def _check(self, address: str, patience: float | None) -> None:
        """Raise BatchError for workers without this version, before each scan fails on them."""
        try:
            self._client.wait_for_workers(1, timeout=patience)
        except TimeoutError:
            raise BatchError(f"--dask {address}: the scheduler has no worker") from None
        for worker, found in self._client.run(version, on_error="return").items():
            if found != __version__:
                what = f"isimp {found}" if isinstance(found, str) else _line(found)
                raise BatchError(f"--dask: the worker {worker} must have isimp {__version__}, it has: {what}")

    def _memory(self) -> tuple[float | None, bool]:
        """Return the MB for a child on the largest worker, and whether the workers have them as a resource."""
        workers = self._client.scheduler_info(n_workers=-1)["workers"].values()
        said = [worker["resources"][_RESOURCE] for worker in workers if _RESOURCE in worker.get("resources", {})]
        if said:
            return max(said), True
        limits = [worker["memory_limit"] / worker["nthreads"] / 2**20 for worker in workers if worker["memory_limit"]]
        return max(limits, default=None), False


def _line(error: object) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())[:300]
