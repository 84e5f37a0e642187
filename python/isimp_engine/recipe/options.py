"""One option of the engine as plain data, so that recipes load without the engine."""

from typing import Any, NamedTuple


class Option(NamedTuple):
    kind: str  #: "int", "float", "bool" or "str"
    default: Any
    words: str = ""  #: the range in words: "in [0, 1)"
    least: float | None = None
    above_least: bool = False  #: least itself is no value
    most: float | None = None
    below_most: bool = False  #: most itself is no value
    choices: tuple[str, ...] = ()

    def holds(self, value: float) -> bool:
        """Whether a number is in the range; infinity and NaN never are."""
        if not abs(value) < float("inf"):
            return False
        low = self.least is None or (value > self.least if self.above_least else value >= self.least)
        high = self.most is None or (value < self.most if self.below_most else value <= self.most)
        return low and high
