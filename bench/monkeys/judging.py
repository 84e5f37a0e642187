"""Judges the results of a case of the monkey from the arrays alone, by numpy.

Each function yields texts about the conditions that do not hold.
"""

from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np

import isimp_engine as engine
from bench.monkeys.draws import Edit, neighbours
from tests.shared import polygon_judge
from tests.shared.polygon_judge import THIN, Scan, groups, polygons_of, topology

NEAR = 1e-9  # share of the diagonal: rounding
#: largest move of a corner by `planar`, in `planar_reach`: at planes that were given and kept, and at others
OF_GIVEN, OF_ANY = 6.0, 1.5
LONGEST = 200  # corners of polygons that are searched for crossings
NOT_FINITE = "is not finite"

Findings = Iterator[str]
May = Callable[[np.ndarray, np.ndarray], np.ndarray]  #: whether faces may go from regions to others


class Surface:
    """A mesh in the units of the caller."""

    def __init__(self, mesh: engine.Mesh) -> None:
        self.mesh = mesh
        self.vertices, self.triangles = np.asarray(mesh.vertices), np.asarray(mesh.triangles)
        self.pairs = neighbours(mesh)
        near = self.vertices - np.asarray(mesh.origin)
        self.corners = near[self.triangles]
        first, second, third = self.corners.transpose(1, 0, 2)
        self.vector = np.cross(second - first, third - first) / 2
        self.area = np.linalg.norm(self.vector, axis=1)
        used = near[np.unique(self.triangles)]
        self.diagonal = float(np.linalg.norm(np.ptp(used, axis=0)))
        self.rounding = NEAR * self.diagonal + 4e-16 * float(np.abs(self.vertices).max())


def numbers_in(value: Any, name: str = "") -> Iterator[tuple[str, float]]:
    """The floating-point numbers of a report, with their names."""
    if isinstance(value, dict):
        for key, each in value.items():
            yield from numbers_in(each, f"{name}.{key}" if name else str(key))
    elif isinstance(value, (list, tuple)):
        for each in value:
            yield from numbers_in(each, name)
    elif isinstance(value, float):
        yield name, value


def mesh_findings(surface: Surface) -> Findings:
    mesh, report = surface.mesh, surface.mesh.report
    yield from (f"mesh: {name} {NOT_FINITE}" for name, value in numbers_in(report) if not np.isfinite(value))
    count, component = groups(len(surface.triangles), surface.pairs)
    if count != report["components"] or len(np.unique(mesh.component)) != count:
        yield f"mesh: {report['components']} components, in truth {count}"
    if len(np.unique(np.stack([component, mesh.component], 1), axis=0)) != count:
        yield "mesh: `component` is another split"
    border = 3 * len(surface.triangles) - 2 * len(surface.pairs)
    if border != report["border_edges"] or (border == 0) != report["closed"]:
        yield f"mesh: {report['border_edges']} border edges, closed {report['closed']}; in truth {border}"
    for name, truth, near in (
        ("area", float(surface.area.sum()), NEAR * surface.diagonal**2),
        ("diagonal", surface.diagonal, 0.0),
    ):
        if abs(report[name] - truth) > 1e-6 * truth + near:
            yield f"mesh: {name} {report[name]:.9g}, in truth {truth:.9g}"


def partition_findings(surface: Surface, part: engine.Partition) -> Findings:
    """Conditions of any partition."""
    label, count = np.asarray(part.face_region), part.region_count
    seed, normal = np.asarray(part.region_seed), np.asarray(part.region_normal)
    if label.shape != (len(surface.triangles),) or label.min() < -1 or label.max() >= count:
        yield f"labels {label.shape} from {label.min()} to {label.max()} of {count} regions"
        return
    sizes = np.bincount(label[label >= 0], minlength=count)
    if (sizes == 0).any():
        yield f"region {np.flatnonzero(sizes == 0)[0]} has no face"
    same = label[surface.pairs[:, 0]] == label[surface.pairs[:, 1]]
    _, of = groups(len(label), surface.pairs[same])
    loose = np.bincount(label[np.unique(of, return_index=True)[1]] + 1, minlength=count + 1)[1:] > 1
    if loose.any():
        yield f"{loose.sum()} regions are not connected, such as region {np.flatnonzero(loose)[0]}"
    if seed.shape != (count,) or (label[seed] != np.arange(count)).any():
        yield "a seed is not in its region"
    length = np.linalg.norm(normal, axis=1)
    if normal.shape != (count, 3) or not (((np.abs(length - 1) < 1e-6) | (length == 0)).all()):
        yield "a region's normal is neither unit nor zero"
    offset, report = np.asarray(part.region_offset), part.report
    if len(offset) not in (0, count) or not np.isfinite(offset).all():
        yield f"region_offset {NOT_FINITE} or has another length"
    yield from (f"partition: {name} {NOT_FINITE}" for name, value in numbers_in(report) if not np.isfinite(value))
    for name, truth in (("regions", count), ("error", part.error), ("distance_max", part.distance_max)):
        if report[name] != truth:
            yield f"partition report: {name} {report[name]}, in truth {truth}"
    yield from round_findings(part, label)
    yield from distance_findings(surface, part, label)
    told = engine.regions.all_statistics(surface.mesh, part)
    if [each["faces"] for each in told] != sizes.tolist():
        yield "all_statistics: another number of faces"
    area = np.bincount(label[label >= 0], surface.area[label >= 0], count)
    if not np.allclose([each["area"] for each in told], area, rtol=1e-6, atol=1e-9 * surface.area.sum()):
        yield "all_statistics: another area"


def round_findings(part: engine.Partition, label: np.ndarray) -> Findings:
    cells = [region for patch in part.curved for region in patch["regions"]]
    if len(set(cells)) < len(cells) or any(not 0 <= region < part.region_count for region in cells):
        yield "round parts share a cell, or have one that is no region"
        return
    for patch in part.curved:
        if patch["faces"] != (truth := int(np.isin(label, patch["regions"]).sum())):
            yield f"round part {patch['number']}: {patch['faces']} faces, in truth {truth}"


def distances_from_planes(surface: Surface, part: engine.Partition) -> np.ndarray:
    """(F,) the largest distance of a corner of each face from its region's plane; 0 where it has none."""
    label, normal, offset = (np.asarray(each) for each in (part.face_region, part.region_normal, part.region_offset))
    corners = surface.vertices[surface.triangles]
    away = np.abs((corners * normal[label][:, None]).sum(axis=2) - offset[label][:, None]).max(axis=1)
    return np.where((label >= 0) & (np.linalg.norm(normal[label], axis=1) > 0), away, 0.0)


def distance_findings(surface: Surface, part: engine.Partition, label: np.ndarray) -> Findings:
    if part.distance_max is None:
        return
    if not len(part.region_offset):
        if part.distance_max > 0:
            yield "distance_max without planes"
        return
    truth = float(distances_from_planes(surface, part).max())
    if truth > part.distance_max + surface.rounding:
        yield f"distance_max {part.distance_max:.6g}, in truth {truth:.6g}"
    if part.bound is not None and part.distance_max > part.bound * (1 + 1e-9) + surface.rounding:
        yield f"distance_max {part.distance_max:.6g} is above the bound {part.bound:.6g}"


def first_findings(
    surface: Surface, part: engine.Partition, options: engine.PartitionOptions, guided: bool
) -> Findings:
    """Conditions of a partition that no edit has changed."""
    label = np.asarray(part.face_region)
    component = np.asarray(surface.mesh.component)
    kept = np.unique(component[label >= 0])
    away = np.setdiff1d(component, kept)
    if np.isin(component[label < 0], kept).any():
        yield "a part is left out in part"
    if len(away) != part.parts_left_out:
        yield f"{part.parts_left_out} parts left out, in truth {len(away)}"
    share = surface.area[label < 0].sum() / max(surface.area.sum(), 1e-300)
    has_area = surface.area.sum() > 1e-12 * surface.diagonal**2  # a smaller one is rounding
    if has_area and abs(share - part.area_left_out) > 1e-6:
        yield f"area_left_out {part.area_left_out:.6g}, in truth {share:.6g}"
    most = max(options.proxies or part.region_count, part.proxies_needed)
    if options.curved:  # about as many
        most += 2 + most // 10
    if part.region_count > most and not guided:
        yield f"{part.region_count} regions, {options.proxies} were asked for and {part.proxies_needed} are needed"
    plain = not guided and not part.curved and not len(part.region_offset)
    if plain and (np.asarray(surface.mesh.source_face) >= 0).all():
        yield from mean_findings(surface, part, label)


def mean_findings(surface: Surface, part: engine.Partition, label: np.ndarray) -> Findings:
    """Normals and error, where all faces have the weight of their area."""
    kept, count = label >= 0, part.region_count
    total = np.stack([np.bincount(label[kept], surface.vector[kept, k], count) for k in range(3)], 1)
    own = np.asarray(part.region_normal)
    area = np.bincount(label[kept], surface.area[kept], count)
    length = np.linalg.norm(total, axis=1)
    off = np.linalg.norm(own * length[:, None] - total, axis=1)
    least = NEAR * max(area.max(initial=0), surface.diagonal**2)
    wrong = np.flatnonzero((off > 1e-6 * area) & (length > 1e-6 * area) & (area > least))
    if len(wrong):
        yield f"the normal of region {wrong[0]} is {off[wrong[0]] / length[wrong[0]]:.3g} off the mean"
    error = 2 * (area.sum() - (total * own).sum())
    if abs(error - part.error) > 1e-6 * part.error + NEAR * (area.sum() + surface.diagonal**2):
        yield f"error {part.error:.9g}, in truth {error:.9g}"


# Edits


def forbidden(before: np.ndarray, after: np.ndarray, region: int, may: May) -> str:
    """A change of labels that may not be; empty: none. region: its number was removed; -1: none was."""
    after = np.where((region >= 0) & (after >= region), after + 1, after)
    wrong = np.flatnonzero((before != after) & ~may(before, after))
    return f"face {wrong[0]} went from region {before[wrong[0]]} to {after[wrong[0]]}" if len(wrong) else ""


def edit_findings(edit: Edit, before: engine.Partition, after: engine.Partition) -> Findings:
    """Conditions of this kind of edit, and of locked regions, which stay."""
    old, new = np.asarray(before.face_region), np.asarray(after.face_region)
    face = edit.arguments.get("face", -1)
    at = SimpleNamespace(
        edit=edit, old=old, new=new, face=face, region=int(old[face]), fresh=before.region_count,
        added=after.region_count - before.region_count, before=before, after=after,
    )  # fmt: skip
    for about, is_wrong in PROMISES.get(edit.name, []):
        if found := is_wrong(at):
            yield f"{about}{'' if found is True else f': {found}'}"
    if edit.name in CHANGE_LOCKED:
        return
    for region in np.flatnonzero(before.region_locked):
        own = new[old == region]
        if len(np.unique(own)) != 1 or (new == own[0]).sum() != len(own) or not after.region_locked[own[0]]:
            yield f"locked region {region} has changed"
            return


def added(number: int) -> tuple[str, Callable[[Any], Any]]:
    return f"regions: not {number:+d}", lambda at: at.added != number and f"{at.added:+d}"


def added_times(sign: int) -> tuple[str, Callable[[Any], Any]]:
    return "regions: another number", lambda at: at.added != sign * at.edit.arguments["times"] and f"{at.added:+d}"


def only(may: Callable[[Any, np.ndarray, np.ndarray], np.ndarray], removed: Any = None) -> tuple[str, Any]:
    """Only these changes of labels. removed: the region whose number was removed."""
    region = removed or (lambda at: -1)
    return "changes more", lambda at: forbidden(at.old, at.new, region(at), lambda old, new: may(at, old, new))


def _of_other(at: Any) -> int:
    return int(at.old[at.edit.arguments["other"]])


def _region_of_first(at: Any) -> int:
    return int(at.old[at.edit.arguments["faces"][0]])


def _lost_paint(at: Any) -> Any:
    """Painted faces of regions that are not locked are in one region, if they are to be a new one."""
    faces, locked = at.edit.arguments["faces"], at.before.region_locked
    if at.edit.arguments["onto"] is not None:
        return False
    free = np.array([face for face in faces if at.old[face] < 0 or not locked[at.old[face]]], int)
    return len(np.unique(at.new[free])) > 1 and f"faces {free.tolist()} are in {np.unique(at.new[free]).tolist()}"


_SPLIT = [
    added(1),
    ("the face left its region", lambda at: at.new[at.face] != at.region),
    only(lambda at, old, new: (old == at.region) & (new == at.fresh)),
]
_SAME_LABELS = [("labels changed", lambda at: not np.array_equal(at.old, at.new))]
#: conditions of each edit: texts, and functions that return the fault, or nothing
PROMISES: dict[str, list[tuple[str, Callable[[Any], Any]]]] = {
    "add_proxy": [
        added(1),
        ("the face is not in the new region", lambda at: at.new[at.face] != at.fresh),
    ],
    "delete_proxy": [added(-1)],
    "split_region": _SPLIT,
    "split_along": _SPLIT,
    "merge_regions": [
        added(-1),
        only(lambda at, old, new: (old == _of_other(at)) & (new == at.region), _of_other),
    ],
    "paint_faces": [("painted faces are apart", _lost_paint)],
    "erase_faces": [
        only(
            lambda at, old, new: old == _region_of_first(at),
            lambda at: _region_of_first(at) if at.added < 0 else -1,
        )
    ],
    "grow_region": [added(0), only(lambda at, old, new: old != at.region)],
    "shrink_region": [added(0), only(lambda at, old, new: old == at.region)],
    "add_worst": [added_times(1)],
    "delete_least": [added_times(-1)],
    "merge_cheapest": [added_times(-1)],
    "improve": [
        added(0),
        ("the error is larger", lambda at: at.after.error > at.before.error * (1 + 1e-9) + 1e-12),
    ],
    "even_borders": [added(0)],
    "lock_regions": _SAME_LABELS,
    "unlock_regions": _SAME_LABELS,
    "leave_out_regions": _SAME_LABELS,
    "align_planes": _SAME_LABELS,
    "release_round": _SAME_LABELS,
}
CHANGE_LOCKED = {"unlock_regions", "paint_faces"}  # painted faces become part of a locked region


# Polygons


def polygon_findings(
    surface: Surface, part: engine.Partition, poly: engine.PolygonMesh, options: engine.MeshingOptions
) -> Findings:
    vertices, loops, start = (np.asarray(each) for each in (poly.vertices, poly.loops, poly.loop_start))
    planarity, report = np.asarray(poly.planarity), poly.report
    yield from (f"polygons: {name} {NOT_FINITE}" for name, value in numbers_in(report) if not np.isfinite(value))
    if not np.isfinite(vertices).all() or not np.isfinite(planarity).all():
        yield f"polygons: a corner or a planarity {NOT_FINITE}"
        return
    if not len(start):
        return
    fewest = np.diff(np.append(start, len(loops))).min()
    if fewest < 3 or not np.array_equal(np.unique(loops), np.arange(len(vertices))):
        yield f"polygons: a vertex is unused, or a polygon has only {fewest} corners"
        return
    each = polygons_of(poly)
    yield from count_findings(surface, part, poly, each)
    yield from reach_findings(surface, part, poly, options)
    yield from lost_findings(surface, part, poly)
    if not report["boxes"]:
        yield from outline_findings(surface, part, poly)


def count_findings(
    surface: Surface, part: engine.Partition, poly: engine.PolygonMesh, each: list[np.ndarray]
) -> Findings:
    """The numbers of the report."""
    report, vertices, region = poly.report, np.asarray(poly.vertices), np.asarray(poly.polygon_region)
    defects, found = topology(each)
    edges = sum(map(len, each))
    ends = np.concatenate([np.stack([loop, np.roll(loop, -1)], 1) for loop in each])
    inner = edges - len(np.unique(np.sort(ends, axis=1), axis=0))
    near = vertices - np.asarray(surface.mesh.origin)
    flat = [polygon_judge.flat(near[loop]) for loop in each]
    planarity = np.asarray(poly.planarity)
    size = np.array([np.linalg.norm(area) for _, area, _ in flat])
    own = np.arange(len(each)) < len(each) - 6 * report["boxes"]  # regions and mean are those without boxes
    truth = {
        "polygons": len(each),
        "corners": edges,
        "vertices": len(vertices),
        "regions": len(np.unique(region[own])),
        "closed": 2 * inner == edges,
        "manifold": not defects,
        "euler": found["euler"],
        "planes_let_go": len(poly.planes_let_go),
    }
    for name, value in truth.items():
        if report[name] != value:
            yield f"polygons: {name} {report[name]}, in truth {value}"
    yield from (f"polygons: {defect}" for defect in defects)
    bend = np.array([off for _, _, off in flat])
    sure = size > 1e-9 * surface.diagonal**2
    wrong = np.flatnonzero(sure & (np.abs(bend - planarity) > 1e-6 * surface.diagonal))
    if len(wrong):
        yield f"polygons: planarity of polygon {wrong[0]} {planarity[wrong[0]]:.6g}, in truth {bend[wrong[0]]:.6g}"
    mean = (planarity * size)[own].sum() / max(size[own].sum(), 1e-300)
    for name, value in (("planarity_max", planarity.max()), ("planarity_mean", mean)):
        if abs(report[name] - value) > 1e-6 * surface.diagonal:
            yield f"polygons: {name} {report[name]:.6g}, in truth {value:.6g}"
    # Left-out regions do not count in the length. Polygons without area have no plane. Polygons that are rounded to
    # float32 must be planar too.
    kept = surface.corners[np.asarray(part.face_region) >= 0].reshape(-1, 3)
    limit, rounding = 1e-6 * np.linalg.norm(np.ptp(kept, axis=0)), 2.0**-21 * np.abs(kept).max()
    if report["planar"]:
        most = planarity[sure].max(initial=0)
        is_wrong = most > 1.001 * limit
    else:
        most = planarity.max()
        is_wrong = most < limit - rounding
    if is_wrong:
        yield f"polygons: planar is {report['planar']}, planarity up to {most:.3g} for {limit:.3g}"


def reach_findings(
    surface: Surface, part: engine.Partition, poly: engine.PolygonMesh, options: engine.MeshingOptions
) -> Findings:
    """Distances of corners from their vertices of the scan. Corners of boxes have none."""
    source, report = np.asarray(poly.source_vertex), poly.report
    loops, start = np.asarray(poly.loops), np.asarray(poly.loop_start)
    moved = np.linalg.norm(np.asarray(poly.vertices) - surface.vertices[source], axis=1)
    if report["boxes"]:
        moved[loops[start[len(start) - 6 * report["boxes"]] :]] = 0.0
    if abs(moved.max() - report["distance_max"]) > surface.rounding + 1e-6 * moved.max():
        yield f"polygons: distance_max {report['distance_max']:.6g}, in truth {moved.max():.6g}"
    limit = np.full(len(source), options.reach * surface.diagonal)
    if options.planar and not report["left_off"]:
        at_given = _corners_of(poly, np.isin(poly.polygon_region, _regions_that_keep(surface, part, poly)))
        limit += np.where(at_given, OF_GIVEN, OF_ANY) * options.planar_reach * surface.diagonal
    limit += report["rims"]["reach"]
    if part.curved:  # corners among cells are where planes meet, by up to half an edge before the move
        limit += _shortest_edges(poly)
    far = np.flatnonzero(moved > limit * (1 + 1e-6) + surface.rounding)
    if len(far):
        share = moved[far[0]] / surface.diagonal
        yield f"polygons: {len(far)} corners out of reach, corner {far[0]} by {share:.6g} of the diagonal"


def _regions_that_keep(surface: Surface, part: engine.Partition, poly: engine.PolygonMesh) -> np.ndarray:
    """The regions with given planes that were not let go, or by some of their polygons only."""
    held, region = engine.planes.is_held(np.asarray(part.region_held)), np.asarray(poly.polygon_region)
    if not held.any():
        return np.flatnonzero(held)
    released = np.zeros(len(held), bool)
    released[poly.planes_let_go] = True
    keeps = held & ~released
    for polygon in np.flatnonzero(released[region]):
        own, corners = region[polygon], np.asarray(poly.vertices)[polygons_of(poly)[polygon]]
        away = np.abs(corners @ part.region_normal[own] - part.region_offset[own]).max()
        keeps[own] |= away <= 1e-6 * surface.diagonal + surface.rounding
    return np.flatnonzero(keeps)


def _corners_of(poly: engine.PolygonMesh, some: np.ndarray) -> np.ndarray:
    """(W,) whether a vertex is a corner of one of some polygons."""
    sizes = np.diff(np.append(poly.loop_start, len(poly.loops)))
    found = np.zeros(len(poly.vertices), bool)
    found[np.asarray(poly.loops)[np.repeat(some, sizes)]] = True
    return found


def _shortest_edges(poly: engine.PolygonMesh) -> np.ndarray:
    """(W,) the length of the shortest edge at each vertex."""
    vertices, shortest = np.asarray(poly.vertices), np.full(len(poly.vertices), np.inf)
    for loop in polygons_of(poly):
        length = np.linalg.norm(vertices[loop] - vertices[np.roll(loop, -1)], axis=1)
        np.minimum.at(shortest, loop, np.minimum(length, np.roll(length, 1)))
    return shortest


def lost_findings(surface: Surface, part: engine.Partition, poly: engine.PolygonMesh) -> Findings:
    """Each region with an area has a polygon, unless it is left out."""
    label = np.asarray(part.face_region)
    wanted = np.setdiff1d(np.flatnonzero(~np.asarray(part.region_left_out)), np.asarray(poly.polygon_region))
    for region in wanted:
        own = label == region
        corners = surface.vertices[surface.triangles[own]].reshape(-1, 3)
        extent = np.linalg.norm(corners - corners.mean(axis=0), axis=1).max()
        if (area := surface.area[own].sum()) > 4 * THIN * surface.diagonal * extent:
            yield f"polygons: region {region} with {area / surface.area.sum():.3g} of the area has none"
    extra = np.setdiff1d(np.asarray(poly.polygon_region), np.arange(part.region_count))
    if len(extra):
        yield f"polygons: of region {extra[0]}, which there is not"


def outline_findings(surface: Surface, part: engine.Partition, poly: engine.PolygonMesh) -> Findings:
    """The topology is that of the scan, and polygons that cross themselves or have no area are in the report."""
    label, component = np.array(part.face_region), np.asarray(surface.mesh.component)
    label[(label < 0) | np.asarray(part.region_left_out)[label]] = -1
    # The promises are about coordinates rounded to float32, relative to the origin.
    origin, each = np.asarray(surface.mesh.origin), polygons_of(poly)
    scan = Scan(SimpleNamespace(vertices=surface.vertices - origin, triangles=surface.triangles), label)
    if not np.isin(component[label < 0], component[label >= 0]).any():  # else the kept faces have another topology
        found, wanted = topology(each)[1], topology(scan.triangles)[1]
        yield from (f"polygons: {what} {found[what]}, scan {n}" for what, n in wanted.items() if found[what] != n)
    position = (np.asarray(poly.vertices) - origin).astype(np.float32).astype(float)
    listed = {entry["polygon"] for entry in poly.report["imperfect"] if entry["flaw"] != "intersecting"}
    for polygon, loop in enumerate(each):
        if polygon in listed:
            continue
        points = position[loop]
        plane, area, _ = polygon_judge.flat(points)
        extent = np.linalg.norm(points - points.mean(axis=0), axis=1).max()
        if np.linalg.norm(area) <= THIN * scan.diagonal * extent:
            if not scan.has_flat_face(np.asarray(poly.source_vertex)[loop]):
                yield f"polygons: polygon {polygon} has no area, which the report lacks"
        elif len(loop) <= LONGEST and polygon_judge.crosses_itself(plane):
            yield f"polygons: polygon {polygon} crosses itself, which the report lacks"


def scan_distance_findings(surface: Surface, within: Any) -> Findings:
    """The distance of the scan that a bound reports."""
    poly, label = within.polygons, np.asarray(within.partition.face_region)
    facets, _ = engine.regions.triangulate(poly.vertices, poly.loops, poly.loop_start)
    meshed = (label >= 0) & ~np.asarray(within.partition.region_left_out)[label]
    kept = np.unique(surface.triangles[meshed])[:: max(1, len(surface.vertices) // 1000)]
    origin = np.asarray(surface.mesh.origin)
    away = polygon_judge.distances(surface.vertices[kept] - origin, np.asarray(poly.vertices) - origin, facets)
    if away.max() > within.distance + 1e-6 * surface.diagonal:
        yield f"scan_distance {within.distance:.6g}, in truth {away.max():.6g} at least"
