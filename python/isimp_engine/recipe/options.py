"""One option of the engine as plain data, so that recipes load without the engine."""

import math
from typing import Any, NamedTuple

#: options that each give the number of regions, and their defaults in the panel
COUNTS = {"detail": 0.005, "tolerance": 1.0, "bound": 1.0, "proxies": 200, "triangles": 1000}


class Option(NamedTuple):
    kind: str  #: "int", "float", "bool" or "str"
    default: Any
    words: str = ""  #: the range in words: "in [0, 1)"
    least: float | None = None
    above_least: bool = False  #: least itself is no value
    most: float | None = None
    below_most: bool = False  #: most itself is no value
    choices: tuple[str, ...] = ()
    unit: str = ""  #: "length": scene units
    label: str = ""  #: the name in the panel; empty: the panel does not show it
    tip: str = ""  #: the tooltip
    low: float | None = None  #: the range of the slider, where it is narrower
    high: float | None = None
    digits: int = 0  #: after the point; 0: as usual
    items: tuple[tuple[str, str, str], ...] = ()  #: name, label and tooltip of each choice

    def holds(self, value: float) -> bool:
        """Whether a number is in the range; infinity and NaN never are."""
        if not math.isfinite(value):
            return False
        low = self.least is None or (value > self.least if self.above_least else value >= self.least)
        high = self.most is None or (value < self.most if self.below_most else value <= self.most)
        return low and high

    @property
    def is_optional(self) -> bool:
        """Whether the engine finds the value where it is not given."""
        return self.default is None

    @property
    def is_below_zero(self) -> bool:
        """Whether a setting below 0 stands for a value that is not given, as 0 is a value; else 0 does."""
        return self.is_optional and self.holds(0)

    @property
    def unset(self) -> Any:
        """The default of a setting, which is never None."""
        if not self.is_optional:
            return self.default
        if self.kind == "int":
            return 0
        return -1.0 if self.is_below_zero else 0.0

    def accepts(self, value: float) -> bool:
        """Whether a setting may have this number."""
        if self.is_below_zero:
            return math.isfinite(value)
        return self.holds(value) or (self.is_optional and value == 0)

    def given(self, value: Any) -> Any:
        """Converts a setting for the engine: to None if it stands for a value that is not given."""
        return None if self.is_optional and not self.holds(value) else value
