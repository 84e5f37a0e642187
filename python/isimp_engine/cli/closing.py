"""Close openings that scanning left: holes and tunnels that are smaller than the regions can show."""

import math
from collections.abc import Iterator
from typing import Any

from .. import CleanOptions, Job, Mesh, PartitionOptions, partition
from ..openings import Lengths, lengths_for
from .settings import Place, Settings

_NEAR = 0.5  #: share of an opening's length: a place that is further from all openings selects none


def is_wanted(settings: Settings) -> bool:
    """False if the user has chosen openings, and with a bound: a bound is a promise for each vertex of the scan."""
    kept = settings.keep_openings or (settings.recipe is not None and not settings.recipe.close_openings)
    clean = settings.clean
    given = max(clean.fill_holes, clean.fill_flat_holes, clean.cut_handles) > 0
    return not (kept or given or settings.partition.bound)


def place(text: str) -> Place:
    """X,Y,Z: a place on the command line."""
    numbers = [float(part) for part in text.split(",")]
    if len(numbers) != 3 or not all(map(math.isfinite, numbers)):
        raise ValueError(text)
    return numbers[0], numbers[1], numbers[2]


place.__name__ = "place X,Y,Z"  # in argparse's message


def told(mesh: Mesh) -> list[dict[str, Any]]:
    """The openings of a repaired mesh for the report, the longest first."""
    names = ("kind", "kept", "center", "length")
    found = [{name: opening[name] for name in names} for opening in mesh.openings]
    return sorted(found, key=lambda opening: -opening["length"])


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


def lengths_of(mesh: Mesh, options: PartitionOptions, regions: int | None, job: Job) -> Lengths:
    """The lengths up to which openings are closed. regions: their number; None or 0: the partition finds it."""
    return lengths_for(mesh, options, regions or None, lambda: partition(mesh, options, job).region_count, job)


def closing_options(clean: CleanOptions, lengths: Lengths) -> CleanOptions:
    """How to repair the scan so that openings up to these lengths are closed."""
    return CleanOptions(**clean.as_dict() | lengths.options())
