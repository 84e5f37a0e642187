"""Files that appear whole or not at all: written beside their places under other names, then moved there."""

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


def draft_of(path: Path) -> tuple[Path, Path]:
    """Where to write for now, and the place to move it to. Devices and pipes are written to as they are.

    A link stays one: the file it leads to is replaced.
    """
    if path.exists() and not path.is_file():
        return path, path
    place = Path(os.path.realpath(path))
    return place.with_name(f".{place.stem}.{os.getpid()}{place.suffix}"), place


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
