"""Signals that ask the command to end."""

import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

_MOMENT = 0.02  # seconds


class Terminated(KeyboardInterrupt):
    """SIGTERM came."""


@contextmanager
def terminable() -> Iterator[None]:
    """Makes SIGTERM and the end of the terminal stop the block like Ctrl-C."""
    with _handled(_endings(), _end), _not_lost():
        yield


@contextmanager
def _not_lost() -> Iterator[None]:
    """Sends a signal again, a moment later, if its exception was raised in a destructor, where it has no effect."""
    before, timers = sys.unraisablehook, list[threading.Timer]()

    def hook(lost: Any) -> None:
        if not isinstance(lost.exc_value, KeyboardInterrupt):
            before(lost)
            return
        number = signal.SIGTERM if isinstance(lost.exc_value, Terminated) else signal.SIGINT
        timers.append(threading.Timer(_MOMENT, signal.raise_signal, (number,)))
        timers[-1].daemon = True
        timers[-1].start()

    sys.unraisablehook = hook
    try:
        yield
    finally:
        sys.unraisablehook = before
        for timer in timers:
            timer.cancel()


class Interrupts:
    """Ctrl-C and SIGTERM: they raise at once before the first call of `check`, and later only when it is called.

    An exception at an arbitrary place may be lost in a destructor, or end a step in the middle. A second signal raises
    at once in any case.
    """

    def __init__(self) -> None:
        self._waits = False
        self._came: int | None = None

    def check(self) -> None:
        self._waits = True
        if self._came is not None:
            _end(self._came, None)

    def handle(self, number: int, frame: FrameType | None) -> None:
        if not self._waits or self._came is not None:
            _end(number, frame)
        self._came = number


@contextmanager
def deferrable() -> Iterator[Interrupts]:
    """Acts like `terminable`, but signals wait for calls of `Interrupts.check`."""
    interrupts = Interrupts()
    is_awaited = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    with _handled(_endings() + [signal.SIGINT] * is_awaited, interrupts.handle):
        yield interrupts


def _endings() -> list[signal.Signals]:
    """The signals that request the end of a process, except Ctrl-C."""
    return [signal.SIGTERM] + ([signal.SIGHUP] if hasattr(signal, "SIGHUP") else [])


def _end(number: int, frame: FrameType | None) -> None:
    raise KeyboardInterrupt if number == signal.SIGINT else Terminated


@contextmanager
def _handled(numbers: list[signal.Signals], handler: Callable[[int, FrameType | None], None]) -> Iterator[None]:
    before = {number: signal.getsignal(number) for number in numbers}
    try:
        for number, other in before.items():
            if other is not signal.SIG_IGN:  # as under nohup
                signal.signal(number, handler)
        yield
    finally:
        for number, other in before.items():
            signal.signal(number, other if other is not None else signal.SIG_DFL)


@contextmanager
def too_late() -> Iterator[None]:
    """Ignores signals during the block: its work is short, and must not be done in part."""
    with _handled([*_endings(), signal.SIGINT], lambda number, frame: None):
        yield
