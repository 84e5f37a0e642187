"""What can be wrong with a batch as a whole."""


class BatchError(Exception):
    """A batch can't be run as asked for. The message is shown as it is."""
