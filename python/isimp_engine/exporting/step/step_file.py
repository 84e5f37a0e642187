"""Writes STEP files (AP 214), with the same bytes for the same shape."""

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from OCP.APIHeaderSection import APIHeaderSection_MakeHeader
from OCP.gp import gp_Trsf
from OCP.IFSelect import IFSelect_RetDone
from OCP.Interface import Interface_Static
from OCP.Message import Message, Message_Fail
from OCP.StepBasic import StepBasic_Product
from OCP.STEPConstruct import STEPConstruct
from OCP.STEPControl import STEPControl_AsIs, STEPControl_Writer
from OCP.TCollection import TCollection_HAsciiString
from OCP.TopAbs import TopAbs_FACE
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location

from ... import _core
from ..._core import FileError, Job, Mesh, Partition, PolygonMesh
from ...lengths import UNITS
from .given import poll
from .solid import Made, make

_LENGTHS = ("write.step.unit", "xstep.cascade.unit")
_NAMES = {"in": "INCH"}  # of units; others are in capital letters


def write(
    path: Path,
    poly: PolygonMesh,
    name: str,
    partition: Partition | None = None,
    mesh: Mesh | None = None,
    job: Job | None = None,
    unit: str = "m",
    place: NDArray[np.float64] | None = None,
) -> dict[str, Any]:
    """Write the shape; see `report_of` for the result. Raises FileError if OpenCASCADE can't write there."""
    if not len(poly.loop_start):
        raise FileError(f"{path}: there are no polygons, and a STEP file needs some")
    made = make(poly, partition, mesh, job)
    if not made.faces:
        raise FileError(f"{path}: no polygon has an area, and a STEP file needs one")
    poll(job)  # OpenCASCADE is not interrupted below
    shape = made.shape if place is None else _moved(made.shape, place)
    writer = STEPControl_Writer()  # before the settings, which it resets
    for printer in Message.DefaultMessenger_s().Printers():
        printer.SetTraceLevel(Message_Fail)  # otherwise it prints to stdout
    with _settings({"write.step.schema": "AP214IS", **dict.fromkeys(_LENGTHS, _NAMES.get(unit, unit.upper()))}):
        length = 1000 * UNITS[unit]  # in millimetres; OpenCASCADE 7 reads it from the model
        writer.Model().SetLocalLengthUnit(length)
        writer.Model().SetWriteLengthUnit(length)
        done = writer.Transfer(shape, STEPControl_AsIs)
    if done != IFSelect_RetDone:
        raise FileError(f"{path}: OpenCASCADE can't write this shape")
    poll(job)
    _name(writer.Model(), name)
    _name_faces(writer, shape, made.names)
    header = APIHeaderSection_MakeHeader(writer.Model())
    header.SetName(_text(name))
    header.SetTimeStamp(TCollection_HAsciiString("1970-01-01T00:00:00"))
    header.SetOriginatingSystem(TCollection_HAsciiString(f"isimp {_core.__version__}"))
    # OpenCASCADE accepts file names in one encoding only, so the file is copied to its place.
    with tempfile.TemporaryDirectory() as folder:
        draft = Path(folder) / "shape.step"
        if writer.Write(str(draft)) != IFSelect_RetDone:
            raise FileError(f"{path}: OpenCASCADE can't write this shape")
        path.write_bytes(draft.read_bytes())
    return report_of(made)


def _text(text: str) -> TCollection_HAsciiString:
    """Return a text with ASCII letters only: versions of OpenCASCADE write other letters in different ways."""
    return TCollection_HAsciiString("".join(c if " " <= c <= "~" and c != "\\" else "_" for c in text))


def _moved(shape: Any, place: NDArray[np.float64]) -> Any:
    move = gp_Trsf()
    move.SetValues(*np.asarray(place, float)[:3].ravel().tolist())
    return shape.Moved(TopLoc_Location(move))


@contextmanager
def _settings(values: dict[str, str]) -> Iterator[None]:
    """Change settings of OpenCASCADE, which are global to the process, and restore them at the end."""
    before = {name: Interface_Static.CVal_s(name) for name in values}
    try:
        for name, value in values.items():
            Interface_Static.SetCVal_s(name, value)
        yield
    finally:
        for name, value in before.items():
            Interface_Static.SetCVal_s(name, value)


def _name(model: Any, name: str) -> None:
    """Set the name of the product, since OpenCASCADE numbers the products of a process."""
    for number in range(1, model.NbEntities() + 1):
        entity = model.Value(number)
        if isinstance(entity, StepBasic_Product):
            entity.SetId(_text(name))
            entity.SetName(_text(name))


def _name_faces(writer: STEPControl_Writer, shape: Any, names: list[str]) -> None:
    """Set the names of faces, which CAD programs show."""
    known = writer.WS().TransferWriter().FinderProcess()
    walk = TopExp_Explorer(shape, TopAbs_FACE)
    for name in names:
        entity = STEPConstruct.FindEntity_s(known, walk.Current())
        if entity is not None:
            entity.SetName(_text(name))
        walk.Next()


def report_of(made: Made) -> dict[str, Any]:
    """Return counts of the shape, and for each round part the kind of its surface, or why its cells are planes."""
    return {
        "faces": made.faces,
        "solids": made.solids,
        "valid": made.valid,
        "volume": made.volume,
        "gap": made.gap,
        "triangulated": made.triangulated,
        "true_surfaces": [{"number": n, "kind": kind} for n, kind in made.surfaces.items()],
        "planes": [{"number": n, "reason": reason} for n, reason in made.reasons.items()],
    }
