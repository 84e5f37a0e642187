"""A cache of recent results within a memory budget."""

from collections import OrderedDict
from collections.abc import Hashable, Sequence
from threading import Lock
from typing import Generic, TypeVar

Value = TypeVar("Value")


class Cache(Generic[Value]):
    """Keeps the values used last, up to `budget` bytes, and at least the newest `least` values. Thread-safe."""

    def __init__(self, budget: int, least: int = 1) -> None:
        self._budget, self._least, self._size = budget, least, 0
        self._items: OrderedDict[Hashable, tuple[Value, int]] = OrderedDict()
        self._lock = Lock()

    def get(self, key: Hashable) -> Value | None:
        with self._lock:
            if key not in self._items:
                return None
            self._items.move_to_end(key)
            return self._items[key][0]

    def put(self, key: Hashable, value: Value, size: int) -> None:
        with self._lock:
            self._drop(key)
            self._items[key] = (value, size)
            self._size += size
            while self._size > self._budget and len(self._items) > self._least:
                self._drop(next(iter(self._items)))

    def drop(self, key: Hashable) -> None:
        with self._lock:
            self._drop(key)

    def _drop(self, key: Hashable) -> None:
        if key in self._items:
            self._size -= self._items.pop(key)[1]

    def longest(self, keys: Sequence[Hashable]) -> tuple[int, Value | None]:
        """How many of the steps of a recipe are done, by a key for each with all before it, and the result of these."""
        for number in range(len(keys), 0, -1):
            if (known := self.get(keys[number - 1])) is not None:
                return number, known
        return 0, None

    def __len__(self) -> int:
        return len(self._items)
