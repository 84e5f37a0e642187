"""The texture of `isimp simplify`: its size, its files, and the files that may not be overwritten."""

import argparse
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from .. import TextureOptions
from ..source import Source
from ..texturing.writing import companions, refusal
from . import words
from .errors import UsageError
from .files import check, is_same
from .task import Simplification


def whole(name: str, text: str) -> int:
    """An argument that is a whole number of TextureOptions: the size of an image, or how many there are."""
    field = next(field for field in TextureOptions.fields() if field["name"] == name)
    wanted = f"must be a whole number {field['range']}, got {text!r}"
    if name == "size":
        wanted = f"SIZE {wanted}; write --texture without SIZE after OUTPUT"
    try:
        number = int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(wanted) from None
    if not field["least"] <= number <= field["most"]:
        raise argparse.ArgumentTypeError(wanted)
    return number


def distance(text: str) -> float:
    """An argument with the largest distance of faces that occlude light."""
    wanted = f"DISTANCE must be a finite length above 0, got {text!r}; write --ao without DISTANCE after OUTPUT"
    try:
        length = float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(wanted) from None
    if not 0 < length < math.inf:
        raise argparse.ArgumentTypeError(wanted)
    return length


def check_output(task: Simplification) -> list[Path]:
    """Returns the files that can be written next to the output; refuses paths that can't be written."""
    if task.settings.texture is None:
        return []
    if why := refusal(task.output):
        raise UsageError(why)
    beside = companions(task.output)
    for path in beside:
        check(path)
    return beside


def check_source(source: Source, beside: list[Path]) -> None:
    """Refuse, before the work, to overwrite the files of the scan's texture."""
    if source.soup is None:
        return
    for path in beside:
        if any(is_same(path, file) for file in source.soup.files):
            raise UsageError(f"{path}: belongs to the scan and would be overwritten; choose another OUTPUT")


def summary(report: dict[str, Any]) -> Iterator[str]:
    pixels, charts = f"{report['size']:,} x {report['size']:,}", words.count(report["charts"], "chart")
    if report["tiles"] > 1:
        pixels = f"{report['tiles']} images of {pixels}"
    yield f"  texture: {pixels} pixels, {charts}, {report['fill']:.0%} filled"
    if report["layers"]:
        yield f"  with {', '.join(report['layers'])}"
    if report["unknown"]:
        yield f"  warning: {report['unknown']:,} pixels show the mean colour, since no face with a texture is near"
