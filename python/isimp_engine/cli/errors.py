"""The errors of the command line alone, and the exit statuses."""

import signal

from .. import _process


class UsageError(Exception):
    """The arguments don't go together, or not with this input; the message is shown as it is."""


def flag(option: str) -> str:
    """The flag of an option."""
    renamed = {"materials": "--keep-materials", "most_vertices": "--max-vertices"}
    return renamed.get(option, "--" + option.replace("_", "-"))


#: exit statuses
OK, USAGE, BAD_INPUT, SOME_FAILED = 0, 2, 3, 4
INTERRUPTED, TERMINATED = _process.INTERRUPTED, 128 + signal.SIGTERM
