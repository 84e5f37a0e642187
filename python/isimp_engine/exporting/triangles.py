"""Polygons as triangles: STL and 3MF, for printers and programs without n-gons."""

import zipfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .. import three_mf
from .._core import Job, PolygonMesh, triangulate
from ..surfaces import far_from_zero

_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
_DATE = (1980, 1, 1, 0, 0, 0)  # the earliest of zip files: equal results are equal files
_PARTS = {
    "[Content_Types].xml": '<?xml version="1.0" encoding="UTF-8"?>\n'
    '<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">'
    '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    '<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>\n',
    "_rels/.rels": '<?xml version="1.0" encoding="UTF-8"?>\n'
    '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
    '<Relationship Target="/3D/3dmodel.model" Id="rel0" '
    'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>\n',
}


def write_stl(draft: Path, polygons: PolygonMesh, job: Job | None = None) -> None:
    """Write binary STL; far from zero, where float32 has too few digits, STL as text."""
    triangles, _ = triangulate(polygons.vertices, polygons.loops, polygons.loop_start, job=job)
    corners = polygons.vertices[triangles]
    normal = _normals(corners)
    if not far_from_zero(polygons.vertices).any():
        rows = np.zeros(len(corners), _RECORD)
        rows["normal"], rows["corners"] = normal, corners
        draft.write_bytes(b"isimp".ljust(80) + np.uint32(len(rows)).tobytes() + rows.tobytes())
        return
    lines = ["solid isimp"]
    for (x, y, z), points in zip(normal.tolist(), corners.tolist(), strict=True):
        lines += [f"facet normal {x:.7g} {y:.7g} {z:.7g}", "outer loop"]
        lines += [f"vertex {a!r} {b!r} {c!r}" for a, b, c in points]
        lines += ["endloop", "endfacet"]
    draft.write_text("\n".join([*lines, "endsolid isimp", ""]), encoding="ascii")


def write_3mf(draft: Path, polygons: PolygonMesh, unit: str, job: Job | None = None) -> None:
    """Write 3MF with one object: a model if the polygons are closed, else a surface. unit: the scene unit."""
    triangles, _ = triangulate(polygons.vertices, polygons.loops, polygons.loop_start, job=job)
    kind = "model" if polygons.report["closed"] else "surface"
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<model unit="{three_mf.UNITS[unit]}" xml:lang="en-US"'
        ' xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">',
        '<metadata name="Application">isimp</metadata>',
        f'<resources><object id="1" type="{kind}"><mesh><vertices>',
        *(f'<vertex x="{x!r}" y="{y!r}" z="{z!r}"/>' for x, y, z in polygons.vertices.tolist()),
        "</vertices><triangles>",
        *(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in triangles.tolist()),
        '</triangles></mesh></object></resources><build><item objectid="1"/></build></model>',
        "",
    ]
    parts = _PARTS | {"3D/3dmodel.model": "\n".join(lines)}
    with zipfile.ZipFile(draft, "w", zipfile.ZIP_DEFLATED) as file:
        for name, text in parts.items():
            file.writestr(zipfile.ZipInfo(name, _DATE), text, zipfile.ZIP_DEFLATED)


def _normals(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """(F, 3) unit normals of triangles; 0 without area."""
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(area, axis=1, keepdims=True)
    unit: NDArray[np.float64] = np.divide(area, length, out=np.zeros_like(area), where=length > 0)
    return unit
