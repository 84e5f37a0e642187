"""Files that appear whole or not at all."""

import argparse
import contextlib
import os
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from types import TracebackType
from typing import TextIO, TypeVar

from .. import FileError
from ..drafts import deliver, draft_of
from ..reading import KINDS
from .ending import too_late
from .errors import UsageError

STDOUT = "-"
T = TypeVar("T")


def place(text: str) -> Path | str:
    """An argument that names an output: STDOUT, or a path."""
    return STDOUT if text == STDOUT else Path(text)


def add_input(command: argparse.ArgumentParser) -> None:
    command.add_argument("input", type=Path, metavar="INPUT", help=f"{', '.join(KINDS)}, and .gz and .zst of them")


def check(path: Path) -> None:
    """Check the output path before the computation."""
    if not path.resolve().parent.is_dir():
        raise UsageError(f"{path}: there is no folder {path.parent} to write to")
    if path.is_dir():
        raise UsageError(f"{path}: is a folder; give the name of a file")
    if path.is_file() and not (path.stat().st_mode & 0o222 and os.access(path, os.W_OK)):
        raise UsageError(f"{path}: is read-only, so it is not replaced")


def check_all(outputs: Iterable[Path], inputs: Iterable[Path]) -> None:
    """Check the paths of all outputs before the computation: no two of them and the inputs are one file."""
    taken = list(inputs)
    for path in outputs:
        check(path)
        if any(is_same(path, other) for other in taken) and not path.is_char_device():
            raise UsageError(f"{path}: is named twice; INPUT and all outputs must be different files")
        taken.append(path)


def show(text: str, beside: bool = False) -> None:
    """Print a text. `beside`: to stderr, since stdout has other output. An error of stdout is no error of the input."""
    stream = sys.stderr if beside else sys.stdout
    if stream is None:
        return
    try:
        print(text, file=stream, flush=True)
    except OSError as error:
        _drop_rest(stream)
        raise OSError(error.errno, error.strerror, "stderr" if beside else "stdout") from None


def _drop_rest(stream: TextIO) -> None:
    """Send the rest of the buffers of a stream to the null device: Python writes it again at its end.

    A second error there would replace the exit status by 120.
    """
    with contextlib.suppress(OSError):  # a stream without a file
        number, null = stream.fileno(), os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, number)
        os.close(null)


def is_same(path: Path, other: Path) -> bool:
    """Whether two names belong to one file: the same path, links to it, or hard links of it."""
    return path.resolve() == other.resolve() or (path.exists() and other.exists() and path.samefile(other))


class Outputs:
    """Files written next to their places under other names. `commit` moves all of them to their places.

    A `with` block that ends before `commit` removes the files, so that no file is half-written.
    """

    def __init__(self) -> None:
        self._moves: list[tuple[Path, Path]] = []

    def __enter__(self) -> "Outputs":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for part, _ in self._moves:
            part.unlink(missing_ok=True)

    def write_text(self, path: Path | str, text: str) -> None:
        if isinstance(path, Path):
            self.write(path, lambda part: part.write_text(text, encoding="utf-8"))
        else:
            show(text.removesuffix("\n"))

    def write(self, path: Path, write: Callable[[Path], T]) -> T:
        """Call `write` with the path to write to for now, and return its result.

        A device or pipe is written to as it is.
        """
        part, place = draft_of(path)
        if part != place:
            self._moves.append((part, place))
        try:
            return write(part)
        except FileError as error:
            raise FileError(str(error).replace(str(part), str(path))) from None
        except OSError as error:
            raise OSError(error.errno, error.strerror or str(error), str(path)) from None

    def commit(self) -> None:
        with too_late():
            while self._moves:
                deliver(*self._moves[0])
                self._moves.pop(0)
