"""The jobs of the steps of a run, and the shares of its progress."""

import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import Protocol

from ._core import Job, _Stretch

#: the job for the work between two shares of all
Jobs = Callable[[float, float], AbstractContextManager[Job | None]]


class Steps(Protocol):
    """Makes the job of each step of a run, in a context that lasts as long as the step."""

    def __call__(self, name: str, /) -> AbstractContextManager[Job]: ...


#: by name of a step: the share of all work that is done after its first call, its second one, and all later ones
_ENDS = {
    "read": (0.05,),
    "clean": (0.15,),
    "partition": (0.35, 0.4, 0.45),
    "regularise": (0.45,),
    "mesh": (0.5, 0.95),
    "texture": (1.0,),
}


class OneJob:
    """All steps in the job of a caller."""

    def __init__(self, job: Job | None) -> None:
        self._job, self._done = job or Job(), 0.0
        self._begun = dict.fromkeys(_ENDS, 0)
        self.seconds: dict[str, float] = {}

    @contextmanager
    def __call__(self, name: str) -> Iterator[Job]:
        begun, ends, number = time.perf_counter(), _ENDS[name], self._begun[name]
        self._begun[name] += 1
        begin, self._done = self._done, max(self._done, ends[min(number, len(ends) - 1)])
        with _Stretch(self._job, begin, self._done):
            yield self._job
        self.seconds[name] = round(self.seconds.get(name, 0.0) + time.perf_counter() - begun, 6)

    def end(self) -> None:
        with _Stretch(self._job, self._done, 1.0):
            pass


def stretches(job: Job | None) -> Jobs:
    """One job for all parts of the work, each of which moves its progress from one share to another."""

    @contextmanager
    def stretch(begin: float, end: float) -> Iterator[Job | None]:
        with nullcontext() if job is None else _Stretch(job, begin, end):
            yield job

    return stretch
