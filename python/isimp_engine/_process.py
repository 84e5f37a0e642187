"""Settings of the command for its process, made first: numpy and the engine load long enough for a Ctrl-C.

Nothing is done in a process that merely imports the engine.
"""

import os
import signal
import sys
from types import FrameType

INTERRUPTED = 130


def is_command() -> bool:
    """Whether this process is the command, as it is installed or as `python -m isimp_engine`."""
    as_module = sys.argv[:1] == ["-m"] and ("-m", __package__) in zip(sys.orig_argv, sys.orig_argv[1:], strict=False)
    return as_module or "isimp_command" in sys.modules


def end_at_once(number: int, frame: FrameType | None) -> None:
    try:
        os.write(2, b"isimp: interrupted, nothing was written\n")
    finally:
        os._exit(INTERRUPTED)


def begin() -> None:
    """Make Ctrl-C end the process without a traceback, unless it is ignored, as for work in the background."""
    for handle in (0, 1, 2):  # a file that is opened later must not replace the output of messages
        try:
            os.fstat(handle)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, end_at_once)


def expect_interrupts() -> None:
    """From now on Ctrl-C is a KeyboardInterrupt, which the command handles."""
    if signal.getsignal(signal.SIGINT) is end_at_once:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def ignore_interrupts() -> None:
    """Ignore a later Ctrl-C, since the work is done or given up."""
    if is_begun and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_IGN)


is_begun = is_command()
if is_begun:
    begin()
