"""Errors of a run on tiles."""


class TilesError(Exception):
    """A run with these arguments is impossible."""


class TileFailed(RuntimeError):
    """A step of a run has failed: a tile can't be read, or memory is not sufficient."""
