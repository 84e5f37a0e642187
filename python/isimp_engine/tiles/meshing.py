"""From thinned tiles to polygons."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import CleanOptions, Mesh, MeshingOptions, clean, partition_from, write
from . import steps
from .store import load, of_tile

Task = dict[str, Any]


class Surface(NamedTuple):
    """A thinned mesh with the labels of its faces, and the moments of the scan faces that they represent."""

    mesh: Mesh
    label: NDArray[np.int32]
    moments: NDArray[np.float64]


def thinned(parts: list[Path], threads: int) -> Surface:
    """Join the thinned meshes of some folders, and thin the result again over the former borders."""
    options = CleanOptions(stitch=0, grid=0, threads=threads)  # its borders are those between parts

    def joined(name: str) -> NDArray[Any]:
        return np.concatenate([load(part, name) for part in parts])

    sizes = [len(load(part, "vertices", mapped=True)) for part in parts]
    first = np.cumsum([0] + sizes)
    triangles = np.concatenate([load(p, "triangles") + int(o) for p, o in zip(parts, first, strict=False)])
    mesh = clean(joined("vertices"), triangles.astype(np.int32, copy=False), options)
    del triangles
    # Moments need more memory than the mesh, so one copy of them exists at a time.
    label, moments = joined("label")[mesh.source_face], joined("moments")[mesh.source_face]
    again = steps.thin(mesh, label, moments)
    del label, moments
    mesh = clean(again.vertices, again.triangles, options)
    source = mesh.source_face
    return Surface(mesh, again.label[source], again.moments[source])


def mesh_all(task: Task, work: Path, made: Path) -> dict[str, Any]:
    """Write the polygons of all tiles."""
    mesh, label, moments = thinned([of_tile(work, "thin", tile) for tile in task["present"]], task["threads"])
    part = partition_from(mesh, label)
    kept = steps.kept_moments(mesh, moments)
    del label, moments
    poly = steps.polygonize_thinned(mesh, part, MeshingOptions(**task["meshing"]), kept)
    write(made / task["output"], poly)
    report = {key: value for key, value in poly.report.items() if key not in ("imperfect", "work")}
    diagonal = mesh.report["diagonal"]
    return {"thinned_faces": len(mesh.triangles), "pieces": part.region_count, "diagonal": diagonal, "output": report}
