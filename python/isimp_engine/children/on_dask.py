"""Children on the workers of a Dask cluster. All machines share a folder for the files.

A Dask task only waits for a child, so a crash or a hang of the child does not affect the worker.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from .. import __version__
from .clusters import Cluster, started
from .errors import BatchError, line_of
from .process import Limits, run_in_folder
from .workers import Workers

_CONNECT = 20  # seconds to wait for a scheduler or a worker
_RESOURCE = "MB"  #: name of the workers' resource for memory, which is optional


def version() -> str:
    return __version__


@contextmanager
def on_cluster(cluster: Cluster, parts: Path, limits: Limits, work: str) -> "Iterator[OnDask]":
    """Start a cluster; yields its workers."""
    with started(cluster) as address, OnDask(address, parts, limits, work, None) as workers:
        yield workers


class OnDask(Workers):
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
            raise BatchError(f"--dask {address}: there is no scheduler of Dask ({line_of(error)})") from None
        try:
            self._check(address, patience)
            self._mb, self._resource = self._memory()
        except BaseException:
            self._client.close()
            raise
        super().__init__(parts, Limits(limits.seconds, self._mb if limits.mb is None else limits.mb), work)

    def __enter__(self) -> "OnDask":
        super().__enter__()
        return self

    def refuses(self, mb: float) -> str:
        if not self._resource or self._mb is None or mb <= self._mb:
            return ""
        return f"needs about {mb:,.0f} MB, and the largest worker has {self._mb:,.0f} MB"

    def threads(self, mb: float, waiting: int) -> int:
        """Return 1: a worker runs as many children as it has threads."""
        return 1

    def _submit(self, number: int, mb: float, arguments: tuple[Any, ...]) -> Any:
        need = mb if self._limits.mb is None else min(mb, self._limits.mb)
        resources = {_RESOURCE: need} if self._resource else None
        return self._client.submit(run_in_folder, *arguments, pure=False, resources=resources, priority=-number)

    def _lost(self, future: Any) -> str:
        if future.status == "finished":
            return ""
        error = future.exception() if future.status == "error" else None
        if isinstance(error, BatchError):
            raise error
        return "Dask cancelled it" if error is None else f"Dask could not run it: {line_of(error)}"

    def _close(self) -> None:
        self._client.cancel(list(self._futures.values()))
        self._client.close()

    def _check(self, address: str, patience: float | None) -> None:
        """Raise BatchError for workers without this version, before each scan fails on them."""
        try:
            self._client.wait_for_workers(1, timeout=patience)
        except TimeoutError:
            raise BatchError(f"--dask {address}: the scheduler has no worker") from None
        for worker, found in self._client.run(version, on_error="return").items():
            if found != __version__:
                what = f"isimp {found}" if isinstance(found, str) else line_of(found)
                raise BatchError(f"--dask: the worker {worker} must have isimp {__version__}, it has: {what}")

    def _memory(self) -> tuple[float | None, bool]:
        """Return the MB for a child on the largest worker, and whether the workers have them as a resource."""
        workers = self._client.scheduler_info(n_workers=-1)["workers"].values()
        said = [worker["resources"][_RESOURCE] for worker in workers if _RESOURCE in worker.get("resources", {})]
        if said:
            return max(said), True
        limits = [worker["memory_limit"] / worker["nthreads"] / 2**20 for worker in workers if worker["memory_limit"]]
        return max(limits, default=None), False
