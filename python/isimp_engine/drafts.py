"""Files that appear whole or not at all: written next to their places under other names, then moved there."""

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

_LONGEST = 150  # bytes, of at most 255: others add text before and behind it


def draft_of(path: Path) -> tuple[Path, Path]:
    """The temporary place of a file, and the place to move it to. Devices and pipes are written to directly.

    A link stays a link: the file it leads to is replaced.
    """
    if path.exists() and not path.is_file():
        return path, path
    place = Path(os.path.realpath(path))
    name, number = f".{_short(place.stem)}.{os.getpid()}", 0
    while os.path.lexists(draft := place.with_name(f"{name}{f'-{number}' if number else ''}{place.suffix}")):
        number += 1  # exists from an earlier process, or is a link that leads elsewhere
    return draft, place


def _short(stem: str) -> str:
    """The beginning of a name, so that a longer one still is a name. Part of a letter is not kept."""
    return os.fsencode(stem)[:_LONGEST].decode("utf-8", "ignore")


def readable(name: str) -> str:
    """A file name as text for the inside of a file: bytes that are no UTF-8 become question marks in a diamond."""
    return os.fsencode(name).decode("utf-8", "replace")


def save_array(path: Path, values: Any, *, synced: bool = False) -> None:
    """Write an array as a .npy file. numpy's own way to a file raises no error on a full disk.

    synced: on disk when this returns.
    """
    with path.open("wb") as file:
        target: Any = SimpleNamespace(write=file.write)
        np.lib.format.write_array(target, np.asanyarray(values), allow_pickle=False)
        if synced:
            file.flush()
            os.fsync(file.fileno())


def deliver(draft: Path, place: Path) -> None:
    """Move a draft to its place, over an older file, whose permissions it takes."""
    if draft == place:
        return
    if place.exists():
        draft.chmod(stat.S_IMODE(place.stat().st_mode))
    draft.replace(place)


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """The draft of a file; when the block ends well it is the file, else nothing of it is left."""
    draft, place = draft_of(path)
    try:
        yield draft
        deliver(draft, place)
    finally:
        if draft != place:
            draft.unlink(missing_ok=True)
