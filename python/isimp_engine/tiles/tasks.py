"""The work of a child process: one step of one tile, or of all together. It reads and writes files of arrays."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import (
    CleanOptions,
    FileError,
    InvalidInput,
    Mesh,
    MeshingOptions,
    PartitionOptions,
    _core,
    clean,
    partition,
    polygonize,
    write,
)
from ..file_faces import cut
from ..reading import read_polygons
from ..surfaces import areas
from . import borders, tileset
from .splitting import split_scan
from .store import MADE, load, of_tile, save, save_values, tile_name

_CLEAN = CleanOptions(stitch=0, grid=0, threads=1)  # tiles share their borders with their neighbours
_T_JUNCTION = 1e-9  # share of the diagonal: largest distance of a T-junction from its edge without welding

Task = dict[str, Any]


def run(task: Task, folder: Path) -> dict[str, Any]:
    """Run the step `task["step"]`. Its files are written to a folder MADE. Returns {"why": ...} if it fails."""
    made = folder / MADE
    made.mkdir()
    work = Path(task["work"])
    try:
        save_values(made, _STEPS[task["step"]](task, work, made))
    except (FileError, InvalidInput) as error:
        return {"why": str(error)}
    except OSError as error:
        return {"why": f"{error.filename or made}: {error.strerror or error}"}
    return {"done": True}


def _split(task: Task, work: Path, made: Path) -> dict[str, Any]:
    return dict(split_scan(Path(task["input"]), made, task["tile_faces"]))


def _prepare(task: Task, work: Path, made: Path) -> dict[str, Any]:
    """Read and repair a tile; save its mesh and its border."""
    if "place" in task:
        vertices, triangles = tileset.read(tileset.Leaf(Path(task["input"]), task["place"], task["up"]))
        faces = len(triangles)
        polygon = np.arange(faces, dtype=np.int32)
    elif "input" in task:
        vertices, loops, loop_start = read_polygons(Path(task["input"]), threads=1)
        triangles, polygon = cut(vertices, loops, loop_start)
        faces = len(loop_start)
        del loops, loop_start
    else:
        folder = of_tile(work, "split", 0) / tile_name(task["tile"])
        vertices, triangles, polygon = (load(folder, name) for name in ("vertices", "triangles", "polygon"))
        faces = len(triangles)
    whole = _clean(vertices, triangles)
    del vertices, triangles
    if whole is None:
        nothing = np.zeros((0, 3))
        save(made, vertices=nothing, triangles=np.zeros((0, 3), np.int32), polygon=np.zeros(0, np.int32))
        save(made, ends=np.zeros((0, 2), np.int32), face=np.zeros(0, np.int32), corner=np.zeros(0, np.int8))
        return {"file_faces": faces, "faces": 0, "repairs": {}, "low": None, "high": None}
    corners = whole.triangles
    face, corner, ends = _border_of(whole)
    save(made, vertices=whole.vertices, triangles=corners, polygon=polygon[whole.source_face])
    save(made, ends=ends, face=face, corner=corner)
    low, high = whole.vertices.min(0).tolist(), whole.vertices.max(0).tolist()
    repairs = {name: count for name, count in whole.report["repairs"].items() if count}
    values = {"file_faces": faces, "faces": len(corners), "repairs": repairs, "low": low, "high": high}
    return values | ({"noise": _core._noise(whole), "area": whole.report["area"]} if task.get("measured") else {})


def _border_of(mesh: Mesh) -> tuple[NDArray[np.int32], NDArray[np.int8], NDArray[np.int32]]:
    """Return the border edges of a mesh: the face and the first corner of each, and its two ends."""
    edge = _core._tile_border(mesh)
    face, corner = edge // 3, edge % 3
    triangles = mesh.triangles
    ends = np.stack([triangles[face, corner], triangles[face, (corner + 1) % 3]], 1)
    return face.astype(np.int32), corner.astype(np.int8), ends


def _clean(vertices: NDArray[Any], triangles: NDArray[Any]) -> Mesh | None:
    """Return the repaired mesh; None if no face of the tile can be used."""
    if not len(triangles):
        return None
    try:
        return clean(vertices, triangles, _CLEAN)
    except InvalidInput as error:
        if str(error).startswith("no usable face"):
            return None
        raise


def _mend(task: Task, work: Path, made: Path) -> dict[str, Any]:
    """Find border vertices to move so that tiles meet, and border vertices to insert into edges of other tiles."""
    tiles = range(task["tiles"])
    folders = [of_tile(work, "prepare", tile) for tile in tiles]
    ends = [load(folder, "ends") for folder in folders]
    vertex = [np.unique(each) for each in ends]
    points = [load(folder, "vertices", mapped=True)[v] for folder, v in zip(folders, vertex, strict=True)]
    tile_of = np.repeat(np.arange(len(vertex), dtype=np.int32), [len(v) for v in vertex])
    place = np.concatenate([np.zeros((0, 3)), *points])
    moved = np.zeros(0, np.int64)
    if task["weld"] > 0 and len(place):
        to = _core._tile_weld(place, tile_of, task["weld"])
        moved = np.flatnonzero((place[to] != place).any(1))
        place = place[to]
    first = np.cumsum([0] + [len(v) for v in vertex])
    rows = [first[k] + np.searchsorted(vertex[k], ends[k]) for k in tiles]
    edge = np.concatenate([np.zeros((0, 2), np.int64), *rows])
    edge_tile = np.repeat(np.arange(len(ends), dtype=np.int32), [len(e) for e in ends])
    names = borders.place_keys(place)
    found = _t_junctions(place, names, tile_of, edge, edge_tile, task)
    junctions = 0
    edge_first = np.cumsum([0] + [len(e) for e in ends])
    for k in tiles:
        own = moved[(moved >= first[k]) & (moved < first[k + 1])]
        split = found[(found[:, 0] >= edge_first[k]) & (found[:, 0] < edge_first[k + 1])]
        at = split[:, 0] - edge_first[k]
        junctions += len(at)
        save(
            made / tile_name(k),
            moved=vertex[k][own - first[k]],
            to=place[own],
            face=load(folders[k], "face")[at],
            corner=load(folders[k], "corner")[at],
            added=place[split[:, 1]],
        )
    return {"welded": len(moved), "t_junctions": junctions}


def _t_junctions(
    place: NDArray[np.float64],
    names: NDArray[np.uint64],
    tile_of: NDArray[np.int32],
    edge: NDArray[np.int64],
    edge_tile: NDArray[np.int32],
    task: Task,
) -> NDArray[np.int64]:
    """Return (J, 2) pairs of a border edge and a vertex of another tile inside it, by edge, then along it."""
    whole = np.ones(len(edge), bool)
    whole[borders.match(names[edge], edge_tile).ravel()] = False
    left = np.flatnonzero(whole)
    nothing = np.zeros((0, 2), np.int64)
    if not len(left):
        return nothing
    points = np.unique(edge[left])
    _, one = np.unique(names[points] ^ tile_of[points].astype(np.uint64), return_index=True)
    points = points[np.sort(one)]
    length = max(task["weld"], _T_JUNCTION * task["diagonal"])
    found = _core._tile_points_on_edges(place[edge[left]].reshape(-1, 3), place[points], length)
    if not len(found):
        return nothing
    result = np.stack([left[found[:, 0]], points[found[:, 1]]], 1)
    result = result[edge_tile[result[:, 0]] != tile_of[result[:, 1]]]
    key = np.stack([result[:, 0].astype(np.uint64), names[result[:, 1]]], 1)
    _, one = np.unique(key, axis=0, return_index=True)  # a place that several tiles share is inserted once
    kept: NDArray[np.int64] = result[np.sort(one)]
    return kept


def _thin(task: Task, work: Path, made: Path) -> dict[str, Any]:
    """Save the mended mesh of a tile with fewer faces, and the thinned face that each face has become part of."""
    mesh, polygon = _mended(work, task["tile"])
    if mesh is None or not mesh.report["area"] > 0:
        return {"faces": 0, "thinned_faces": 0}
    faces = len(mesh.triangles)
    area = areas(mesh.vertices, mesh.triangles).astype(np.float32)
    save(made, edge_keys=borders.place_keys(mesh.vertices)[_border_of(mesh)[2]], area=area, polygon=polygon)
    vertices, triangles, to = _core._tile_thin(mesh, math.ceil(task["share"] * faces))
    save(made, vertices=vertices, triangles=triangles, to=to)
    return {"faces": faces, "thinned_faces": len(triangles)}


def _mended(work: Path, tile: int) -> tuple[Mesh | None, NDArray[np.int32]]:
    """Return the mesh of a tile that fits its neighbours, and the face of the file that each face is part of."""
    folder, mend = of_tile(work, "prepare", tile), of_tile(work, "mend", 0) / tile_name(tile)
    polygon = load(folder, "polygon")
    if not len(polygon):
        return None, polygon
    vertices, triangles = load(folder, "vertices"), load(folder, "triangles")
    moved, added = load(mend, "moved"), load(mend, "added")
    if not len(moved) and not len(added):
        return Mesh(vertices, triangles, threads=1), polygon
    vertices[moved] = load(mend, "to")
    number = np.arange(len(vertices), len(vertices) + len(added), dtype=np.int32)
    triangles, source = borders.split_faces(triangles, load(mend, "face"), load(mend, "corner"), number)
    mesh = _clean(np.concatenate([vertices, added]), triangles)
    return mesh, polygon[source[mesh.source_face]] if mesh is not None else polygon[:0]


def _mesh(task: Task, work: Path, made: Path) -> dict[str, Any]:
    """Join the thinned tiles, write the polygons, and save the region of each thinned face; -1: none."""
    folders = [of_tile(work, "thin", tile) for tile in task["present"]]
    mesh = _joined(folders)
    options = PartitionOptions(**task["partition"], threads=task["threads"])
    part = partition(mesh, options)
    region = np.full(sum(len(load(folder, "triangles", mapped=True)) for folder in folders), -1, np.int32)
    region[mesh.source_face] = part.face_region
    save(made, region=region)
    poly = polygonize(mesh, part, MeshingOptions(**task["meshing"], threads=task["threads"]))
    write(made / task["output"], poly)
    report = {key: value for key, value in poly.report.items() if key not in ("imperfect", "work")}
    found = {name: part.report[name] for name in ("tolerance", "noise", "snapped", "error")}
    return (
        found
        | _border_counts(folders)
        | {
            "regions": part.region_count,
            "parts_left_out": part.parts_left_out,
            "area_left_out": part.area_left_out,
            "thinned_faces": len(mesh.triangles),
            "diagonal": mesh.report["diagonal"],
            "output": report,
        }
    )


def _joined(folders: list[Path]) -> Mesh:
    """Join the thinned meshes of tiles. Equal vertices become one, so tiles join where they fit."""
    first = np.cumsum([0] + [len(load(folder, "vertices", mapped=True)) for folder in folders])
    vertices = np.concatenate([load(folder, "vertices") for folder in folders])
    triangles = np.concatenate([load(f, "triangles") + np.int32(o) for f, o in zip(folders, first, strict=False)])
    return clean(vertices, triangles, CleanOptions(stitch=0, grid=0))


def _border_counts(folders: list[Path]) -> dict[str, int]:
    keys = [load(folder, "edge_keys") for folder in folders]
    tile = np.repeat(np.arange(len(keys), dtype=np.int32), [len(k) for k in keys])
    return {"border_edges": len(tile), "matched_edges": 2 * len(borders.match(np.concatenate(keys), tile))}


_STEPS: dict[str, Callable[[Task, Path, Path], dict[str, Any]]] = {
    "split": _split,
    "prepare": _prepare,
    "mend": _mend,
    "thin": _thin,
    "mesh": _mesh,
}
#: regular expression of the folders of steps in a work folder, also of earlier versions
FOLDERS = "|".join([*_STEPS, "patches|group|level|cut|join|halo|touch|regroup|merge", r"(first|last)-\d+(-sums)?"])
