"""results.jsonl, with one line for each scan, on disk as soon as the scan is done; the lock of an output folder."""

import json
import os
import re
import socket
from collections.abc import Callable
from pathlib import Path, PurePath
from types import TracebackType
from typing import IO, Any

from ..children.errors import BatchError
from ..folders import WORK, NotOwn, Own

Row = dict[str, Any]

NAME = "results.jsonl"
MADE = "made"  #: in the folder of a child: the result and its other files, by their final names
PICTURE = "picture.png"  #: in the folder of a child
_LARGEST = 1e300  # upper bound of numbers in rows
_NAMES = r"lock|results\.jsonl|results\.html|parts|pictures|running-\w+"  # names in WORK


def read_rows(folder: str | os.PathLike[str]) -> list[Row]:
    """Return the last row of each scan in results.jsonl of an output folder, in the order of their first rows.

    A line that is not a row is skipped, such as one that a power failure cut short. Without a file there are no rows.
    """
    try:
        lines = (Path(folder) / NAME).read_bytes().splitlines()
    except FileNotFoundError:
        return []
    rows: dict[str, Row] = {}
    for line in lines:
        row = _row(line)
        if row is not None:
            rows[row["name"]] = row
    return list(rows.values())


def _row(line: bytes) -> Row | None:
    """Parse a line; None if it is not a row. Values that a row can't have are left out."""
    try:
        row = json.loads(line)
    except (ValueError, RecursionError):
        return None
    if not isinstance(row, dict) or not _is_text(row.get("name")) or row.get("status") not in ("ok", "failed"):
        return None
    told = {name: value for name, value in row.items() if name not in _KINDS or _KINDS[name](value)}
    return told | {name: value for name, value in _MISSING.items() if name not in told}


def _is_text(value: Any) -> bool:
    """Return whether a value is a text that can be shown. All file names are."""
    try:
        return isinstance(value, str) and os.fsencode(value) is not None
    except UnicodeError:
        return False


def _is_names(value: Any) -> bool:
    """Return whether a value is a list of names of files. Old results are removed by name."""
    return isinstance(value, list) and all(_is_text(each) and PurePath(each).name == each for each in value)


def _is_number(value: Any) -> bool:
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return is_number and abs(value) < _LARGEST


def _is_key(value: Any) -> bool:
    """Return whether a value is a key. Keys are names of picture files, which are removed by name."""
    return isinstance(value, str) and re.fullmatch("[0-9a-f]{32}", value) is not None


def _or_none(fits: Callable[[Any], bool]) -> Callable[[Any], bool]:
    return lambda value: value is None or fits(value)


_COUNTS = ("faces", "repaired", "regions", "polygons", "vertices", "corners", "crossing", "flipped", "bent")
_LENGTHS = ("error", "planarity_max", "planarity_mean", "diagonal", "scan_distance", "scan_distance_allowed")
_KINDS: dict[str, Callable[[Any], bool]] = {  # checks of the values of the keys that are used here
    "key": _is_key,
    "files": _is_names,
    "warnings": lambda value: isinstance(value, list) and all(map(_is_text, value)),
    **dict.fromkeys((*_COUNTS, "intersecting", "seconds"), _is_number),
    **dict.fromkeys((*_LENGTHS, "peak_mb"), _or_none(_is_number)),
    **dict.fromkeys(("input", "why", "output", "isimp", "ended"), _or_none(_is_text)),
}
_MISSING: Row = {"why": None, "output": None, "seconds": 0.0, "peak_mb": None, "key": "", "files": []}


class Table:
    """The rows of an output folder, open in one process."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / NAME
        if self.path.is_symlink():
            raise BatchError(f"{self.path}: is a link, and rows are written to this file; remove the link")
        self.cut_short = 0  #: 1 if the end of an earlier process cut the last line short
        data = self.path.read_bytes() if self.path.exists() else b""
        self.rows: dict[str, Row] = {row["name"]: row for row in read_rows(folder)}
        self._lines = len(data.splitlines())
        end = data.rfind(b"\n") + 1
        self._file: IO[bytes] = self.path.open("ab")
        if end < len(data):
            if _row(data[end:]) is None:
                self._file.truncate(end)
                self.cut_short = 1
                self._lines -= 1
            else:
                self._file.write(b"\n")
            self._sync()
        self._begin = self.path.stat().st_size

    def __enter__(self) -> "Table":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._file.close()

    def add(self, row: Row) -> None:
        """Append a row. It is on disk when this method returns."""
        self._file.write(_line(row))
        self._sync()
        self._lines += 1
        self.rows[row["name"]] = row

    def added(self) -> int:
        """Return the number of rows that were added."""
        self._file.flush()
        return self.path.read_bytes()[self._begin :].count(b"\n")

    def tidy(self) -> None:
        """Keep one line for each scan, and remove rows that were replaced.

        The file is read again: an interrupt may have occurred while a row was added.
        """
        self._sync()
        self.rows = {row["name"]: row for row in read_rows(self.path.parent)}
        self._lines = len(self.path.read_bytes().splitlines())
        if self._lines == len(self.rows):
            return
        part = self.path.parent / WORK / NAME
        with part.open("wb") as file:
            file.writelines(map(_line, self.rows.values()))
            file.flush()
            os.fsync(file.fileno())
        self._file.close()
        part.replace(self.path)
        sync_folder(self.path.parent)
        self._file = self.path.open("ab")
        self._lines = len(self.rows)

    def _sync(self) -> None:
        self._file.flush()
        os.fsync(self._file.fileno())


def _line(row: Row) -> bytes:
    return json.dumps(row, allow_nan=False).encode() + b"\n"


def sync_folder(folder: Path) -> None:
    """Write the names in a folder to disk, if the system supports it."""
    try:
        handle = os.open(folder, os.O_RDONLY)
    except OSError:  # Windows
        return
    try:
        os.fsync(handle)
    except OSError:  # some network folders
        pass
    finally:
        os.close(handle)


class Lock:
    """Reserves an output folder for one process. The lock ends with the process, even if it is killed."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._own = Own(folder / WORK, _NAMES)
        self._file: IO[str] | None = None

    def __enter__(self) -> "Lock":
        import fcntl  # not on Windows

        try:
            self._own.take(unmarked=True)
        except NotOwn as error:
            raise BatchError(str(error)) from None
        self._file = (self._own.path / "lock").open("a+")
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self._file.seek(0)
            who = self._file.read().strip() or "another process"
            self._file.close()
            raise BatchError(f"{self._folder}: {who} works on it; wait for its end or give another folder") from None
        except OSError as error:
            self._file.close()
            raise BatchError(f"{self._folder}: can't be locked for one process: {error.strerror}") from None
        self._file.truncate(0)
        self._file.write(f"process {os.getpid()} on {socket.gethostname()}\n")
        self._file.flush()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._file is not None:
            self._file.close()

    def remove(self) -> None:
        """Remove the folder of the lock while the lock is held."""
        self._own.remove()
