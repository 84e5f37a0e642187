"""DXF: a MESH for each class of surfaces, on a layer of its name. Needs the package ezdxf."""

from pathlib import Path
from typing import Any

import numpy as np

from .._core import PolygonMesh
from .surfaces import CLASSES, Surfaces, rings

_COLORS = {"WallSurface": 9, "RoofSurface": 1, "GroundSurface": 3, "OuterCeilingSurface": 30}
_METRES = 6


def write(path: Path, poly: PolygonMesh, surfaces: Surfaces) -> None:
    """N-gons stay n-gons; coordinates are the scan's, in double precision."""
    import ezdxf

    drawing: Any = ezdxf.new("R2000")
    drawing.header["$INSUNITS"] = _METRES
    space = drawing.modelspace()
    at, loops = np.asarray(poly.vertices, dtype=np.float64), rings(poly)
    for kind in CLASSES:
        some = surfaces.of(kind)
        if not some:
            continue
        drawing.layers.add(kind, color=_COLORS[kind])
        used, local = np.unique(np.concatenate([loops[q] for q in some]), return_inverse=True)
        ends = np.cumsum([len(loops[q]) for q in some])[:-1]
        mesh = space.add_mesh(dxfattribs={"layer": kind})
        with mesh.edit_data() as data:
            data.vertices = at[used].tolist()
            data.faces = [part.tolist() for part in np.split(local, ends)]
    drawing.saveas(path)
