"""Applies each step of a recipe by the engine, except Partition, which session.py applies."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from . import recipe as rcp
from . import smoothing, view
from .engine import engine
from .language import said
from .outcome import EXACT, Outcome
from .prepared import Prepared, face_regions, joined_pairs, pair_lengths, triangle_at, triangles_at, with_split_faces
from .task import Stopped, Watch

ALONG_AN_AXIS = 0.94  #: cosine of the largest angle (20 degrees) between an axis and a normal along it
#: numbers about a bound that would bring the regions of a drawn model nearer to it
NEARER = ("nearer_bound", "nearer_regions", "nearer_times")


def engine_call(watch: Watch, begin: float, end: float, stage: str, function, *args):
    """Calls the engine with a job of its own, which reports progress and can be cancelled."""
    with watch.part(stage, begin, end, engine.Job()) as job:
        try:
            return function(*args, job=job)
        except engine.Cancelled:
            raise Stopped from None


def _needs_regions(before: Outcome | None) -> Outcome:
    if before is None:
        raise ValueError(said("there are no regions yet: a Partition step must come first"))
    return before


def with_regions(prepared: Prepared, partition, kept: np.ndarray | None, numbers: dict) -> Outcome:
    """Return the outcome of a partition. kept: (R,) the previous colour of each region, -1 for a new region."""
    face_region = face_regions(prepared, partition)
    border = view.border_pairs(face_region, prepared.face_pairs)
    pairs = view.region_pairs(face_region, prepared.face_pairs[border])
    color = view.assign_colors(partition.region_count, pairs, kept)
    known = {"regions": partition.region_count, "error": partition.error, "left_out": int((face_region < 0).sum())}
    away = int(np.count_nonzero(partition.region_left_out))
    known["locked"] = int(np.count_nonzero(partition.region_locked)) - away
    known |= {"regions_left_out": away} if away else {}
    known |= planes_known(partition)
    known |= _mirror_numbers(partition.symmetry)
    known |= _round_known(prepared, partition)
    return Outcome(face_region, color, border, partition, numbers=known | numbers, closing=prepared.closing)


def _mirror_numbers(symmetry: dict | None) -> dict:
    """Return the axis across which a partition mirrors and its number of mirrored regions; empty without symmetry."""
    if symmetry is None:
        return {}
    axis = int(np.argmax(np.abs(symmetry["normal"])))
    along = abs(symmetry["normal"][axis]) > ALONG_AN_AXIS
    found = {} if symmetry["regions"] is None else {"mirrored_regions": symmetry["regions"]}
    return {"symmetry": "XYZ"[axis] if along else "oblique"} | found


def _round_known(prepared: Prepared, partition) -> dict:
    """Return kind, radius, segments, rings and one face of the scan of each round part, the largest part first."""
    parts = sorted(partition.curved, key=lambda part: -part.faces)
    if not parts:
        return {}
    faces = [int(prepared.mesh_face[partition.region_seed[part.regions[0]]]) for part in parts]
    told = zip(parts, faces, strict=True)
    return {"round": [[part.kind, part.radius, part.segments, part.rings, face] for part, face in told]}


def _apply_add(step: rcp.AddProxy, prepared, before, watch, begin, end) -> Outcome:
    before, triangle = _needs_regions(before), triangle_at(prepared, step.face)
    args = (prepared.mesh, before.partition, triangle)
    partition = engine_call(watch, begin, end, "adding a region", engine.add_proxy, *args)
    return with_regions(prepared, partition, np.append(before.region_color, -1), {})


def _apply_delete(step: rcp.DeleteProxy, prepared, before, watch, begin, end) -> Outcome:
    before, triangle = _needs_regions(before), triangle_at(prepared, step.face)
    args = (prepared.mesh, before.partition, triangle)
    partition = engine_call(watch, begin, end, "deleting a region", engine.delete_proxy, *args)
    gone = int(before.partition.face_region[triangle])  # regions above it move down by one
    return with_regions(prepared, partition, np.delete(before.region_color, gone), {})


def defects(report: dict) -> dict:
    """Return {kind of defect: polygons}, without pairs that intersect in the scan itself."""
    found = {}
    for entry in report.get("imperfect", ()):
        if entry["flaw"] != "excused":
            found.setdefault(entry["flaw"], set()).add(entry["polygon"])
    return {kind: sorted(polygons) for kind, polygons in found.items()}


def carried_colors(before: Outcome, partition) -> np.ndarray:
    """Return (R,) the previous colour of each region, -1 for a new region. The seeds identify regions."""
    old, color = before.partition, before.region_color
    came, went = old.face_region[partition.region_seed], partition.face_region[old.region_seed]
    kept = np.full(partition.region_count, -1, color.dtype)
    for region in range(len(color) - 1, -1, -1):  # merged regions have the colour of the lowest one
        if went[region] >= 0:
            kept[went[region]] = color[region]
    same = (came >= 0) & (went[came] == np.arange(len(came)))
    kept[same] = color[came[same]]
    return kept


def _apply_edit(step: rcp.Step, prepared, before, watch, begin, end) -> Outcome:
    before = _needs_regions(before)
    stage, function, arguments = _EDITS[type(step)]
    args = (prepared.mesh, before.partition, *arguments(step, prepared))
    partition = engine_call(watch, begin, end, stage, getattr(engine, function), *args)
    return with_regions(prepared, partition, carried_colors(before, partition), {})


def _apply_merge(step: rcp.MergeRegions, prepared, before, watch, begin, end) -> Outcome:
    before, other = _needs_regions(before), triangle_at(prepared, step.other)
    args = (prepared.mesh, before.partition, triangle_at(prepared, step.face), other)
    partition = engine_call(watch, begin, end, "merging", engine.merge_regions, *args)
    gone = int(before.partition.face_region[other])  # regions above it move down by one
    return with_regions(prepared, partition, np.delete(before.region_color, gone), {})


def _apply_paint(step: rcp.PaintFaces, prepared, before, watch, begin, end) -> Outcome:
    before, faces = _needs_regions(before), triangles_at(prepared, step.faces)
    onto = None if step.onto < 0 else triangle_at(prepared, step.onto)
    args = (prepared.mesh, before.partition, faces, onto)
    partition = engine_call(watch, begin, end, "painting", engine.paint_faces, *args)
    if step.lock:
        painted = partition.region_seed[-1] if onto is None else onto
        partition = engine.lock_regions(prepared.mesh, partition, np.array([painted]))
    return with_regions(prepared, partition, carried_colors(before, partition), {})


def _apply_erase(step: rcp.EraseFaces, prepared, before, watch, begin, end) -> Outcome:
    """Erases faces, also from a locked region: the user chose them."""
    before, faces = _needs_regions(before), triangles_at(prepared, step.faces)
    partition, region = before.partition, int(before.partition.face_region[faces[0]])
    locked = region >= 0 and bool(partition.region_locked[region])
    if locked:
        partition = engine.unlock_regions(prepared.mesh, partition, faces[:1])
    partition = engine_call(watch, begin, end, "erasing", engine.erase_faces, prepared.mesh, partition, faces)
    if locked and partition.region_count == before.partition.region_count:  # the region still exists
        partition = engine.lock_regions(prepared.mesh, partition, np.flatnonzero(partition.face_region == region)[:1])
    return with_regions(prepared, partition, carried_colors(before, partition), {})


def _apply_smooth(step: rcp.SmoothFaces, prepared, before, watch, begin, end) -> Outcome:
    """Smooths borders on the faces of the scan, then paints changed faces onto their new regions, one at a time.

    A stroke that begins in a locked region smooths that region too. Other locked regions stay unchanged.
    """
    before, count = _needs_regions(before), prepared.scan.face_count
    triangles_at(prepared, step.faces)  # raises if a face does not exist
    inside = np.zeros(count, bool)
    inside[list(step.faces)] = True
    inside &= prepared.face_triangle >= 0
    partition, label = before.partition, before.face_region
    joined = joined_pairs(prepared, engine.separated_faces(prepared.mesh, partition))
    pairs = prepared.face_pairs[joined]
    fixed, first = np.array(partition.region_locked, bool), int(label[step.faces[0]])
    locked = first >= 0 and bool(fixed[first])
    if locked:
        partition = engine.unlock_regions(prepared.mesh, partition, triangles_at(prepared, step.faces[:1]))
        fixed[first] = False
    wanted = smoothing.smoothed(label, pairs, inside, fixed, step.rounds, watch.poll)
    wanted = smoothing.shortened(wanted, pairs, pair_lengths(prepared)[joined], inside, fixed)
    for region in np.unique(label[wanted != label]):
        if not (wanted[label == region] == region).any():
            wanted[label == region] = region  # a brush that covers a whole region must not remove it
    for region in np.unique(wanted[wanted != label]):
        stays = int(np.flatnonzero((label == region) & (wanted == region))[0])
        now = face_regions(prepared, partition)
        moved = smoothing.reachable((wanted == region) & (now != now[stays]) & inside, now == now[stays], pairs)
        if moved.any():
            whole = with_split_faces(prepared, partition, moved, now == now[stays], pairs)
            faces = triangles_at(prepared, tuple(np.flatnonzero(whole).tolist()))
            args = (prepared.mesh, partition, faces, triangle_at(prepared, stays))
            partition = engine_call(watch, begin, end, "smoothing", engine.paint_faces, *args)
    if locked:
        stays = int(np.flatnonzero((label == first) & (wanted == first))[0])
        partition = engine.lock_regions(prepared.mesh, partition, np.array([triangle_at(prepared, stays)]))
    return with_regions(prepared, partition, carried_colors(before, partition), {})


def _apply_lock(step: rcp.LockRegions, prepared, before, watch, begin, end) -> Outcome:
    before = _needs_regions(before)
    change = getattr(engine, _LOCKS[type(step)])
    if isinstance(step, rcp.LeaveOutRegions):
        change = partial(change, box=step.box)
    faces = np.array([triangle_at(prepared, face) for face in step.faces])
    partition = change(prepared.mesh, before.partition, faces)
    return with_regions(prepared, partition, before.region_color, {})


_LOCKS = {
    rcp.LockRegions: "lock_regions",
    rcp.UnlockRegions: "unlock_regions",
    rcp.LeaveOutRegions: "leave_out_regions",
}


def _up(step: rcp.Regularise | rcp.AlignPlanes, prepared, before) -> np.ndarray | None:
    """Return (3,) the up direction in the scan's space; None if the step has none."""
    if step.up == "none":
        return None
    if step.up == "region":
        if step.face < 0:
            raise ValueError(said("no region is chosen for the up direction: select a face and press Regularise"))
        partition = before.partition
        region = int(partition.face_region[triangle_at(prepared, step.face)])
        if region < 0:
            raise ValueError(said("the region for the up direction was left out: select another face"))
        return engine.region_fits(prepared.mesh, partition)[0][region]
    if step.up == "scene":
        return np.array(step.direction or (0.0, 0.0, 1.0))
    return np.eye(3)["xyz".index(step.up)]


def _apply_regularise(step: rcp.Regularise, prepared, before, watch, begin, end) -> Outcome:
    before = _needs_regions(before)
    up = _up(step, prepared, before)
    own = rcp.engine_options(step, rcp.REGULARISE) | {"up": "none" if up is None else "z"}
    options = engine.RegulariseOptions(**own)
    snap = partial(engine.regularise, up_direction=up)
    args = (prepared.mesh, before.partition, options)
    partition = engine_call(watch, begin, end, "regularising", snap, *args)
    if partition.regularity["islands_merged"]:
        return with_regions(prepared, partition, carried_colors(before, partition), {})
    return _with_planes(prepared, before, partition)


def _apply_align(step: rcp.AlignPlanes, prepared, before, watch, begin, end) -> Outcome:
    before = _needs_regions(before)
    up = _up(step, prepared, before)
    if up is None:
        if step.to in ("level", "upright"):
            raise ValueError(said("level and upright need an up direction: choose an axis for Up"))
        up = np.array([0.0, 0.0, 1.0])
    faces = np.array([triangle_at(prepared, face) for face in step.faces])
    align = partial(engine.align_planes, length=step.length or None)
    args = (prepared.mesh, before.partition, faces, step.to, up)
    return _with_planes(prepared, before, engine_call(watch, begin, end, "aligning planes", align, *args))


def _with_planes(prepared: Prepared, before: Outcome, partition) -> Outcome:
    """Return the outcome with the same regions and the planes of `partition`."""
    names = ("regions", "error", "left_out", "locked", "regions_left_out")
    known = {name: before.numbers[name] for name in names if name in before.numbers}
    return replace(
        before,
        partition=partition,
        polygons=None,
        region_distance=None,
        made=None,
        numbers=known | planes_known(partition) | _round_known(prepared, partition),
    )


def planes_known(partition) -> dict:
    """Return the number of regions with a held plane, and numbers of `engine.Partition.regularity`."""
    held, found = np.asarray(partition.region_held), partition.regularity
    known = {"held": int(((held == 1) | (held == 2)).sum())}
    if found is not None:
        known |= {name: found[name] for name in ("planes", "directions")}
        known["planes_add"] = max(0.0, found["rms_added"])
    return known if known["held"] or found is not None else {}


def _apply_texture(step: rcp.Texture, prepared, before, watch, begin, end) -> Outcome:
    """Checks that there are polygons. `Session.texture` bakes, since images are not in the scan's arrays."""
    if before is None or before.polygons is None:
        raise ValueError(said("there are no polygons: a Mesh step must come right before"))
    return before


def _cut_arguments(step: rcp.CutRegion, prepared) -> tuple:
    direction = np.array(step.direction, float) if step.direction else None
    return triangle_at(prepared, step.face), np.array(step.line, float), direction


def _at_face(step, prepared) -> tuple:
    return (triangle_at(prepared, step.face),)


def _at_face_by_rings(step, prepared) -> tuple:
    return triangle_at(prepared, step.face), step.rings


def _times(step, prepared) -> tuple:
    return (step.times,)


def _round_arguments(step: rcp.RoundRegions, prepared) -> tuple:
    return triangles_at(prepared, step.faces), step.kind or None


def _segments_arguments(step: rcp.RoundSegments, prepared) -> tuple:
    return triangle_at(prepared, step.face), step.segments, step.rings


#: by class of step: name of the stage in the progress line, function of the engine, and its arguments
_EDITS = {
    rcp.SplitRegion: ("splitting", "split_region", _at_face),
    rcp.CutRegion: ("splitting", "split_along", _cut_arguments),
    rcp.GrowRegion: ("growing", "grow_region", _at_face_by_rings),
    rcp.ShrinkRegion: ("shrinking", "shrink_region", _at_face_by_rings),
    rcp.AddWorst: ("adding regions", "add_worst", _times),
    rcp.DeleteLeast: ("deleting regions", "delete_least", _times),
    rcp.MergeCheapest: ("merging", "merge_cheapest", _times),
    rcp.Improve: ("improving", "improve", lambda step, prepared: ()),
    rcp.EvenBorders: ("evening out", "even_borders", lambda step, prepared: (step.strength,)),
    rcp.RoundRegions: ("making round", "make_round", _round_arguments),
    rcp.RoundSegments: ("cutting round parts", "with_segments", _segments_arguments),
    rcp.ExplodeRound: ("cutting round parts", "explode_round", _at_face),
}


def apply_mesh(step: rcp.Mesh, prepared, before, watch, begin, end, threads: int) -> Outcome:
    """Makes polygons. If they violate the bound, repartitions with a smaller one, unless the partition was edited."""
    before = _needs_regions(before)
    options = engine.MeshingOptions(**rcp.engine_options(step, rcp.MESHING), threads=threads)

    def job(of: float, to: float):
        share = 0.9 * (end - begin)
        return watch.part("meshing", begin + of * share, begin + to * share, engine.Job())

    args = (prepared.mesh, before.partition, options)
    try:
        found = engine.within.polygonize_within(*args, made=before.made, jobs=job)
    except engine.Cancelled:
        raise Stopped from None
    regions = before
    if found.partition is not before.partition:
        regions = with_regions(prepared, found.partition, carried_colors(before, found.partition), {})
    args = (prepared.mesh, regions.partition, found.polygons, 0.0)
    away = engine_call(watch, end - 0.1 * (end - begin), end, "measuring", engine.within.scan_distances, *args)
    numbers = _mesh_numbers(found, regions, away, prepared.mesh.report["diagonal"])
    numbers |= {"regions_before": before.numbers["regions"]}
    return replace(
        regions,
        polygons=found.polygons,
        origin=prepared.mesh.origin,
        numbers=numbers,
        region_distance=_of_regions(prepared.mesh, regions.partition, away),
    )


def _mesh_numbers(found, regions: Outcome, away: np.ndarray, diagonal: float) -> dict:
    """Return the numbers of the report. away: (V,) distance of each vertex from the polygons, NaN outside regions.

    diagonal: of the scan.
    """
    polygons, report = found.polygons, found.report
    names = ("regions", "error", "left_out", "regions_left_out", "symmetry", "round", *NEARER)
    more = ("closed", "manifold", "planarity_max", "planarity_mean", "scan_distance", "scan_distance_allowed")
    numbers = {name: regions.numbers[name] for name in names if name in regions.numbers}
    numbers |= planes_known(regions.partition)
    numbers |= {
        "polygons": len(polygons.loop_start),
        "corners": len(polygons.loops),
        "vertices": len(polygons.vertices),
        **{name: report[name] for name in more if name in report},
        "flaws": defects(report),
        "let_go": report.get("planes_let_go", 0),
        "split": {name: report[name] for name in report if name.startswith("split_for_")}
        | {
            "cut_to_be_planar": report.get("faces_added", 0),
            "without_area": regions.numbers["regions"] - regions.numbers.get("regions_left_out", 0) - report["regions"],
        },
    }
    if found := engine.clutter.clutter(polygons):
        numbers |= {"cluttered": len(found), "clutter_polygons": sum(each.polygons for each in found)}
    if report.get("left_off"):
        numbers["cut_if_planar"] = 1 - report["whole"]
        numbers["not_flat"] = int(np.count_nonzero(np.asarray(polygons.planarity) > EXACT * diagonal))
    if "symmetry" in numbers:
        numbers["mirrored_corners"] = report["mirrored_corners"]
    known = away[np.isfinite(away)]
    if len(known):
        numbers |= {"away_mean": float(known.mean()), "away_max": float(known.max())}
    return numbers


def _of_regions(mesh, partition, away: np.ndarray) -> np.ndarray:
    """Return (R,) the largest distance of a vertex of each region."""
    label, triangles = np.asarray(partition.face_region), np.asarray(mesh.triangles)
    largest, inside = np.zeros(partition.region_count), label >= 0
    each = np.nan_to_num(away)[triangles[inside]].max(axis=1)
    np.maximum.at(largest, label[inside], each)
    return largest


#: relative times of steps, 1 if not listed, and of the preparation before the first step
TIMES = {rcp.Partition: 5.0, rcp.Mesh: 14.0}
PREPARING = 3.0

APPLY = {
    rcp.AddProxy: _apply_add,
    rcp.DeleteProxy: _apply_delete,
    rcp.MergeRegions: _apply_merge,
    rcp.PaintFaces: _apply_paint,
    rcp.EraseFaces: _apply_erase,
    rcp.SmoothFaces: _apply_smooth,
    **dict.fromkeys(_LOCKS, _apply_lock),
    rcp.Regularise: _apply_regularise,
    rcp.AlignPlanes: _apply_align,
    rcp.Texture: _apply_texture,
    **dict.fromkeys(_EDITS, _apply_edit),
}
