"""Errors of a batch as a whole."""


class BatchError(Exception):
    """A batch can't be run with these arguments. The message is for the user."""


def line_of(error: object) -> str:
    """An error of another package as the end of a message."""
    return " ".join(f"{type(error).__name__}: {error}".split())[:300]
