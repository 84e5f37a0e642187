"""DXF of AutoCAD 2000 as text: a MESH for each class of surfaces, on a layer of its name."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from .._core import PolygonMesh
from .surfaces import CEILING, CLASSES, GROUND, ROOF, WALL, Surfaces, part_of, rings

_COLORS = {WALL: 9, ROOF: 1, GROUND: 3, CEILING: 30}
_METRES = 6
_Pairs = Iterable[tuple[int, Any]]  # group codes with their values


class _Drawing:
    """A drawing that grows; every record has a handle, a number in hexadecimal digits."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.handles = 0

    def put(self, *pairs: tuple[int, Any]) -> None:
        self.lines += [f"{code}\n{value}" for code, value in pairs]

    def record(self, kind: str, owner: str, pairs: _Pairs) -> str:
        self.handles += 1
        handle = f"{self.handles:X}"
        self.put((0, kind), (105 if kind == "DIMSTYLE" else 5, handle), (330, owner), *pairs)
        return handle

    def table(self, name: str, record: str, rows: dict[str, _Pairs]) -> list[str]:
        """Returns the handles of the rows."""
        self.handles += 1
        own = f"{self.handles:X}"
        self.put((0, "TABLE"), (2, name), (5, own), (330, 0), (100, "AcDbSymbolTable"), (70, len(rows)))
        if name == "DIMSTYLE":
            self.put((100, "AcDbDimStyleTable"))
        head = (100, "AcDbSymbolTableRecord"), (100, f"AcDb{record}TableRecord")
        made = [self.record(name, own, [*head, (2, row), *pairs]) for row, pairs in rows.items()]
        self.put((0, "ENDTAB"))
        return made

    def section(self, name: str) -> None:
        self.put((0, "ENDSEC"), (0, "SECTION"), (2, name))


def dxf(poly: PolygonMesh, surfaces: Surfaces) -> str:
    """The file's text: n-gons without triangulation; coordinates are the scan's, in double precision."""
    drawing = _Drawing()
    drawing.put((0, "SECTION"), (2, "HEADER"), (9, "$ACADVER"), (1, "AC1015"), (9, "$INSUNITS"), (70, _METRES))
    drawing.put((9, "$HANDSEED"), (5, "FFFF"))
    drawing.section("CLASSES")
    drawing.section("TABLES")
    used = [kind for kind in CLASSES if kind in surfaces.kind]
    space = _tables(drawing, poly, used)
    drawing.section("ENTITIES")
    loops = rings(poly)
    for kind in used:
        at, parts = part_of(poly, loops, surfaces.of(kind))
        mesh: list[tuple[int, Any]] = [(100, "AcDbEntity"), (8, kind), (100, "AcDbSubDMesh"), (71, 2), (72, 0), (91, 0)]
        mesh.append((92, len(at)))
        mesh += [(code, value) for point in at.tolist() for code, value in zip((10, 20, 30), point, strict=True)]
        mesh.append((93, sum(len(part) + 1 for part in parts)))
        mesh += [(90, value) for part in parts for value in (len(part), *part.tolist())]
        drawing.record("MESH", space, [*mesh, (94, 0), (95, 0), (90, 0)])  # no edges, creases and overrides
    drawing.section("OBJECTS")
    groups = f"{drawing.handles + 2:X}"
    root = drawing.record("DICTIONARY", "0", [(100, "AcDbDictionary"), (3, "ACAD_GROUP"), (350, groups)])
    drawing.record("DICTIONARY", root, [(100, "AcDbDictionary")])
    drawing.put((0, "ENDSEC"), (0, "EOF"))
    return "\n".join([*drawing.lines, ""])


def _tables(drawing: _Drawing, poly: PolygonMesh, layers: list[str]) -> str:
    """The tables and blocks that every drawing has, and the layers; returns the handle of the model space."""
    at = np.asarray(poly.vertices, dtype=np.float64).reshape(-1, 3)
    low, high = (at.min(0), at.max(0)) if len(at) else (np.zeros(3), np.ones(3))
    (x, y, _), height = ((low + high) / 2).tolist(), float((high - low)[:2].max())
    view = [(70, 0), (12, x), (22, y), (16, 0.0), (26, 0.0), (36, 1.0), (40, height), (41, 1.0)]  # all, from above
    drawing.table("VPORT", "Viewport", {"*Active": view})
    line = [(70, 0), (3, ""), (72, 65), (73, 0), (40, 0.0)]
    drawing.table("LTYPE", "Linetype", dict.fromkeys(("ByBlock", "ByLayer", "Continuous"), line))
    colors = {"0": 7} | {kind: _COLORS[kind] for kind in layers}
    drawing.table("LAYER", "Layer", {name: [(70, 0), (62, c), (6, "Continuous")] for name, c in colors.items()})
    letters = [(70, 0), (40, 0.0), (41, 1.0), (50, 0.0), (71, 0), (42, 1.0), (3, "txt"), (4, "")]
    drawing.table("STYLE", "TextStyle", {"Standard": letters})
    drawing.table("VIEW", "View", {})
    drawing.table("UCS", "UCS", {})
    drawing.table("APPID", "RegApp", {"ACAD": [(70, 0)]})
    drawing.table("DIMSTYLE", "DimStyle", {"Standard": [(70, 0)]})
    names = ("*Model_Space", "*Paper_Space")
    owners = drawing.table("BLOCK_RECORD", "Block", dict.fromkeys(names, ((340, 0),)))
    drawing.section("BLOCKS")
    for name, owner in zip(names, owners, strict=True):
        begin = [(2, name), (70, 0), (10, 0.0), (20, 0.0), (30, 0.0), (3, name), (1, "")]
        drawing.record("BLOCK", owner, [(100, "AcDbEntity"), (8, "0"), (100, "AcDbBlockBegin"), *begin])
        drawing.record("ENDBLK", owner, [(100, "AcDbEntity"), (8, "0"), (100, "AcDbBlockEnd")])
    return owners[0]
