"""Folders that isimp makes for itself, and the only code that removes the results of an earlier run there.

Such a folder holds an empty file MARK, which is made first and removed last, so that a run that is ended at any moment
leaves a folder that the next run recognises. Nothing is removed where the mark is missing, by way of a link, or in a
folder with any file that isimp does not put there.
"""

import contextlib
import os
import re
import shutil
from pathlib import Path

MARK = ".isimp-own"
WORK = ".isimp-batch"  #: the folder in a folder of results that has the lock
_OF_SYSTEMS = re.compile(r"\.nfs\w+|\.DS_Store")  # files that file systems add to folders
_DEEPEST = 4  # folders between one that is removed and the one that has the mark


class NotOwn(Exception):
    """A folder is not isimp's own, so that nothing is removed there; the message names the content."""


class Own:
    """A folder of isimp's own."""

    def __init__(self, path: Path, names: str) -> None:
        """names: a regular expression for all names that isimp puts there; all other files are the user's."""
        self.path, self._names = path, re.compile(names)

    def take(self, unmarked: bool) -> None:
        """Make the folder, or reuse one that isimp made. Raises NotOwn or OSError.

        unmarked: take it also without a mark, since its name or a file in it shows that it is isimp's.
        """
        if self.path.is_symlink():
            raise NotOwn(f"{self.path}: is a link, and files are removed in this folder; remove the link")
        self.path.mkdir(parents=True, exist_ok=True)
        mark = self.path / MARK
        marked = mark.is_file() and not mark.is_symlink()
        for name in self._contents():
            if not marked and not unmarked:
                raise NotOwn(f"{self.path}: is not empty and no work folder of isimp tiles; give another one")
            if not self._names.fullmatch(name):
                raise NotOwn(f"{self.path}: holds {name}, which isimp did not put there; move it, or give another one")
            if (self.path / name).is_symlink():
                raise NotOwn(f"{self.path / name}: is a link, and files are removed there; remove the link")
        if not marked:
            with contextlib.suppress(FileExistsError):  # made by another run that begins now
                os.close(os.open(mark, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))

    def clear(self, first: str = "") -> None:
        """Remove all that isimp put there except the mark and the lock; `first` before all else. Raises OSError."""
        for name in sorted(self._contents(), key=lambda name: name != first):
            if self._names.fullmatch(name):
                _drop(self.path / name)

    def remove(self, first: str = "") -> None:
        """Remove the folder too; where something can't be removed, or is there by now, the folder stays."""
        with contextlib.suppress(OSError):
            self.clear(first)
            (self.path / MARK).unlink(missing_ok=True)
            self.path.rmdir()

    def _contents(self) -> list[str]:
        return [name for name in os.listdir(self.path) if name not in (MARK, WORK) and not _OF_SYSTEMS.fullmatch(name)]


def discard(folder: Path) -> None:
    """Remove a folder inside one of isimp's own, and its content, as far as possible."""
    if not any((outer / MARK).is_file() for outer in list(folder.parents)[:_DEEPEST]):
        raise NotOwn(f"{folder}: is in no folder of isimp's own, so it is not removed")
    with contextlib.suppress(OSError):
        _drop(folder)


def _drop(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)
