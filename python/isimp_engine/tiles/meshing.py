"""From thinned tiles to polygons: all at once, or by groups of tiles and then what lies between them.

By groups: regions inside a group become polygons together with what its tiles have of the regions that reach, or touch,
another group. Of the latter only the planes count; their polygons are dropped. At last these regions become polygons in
one piece. On the chains between the two, corners and places are those that the groups chose, so both sides agree; a
corner that the last part adds lies on the chord, and goes into the polygon on the other side too. Then these corners
settle where the planes of all regions round them would have them.
"""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import CleanOptions, Mesh, MeshingOptions, PolygonMesh, clean, partition_from, write
from . import steps
from .borders import found_in, place_keys
from .parts import Added, Joined, Part, joined
from .store import load, of_tile, save, save_values, values_of

_FREE, _PLACE, _CORNER = 0, 1, 2  # as Fixed in meshing/part.h
_MENDED = ("crossing", "no_area", "flipped", "intersecting")
_ROUNDS = 5  # of making polygons again that meet those of another part
_LARGE = 100  # corners of a polygon, above which what is beside it is not made again for its sake
_FLAWS = ("crossing", "no_area", "flipped", "bent", "intersecting", "excused")
_COUNTS = ("regions_split", "merged_without_area", "joined_junctions", "diagonals", "planes_let_go", "without_area")
_SPLITS = tuple(f"split_for_{why}" for why in ("unconnected", "holes", "handles", "pinches", "closed", "repair"))

Task = dict[str, Any]


class Surface(NamedTuple):
    """A thinned mesh with the labels of its faces, and the moments of what they stand for."""

    mesh: Mesh
    label: NDArray[np.int32]
    moments: NDArray[np.float64]


def thinned(parts: list[Path], threads: int) -> Surface:
    """The thinned meshes of some folders as one, thinned again over what were borders between them."""
    options = CleanOptions(threads=threads)

    def joined(name: str) -> NDArray[Any]:
        return np.concatenate([load(part, name) for part in parts])

    sizes = [len(load(part, "vertices", mapped=True)) for part in parts]
    first = np.cumsum([0] + sizes)
    triangles = np.concatenate([load(p, "triangles") + int(o) for p, o in zip(parts, first, strict=False)])
    mesh = clean(joined("vertices"), triangles.astype(np.int32, copy=False), options)
    del triangles
    # Moments take more than the mesh, so there is one copy of them at a time.
    label, moments = joined("label")[mesh.source_face], joined("moments")[mesh.source_face]
    again = steps.thin(mesh, label, moments)
    del label, moments
    mesh = clean(again.vertices, again.triangles, options)
    source = mesh.source_face
    return Surface(mesh, again.label[source], again.moments[source])


def mesh_all(task: Task, work: Path, made: Path) -> dict[str, Any]:
    """The polygons of all tiles."""
    mesh, label, moments = thinned([of_tile(work, "thin", tile) for tile in task["present"]], task["threads"])
    part = partition_from(mesh, label)
    kept = steps.kept_moments(mesh, moments)
    del label, moments
    poly = steps.polygonize_thinned(mesh, part, MeshingOptions(**task["meshing"]), kept)
    write(made / task["output"], poly)
    report = {key: value for key, value in poly.report.items() if key not in ("imperfect", "work")}
    diagonal = mesh.report["diagonal"]
    return {"thinned_faces": len(mesh.triangles), "pieces": part.region_count, "diagonal": diagonal, "output": report}


def _options(task: Task, surface: Surface, regions: int) -> MeshingOptions:
    """The options of the whole: its shares of the diagonal, and of the mean size of regions, are others of a part."""
    given, whole = MeshingOptions(**task["meshing"]), task["whole"]
    long = whole["diagonal"] / max(surface.mesh.report["diagonal"], 1e-300)
    area = max(float(surface.moments[:, 0].sum()), 1e-300)
    wide = (whole["area"] / whole["regions"]) ** 0.5 / (area / max(regions, 1)) ** 0.5
    return MeshingOptions(
        **task["meshing"],
        reach=min(1.0, given.reach * long),
        flatness=min(100.0, given.flatness * long),
        flatness_from=round(given.flatness_from * max(regions, 1) / whole["regions"]),
        chord_tolerance=min(100.0, given.chord_tolerance * wide),
        join_junctions=min(100.0, given.join_junctions * wide),
    )


class Pieces(NamedTuple):
    """What polygons stand for; a piece of a region may have several of them."""

    of: NDArray[np.int32]  #: (Q,) the piece of each polygon
    first: NDArray[np.int32]  #: (L,) the first polygon of each piece, in rising order
    vector_area: NDArray[np.float64]  #: (L, 3)
    moments: NDArray[np.float64]  #: (L, 10)


def _pieces(surface: Surface, face_polygon: NDArray[np.int32], polygons: int) -> Pieces:
    own = face_polygon >= 0
    first, piece = np.unique(face_polygon[own], return_inverse=True)
    a, b, c = (surface.mesh.vertices[surface.mesh.triangles[own, k]] for k in range(3))
    across = np.cross(b - a, c - a) / 2
    area = np.stack([np.bincount(piece, across[:, k], len(first)) for k in range(3)], 1).astype(np.float64, copy=False)
    of = (np.searchsorted(first, np.arange(polygons), "right") - 1).astype(np.int32)
    return Pieces(of, first, area, steps.moments_of(piece, surface.moments[own], len(first)))


class Made(NamedTuple):
    """Polygons of a part, and of what they were made."""

    vertices: NDArray[np.float64]  #: (W, 3)
    keys: NDArray[np.uint64]  #: (W,) names of the places of the scan's vertices that they stand for
    polygons: list[NDArray[np.int32]]  #: vertices of each
    region: NDArray[np.int32]  #: (Q,)
    face_polygon: NDArray[np.int32]  #: (F,)
    source: NDArray[np.int32]  #: (W,) vertices of the mesh
    pieces: Pieces
    report: dict[str, Any]


def _polygons(surface: Surface, keys: NDArray[np.uint64], fixed: NDArray[np.uint8], mesh: Mesh, task: Task) -> Made:
    """The polygons of a part. mesh: that of `surface`, with its vertices where `fixed` ones are to be."""
    part = partition_from(mesh, surface.label)
    options = _options(task, surface, len(np.unique(surface.label)))
    poly, face_polygon = steps.polygonize_part(mesh, part, options, surface.moments, fixed)
    named = np.full(part.region_count, -1, np.int32)
    named[part.face_region] = surface.label
    loops = np.split(poly.loops, poly.loop_start[1:])
    source = poly.source_vertex
    pieces, region = _pieces(surface, face_polygon, len(loops)), named[poly.polygon_region]
    return Made(poly.vertices, keys[source], loops, region, face_polygon, source, pieces, poly.report)


def _flaws(report: dict[str, Any], kept: NDArray[np.bool_]) -> dict[str, int]:
    """Flaws among polygons that are kept, of those that are listed."""
    counts = dict.fromkeys(_FLAWS, 0)
    for each in report["imperfect"]:
        other = each.get("other", -1)
        if kept[each["polygon"]] and (other < 0 or (kept[other] and each["polygon"] < other)):
            counts[each["flaw"]] += 1
    return counts


def mesh_group(task: Task, work: Path, made: Path) -> dict[str, Any]:
    """The polygons of the regions inside a group, and the regions of the last part."""
    surface = thinned([of_tile(work, "thin", tile) for tile in task["own"]], 1)
    mesh, label, moments = surface
    keys, triangles = place_keys(mesh.vertices), mesh.triangles
    outer = np.isin(keys, np.unique(load(of_tile(work, "group", task["tile"]), "edge_keys")))
    _, which, often = np.unique(keys, return_inverse=True, return_counts=True)
    alike = often[which] > 1  # vertices at one place, where the scan is no manifold, can't be told apart by it
    at_border: NDArray[np.bool_] = np.any((outer | alike)[triangles], axis=1)
    between = np.unique(label[at_border])
    seen = Surface(mesh, label, _with_outside(task, work, label, at_border, moments))
    found = _polygons(seen, keys, np.zeros(len(keys), np.uint8), mesh, task)
    final = np.where(found.face_polygon >= 0, found.region[found.face_polygon], -1).astype(np.int32)
    between = np.union1d(between, final[at_border])  # a face at the border may have gone to a region inside
    group = _Group(mesh.vertices, triangles, final, moments, found, _across(mesh))
    _save_group(made / "group", group)
    values = _part(made, group, between)
    return values | {"faces": len(triangles), "rounds": found.report["repair_rounds"]}


def _with_outside(
    task: Task, work: Path, label: NDArray[np.int32], at_border: NDArray[np.bool_], moments: NDArray[np.float64]
) -> NDArray[np.float64]:
    """The moments of faces; one of each region at the border also stands for what near tiles have of that region."""
    folders = [of_tile(work, "thin", tile) for tile in task["beside"]]
    region = np.concatenate([np.zeros(0, np.int32), *(load(folder, "regions") for folder in folders)])
    outside = np.concatenate([np.zeros((0, 10)), *(load(folder, "of_regions") for folder in folders)])
    faces = np.flatnonzero(at_border)
    own, first = np.unique(label[faces], return_index=True)
    known = np.isin(region, own)
    faces = faces[first]
    number = np.append(np.arange(len(own)), np.searchsorted(own, region[known])).astype(np.int32)
    result = moments.copy()
    result[faces] = steps.moments_of(number, np.concatenate([moments[faces], outside[known]]), len(own))
    return result


def _across(mesh: Mesh) -> NDArray[np.int32]:
    """(F, 3) the face across each edge; -1 where there is none."""
    neighbour, mesh_face = steps.faces_of(mesh)[1:3]
    across = np.full(neighbour.shape, -1, np.int32)
    across[mesh_face] = np.where(neighbour >= 0, mesh_face[neighbour], -1)
    return across


class _Group(NamedTuple):
    """A group after its polygons were made."""

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int32]
    label: NDArray[np.int32]  #: regions whose polygons the faces went to
    moments: NDArray[np.float64]
    found: Made
    across: NDArray[np.int32]


def _part(made: Path, group: _Group, between: NDArray[np.int32]) -> dict[str, Any]:
    """Save the polygons of all regions but those of `between`, and what the last part needs of the latter."""
    found = group.found
    kept = ~np.isin(found.region, between)
    stays = np.isin(group.label, between)
    save(made / "polygons", **_parted(found, group.vertices[found.source], kept)._asdict())
    save(made, **_chains(group, kept, stays), between=between)
    used, local = np.unique(group.triangles[stays], return_inverse=True)
    corners = local.reshape(-1, 3).astype(np.int32)
    save(made / "rest", vertices=group.vertices[used], triangles=corners)
    save(made / "rest", label=group.label[stays], moments=group.moments[stays])
    counts = {name: found.report[name] for name in (*_COUNTS, *_SPLITS)}
    return {"rest": int(stays.sum()), "counts": counts, "flaws": _flaws(found.report, kept)}


def _save_group(folder: Path, group: _Group) -> None:
    found = group.found
    save(folder, vertices=group.vertices, triangles=group.triangles, label=group.label)
    save(folder, moments=group.moments, across=group.across)
    sizes = np.array([len(loop) for loop in found.polygons], np.int32)
    save(folder, places=found.vertices, keys=found.keys, loops=np.concatenate(found.polygons), sizes=sizes)
    save(folder, region=found.region, face_polygon=found.face_polygon, source=found.source)
    save(folder, **{f"piece_{name}": array for name, array in found.pieces._asdict().items()})
    save_values(folder, {name: found.report[name] for name in (*_COUNTS, *_SPLITS, "imperfect", "repair_rounds")})


def _load_group(folder: Path) -> _Group:
    loops = np.split(load(folder, "loops"), np.cumsum(load(folder, "sizes"))[:-1])
    region, face_polygon, source = (load(folder, name) for name in ("region", "face_polygon", "source"))
    report = values_of(folder)
    pieces = Pieces(*(load(folder, f"piece_{name}") for name in Pieces._fields))
    found = Made(load(folder, "places"), load(folder, "keys"), loops, region, face_polygon, source, pieces, report)
    vertices, triangles, label, moments = (load(folder, n) for n in ("vertices", "triangles", "label", "moments"))
    return _Group(vertices, triangles, label, moments, found, load(folder, "across"))


def _parted(found: Made, home: NDArray[np.float64], kept: NDArray[np.bool_]) -> Part:
    """The polygons of a part that are kept."""
    chosen = [found.polygons[q] for q in np.flatnonzero(kept)]
    sizes, loops = np.array([len(loop) for loop in chosen], np.int32), np.concatenate([np.zeros(0, np.int32), *chosen])
    piece = found.pieces.of[kept]
    areas, moments = found.pieces.vector_area[piece], found.pieces.moments[piece]
    return Part(found.vertices, home, found.keys, loops, sizes, found.region[kept], areas, moments)


def _chains(group: _Group, kept: NDArray[np.bool_], stays: NDArray[np.bool_]) -> dict[str, NDArray[Any]]:
    """The chains between polygons that are kept and faces that stay: what is fixed of their vertices.

    fixed_key, fixed_flag, fixed_place: of each vertex. added_key, added_polygon, added_after: vertices inside chords,
    in order along each, and behind which corner of which kept polygon they would stand.
    """
    found, vertices = group.found, group.vertices
    chord = _chords(found, kept)
    walk = _walked(group, stays, chord)
    place, flag = np.empty((len(vertices), 3)), np.zeros(len(vertices), np.uint8)
    # Vertices inside a chain are spread along its chord.
    rows, chain = walk.vertex, walk.chord
    before = np.where(np.append(True, chain[1:] != chain[:-1])[: len(chain)], chord.begin[chain], np.roll(rows, 1))
    length = np.linalg.norm(vertices[rows] - vertices[before], axis=1)
    total = np.bincount(chain, length, len(chord.begin))
    run = np.cumsum(length) - (np.cumsum(total) - total)[chain]
    inside = rows != chord.end[chain]
    first, last = found.vertices[chord.first[chain]], found.vertices[chord.last[chain]]
    share = (run / np.maximum(total[chain], 1e-300))[:, None]
    place[rows[inside]], flag[rows[inside]] = (first + share * (last - first))[inside], _PLACE
    for ends, corners in ((chord.begin, chord.first), (chord.end, chord.last)):
        place[ends[walk.is_whole]], flag[ends[walk.is_whole]] = found.vertices[corners[walk.is_whole]], _CORNER
    fixed = np.flatnonzero(flag)
    keys = place_keys(vertices)
    return {
        "fixed_key": keys[fixed],
        "fixed_flag": flag[fixed],
        "fixed_place": place[fixed],
        "added_key": keys[rows[inside]],
        "added_polygon": chord.polygon[chain[inside]],
        "added_after": chord.after[chain[inside]],
    }


class _Chords(NamedTuple):
    """The edges of polygons that are kept, in the order of these."""

    piece: NDArray[np.int64]  #: (N,)
    begin: NDArray[np.int64]  #: (N,) vertices of the mesh at its ends
    end: NDArray[np.int64]
    first: NDArray[np.int64]  #: (N,) vertices of the polygons there
    last: NDArray[np.int64]
    polygon: NDArray[np.int64]  #: (N,) which of those kept
    after: NDArray[np.int64]  #: (N,) which of its corners begins it


def _chords(found: Made, kept: NDArray[np.bool_]) -> _Chords:
    sizes = np.array([len(loop) for loop in found.polygons], np.int64)[kept]
    first = np.concatenate([np.zeros(0, np.int32), *(found.polygons[q] for q in np.flatnonzero(kept))]).astype(np.int64)
    starts = np.cumsum(sizes) - sizes
    polygon = np.repeat(np.arange(len(sizes)), sizes)
    at = np.arange(len(first))
    last = first[np.where(at + 1 == (starts + sizes)[polygon], starts[polygon], at + 1)]
    source, piece = found.source.astype(np.int64), found.pieces.of[kept].astype(np.int64)
    return _Chords(piece[polygon], source[first], source[last], first, last, polygon, at - starts[polygon])


class _Walked(NamedTuple):
    """The vertices of chains after the first of each, in order along each; only of chains that join a chord's ends."""

    chord: NDArray[np.int64]  #: (M,) rising
    vertex: NDArray[np.int64]  #: (M,)
    is_whole: NDArray[np.bool_]  #: (N,) of each chord whether it has one


def _walked(group: _Group, stays: NDArray[np.bool_], chord: _Chords) -> _Walked:
    """Walk along the boundaries between kept pieces and faces that stay, of all chords a step at a time."""
    found, across, count = group.found, group.across, np.int64(len(group.vertices))
    left = ~stays & (found.face_polygon >= 0)
    face, corner = np.nonzero(left[:, None] & (across >= 0) & stays[across])
    piece = found.pieces.of[found.face_polygon[face]]
    name = piece * count + group.triangles[face, corner]
    order = np.argsort(name, kind="stable")
    name, to = name[order], group.triangles[face, (corner + 1) % 3].astype(np.int64)[order]
    loops = np.concatenate([np.zeros(0, np.int32), *found.polygons])
    of = np.repeat(found.pieces.of, [len(loop) for loop in found.polygons])
    is_end = np.isin(piece[order] * count + to, of * count + found.source[loops])
    after, has_after = found_in(name, piece[order] * count + to)
    after = np.where(has_after & ~is_end, after, -1)
    at, begins = found_in(name, chord.piece * count + chord.begin)
    chains = np.flatnonzero(begins)
    at = at[chains]
    steps_of, vertices_of = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
    end = np.full(len(chord.begin), -1, np.int64)
    while len(chains):
        steps_of.append(chains)
        vertices_of.append(to[at])
        end[chains] = to[at]
        at = after[at]
        chains, at = chains[at >= 0], at[at >= 0]
    whole: NDArray[np.bool_] = end == chord.end
    walked, vertex = np.concatenate(steps_of), np.concatenate(vertices_of)
    rank = np.argsort(walked, kind="stable")
    rank = rank[whole[walked[rank]]]
    return _Walked(walked[rank], vertex[rank], whole)


def mesh_rest(task: Task, work: Path, made: Path) -> dict[str, Any]:
    """The polygons of the regions between groups, and all polygons together.

    Where polygons of the two still meet, those of groups are dropped, and their regions made again with the others.
    """
    folders = [of_tile(work, "mesh-group", k) for k in range(task["groups"])]
    values = [values_of(folder) for folder in folders]
    again = 0
    for number in range(_ROUNDS + 1):
        poly, of, last = _together(folders, task)
        faulty = _faulty(poly, of, last, len(folders))
        if not faulty or number == _ROUNDS:
            break
        again += sum(len(regions) for regions in faulty.values())
        for k, regions in faulty.items():
            whole = of_tile(work, "mesh-group", k) / "group"
            between = np.union1d(load(folders[k], "between"), regions).astype(np.int32)
            folders[k] = made / f"group-{k}-{number}"
            values[k] |= _part(folders[k], _load_group(whole), between)
    write(made / task["output"], poly)
    for folder in made.glob("group-*"):
        shutil.rmtree(folder)
    return _report(task, poly, values, last) | {"made_again": again}


def _faulty(poly: PolygonMesh, of: Joined, last: dict[str, Any] | None, groups: int) -> dict[int, list[int]]:
    """By group, the regions whose polygons are at fault, or beside one of the last part that is, if it is not large.

    At fault are polygons that cross themselves or are turned over, that meet another one, or that share an edge with
    more than one other, since another part has a chord with the same ends.
    """
    polygons = len(of.part)
    bad = np.zeros(polygons, bool)
    bad[[each["polygon"] for each in poly.report["imperfect"]]] = True
    if last is not None:
        flaws = [each["polygon"] for each in last["imperfect"] if each["flaw"] in _MENDED]
        bad |= (of.part == groups) & np.isin(of.polygon, flaws)
    size = np.diff(np.append(poly.loop_start, len(poly.loops)))
    owner, start = np.repeat(np.arange(polygons), size), np.repeat(poly.loop_start, size)
    place = np.arange(len(poly.loops))
    to = poly.loops[np.where(place + 1 == start + np.repeat(size, size), start, place + 1)]
    low, high = np.minimum(poly.loops, to).astype(np.int64), np.maximum(poly.loops, to)
    _, edge, often = np.unique(low * len(poly.vertices) + high, return_inverse=True, return_counts=True)
    bad[owner[often[edge] > 2]] = True
    near = np.zeros(len(poly.vertices), bool)
    small = size <= _LARGE  # beside the ground of a city are most polygons of all groups
    near[poly.loops[(bad & small)[owner] & (of.part[owner] == groups)]] = True
    bad[owner[near[poly.loops]]] = True
    chosen = np.flatnonzero(bad & (of.part < groups))
    found: dict[int, set[int]] = {}
    for k, region in zip(of.part[chosen].tolist(), poly.polygon_region[chosen].tolist(), strict=True):
        found.setdefault(k, set()).add(region)
    return {k: sorted(found[k]) for k in sorted(found)}


def _together(folders: list[Path], task: Task) -> tuple[PolygonMesh, Joined, dict[str, Any] | None]:
    """The polygons of all parts, settled where they meet; where each is from, and the report of the last part."""
    keys, flag, place = (np.concatenate([load(f, f"fixed_{n}") for f in folders]) for n in ("key", "flag", "place"))
    keys, one = np.unique(keys, return_index=True)
    flag, place = flag[one], place[one]
    parts = [Part(*(load(folder / "polygons", name) for name in Part._fields)) for folder in folders]
    added = [Added(*(load(folder, f"added_{name}") for name in Added._fields)) for folder in folders]
    last = None
    if any(len(load(folder / "rest", "label", mapped=True)) for folder in folders):
        surface = thinned([folder / "rest" for folder in folders], task["threads"])
        home = surface.mesh.vertices
        own = place_keys(home)
        at, known = found_in(keys, own)
        fixed, vertices = np.zeros(len(own), np.uint8), home.copy()
        fixed[known], vertices[known] = flag[at[known]], place[at[known]]
        moved = Mesh(vertices, surface.mesh.triangles, threads=1)
        found = _polygons(surface, own, fixed, moved, task)
        parts.append(_parted(found, home[found.source], np.ones(len(found.polygons), bool)))
        last = found.report | {"faces": len(surface.label)}
    all_parts = joined(parts, added, keys, place)
    whole = task["whole"]
    poly = steps.settle_seams(
        all_parts.vertices,
        all_parts.loops,
        all_parts.starts,
        all_parts.region,
        all_parts.part,
        home=all_parts.home,
        vector_area=all_parts.vector_area,
        moments=all_parts.moments,
        diagonal=whole["diagonal"],
        region_count=whole["regions"],
        options=MeshingOptions(**task["meshing"]),
    )
    return poly, all_parts, last


def _report(task: Task, poly: PolygonMesh, groups: list[dict[str, Any]], last: dict[str, Any] | None) -> dict[str, Any]:
    together = poly.report
    report = {key: value for key, value in together.items() if key not in ("imperfect", "work")}
    report["regions"] = len(np.unique(poly.polygon_region))
    found = [each["flaws"] for each in groups]
    if last is not None:
        found.append(_flaws(last, np.ones(last["polygons"], bool)))
    for name in (*_COUNTS, *_SPLITS):
        report[name] = (last or {}).get(name, 0) + sum(each["counts"][name] for each in groups)
    sums = {name: sum(each[name] for each in found) for name in _FLAWS}
    report["excused"] = sums["excused"]
    for name in ("flipped", "bent"):
        report[name] += sums[name]
    report["crossing"] = max(report["crossing"], sums["crossing"] + sums["no_area"])
    report["intersecting"] += sums["intersecting"]
    report["repair_rounds"] = max([(last or {}).get("repair_rounds", 0), *(each["rounds"] for each in groups)])
    return {
        "thinned_faces": sum(each["faces"] for each in groups),
        "rest_faces": (last or {}).get("faces", 0),
        "pieces": report["regions"],
        "diagonal": task["whole"]["diagonal"],
        "seam_intersections": together["intersecting"],
        "output": report,
    }
