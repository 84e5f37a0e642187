"""What can be wrong with a run on tiles."""


class TilesError(Exception):
    """It can't be run as it was asked for."""


class TileFailed(RuntimeError):
    """A step of a run has failed: a tile can't be read, or there is too little memory."""
