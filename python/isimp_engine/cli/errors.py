"""What only the command line can do wrong."""


class UsageError(Exception):
    """The arguments don't go together, or not with this input; the message is shown as it is."""
