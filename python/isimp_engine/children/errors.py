"""Errors of a batch as a whole."""


class BatchError(Exception):
    """A batch can't be run with these arguments. The message is for the user."""
