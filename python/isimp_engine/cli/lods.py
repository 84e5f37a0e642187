"""Levels of detail: several results of one scan, each with fewer polygons and a smaller image than the one before."""

import argparse
import copy
from itertools import pairwise
from pathlib import Path

from .. import TextureOptions, exporting
from . import texturing
from .errors import UsageError
from .files import STDOUT

_COUNTS = ("proxies", "triangles", "detail", "tolerance", "bound")


def counts(text: str) -> list[int]:
    """An argument that gives the regions of each level: `1000,300,100`."""
    try:
        levels = [int(word) for word in text.split(",")]
    except ValueError:
        levels = []
    if not levels or min(levels) < 1 or any(a <= b for a, b in pairwise(levels)):
        wanted = "numbers of regions with commas between them, each below the one before: 1000,300,100"
        raise argparse.ArgumentTypeError(f"must be {wanted}; got {text!r}")
    return levels


def check(arguments: argparse.Namespace) -> None:
    """Refuse arguments that contradict levels."""
    given = [flag for flag in _COUNTS if getattr(arguments, flag) is not None]
    if given:
        raise UsageError(f"--lods says how many regions each level has: leave out --{given[0]}")


def levels(arguments: argparse.Namespace) -> list[argparse.Namespace]:
    """The arguments of each level; the given arguments alone without --lods."""
    if arguments.lods is None:
        return [arguments]
    check(arguments)
    return [_level(arguments, number, regions) for number, regions in enumerate(arguments.lods)]


def _level(arguments: argparse.Namespace, number: int, regions: int) -> argparse.Namespace:
    level = copy.copy(arguments)
    level.options = copy.copy(arguments.options)
    for name in _COUNTS:  # the counts of the recipe
        setattr(level.options, name, None)
    level.options.proxies = regions
    level.output = named(arguments.output, number)
    if isinstance(arguments.labels, Path):
        level.labels = named(arguments.labels, number)
    level.report = arguments.report if number == 0 else None
    return level


def named(path: Path, number: int) -> Path:
    """The name of a level as engines of games expect it: `stone_LOD1.glb`."""
    if str(path) == STDOUT:
        return path
    suffix = exporting.kind_of(path) or path.suffix  # .city.json is one
    return path.with_name(f"{path.name[: len(path.name) - len(suffix)]}_LOD{number}{suffix}")


def halved(size: int, times: int) -> int:
    """The side of a level's image."""
    least = next(field["least"] for field in TextureOptions.fields() if field["name"] == "size")
    return size if size == texturing.LIKE_THE_SCAN else max(int(least), size >> times)
