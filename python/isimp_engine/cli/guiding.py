"""The options of the command line that name single faces and edges of the file, as arrays for the engine."""

import argparse
import tokenize
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import Job, Mesh, guides, partition_from
from ..guided import Guides
from .errors import UsageError
from .loading import Input
from .settings import GuideFiles, Simplification

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


def as_dict(task: Simplification) -> dict[str, Any]:
    """The given guides, for the report."""
    return {"angle": task.settings.angle} | {name: path and str(path) for name, path in vars(task.guides).items()}


def guides_of(files: GuideFiles, angle: float | None, source: Input, mesh: Mesh, job: Job) -> Guides:
    """Returns the guides, by faces and vertices of the mesh. angle: see `Settings`."""
    face = np.where(mesh.source_face >= 0, source.polygon[mesh.source_face], -1)
    barriers = []
    if angle is not None:
        barriers.append(guides.sharp_edges(mesh, np.radians(angle)))
    if files.borders:
        values = _load(files.borders, "borders", (source.faces,))
        barriers.append(guides.attribute_borders(mesh, values[face], among=face >= 0))
    weights = _load(files.weights, "weights", (source.faces,)) if files.weights else None
    before = None
    if files.base:
        if not files.part:
            raise UsageError("--base needs --part: it gives the regions of the faces outside the part")
        labels = _load(files.base, "base", (source.faces,))
        before = partition_from(mesh, np.where(face >= 0, labels[face], -1), job)
    return Guides(
        weights=None if weights is None else np.where(face >= 0, weights[face], 1.0),
        barriers=np.concatenate(barriers) if barriers else None,
        cuts=guides.marked_edges(mesh, _cuts(files, source)) if files.cuts else None,
        faces=_part(files, source, face) if files.part else None,
        before=before,
    )


def _cuts(files: GuideFiles, source: Input) -> NDArray[Any]:
    edges, count = _load(files.cuts, "cuts", (None, 2)), len(source.vertices)
    if (bad := np.argwhere((edges < 0) | (edges >= count))).size:
        row, end = bad[0]
        raise UsageError(
            f"{files.cuts}: row {row} (the first is 0) names vertex {edges[row, end]}; "
            f"the vertices of INPUT are 0 to {count - 1}"
        )
    return edges


def _part(files: GuideFiles, source: Input, face: NDArray[Any]) -> NDArray[np.intp]:
    chosen = _load(files.part, "part", (None,))
    if len(chosen) and not 0 <= chosen.min() <= chosen.max() < source.faces:
        raise UsageError(f"{files.part}: faces must be in [0, {source.faces})")
    return np.flatnonzero(np.isin(face, chosen))


def _load(path: Path | None, name: str, shape: tuple[int | None, ...]) -> NDArray[Any]:
    """The array in the file of an option, with this shape (None: any length) and of numbers."""
    assert path is not None  # the option is given
    try:
        with path.open("rb") as file:  # not np.load, which opens archives and pickles too
            values = np.lib.format.read_array(file, allow_pickle=False)
    except (ValueError, EOFError, SyntaxError, tokenize.TokenError):  # all errors that a wrong header can raise
        raise UsageError(f"{path}: is not a .npy file of numbers") from None
    except MemoryError:
        raise UsageError(f"{path}: there is not enough memory for it") from None
    fits = values.ndim == len(shape) and all(n in (None, m) for n, m in zip(shape, values.shape, strict=True))
    whole = name in ("weights", "borders") or values.dtype.kind in "iu"
    if not fits or not whole or values.dtype.kind not in "iufb":
        wanted = ", ".join("K" if n is None else str(n) for n in shape)
        kind = "numbers" if name in ("weights", "borders") else "integers"
        raise UsageError(f"{path}: must be ({wanted}) {kind}, is {values.shape} {values.dtype}")
    return values
