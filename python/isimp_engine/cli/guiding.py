"""The options of the command line that name single faces and edges of the file, as arrays for the engine."""

import argparse
import tokenize
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..marks import Marks, marks_of
from ..settings import OptionError
from ..source import Source
from .errors import UsageError

FILES = {
    "weights": ("W.npy", "one number per face of INPUT, at least 0; regions grow dense like the root of it"),
    "borders": ("B.npy", "one value per face of INPUT; no region has faces of two values"),
    "cuts": ("E.npy", "(K, 2) vertices of INPUT, edges that no region crosses and that split a region they end in"),
    "part": ("P.npy", "split these faces of INPUT alone, by their numbers; the others stay as --base has them"),
    "base": ("L.npy", "one region per face of INPUT, as --labels wrote it; without it the others have none"),
}


def add_angle(command: argparse.ArgumentParser) -> None:
    about = "no region crosses an edge at which INPUT bends by more than A degrees, in [0, 180]"
    command.add_argument("--angle", type=float, metavar="A", help=about)


def add_files(command: argparse.ArgumentParser) -> None:
    """Options that name arrays of single faces and edges of one file."""
    for name, (metavar, about) in FILES.items():
        command.add_argument(f"--{name}", type=Path, metavar=metavar, help=about)


@dataclass(frozen=True)
class GuideFiles:
    """Files with arrays of single faces and edges of one scan."""

    weights: Path | None = None
    borders: Path | None = None
    cuts: Path | None = None
    part: Path | None = None
    base: Path | None = None

    def marks(self, source: Source) -> Marks:
        """The arrays of a scan."""
        try:
            return marks_of(source, {name: path and _load(path) for name, path in vars(self).items()})
        except OptionError as error:
            raise UsageError(error.shown(lambda name: str(getattr(self, name)))) from None

    def as_dict(self) -> dict[str, str | None]:
        """The files that are given, for the report."""
        return {name: path and str(path) for name, path in vars(self).items()}


def guide_files(arguments: argparse.Namespace) -> GuideFiles:
    return GuideFiles(**{name: getattr(arguments, name) for name in FILES})


def _load(path: Path) -> NDArray[Any]:
    """The array in a file."""
    try:
        with path.open("rb") as file:  # not np.load, which opens archives and pickles too
            return np.lib.format.read_array(file, allow_pickle=False)
    except (ValueError, EOFError, SyntaxError, tokenize.TokenError):  # all errors that a wrong header can raise
        raise UsageError(f"{path}: is not a .npy file of numbers") from None
    except MemoryError:
        raise UsageError(f"{path}: there is not enough memory for it") from None
