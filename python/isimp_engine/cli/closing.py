"""The openings on the command line and in its summary: holes and tunnels that are too small for the regions."""

import math
from collections.abc import Iterator
from typing import Any

from ..settings import Place

_NEAR = 0.5  #: share of an opening's length: a place that is further from all openings selects none


def place(text: str) -> Place:
    """X,Y,Z: a place on the command line."""
    numbers = [float(part) for part in text.split(",")]
    if len(numbers) != 3 or not all(map(math.isfinite, numbers)):
        raise ValueError(text)
    return numbers[0], numbers[1], numbers[2]


place.__name__ = "place X,Y,Z"  # in argparse's message


def lines(openings: list[dict[str, Any]], places: list[Place], below: float | None) -> Iterator[str]:
    """The lines of the summary about openings."""
    closed = [opening for opening in openings if not opening["kept"]]
    if closed and below:
        longest = f"the longest, a {closed[0]['kind']} of {closed[0]['length']:.4g}, at {_at(closed[0]['center'])}"
        yield f"  closed: openings up to {below:.4g} long; {longest}"
        yield "    --keep-opening X,Y,Z keeps one open, --keep-openings all; the report lists them"
    kept = [opening for opening in openings if opening["kept"]]
    for opening in kept:
        yield f"  kept open: a {opening['kind']} of {opening['length']:.4g} at {_at(opening['center'])}"
    for each in places if openings else ():
        if all(math.dist(each, opening["center"]) > _NEAR * opening["length"] for opening in kept):
            yield f"  warning: no opening that would be closed is at {_at(each)}"


def _at(place: Place) -> str:
    return ",".join(f"{number:.9g}" for number in place)
