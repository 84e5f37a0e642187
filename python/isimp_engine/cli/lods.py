"""Levels of detail: several results of one scan, each with fewer polygons and a smaller image than the one before."""

import argparse
import copy
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

from .. import TextureOptions, exporting
from ..recipes import COUNTS
from ..settings import LIKE_THE_SCAN
from .errors import UsageError
from .files import STDOUT
from .task import Simplification


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
    given = [flag for flag in COUNTS if getattr(arguments, flag) is not None]
    if given:
        raise UsageError(f"--lods sets the number of regions of each level: leave out --{given[0]}")
    if arguments.scale is not None:
        raise UsageError("--lods and --scale exclude each other: the sizes of each level differ")


def levels(task: Simplification) -> list[Simplification]:
    """The run of each level; the given one alone without levels."""
    if task.lods is None:
        return [task]
    return [_level(task, number, regions) for number, regions in enumerate(task.lods)]


def _level(task: Simplification, number: int, regions: int) -> Simplification:
    partition = copy.copy(task.settings.partition)
    for name in COUNTS:  # the counts of the recipe
        setattr(partition, name, None)
    partition.proxies = regions
    return replace(
        task,
        settings=replace(task.settings, partition=partition),
        output=named(task.output, number),
        labels=named(task.labels, number) if isinstance(task.labels, Path) else task.labels,
        report=task.report if number == 0 else None,
    )


def named(path: Path, number: int) -> Path:
    """The name of a level as engines of games expect it: `stone_LOD1.glb`."""
    if str(path) == STDOUT:
        return path
    suffix = exporting.kind_of(path) or path.suffix  # .city.json is one
    return path.with_name(f"{path.name[: len(path.name) - len(suffix)]}_LOD{number}{suffix}")


def with_halved_texture(level: Simplification, size: int, times: int) -> Simplification:
    """The level with an image whose side is halved `times` times. size: side of the first level's image."""
    assert level.settings.texture is not None
    least = next(field["least"] for field in TextureOptions.fields() if field["name"] == "size")
    side = size if size == LIKE_THE_SCAN else max(int(least), size >> times)
    texture = replace(level.settings.texture, size=side)
    return replace(level, settings=replace(level.settings, texture=texture))
