"""A cache of recent results within a memory budget. Standard library only."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Hashable
from threading import Lock
from typing import Any


class Cache:
    """Keeps the values used last, up to `budget` bytes, and at least the newest `least` values. Thread-safe."""

    def __init__(self, budget: int, least: int = 1):
        self._budget, self._least, self._size = budget, least, 0
        self._items: OrderedDict[Hashable, tuple[Any, int]] = OrderedDict()
        self._lock = Lock()

    def get(self, key: Hashable) -> Any:
        with self._lock:
            if key not in self._items:
                return None
            self._items.move_to_end(key)
            return self._items[key][0]

    def put(self, key: Hashable, value: Any, size: int) -> None:
        with self._lock:
            if key in self._items:
                self._size -= self._items.pop(key)[1]
            self._items[key] = (value, size)
            self._size += size
            while self._size > self._budget and len(self._items) > self._least:
                self._size -= self._items.popitem(last=False)[1][1]

    def __len__(self) -> int:
        return len(self._items)
