"""Failures of readers and writers as one kind of error that names the file."""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from . import _core
from ._core import FileError, InvalidInput


@contextmanager
def reader(path: object, wrong: str) -> Iterator[None]:
    """Reads the content of a file: every failure in the block becomes a FileError that names the file.

    wrong: the text for a file with unexpected content, such as "is damaged". Numbers that are not finite give no
    warnings in the block: the reader must check them.
    """
    try:
        with np.errstate(all="ignore"):
            yield
    except (FileError, _core.Cancelled, MemoryError):
        raise
    except InvalidInput as error:
        raise FileError(f"{path}: {error}") from None
    except OSError as error:
        other = f"{error.filename}: " if error.filename is not None and str(error.filename) != str(path) else ""
        raise FileError(f"{path}: {other}{error.strerror or f'{wrong} ({_said(error)})'}") from None
    except RecursionError:
        raise FileError(f"{path}: {wrong} (it is nested too deep)") from None
    except Exception as error:  # noqa: BLE001  (a file may hold anything, and each reader fails in its own way)
        raise FileError(f"{path}: {wrong} ({_said(error)})") from None


def _said(error: Exception) -> str:
    if isinstance(error, KeyError):
        return f"it lacks {error}"
    return " ".join(str(error).split())[:200] or type(error).__name__
