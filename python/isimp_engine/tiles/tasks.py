"""The work of a child process: one step of one tile, or of all together. It reads and writes files of arrays."""

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
    clean,
)
from ..file_faces import cut, largest_shares
from ..reading import read_polygons
from . import borders, grouped, meshing, steps, tileset
from .splitting import split_scan
from .store import MADE, load, of_tile, save, save_values, tile_name

_CLEAN = CleanOptions(stitch=0, grid=0, threads=1)  # tiles share their borders with their neighbours
_FINER = 4.0  # ratio of the tolerance at which the joined tree is cut to that of the patches
SURPLUS = 2.2  # regions before the last merging, as a multiple of a given number
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
    neighbour, mesh_face = steps.faces_of(whole)[1:3]
    at, corner = borders.border_edges(neighbour)
    face = mesh_face[at]
    corners = whole.triangles
    save(made, vertices=whole.vertices, triangles=corners, polygon=polygon[whole.source_face])
    save(made, ends=np.stack([corners[face, corner], corners[face, (corner + 1) % 3]], 1), face=face, corner=corner)
    low, high = whole.vertices.min(0).tolist(), whole.vertices.max(0).tolist()
    repairs = {name: count for name, count in whole.report["repairs"].items() if count}
    values = {"file_faces": faces, "faces": len(corners), "repairs": repairs, "low": low, "high": high}
    return values | ({"extent": steps.measure(whole)._asdict()} if task.get("measured") else {})


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
        to = steps.weld(place, tile_of, task["weld"])
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
    found = steps.points_on_edges(place[edge[left]].reshape(-1, 3), place[points], length)
    if not len(found):
        return nothing
    result = np.stack([left[found[:, 0]], points[found[:, 1]]], 1)
    result = result[edge_tile[result[:, 0]] != tile_of[result[:, 1]]]
    key = np.stack([result[:, 0].astype(np.uint64), names[result[:, 1]]], 1)
    _, one = np.unique(key, axis=0, return_index=True)  # a place that several tiles share is inserted once
    kept: NDArray[np.int64] = result[np.sort(one)]
    return kept


def _patches(task: Task, work: Path, made: Path) -> dict[str, Any]:
    """Save the faces of the mended mesh of a tile, its patches, and the fringe that other tiles need."""
    tile = task["tile"]
    mesh, polygon = _mended(work, tile)
    if mesh is None:
        return {"faces": 0, "patches": 0}
    # The arrays for relaxing are saved before the patches are made, so that memory never holds both.
    record, neighbour, mesh_face, length = steps.faces_of(mesh)
    save(made, record=record, neighbour=neighbour, mesh_face=mesh_face, length=length, polygon=polygon)
    del length, polygon
    fringe = borders.fringe_of(record, neighbour, mesh_face, mesh.triangles, mesh.vertices)
    save(made, **{f"fringe_{name}": array for name, array in fringe._asdict().items()})
    faces, edge_face = len(record), fringe.edge_face
    del record, neighbour, mesh_face, fringe
    if "tolerance" in task:
        found = steps.detail_patches(mesh, task["tolerance"] / _FINER, task["noise"])
    else:
        found = steps.patches(mesh, task["size"], task["smooth"])
    save(made, label=found.label, sums=found.sums, pairs=found.pairs, edge_patch=found.label[edge_face])
    return {"faces": faces, "patches": len(found.sums)}


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


def fringe(work: Path, tile: int) -> borders.Fringe:
    folder = of_tile(work, "patches", tile)
    return borders.Fringe(*(load(folder, f"fringe_{name}") for name in borders.Fringe._fields))


def _join(task: Task, work: Path, made: Path) -> dict[str, Any]:
    """Join the graphs of patches, or of groups, and merge them to the number found, or to SURPLUS times a given one."""
    tiles, groups = task["present"], task["groups"]
    folders = [of_tile(work, "cut" if groups else "patches", k) for k in (range(groups) if groups else tiles)]
    sums = [load(folder, "sums") for folder in folders]
    first = np.cumsum([0] + [len(each) for each in sums])
    keys = [load(folder, "fringe_edge_keys") for folder in folders]
    patch = np.concatenate([load(f, "edge_patch") + o for f, o in zip(folders, first, strict=False)]).astype(np.int32)
    edge_tile = np.repeat(np.arange(len(keys), dtype=np.int32), [len(k) for k in keys])
    matched = borders.match(np.concatenate(keys), edge_tile)
    inner = [load(f, "pairs") + o for f, o in zip(folders, first, strict=False)]
    pairs = np.concatenate([*inner, patch[matched]]).astype(np.int32)
    lengths = np.zeros(len(pairs))  # borders cost nothing yet
    whole = np.concatenate(sums)
    free = np.ones(len(patch), bool)
    free[matched.ravel()] = False
    open_nodes = np.concatenate([load(f, "open") for f in folders]) if groups else np.zeros(len(whole), np.uint8)
    open_nodes[patch[free]] = 1
    asked = task["wanted"].get("proxies")
    found = steps.find_components(whole, pairs, lengths, open_nodes, asked or 1, task["leave_out"])
    needed = int(found.need.sum())
    by_detail = None if asked else steps.find_regions(whole, pairs, found, **task["wanted"])
    wanted = max(asked if by_detail is None else by_detail.regions, needed)
    target = int(SURPLUS * wanted) if asked else wanted
    label = steps.merge(whole, pairs, lengths, found, max(target, needed))
    region_sums, component = _merged(whole, found.component, label)
    save(made, first=first, label=label, sums=region_sums, component=component, need=found.need)
    return {
        "regions": len(region_sums),
        "wanted": wanted,
        "cost": by_detail and by_detail.cost,
        "snapped": by_detail and by_detail.snapped,
        "needed": needed,
        "left_out": found.left_out,
        "area_left_out": found.area_left_out,
        "area": float(whole[:, 3].sum() / 2),
    } | (grouped.totals(work, groups) if groups else _totals(tiles, folders, keys, len(whole), len(matched)))


def _totals(tiles: list[int], folders: list[Path], keys: list[Any], patches: int, matched: int) -> dict[str, Any]:
    near = borders.neighbours_of(keys)
    return {
        "patches": patches,
        "border_edges": sum(len(each) for each in keys),
        "matched_edges": 2 * matched,
        "graph_bytes": grouped.graph_bytes(folders),
        "near": {str(tiles[k]): [tiles[j] for j in near[k]] for k in range(len(tiles))},
    }


def _merged(
    sums: NDArray[np.float64], component: NDArray[np.int32], label: NDArray[np.int32]
) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Return the sums and the components of regions, from the sums and components of their nodes."""
    kept = label >= 0
    count = int(label.max()) + 1
    merged = np.empty((count, 5))
    for k in range(5):
        merged[:, k] = np.bincount(label[kept], sums[kept, k], count)
    of = np.full(count, -1, np.int32)
    of[label[kept]] = component[kept]
    return merged, of


def _halo(task: Task, work: Path, made: Path) -> dict[str, Any]:
    """Save the halo of a tile, and the first labels of its faces."""
    tile, near = task["tile"], task["near"]
    folder, join = of_tile(work, "patches", tile), of_tile(work, "join", 0)
    own = fringe(work, tile)
    halo = borders.halo_of(tile, load(folder, "neighbour"), own, {k: fringe(work, k) for k in near})
    save(made, **halo._asdict())
    label = load(folder, "label")
    if "group" in task:
        label = load(of_tile(work, "cut", task["group"]), "label")[task["at"] + label]
    label = load(join, "label")[task["first"] + label]
    save(made, label=label, fringe_label=label[own.face])
    return {"halo": len(halo.record)}


def _labels(task: Task, work: Path) -> NDArray[np.int32]:
    """Return the labels of a tile and its halo after the previous step."""
    tile, before = task["tile"], task["before"]
    halo = of_tile(work, "halo", tile)
    owner, place = load(halo, "tile"), load(halo, "place")
    label = np.append(load(of_tile(work, before, tile), "label"), np.empty(len(owner), np.int32))
    out = label[len(label) - len(owner) :]
    for other in np.unique(owner).tolist():
        rows = owner == other
        out[rows] = load(of_tile(work, before, other), "fringe_label")[place[rows]]
    if "relabel" in task:
        to = np.append(load(of_tile(work, task["relabel"], 0), "label"), np.int32(-1))
        label = to[label]
    return label


def _relax(task: Task, work: Path, made: Path) -> dict[str, Any]:
    tile = task["tile"]
    folder, place = of_tile(work, "patches", tile), of_tile(work, "halo", tile)
    halo = borders.Halo(*(load(place, name) for name in borders.Halo._fields))
    record = np.concatenate([load(folder, "record"), halo.record])
    own = len(record) - len(halo.record)
    rank = borders.ranks(task["tiles"], task["round"])
    done = steps.relax(
        record,
        halo.neighbour,
        own,
        _labels(task, work),
        borders.frozen_of(halo, own, tile, rank),
        load(of_tile(work, task["sums"], 0), "sums"),
        steps.WholeScan(**task["whole"]),
    )
    save(made, label=done.label, fringe_label=done.label[load(folder, "fringe_face")])
    save(made, changed=done.changed, change=done.change)
    return {"moves": done.moves}


def _sum(task: Task, work: Path, made: Path) -> dict[str, Any]:
    """Save the sums of all regions after a round."""
    folders = [of_tile(work, task["after"], tile) for tile in task["present"]]
    changes = [(load(folder, "changed"), load(folder, "change")) for folder in folders]
    save(made, sums=steps.add_changes(load(of_tile(work, task["sums"], 0), "sums"), changes))
    return {}


def _touch(task: Task, work: Path, made: Path) -> dict[str, Any]:
    tile = task["tile"]
    length = load(of_tile(work, "patches", tile), "length")
    place, label = of_tile(work, "halo", tile), _labels(task, work)
    pairs, lengths = steps.touching(load(place, "neighbour"), len(length), label, length)
    save(made, pairs=pairs, lengths=lengths)
    if task["groups"]:
        halo = borders.Halo(*(load(place, name) for name in borders.Halo._fields))
        save(made, rim=grouped.rim_of(halo, label, len(length)))
    return {}


def _merge(task: Task, work: Path, made: Path) -> dict[str, Any]:
    """Merge the regions to the number to be made."""
    folders = [of_tile(work, "touch", tile) for tile in task["present"]]
    pairs, lengths = (np.concatenate([load(folder, name) for folder in folders]) for name in ("pairs", "lengths"))
    sums, join, groups = load(of_tile(work, task["sums"], 0), "sums"), of_tile(work, "join", 0), task["groups"]
    whole, component, need = len(sums), load(join, "component"), load(join, "need")
    target, cost = task["target"], task["cost"]

    def part(label: NDArray[np.int32]) -> tuple[Any, Any, Any, steps.Components]:
        joined = steps.contracted(label, sums, pairs, lengths)
        of = np.empty(len(joined[0]), np.int32)
        of[label] = component
        return *joined, steps.Components(of, need, 0, 0.0)

    label = np.arange(whole, dtype=np.int32)
    rest, near, own_lengths, found = sums, pairs, lengths, steps.Components(component, need, 0, 0.0)
    if groups:
        price = grouped.price_of_regions(work, groups, whole, target) if cost is None else cost / 2
        label = grouped.merged_in_groups(work, groups, whole, price)
        rest, near, own_lengths, found = part(label)
    if cost is not None:  # count again: borders have moved, and some regions are now similar to their neighbours
        target = min(target, steps.find_regions(rest, near, found, 0.0, 0.0, cost=cost).regions)
    joined = len(rest)
    label = steps.merge(rest, near, own_lengths, found, target, task["smooth"], task["error"], target)[label]
    merged, of = _merged(sums, component, label)
    save(made, label=label, sums=merged, component=of)
    return {"regions": len(merged), "joined": joined}


def _thin(task: Task, work: Path, made: Path) -> dict[str, Any]:
    """Save the thinned mesh of a tile for meshing, and the labels of the file's faces."""
    tile = task["tile"]
    mesh, polygon = _mended(work, tile)
    assert mesh is not None
    folder = of_tile(work, "patches", tile)
    mesh_face = load(folder, "mesh_face")
    region = np.empty(len(mesh_face), np.int32)
    region[mesh_face] = load(of_tile(work, task["before"], tile), "label")
    area = np.empty(len(mesh_face))
    area[mesh_face] = load(folder, "record")[:, 3]
    if task["labels"]:
        save(made, face=np.unique(polygon), region=_file_labels(polygon, region, area))
    thinned = steps.thin(mesh, region)
    save(made, **thinned._asdict())
    length = load(folder, "length")
    neighbour = load(of_tile(work, "halo", tile), "neighbour")
    borders_length = float(steps.touching(neighbour, len(length), _labels(task, work), length)[1].sum())
    return {"faces": len(thinned.triangles), "borders": borders_length}


def _file_labels(polygon: NDArray[np.int32], region: NDArray[np.int32], area: NDArray[np.float64]) -> NDArray[np.int32]:
    """Return the region with most of the area of each face of the file that is left, in rising order of the faces."""
    kept = region >= 0
    faces, at = np.unique(polygon, return_inverse=True)
    result = np.full(len(faces), -1, np.int32)
    result[at[kept]] = region[kept]
    shared = np.bincount(at[kept][result[at[kept]] != region[kept]], minlength=len(faces)) > 0
    several = kept & shared[at]
    if several.any():
        place, largest = largest_shares(at[several].astype(np.int32), region[several], area[several])
        result[place] = largest
    return result


_STEPS: dict[str, Callable[[Task, Path, Path], dict[str, Any]]] = {
    "split": _split,
    "prepare": _prepare,
    "mend": _mend,
    "patches": _patches,
    "group": grouped.group,
    "level": grouped.level,
    "cut": grouped.cut,
    "join": _join,
    "halo": _halo,
    "relax": _relax,
    "sum": _sum,
    "touch": _touch,
    "regroup": grouped.regroup,
    "merge": _merge,
    "thin": _thin,
    "mesh": meshing.mesh_all,
}
#: regular expression of the folders of steps in a work folder; rounds of relaxing have a number
FOLDERS = "|".join([*(step for step in _STEPS if step not in ("relax", "sum")), r"(first|last)-\d+(-sums)?"])
