"""The files of a report about a model."""

from contextlib import ExitStack
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .._core import Mesh, Partition, PolygonMesh
from ..batch import picture
from ..drafts import whole
from ..sizes import SIZE_COLUMNS, SNAPPED_COLUMNS, size_rows
from .page import numbers_of, write_page
from .planes import PlaneTable, write_csv, write_geojson
from .round_parts import ROUND_COLUMNS

ANGLES = "angles.csv"
_PLANES, _ROUND, _MAP, _PAGE = "planes.csv", "round_parts.csv", "planes.geojson", "report.html"
_SIZES = "sizes.csv"
NAMES = (_PLANES, _ROUND, _SIZES, _MAP, _PAGE, ANGLES)  #: all files that a report can have

_SIDE = 420  # pixels of each picture


def texts_of(
    title: str,
    mesh: Mesh,
    part: Partition,
    polygons: PolygonMesh,
    table: PlaneTable,
    crs: int | None = None,
    turn: NDArray[np.float64] | None = None,
    step: float | None = None,
) -> dict[str, str]:
    """Return the content of each file of a report, by name. Round parts and sizes have one if there are some.

    table: the planes, as `plane_table` returns them. crs: EPSG number of the coordinates, or None. turn: (3, 3) from
    the coordinates of the mesh to the coordinates of the pictures; None: the same. step: of snapped sizes, as in
    `size_rows`.
    """
    scan, model = np.asarray(mesh.vertices), np.asarray(polygons.vertices)
    if turn is not None:
        scan, model = scan @ turn.T, model @ turn.T
    shown = model, polygons.loops, polygons.loop_start, polygons.polygon_region
    seen = picture.beside((scan, np.asarray(mesh.triangles)), shown, _SIDE)
    parts = {_ROUND: write_csv(table.round_parts, ROUND_COLUMNS)} if table.round_parts else {}
    sizes = size_rows(mesh, part, step)
    parts |= {_SIZES: write_csv(sizes, SNAPPED_COLUMNS if step else SIZE_COLUMNS)} if sizes else {}
    return {
        _PLANES: write_csv(table.rows),
        **parts,
        _MAP: write_geojson(table, crs),
        _PAGE: write_page(title, numbers_of(mesh, part, polygons.report, table), table, seen),
    }


def write(folder: Path, texts: dict[str, str]) -> None:
    """Write the files of a report, by name, and remove the files of an earlier report that this one lacks.

    The folder is made if it does not exist. If a file can't be written, all files stay as they were. Raises OSError.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with ExitStack() as drafts:
        for name, text in texts.items():
            try:
                drafts.enter_context(whole(folder / name)).write_text(text, encoding="utf-8")
            except OSError as error:
                raise OSError(error.errno, error.strerror or str(error), str(folder / name)) from None
    for name in NAMES:
        if name not in texts:
            (folder / name).unlink(missing_ok=True)
