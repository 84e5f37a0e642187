"""Arrays of single faces and edges of one scan that guide its partition."""

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import guides
from ._core import Job, partition_from
from .guided import Guides
from .repairs import Repaired
from .settings import OptionError, literal
from .source import Source


@dataclass(frozen=True, eq=False)
class Marks:
    """Arrays of single faces and edges, by the faces and vertices of the caller's scan."""

    weights: NDArray[Any] | None = None  #: (faces,) at least 0; regions grow dense like the root of it
    borders: tuple[NDArray[Any], ...] = ()  #: (faces,) each: no region has faces of two values
    cuts: NDArray[Any] | None = None  #: (K, 2) edges that no region crosses, and that split a region they end in
    part: NDArray[Any] | None = None  #: (K,) only these faces are split; the others stay as `base` has them
    base: NDArray[Any] | None = None  #: (faces,) the region of each face, -1 for none


MARKS = frozenset(each.name for each in fields(Marks))


def marks_of(source: Source, given: dict[str, Any]) -> Marks:
    """The arrays of a scan by their names, checked. Raises OptionError, which begins with the name."""
    arrays = {name: np.asarray(values) for name, values in given.items() if values is not None}
    for name, values in arrays.items():
        _check(name, values, {"cuts": (None, 2), "part": (None,)}.get(name, (source.faces,)), not source.is_whole)
    if "cuts" in arrays:
        edges, count = arrays["cuts"], len(source.vertices)
        if (bad := np.argwhere((edges < 0) | (source.is_whole & (edges >= count)))).size:
            row, end = bad[0]
            text = f"{{}}: row {row} (the first is 0) names vertex {edges[row, end]}; "
            known = f"are 0 to {count - 1}" if source.is_whole else "begin with 0"
            raise OptionError(f"{text}the vertices of the scan {known}", "cuts")
    chosen = arrays.get("part", np.zeros(0, int))
    if len(chosen) and not (chosen.min() >= 0 and (chosen.max() < source.faces or not source.is_whole)):
        raise OptionError(f"{{}}: faces must be in [0, {source.faces})", "part")
    borders = (arrays.pop("borders"),) if "borders" in arrays else ()
    return Marks(**arrays, borders=borders)


def _check(name: str, values: NDArray[Any], shape: tuple[int | None, ...], longer: bool) -> None:
    """Refuse an array of another shape (None: any length; longer: or more), and one without numbers."""
    sizes = list(zip(shape, values.shape, strict=False))
    fits = values.ndim == len(shape) and all(n in (None, m) or (longer and n < m) for n, m in sizes)
    whole = name in ("weights", "borders") or values.dtype.kind in "iu"
    if not fits or not whole or values.dtype.kind not in "iufb":
        wanted = ", ".join("K" if n is None else str(n) for n in shape)
        wanted = f"{wanted} or more" if longer and shape[0] is not None else wanted
        kind = "numbers" if name in ("weights", "borders") else "integers"
        raise OptionError(literal(f": must be ({wanted}) {kind}, is {values.shape} {values.dtype}"), name)
    if np.isnan(values).any():
        raise OptionError(literal(f": face {int(np.isnan(values).argmax())} has no number"), name)


def guides_of(marks: Marks, angle: float | None, repaired: Repaired, job: Job) -> Guides:
    """The guides of a partition, by faces and vertices of the mesh. angle: see `Settings`.

    Faces that cover an opening have the weight and the values of the nearest face.
    """
    source, mesh = repaired.source, repaired.mesh
    face = np.where(mesh.source_face >= 0, source.polygon[mesh.source_face], -1)
    barriers = [guides.attribute_borders(mesh, values[repaired.faces.mesh_face]) for values in marks.borders]
    if angle is not None:
        barriers.append(guides.sharp_edges(mesh, np.radians(angle)))
    before = None
    if marks.base is not None:
        before = partition_from(mesh, np.where(face >= 0, marks.base[face], -1), job=job)
    return Guides(
        weights=None if marks.weights is None else marks.weights[repaired.faces.mesh_face],
        barriers=np.concatenate(barriers) if barriers else None,
        cuts=None if marks.cuts is None else guides.marked_edges(mesh, marks.cuts),
        faces=None if marks.part is None else np.flatnonzero(np.isin(face, marks.part)),
        before=before,
    )
