"""Writes DXF: a MESH for each class of surfaces, on a layer of its name. Needs the package ezdxf."""

from pathlib import Path
from typing import Any

from .._core import PolygonMesh
from .surfaces import CLASSES, Surfaces, part_of, rings

_COLORS = {"WallSurface": 9, "RoofSurface": 1, "GroundSurface": 3, "OuterCeilingSurface": 30}
_METRES = 6


def write(path: Path, poly: PolygonMesh, surfaces: Surfaces) -> None:
    """Write n-gons without triangulation; coordinates are the scan's, in double precision."""
    import ezdxf

    drawing: Any = ezdxf.new("R2000")
    drawing.header["$INSUNITS"] = _METRES
    space = drawing.modelspace()
    loops = rings(poly)
    for kind in CLASSES:
        some = surfaces.of(kind)
        if not some:
            continue
        drawing.layers.add(kind, color=_COLORS[kind])
        at, parts = part_of(poly, loops, some)
        mesh = space.add_mesh(dxfattribs={"layer": kind})
        with mesh.edit_data() as data:
            data.vertices = at.tolist()
            data.faces = [part.tolist() for part in parts]
    drawing.saveas(path)
