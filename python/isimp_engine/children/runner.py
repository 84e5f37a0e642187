"""Runs pieces of work in child processes: starts the pieces that fit into memory and yields their endings."""

import os
import shutil
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

from ..folders import discard
from .clusters import Cluster
from .errors import BatchError
from .local import Local
from .on_dask import OnDask, on_cluster
from .process import Ending, Limits
from .workers import Workers

_TICK = 0.2  # most seconds between two calls of `watch`

Key = TypeVar("Key")


@dataclass(frozen=True)
class Children:
    """The place of children, this machine or the workers of a cluster, and their limits.

    Raises BatchError if no child can start.
    """

    jobs: int | None = None  #: largest number of children at once on this machine; None: one for each core
    dask: str | None = None  #: address of a Dask scheduler, whose workers have access to the same files
    cluster: Cluster | None = None  #: a cluster to start, in place of `dask`
    time_limit: float | None = None  #: limit of each child, seconds; None: no limit
    memory_limit: float | None = None  #: limit of each child, MB; None: the free memory

    def __post_init__(self) -> None:
        if not hasattr(os, "fork"):
            raise BatchError("child processes with limits need Linux or macOS")
        if self.jobs is not None and self.jobs < 1:
            raise BatchError(f"the number of jobs must be at least 1, got {self.jobs}")
        for name, value in (("time limit", self.time_limit), ("memory limit", self.memory_limit)):
            if value is not None and not 0 < value < float("inf"):
                raise BatchError(f"the {name} must be above 0, got {value:g}")
        if self.dask is not None and self.cluster is not None:
            raise BatchError("--dask and --cluster contradict each other; give one of them")

    def workers(self, parts: Path, work: str, threads: int | None = None) -> AbstractContextManager[Workers]:
        """Return the workers. parts: a folder for the folders of children. work, threads: see process.run and Local."""
        limits = Limits(self.time_limit, self.memory_limit)
        if self.cluster is not None:
            return on_cluster(self.cluster, parts, limits, work)
        if self.dask is not None:
            return OnDask(self.dask, parts, limits, work)
        return Local(parts, self.jobs, limits, work, threads)


@dataclass(frozen=True)
class Assignment(Generic[Key]):
    """A piece of work for a child."""

    key: Key  #: the caller's identifier
    mb: float  #: estimated need of memory
    task: Callable[[int], dict[str, Any]]  #: the task of the child, for a number of threads


def clear(parts: Path) -> None:
    """Make the folder of children, without the files that a killed run left in it and next to it."""
    for file in list(parts.parent.glob("running-*")):
        file.unlink(missing_ok=True)
    discard(parts)
    parts.mkdir(parents=True)


def endings(
    workers: Workers, pieces: Iterable[Assignment[Key]], watch: Callable[[list[Key]], None]
) -> Iterator[tuple[Key, Path | None, Ending]]:
    """Run pieces, the largest first; yields the key, the folder and the ending of each.

    The folder is removed after the caller has used it. None: the workers refused the piece. watch: called several times
    a second with the keys of the running pieces.
    """
    waiting = sorted(pieces, key=lambda piece: -piece.mb)  # large pieces must not be the last
    running: dict[int, Key] = {}
    following = 0
    while following < len(waiting) or running:
        while following < len(waiting):
            piece = waiting[following]
            if why := workers.refuses(piece.mb):
                yield piece.key, None, Ending(why, {})
            elif threads := workers.threads(piece.mb, len(waiting) - following):
                running[following] = piece.key
                workers.start(following, piece.task(threads), piece.mb)
            else:
                break
            following += 1
        for number, folder, ending in workers.endings(_TICK) if running else []:
            yield running.pop(number), folder, ending
            shutil.rmtree(folder, ignore_errors=True)
        watch(list(running.values()))
