"""UDIM tiles: images of one material that lie side by side, ten in a row, from number 1001 on."""

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

FIRST, ROW = 1001, 10
Tiles = Mapping[int, Any]  # the image of each tile by its number
_MARK = re.compile(re.escape("<udim>"), re.IGNORECASE)


def is_pattern(path: Path) -> bool:
    """Whether a file's name stands for the names of all tiles: `wall.<UDIM>.png`."""
    return _MARK.search(path.name) is not None


def files(path: Path) -> dict[int, Path]:
    """Return the existing files of a pattern by tile number. A path without a pattern is tile 1001."""
    if not is_pattern(path):
        return {FIRST: path}
    before, after = _MARK.split(path.name, maxsplit=1)
    form = re.compile(re.escape(before) + r"(\d{4})" + re.escape(after))
    found = {}
    for file in sorted(path.parent.iterdir()) if path.parent.is_dir() else ():
        match = form.fullmatch(file.name)
        if match and FIRST <= int(match[1]) < 2000:
            found[int(match[1])] = file
    return found


def exists(path: Path) -> bool:
    """Whether there is such a file, or one that a pattern stands for."""
    return any(file.is_file() for file in files(path).values())


def each(image: Any, change: Callable[[Any], Any]) -> Any:
    """An image, or each of its tiles, changed."""
    return {tile: change(one) for tile, one in image.items()} if isinstance(image, Mapping) else change(image)
