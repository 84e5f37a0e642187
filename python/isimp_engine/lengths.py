"""Lengths with a unit, as people write them: 1mm, .5 mm, 1/16in."""

import math
import re

#: metres of each unit of a scene
UNITS = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "um": 1e-6, "in": 0.0254, "ft": 0.3048}
_WRITTEN = UNITS | {'"': UNITS["in"]}

_NUMBER = r"((?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?)"
_LENGTH = re.compile(rf"{_NUMBER}(?:/{_NUMBER})?\s*({'|'.join(map(re.escape, _WRITTEN))})?")


def length_of(text: str | float, unit: str | None) -> float:
    """A length in scene units. unit: of the scene; None: unknown. A number without a unit is in scene units.

    Raises ValueError, whose text follows a name: it is no length above 0, or needs the unit of the scene.
    """
    found = _LENGTH.fullmatch(str(text).strip().lower())
    value = float(found[1]) / float(found[2] or 1) if found and float(found[2] or 1) else 0.0
    if found is None or not 0 < value < math.inf:
        raise ValueError(f" must be a length as 1mm, .5mm, 1/16in, or a number of scene units, got '{text}'")
    if found[3] is None:
        return value
    if unit is None:
        raise ValueError(f": '{text}' needs the unit of the scene")
    return value * _WRITTEN[found[3]] / UNITS[unit]
