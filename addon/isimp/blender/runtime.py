"""What lives as long as the add-on is switched on: made by `start`, dropped by `stop`."""

from ..session import Session


class Runtime:
    def __init__(self):
        self.session = Session()
        self.running = None  #: the modal operator's Work while there is one
        self.nodes = {}  #: what store.py knows beyond what undo takes back
        self.recipes = {}  #: state -> Recipe, parsed


_current = None


def start() -> None:
    global _current  # noqa: PLW0603  (the one piece of state the add-on has outside the file)
    _current = Runtime()


def stop() -> None:
    global _current  # noqa: PLW0603
    if _current is not None and _current.running is not None:
        _current.running.abandon()
    _current = None


def get() -> Runtime:
    return _current
