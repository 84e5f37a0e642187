"""From thinned tiles to polygons: all at once, or by groups of tiles and then what lies between them.

By groups: regions inside a group become polygons together with what its tiles have of the regions that reach, or touch,
another group. Of the latter only the planes count; their polygons are dropped. At last these regions become polygons in
one piece. On the chains between the two, corners and places are those that the groups chose, so both sides agree; a
corner that the last part adds lies on the chord, and goes into the polygon on the other side too.
"""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import CleanOptions, Mesh, MeshingOptions, PolygonMesh, clean, partition_from, write
from . import steps
from .borders import place_keys
from .store import load, of_tile, save, save_values, values_of

_FREE, _PLACE, _CORNER = 0, 1, 2  # as Fixed in meshing/part.h
_MENDED = ("crossing", "no_area", "flipped", "intersecting")
_ROUNDS = 5  # of making polygons again that meet those of another part
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

    sizes = [len(np.load(part / "vertices.npy", mmap_mode="r")) for part in parts]
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
    poly = steps.polygonize_thinned(mesh, part, MeshingOptions(**task["meshing"]), moments)
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


class Made(NamedTuple):
    """Polygons of a part, and of what they were made."""

    vertices: NDArray[np.float64]  #: (W, 3)
    keys: NDArray[np.uint64]  #: (W,) names of the places of the scan's vertices that they stand for
    polygons: list[NDArray[np.int32]]  #: vertices of each
    region: NDArray[np.int32]  #: (Q,)
    face_polygon: NDArray[np.int32]  #: (F,)
    source: NDArray[np.int32]  #: (W,) vertices of the mesh
    report: dict[str, Any]


def _polygons(surface: Surface, keys: NDArray[np.uint64], fixed: NDArray[np.uint8], task: Task) -> Made:
    part = partition_from(surface.mesh, surface.label)
    options = _options(task, surface, len(np.unique(surface.label)))
    poly, face_polygon = steps.polygonize_part(surface.mesh, part, options, surface.moments, fixed)
    named = np.full(part.region_count, -1, np.int32)
    named[part.face_region] = surface.label
    loops = np.split(poly.loops, poly.loop_start[1:])
    source = poly.source_vertex
    return Made(poly.vertices, keys[source], loops, named[poly.polygon_region], face_polygon, source, poly.report)


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
    found = _polygons(seen, keys, np.zeros(len(keys), np.uint8), task)
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
    _save_polygons(made, found, kept)
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
    save_values(folder, {name: found.report[name] for name in (*_COUNTS, *_SPLITS, "imperfect", "repair_rounds")})


def _load_group(folder: Path) -> _Group:
    loops = np.split(load(folder, "loops"), np.cumsum(load(folder, "sizes"))[:-1])
    region, face_polygon, source = (load(folder, name) for name in ("region", "face_polygon", "source"))
    report = values_of(folder)
    found = Made(load(folder, "places"), load(folder, "keys"), loops, region, face_polygon, source, report)
    vertices, triangles, label, moments = (load(folder, n) for n in ("vertices", "triangles", "label", "moments"))
    return _Group(vertices, triangles, label, moments, found, load(folder, "across"))


def _save_polygons(made: Path, found: Made, kept: NDArray[np.bool_]) -> None:
    chosen = [found.polygons[q] for q in np.flatnonzero(kept)]
    sizes = np.array([len(loop) for loop in chosen], np.int32)
    loops = np.concatenate([np.zeros(0, np.int32), *chosen])
    save(made, vertices=found.vertices, keys=found.keys, loops=loops, sizes=sizes, region=found.region[kept])


def _chains(group: _Group, kept: NDArray[np.bool_], stays: NDArray[np.bool_]) -> dict[str, NDArray[Any]]:
    """The chains between polygons that are kept and faces that stay: what is fixed of their vertices.

    fixed_key, fixed_flag, fixed_place: of each vertex. added_key, added_polygon, added_after: vertices inside chords,
    in order along each, and behind which corner of which kept polygon they would stand.
    """
    found, triangles, across, vertices = group.found, group.triangles, group.across, group.vertices
    left = ~stays & (found.face_polygon >= 0)
    seam = left[:, None] & (across >= 0) & stays[across]
    face, corner = np.nonzero(seam)
    piece = found.face_polygon[face]
    leads = {
        (p, a): b
        for p, a, b in zip(
            piece.tolist(),
            triangles[face, corner].tolist(),
            triangles[face, (corner + 1) % 3].tolist(),
            strict=True,
        )
    }
    pieces = np.unique(found.face_polygon[left])
    keys = place_keys(vertices)
    fixed: dict[int, tuple[int, NDArray[np.float64]]] = {}
    added: list[tuple[int, int, int]] = []
    number = np.cumsum(kept) - 1
    chosen = np.flatnonzero(kept).tolist()
    starts = np.append(np.zeros(0 if len(pieces) else 1, np.int32), pieces)
    of_piece = starts[np.maximum(np.searchsorted(starts, np.arange(len(kept)), "right") - 1, 0)].tolist()
    corners: dict[int, set[int]] = {}
    for q, loop in enumerate(found.polygons if chosen else []):
        corners.setdefault(of_piece[q], set()).update(found.source[loop].tolist())
    for q in chosen:
        own = of_piece[q]
        loop = found.polygons[q]
        ends = found.source[loop].tolist()
        for at, (a, b) in enumerate(zip(ends, ends[1:] + ends[:1], strict=True)):
            chain = [a]
            while (own, chain[-1]) in leads and (len(chain) == 1 or chain[-1] not in corners[own]):
                chain.append(leads[own, chain[-1]])
            if len(chain) == 1 or chain[-1] != b:  # no chain, or a diagonal beside one
                continue
            first, last = found.vertices[loop[at]], found.vertices[loop[(at + 1) % len(loop)]]
            fixed[a], fixed[b] = (_CORNER, first), (_CORNER, last)
            length = np.cumsum(np.linalg.norm(np.diff(vertices[chain], axis=0), axis=1))
            for v, share in zip(chain[1:-1], (length[:-1] / length[-1]).tolist(), strict=True):
                fixed[v] = (_PLACE, first + share * (last - first))
                added.append((v, int(number[q]), at))
    order = sorted(fixed)
    rows = np.array(added, np.int64).reshape(-1, 3)
    return {
        "fixed_key": keys[order],
        "fixed_flag": np.array([fixed[v][0] for v in order], np.uint8),
        "fixed_place": np.array([fixed[v][1] for v in order]).reshape(-1, 3),
        "added_key": keys[rows[:, 0]],
        "added_polygon": rows[:, 1],
        "added_after": rows[:, 2],
    }


def mesh_rest(task: Task, work: Path, made: Path) -> dict[str, Any]:
    """The polygons of the regions between groups, and all polygons together.

    Where polygons of the two meet, those of groups are dropped, and their regions made again with the others.
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


def _faulty(poly: PolygonMesh, of: _Origin, last: dict[str, Any] | None, groups: int) -> dict[int, list[int]]:
    """By group, the regions whose polygons are at fault, or beside one of the last part that is.

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
    near[poly.loops[bad[owner] & (of.part[owner] == groups)]] = True
    bad[owner[near[poly.loops]]] = True
    chosen = np.flatnonzero(bad & (of.part < groups))
    found: dict[int, set[int]] = {}
    for k, region in zip(of.part[chosen].tolist(), poly.polygon_region[chosen].tolist(), strict=True):
        found.setdefault(k, set()).add(region)
    return {k: sorted(found[k]) for k in sorted(found)}


def _together(folders: list[Path], task: Task) -> tuple[PolygonMesh, _Origin, dict[str, Any] | None]:
    """The polygons of all parts, where each is from, and the report of the last one."""
    keys, flag, place = (np.concatenate([load(f, f"fixed_{n}") for f in folders]) for n in ("key", "flag", "place"))
    order = np.argsort(keys, kind="stable")
    keys, flag, place = keys[order], flag[order], place[order]
    parts = [_read(folder, k) for k, folder in enumerate(folders)]
    last = None
    if any(len(np.load(folder / "rest" / "label.npy", mmap_mode="r")) for folder in folders):
        surface = thinned([folder / "rest" for folder in folders], task["threads"])
        own = place_keys(surface.mesh.vertices)
        at = np.minimum(np.searchsorted(keys, own), max(0, len(keys) - 1))
        known = keys[at] == own if len(keys) else np.zeros(len(own), bool)
        fixed, vertices = np.zeros(len(own), np.uint8), surface.mesh.vertices.copy()
        fixed[known], vertices[known] = flag[at[known]], place[at[known]]
        moved = Surface(Mesh(vertices, surface.mesh.triangles, threads=1), surface.label, surface.moments)
        found = _polygons(moved, own, fixed, task)
        parts.append(_Part(found.vertices, found.keys, found.polygons, found.region, {}, len(folders)))
        last = found.report | {"faces": len(moved.label)}
    return *_joined(parts, keys, place), last


class _Origin(NamedTuple):
    """Where polygons are from."""

    part: NDArray[np.int32]  #: (Q,) the group; the number of groups for the last part
    polygon: NDArray[np.int32]  #: (Q,) which of its polygons


class _Part(NamedTuple):
    vertices: NDArray[np.float64]
    keys: NDArray[np.uint64]
    polygons: list[NDArray[np.int32]]
    region: NDArray[np.int32]
    added: dict[tuple[int, int], list[int]]  # by polygon and corner: names of places that may come after it
    number: int


def _read(folder: Path, number: int) -> _Part:
    sizes = load(folder, "sizes")
    loops = np.split(load(folder, "loops"), np.cumsum(sizes)[:-1]) if len(sizes) else []
    added: dict[tuple[int, int], list[int]] = {}
    names = ("added_key", "added_polygon", "added_after")
    for key, q, at in zip(*(load(folder, name).tolist() for name in names), strict=True):
        added.setdefault((q, at), []).append(key)
    return _Part(load(folder, "vertices"), load(folder, "keys"), loops, load(folder, "region"), added, number)


def _joined(parts: list[_Part], fixed: NDArray[np.uint64], place: NDArray[np.float64]) -> Any:
    """The polygons of all parts as one mesh, and the part of each. Parts share the vertices of common chains."""
    on_chain = {key: n for n, key in enumerate(fixed.tolist())}
    last = parts[-1] if parts[-1].added == {} else None
    corners = set() if last is None else {k for k in last.keys.tolist() if k in on_chain}
    vertices: list[NDArray[np.float64]] = []
    shared: dict[int, int] = {}
    loops: list[list[int]] = []
    region: list[int] = []
    of: list[int] = []
    places: list[int] = []

    def name(key: int) -> int:
        if key not in shared:
            shared[key] = len(vertices)
            vertices.append(place[on_chain[key]])
        return shared[key]

    for part in parts:
        keys = part.keys.tolist()
        number: dict[int, int] = {}
        for q, loop in enumerate(part.polygons):
            row: list[int] = []
            for at, v in enumerate(loop.tolist()):
                if keys[v] in on_chain:
                    row.append(name(keys[v]))
                else:
                    if v not in number:
                        number[v] = len(vertices)
                        vertices.append(part.vertices[v])
                    row.append(number[v])
                row += [name(key) for key in part.added.get((q, at), ()) if key in corners]
            loops.append(row)
            region.append(int(part.region[q]))
            of.append(part.number)
            places.append(q)
    order = np.argsort(np.array(region), kind="stable")
    starts = np.cumsum([0] + [len(loops[q]) for q in order.tolist()])[:-1]
    flat = np.array([v for q in order.tolist() for v in loops[q]], np.int32)
    origin = _Origin(*(np.array(each, np.int32)[order] for each in (of, places)))
    regions = np.array(region, np.int32)[order]
    return steps.judge_together(np.array(vertices).reshape(-1, 3), flat, starts, regions, origin.part), origin


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
    report |= {name: sums[name] for name in ("flipped", "bent", "excused")}
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
