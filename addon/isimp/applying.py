"""Applies each step of a recipe by the engine, except Partition, which session.py applies."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import replace
from itertools import chain

import numpy as np

from . import recipe as rcp
from . import view
from .engine import engine
from .language import said
from .outcome import EXACT, Outcome
from .task import Stopped, Watch

_MOST_REGIONS, _MOST_SIZES = 200, 40  # regions of a scan whose sizes are listed, and sizes in the list
_RIGHT = 1e-6  # degrees: difference from a right angle


def engine_call(watch: Watch, begin: float, end: float, stage: str, function, *args):
    """Calls the engine with a job of its own, which reports progress and can be cancelled."""
    with watch.part(stage, begin, end, engine.Job()) as job:
        try:
            return function(*args, job=job)
        except engine.Cancelled:
            raise Stopped from None


class Stages:
    """The jobs of the engine's steps, each of which is a stage of the progress."""

    def __init__(self, watch: Watch, begin: float, end: float):
        self._watch, self._span = watch, (begin, end)

    @contextmanager
    def __call__(self, name: str):
        with self._watch.part(STAGES[name], *self._span, engine.Job()) as job:
            try:
                yield job
            except engine.Cancelled:
                raise Stopped from None


def _needs_regions(before: Outcome | None) -> Outcome:
    if before is None:
        raise ValueError(said("there are no regions yet: a Partition step must come first"))
    return before


def with_regions(repaired, partition, kept: np.ndarray | None, numbers: dict) -> Outcome:
    """Return the outcome of a partition. kept: (R,) the previous colour of each region, -1 for a new region."""
    face_region = repaired.faces.regions(partition)
    border = view.border_pairs(face_region, repaired.faces.pairs)
    pairs = view.region_pairs(face_region, repaired.faces.pairs[border])
    color = view.assign_colors(partition.region_count, pairs, kept)
    known = {"regions": partition.region_count, "error": partition.error, "left_out": int((face_region < 0).sum())}
    away = int(np.count_nonzero(partition.region_left_out))
    known["locked"] = int(np.count_nonzero(partition.region_locked)) - away
    known |= {"regions_left_out": away} if away else {}
    known |= planes_known(partition)
    known |= _round_known(repaired, partition)
    return Outcome(face_region, color, border, partition, numbers=known | numbers, repair=repaired.repair)


def _round_known(repaired, partition) -> dict:
    """Return kind, radius, segments, rings, a face of the scan and the regions of each round part, largest first."""
    parts = sorted(partition.curved, key=lambda part: -part.faces)
    if not parts:
        return {}
    faces = [int(repaired.faces.mesh_face[partition.region_seed[part.regions[0]]]) for part in parts]
    told = [[part.kind, part.radius, part.segments, part.rings] for part in parts]
    regions = [list(map(int, part.regions)) for part in parts]
    return {"round": [[*row, face, cells] for row, face, cells in zip(told, faces, regions, strict=True)]}


def _sizes_known(repaired, partition, numbers: dict) -> dict:
    """Return name, kind, value, uncertainty, measured value, whether it was snapped, and regions of each size.

    Lengths come first, and right angles are left out. Scans of many regions are no machine parts.
    """
    if partition.region_count > _MOST_REGIONS:
        return {}
    rows = engine.sizes.size_rows(repaired.mesh, partition, numbers.get("size_step"))
    rows = [row for row in rows if row["kind"] != "angle" or abs(row["value"] - 90) > _RIGHT]
    rows.sort(key=lambda row: row["kind"] == "angle")
    cells = {part.number: list(map(int, part.regions)) for part in partition.curved}
    found = []
    for row in rows[:_MOST_SIZES]:
        parts = {"diameter": 1, "axis": 1, "axes": 2}.get(row["kind"], 0)  # `of`, or both, are round parts
        ends = (row["of"], row["to"])
        regions = [cells[end] if at < parts else [end] for at, end in enumerate(ends) if end is not None]
        told = [row[name] for name in ("name", "kind", "value", "uncertainty")]
        found.append([*told, row.get("measured"), row.get("snapped"), list(chain(*regions))])
    return {"sizes": found}


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


def apply_edit(step: rcp.Step, repaired, before, watch, begin, end) -> Outcome:
    """Applies a step that changes regions or planes."""
    before, kind = _needs_regions(before), rcp.KINDS[type(step)]
    args = (kind, step, repaired.faces, before.partition)
    partition = engine_call(watch, begin, end, STAGES[kind], engine.replay.edited, *args)
    if isinstance(step, (rcp.Regularise, rcp.AlignPlanes)):
        step_of_sizes = getattr(step, "snap_sizes", before.numbers.get("size_step"))
        return _with_planes(repaired, before, partition, {"size_step": step_of_sizes} if step_of_sizes else {})
    return with_regions(repaired, partition, _kept_colors(step, repaired, before, partition), {})


def _kept_colors(step: rcp.Step, repaired, before: Outcome, partition) -> np.ndarray:
    """Return (R,) the previous colour of each region, -1 for a new region."""
    if isinstance(step, rcp.LockRegions):
        return before.region_color
    if isinstance(step, rcp.AddProxy):
        return np.append(before.region_color, -1)
    if isinstance(step, (rcp.DeleteProxy, rcp.MergeRegions)):  # regions above the lost one move down by one
        face = step.face if isinstance(step, rcp.DeleteProxy) else step.other
        return np.delete(before.region_color, int(before.partition.face_region[repaired.faces.triangle_at(face)]))
    return carried_colors(before, partition)


def _with_planes(repaired, before: Outcome, partition, more: dict) -> Outcome:
    """Return the outcome with the same regions and the planes of `partition`. more: further numbers."""
    names = ("regions", "error", "left_out", "locked", "regions_left_out", "not_round")
    known = {name: before.numbers[name] for name in names if name in before.numbers}
    return replace(
        before,
        partition=partition,
        polygons=None,
        region_distance=None,
        made=None,
        numbers=known | planes_known(partition) | _round_known(repaired, partition) | more,
    )


def planes_known(partition) -> dict:
    """Return the number of regions with a held plane, and numbers of `engine.Partition.regularity`."""
    held, found = np.asarray(partition.region_held), partition.regularity
    known = {"held": int(engine.planes.is_fixed(held).sum())}
    if found is not None:
        known |= {name: found[name] for name in ("planes", "directions")}
        known["planes_add"] = max(0.0, found["rms_added"])
    return known if known["held"] or found is not None else {}


def apply_texture(before: Outcome | None) -> Outcome:
    """Checks that there are polygons. `Session.texture` bakes, since images are not in the scan's arrays."""
    if before is None or before.polygons is None:
        raise ValueError(said("there are no polygons: a Mesh step must come right before"))
    return before


#: the stage in the progress line, by name of a step
STAGES = {
    **dict.fromkeys(("merge_regions", "merge_cheapest"), "merging"),
    **dict.fromkeys(("split_region", "cut_region"), "splitting"),
    **dict.fromkeys(("lock", "unlock", "leave_out"), "locking"),
    **dict.fromkeys(("segments", "explode"), "cutting round parts"),
    "clean": "reading the mesh",
    "partition": "partitioning",
    "add_proxy": "adding a region",
    "add_worst": "adding regions",
    "delete_proxy": "deleting a region",
    "delete_least": "deleting regions",
    "paint": "painting",
    "erase": "erasing",
    "smooth": "smoothing",
    "grow": "growing",
    "shrink": "shrinking",
    "improve": "improving",
    "even_borders": "evening out",
    "round": "making round",
    "regularise": "regularising",
    "align": "aligning planes",
}


def apply_mesh(step: rcp.Mesh, repaired, before, watch, begin, end, threads: int) -> Outcome:
    """Makes polygons. If they violate the bound, repartitions with a smaller one, unless the partition was edited."""
    before = _needs_regions(before)
    options = engine.MeshingOptions(**rcp.engine_options(step, rcp.MESHING), threads=threads)

    def job(of: float, to: float):
        share = 0.9 * (end - begin)
        return watch.part("meshing", begin + of * share, begin + to * share, engine.Job())

    args = (repaired.mesh, before.partition, options)
    try:
        found = engine.within.polygonize_within(*args, made=before.made, jobs=job)
    except engine.Cancelled:
        raise Stopped from None
    regions = before
    if found.partition is not before.partition:
        regions = with_regions(repaired, found.partition, carried_colors(before, found.partition), {})
    args = (repaired.mesh, regions.partition, found.polygons)
    away = engine_call(watch, end - 0.1 * (end - begin), end, "measuring", engine.within.scan_distances, *args)
    numbers = _mesh_numbers(found, regions, away, repaired.mesh.report["diagonal"])
    numbers |= {"regions_before": before.numbers["regions"]}
    numbers |= _sizes_known(repaired, regions.partition, numbers)
    return replace(
        regions,
        polygons=found.polygons,
        origin=repaired.mesh.origin,
        numbers=numbers,
        region_distance=_of_regions(repaired.mesh, regions.partition, away),
    )


def _mesh_numbers(found, regions: Outcome, away: np.ndarray, diagonal: float) -> dict:
    """Return the numbers of the report. away: (V,) distance of each vertex from the polygons, NaN outside regions.

    diagonal: of the scan.
    """
    polygons, report = found.polygons, found.report
    names = ("regions", "error", "left_out", "regions_left_out", "round", "not_round", "size_step")
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
            "cut_to_be_convex": report.get("cut_to_be_convex", 0),
            "without_area": regions.numbers["regions"] - regions.numbers.get("regions_left_out", 0) - report["regions"],
        },
    }
    if cluttered := engine.clutter.clutter(polygons):
        numbers |= {"cluttered": len(cluttered), "clutter_polygons": sum(each.polygons for each in cluttered)}
    if report.get("left_off"):
        numbers["cut_if_planar"] = 1 - report["whole"]
        numbers["not_flat"] = int(np.count_nonzero(np.asarray(polygons.planarity) > EXACT * diagonal))
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
