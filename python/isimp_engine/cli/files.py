"""Files that appear whole or not at all."""

import os
from collections.abc import Callable
from pathlib import Path
from types import TracebackType

from .. import FileError


class Outputs:
    """Files written beside their places under other names, and moved there together by `commit`.

    Whatever ends the `with` block before that removes them, so that nothing half-written is left.
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

    def write(self, path: Path, write: Callable[[Path], object]) -> None:
        """Call `write` with the path to write to for now; a device or pipe is written to as it is."""
        part = path
        if path.is_file() or not path.exists():
            place = Path(os.path.realpath(path))  # a link stays one
            part = place.with_name(f".{place.stem}.{os.getpid()}{place.suffix}")
            self._moves.append((part, place))
        try:
            write(part)
        except FileError as error:
            raise FileError(str(error).replace(str(part), str(path))) from None
        except OSError as error:
            raise OSError(error.errno, error.strerror, str(path)) from None

    def commit(self) -> None:
        while self._moves:
            part, place = self._moves[0]
            part.replace(place)
            self._moves.pop(0)
