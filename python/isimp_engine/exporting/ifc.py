"""IFC4 as text: walls, a roof and slabs as IfcPolygonalFaceSet."""

import hashlib
import re
import string
import uuid

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._core import PolygonMesh
from .surfaces import CEILING, CLASSES, GROUND, ROOF, WALL, Surfaces, part_of, rings, shift_of

_ELEMENTS = {WALL: "IFCWALL", ROOF: "IFCROOF", GROUND: "IFCSLAB", CEILING: "IFCSLAB"}
_TYPES = {GROUND: ".BASESLAB.", CEILING: ".FLOOR."}
_DIGITS = string.digits + string.ascii_uppercase + string.ascii_lowercase + "_$"
_DATE = "1970-01-01T00:00:00"  # the format wants one: equal results are equal files


class _File:
    """The lines of a file. Each is named by its number."""

    def __init__(self, of: uuid.UUID) -> None:
        self.lines: list[str] = []
        self.of = of

    def add(self, text: str) -> str:
        self.lines.append(f"#{len(self.lines) + 1}={text};")
        return f"#{len(self.lines)}"

    def rooted(self, kind: str, role: str, rest: str) -> str:
        """Add an entity with a GlobalId, which depends on its role and on the model."""
        number = uuid.uuid5(self.of, role).int
        digits = "".join(_DIGITS[number >> 6 * k & 63] for k in range(21, -1, -1))
        return self.add(f"{kind}('{digits}',$,{rest})")

    def placement(self, parent: str, place: list[float]) -> str:
        axes = self.add(f"IFCAXIS2PLACEMENT3D({self.add(f'IFCCARTESIANPOINT({_reals(place)})')},$,$)")
        return self.add(f"IFCLOCALPLACEMENT({parent},{axes})")


def ifc(poly: PolygonMesh, surfaces: Surfaces, name: str, crs: int | None = None) -> str:
    """The file's text: n-gons without triangulation.

    The shift is a map conversion with a reference system, else the placement of the site.
    """
    at = np.asarray(poly.vertices, dtype=np.float64).reshape(-1, 3)
    shift = np.floor(at.min(0)) if len(at) and crs is not None else shift_of(poly)
    file, title = _File(_identity(poly, name, crs)), _quoted(name)
    world = file.add(f"IFCAXIS2PLACEMENT3D({file.add('IFCCARTESIANPOINT((0.,0.,0.))')},$,$)")
    context = file.add(f"IFCGEOMETRICREPRESENTATIONCONTEXT($,'Model',3,1.E-6,{world},$)")
    body = file.add(f"IFCGEOMETRICREPRESENTATIONSUBCONTEXT('Body','Model',*,*,*,*,{context},$,.MODEL_VIEW.,$)")
    if crs is not None:
        system = file.add(f"IFCPROJECTEDCRS('EPSG:{crs}',$,$,$,$,$,$)")
        place = ",".join(map(_real, shift.tolist()))
        file.add(f"IFCMAPCONVERSION({context},{system},{place},$,$,$)")
    kinds = {"LENGTHUNIT": "METRE", "AREAUNIT": "SQUARE_METRE", "VOLUMEUNIT": "CUBIC_METRE", "PLANEANGLEUNIT": "RADIAN"}
    units = ",".join(file.add(f"IFCSIUNIT(*,.{kind}.,$,.{unit}.)") for kind, unit in kinds.items())
    units = file.add(f"IFCUNITASSIGNMENT(({units}))")
    project = file.rooted("IFCPROJECT", "project", f"{title},$,$,$,$,({context}),{units}")
    placed = file.placement("$", (shift if crs is None else np.zeros(3)).tolist())
    site = file.rooted("IFCSITE", "site", f"{title},$,$,{placed},$,$,$,$,$,$,$,$")
    placed = file.placement(placed, [0.0] * 3)
    building = file.rooted("IFCBUILDING", "building", f"{title},$,$,{placed},$,$,$,$,$,$")
    placed = file.placement(placed, [0.0] * 3)
    storey = file.rooted("IFCBUILDINGSTOREY", "storey", f"{title},$,$,{placed},$,$,$,0.")
    for role, (whole, part) in enumerate([(project, site), (site, building), (building, storey)]):
        file.rooted("IFCRELAGGREGATES", f"part {role}", f"$,$,{whole},({part})")
    loops, elements = rings(poly), []
    for kind in CLASSES:
        if some := surfaces.of(kind):
            points, parts = part_of(poly, loops, some)
            shape = _shape(file, points - shift, parts, body)
            rest = f"'{kind}',$,$,{file.placement(placed, [0.0] * 3)},{shape},$,{_TYPES.get(kind, '$')}"
            elements.append(file.rooted(_ELEMENTS[kind], kind, rest))
    if elements:
        rest = f"$,$,({','.join(elements)}),{storey}"
        file.rooted("IFCRELCONTAINEDINSPATIALSTRUCTURE", "contents", rest)
    return "\n".join([*_head(name), *file.lines, "ENDSEC;", "END-ISO-10303-21;", ""])


def _shape(file: _File, points: NDArray[np.float64], parts: list[NDArray[np.int64]], body: str) -> str:
    places = file.add(f"IFCCARTESIANPOINTLIST3D(({','.join(map(_reals, points.tolist()))}))")
    texts = (",".join(map(str, (part + 1).tolist())) for part in parts)
    faces = ",".join([file.add(f"IFCINDEXEDPOLYGONALFACE(({text}))") for text in texts])
    surface = file.add(f"IFCPOLYGONALFACESET({places},.F.,({faces}),$)")
    shown = file.add(f"IFCSHAPEREPRESENTATION({body},'Body','Tessellation',({surface}))")
    return file.add(f"IFCPRODUCTDEFINITIONSHAPE($,$,({shown}))")


def _head(name: str) -> list[str]:
    return [
        "ISO-10303-21;",
        "HEADER;",
        "FILE_DESCRIPTION(('ViewDefinition [ReferenceView_V1.2]'),'2;1');",
        f"FILE_NAME({_quoted(name)},'{_DATE}',(''),(''),'isimp','isimp {_core.__version__}','');",
        "FILE_SCHEMA(('IFC4'));",
        "ENDSEC;",
        "DATA;",
    ]


def _identity(poly: PolygonMesh, name: str, crs: int | None) -> uuid.UUID:
    """Equal for equal models."""
    digest = hashlib.sha256(f"{name}\0{crs}".encode())
    for values in (poly.vertices, poly.loops, poly.loop_start):
        digest.update(np.ascontiguousarray(values).tobytes())
    return uuid.UUID(bytes=digest.digest()[:16])


def _real(value: float) -> str:
    """A number as STEP files want it, with a point."""
    digits, e, power = repr(value).upper().partition("E")
    return digits + ("" if "." in digits else ".") + e + power


def _reals(values: list[float]) -> str:
    return f"({','.join(map(_real, values))})"


def _quoted(text: str) -> str:
    """A text as STEP files want it: ASCII, other letters by their code."""
    plain = text.replace("\\", "\\\\").replace("'", "''")
    return "'" + re.sub("[^ -~]", lambda found: _code(ord(found[0])), plain) + "'"


def _code(letter: int) -> str:
    return f"\\X2\\{letter:04X}\\X0\\" if letter < 1 << 16 else f"\\X4\\{letter:08X}\\X0\\"
