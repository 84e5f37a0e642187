"""The files that a scan may name: in its folder, the folders below, and sister folders (`../textures/wall.png`)."""

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path, PureWindowsPath
from typing import NoReturn

from .._core import FileError
from . import udim
from .look import Fault

_ADDRESS = re.compile(r"[A-Za-z][\w+.-]+:/|//")  # one letter and a colon are a drive of Windows


def refuse(fault: str) -> NoReturn:
    """Refuses a file with a fault. `read_look` collects faults instead."""
    raise FileError(fault)


@contextmanager
def faults(fault: Fault) -> Iterator[None]:
    """Passes a FileError of the block to `fault`."""
    try:
        yield
    except FileError as error:
        fault(str(error))


def folder_of(scan: Path) -> Path:
    return _absolute(scan).parent


def root_of(scan: Path) -> Path:
    """The folder in which all files are that a scan names: the one above its own."""
    folder = folder_of(scan)
    above = folder.parent
    return folder if above == above.parent else above  # never all of the machine


def file(name: str, folder: Path, root: Path, place: str) -> Path:
    """The file of a name in a file of this folder. Raises FileError, which begins with `place`."""
    if _ADDRESS.match(name):
        raise FileError(f"{place}: {name} is not a file of this machine; fetch it, and correct the name")
    path = Path(os.path.normpath(folder / name))
    if not _absolute(path).is_relative_to(root):
        raise FileError(f"{place}: {name} is outside of {root}; put the file there, and correct the name")
    return path


def image(name: str, folder: Path, root: Path, place: str) -> Path:
    """As above for an image. A name from another machine is searched for next to the file that has it."""
    beside = folder / PureWindowsPath(name).name
    plain = name.replace("\\", "/")
    inside = not _ADDRESS.match(plain) and _absolute(folder / plain).is_relative_to(root)
    if udim.exists(beside) and not (inside and udim.exists(folder / plain)):
        return beside
    return file(plain, folder, root, place)


def _absolute(path: Path) -> Path:
    return Path(os.path.abspath(path))  # noqa: PTH100  (links stay as they are)
