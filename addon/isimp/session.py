"""Replays a recipe on arrays and returns arrays; earlier results are kept. The only importer of the engine."""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from . import recipe as rcp
from . import smoothing, view
from .cache import Cache
from .engine_options import MESHING, PARTITION
from .prepared import (
    Prepared,
    face_areas,
    face_regions,
    in_users_faces,
    joined_pairs,
    pair_lengths,
    scan_numbers,
    triangle_at,
    triangles_at,
    with_split_faces,
)
from .scan import Scan
from .task import Stopped, Watch, shares

ENGINE_PROBLEM = ""  #: why the engine can't be used; empty when it can
try:
    import isimp_engine as engine
except ImportError as outer:
    try:
        from . import isimp_engine as engine
    except ImportError as inner:
        engine = None
        # What is there and does not load says more than what is not there.
        ENGINE_PROBLEM = str(inner if isinstance(outer, ModuleNotFoundError) else outer)


def backends() -> list[str]:
    """Where parallel methods can run here: "cpu" first, and "cuda" if a device is present."""
    return engine.backends() if engine else []


class StepFailed(Exception):
    """A step failed; `outcome` is the result of the steps before it, None if there were none."""

    def __init__(self, index: int, step: rcp.Step, reason: str, outcome: Outcome | None):
        super().__init__(f"Step {index + 1}, {step.describe()}: {reason}")
        self.index, self.step, self.reason, self.outcome = index, step, reason, outcome


@dataclass(frozen=True, eq=False)
class Outcome:
    """The result of a recipe. Arrays are by the user's faces."""

    face_region: np.ndarray  #: (face_count,) int32, -1 where a face is in no region
    region_color: np.ndarray  #: (R,) int32 into view.PALETTE
    border: np.ndarray  #: (K,) those of the scan's `face_edges` where regions meet, or a region and none
    partition: Any
    polygons: Any = None  #: the engine's PolygonMesh after Mesh, else None
    origin: tuple = (0.0, 0.0, 0.0)  #: near the polygons, exactly; 0 where they lie near zero. See `engine.Mesh.origin`
    numbers: dict = field(default_factory=dict)  #: of the last step and of the scan
    made: Any = None  #: how the engine made the partition; None once it was edited

    @property
    def face_color(self) -> np.ndarray:
        """(face_count,) uint8 into view.COLORS."""
        return view.face_colors(self.face_region, self.region_color)


@dataclass(frozen=True, eq=False)
class Shown:
    """What the triangles of a scan show."""

    uv: np.ndarray  #: (T, 3, 2) of each corner
    material: np.ndarray  #: (T,) which image
    images: list  #: (H, W, 4) uint8, row 0 at the top


class Session:
    """Replays recipes on scans. One thread at a time."""

    def __init__(self, budget: int = 1 << 30, backend: str = "cpu", threads: int = 0):
        # Neither changes the result:
        self.backend = backend  #: one of backends(), for parallel methods
        self.threads = threads  #: how many may work; 0: as many as there are cores
        self._meshes = Cache(budget)
        self._outcomes = Cache(budget)
        self._parts = Cache(0)  # the last one alone

    def replay(self, scan: Scan, recipe: rcp.Recipe, watch: Watch | None = None) -> Outcome:
        """The outcome of the recipe on the scan.

        Raises StepFailed (which carries the last good outcome), ValueError (the scan itself can't be used) or Stopped.
        """
        watch = watch or Watch()
        steps, keys = recipe.active(), _keys(scan, recipe)
        done, outcome = self._longest_known(keys)
        if done < len(steps):
            times = [0.0 if self._meshes.get(scan.digest) else _PREPARING]
            ends = shares(times + [_TIMES.get(type(step), 1.0) for _, step in steps[done:]])
            prepared = replace(self.prepare(scan, watch, 0.0, ends[0]), layers=scan.layers)
        for number in range(done, len(steps)):
            index, step = steps[number]
            begin, end = ends[number - done : number - done + 2]
            try:
                outcome = self._apply(step, prepared, outcome, watch, begin, end)
            except engine.InvalidInput as error:
                raise StepFailed(index, step, in_users_faces(str(error), prepared), outcome) from error
            except (ValueError, RuntimeError) as error:  # that of a device that ran out of memory, say
                raise StepFailed(index, step, str(error), outcome) from error
            self._outcomes.put(keys[number], outcome, _size(outcome, prepared))
        if outcome is None:
            raise ValueError("The recipe has no active step: press Partition.")
        return outcome

    def prepare(self, scan: Scan, watch: Watch | None = None, begin: float = 0.0, end: float = 1.0) -> Prepared:
        """The scan, checked and repaired. Raises ValueError if nothing usable is in it."""
        prepared = self._meshes.get(scan.digest)
        if prepared is None:
            prepared = _prepare(scan, watch or Watch(), begin, end)
            # Adjacency, normals and other data of the engine: about 300 bytes a face.
            self._meshes.put(scan.digest, prepared, 300 * len(scan.triangles))
        return prepared

    def triangulate(self, polygons) -> tuple[np.ndarray, np.ndarray]:
        """(T, 3) vertices and (T,) polygon of triangles that fill the polygons of an outcome."""
        args = (np.asarray(polygons.vertices), np.asarray(polygons.loops), np.asarray(polygons.loop_start))
        triangles, polygon = engine.triangulate(*args)
        return np.asarray(triangles), np.asarray(polygon)

    def texture(self, scan: Scan, outcome: Outcome, shown: Shown, size: int | None = None):
        """UVs and images of an outcome's polygons; see `engine.texture`. Raises ValueError."""
        mesh = self.prepare(scan).mesh
        soup = engine.TexturedSoup(scan.vertices, scan.triangles, shown.uv, shown.material, shown.images)
        options = engine.TextureOptions(size=size, threads=self.threads)
        return engine.texture(mesh, outcome.partition, outcome.polygons, soup, options)

    def region_at(self, scan: Scan, outcome: Outcome, face: int) -> dict:
        """The result of `engine.region_statistics` for the region of one of the user's faces.

        Raises ValueError if there is no such face, or it is in no region. Cost: of the size of the region.
        """
        prepared = self.prepare(scan)
        return engine.region_statistics(prepared.mesh, outcome.partition, triangle_at(prepared, face))

    def locked_regions(self, scan: Scan, recipe: rcp.Recipe, watch: Watch | None = None) -> np.ndarray:
        """The numbers of the regions that the recipe leaves locked. Raises ValueError or Stopped."""
        if not any(isinstance(step, (rcp.LockRegions, rcp.PaintFaces)) for _, step in recipe.active()):
            return np.empty(0, np.int64)
        try:
            outcome = self.replay(scan, recipe.without_mesh(), watch)
        except StepFailed as error:
            outcome = error.outcome
        return np.empty(0, np.int64) if outcome is None else np.flatnonzero(outcome.partition.region_locked)

    def known(self, scan: Scan, recipe: rcp.Recipe) -> Outcome | None:
        """The kept outcome of the recipe, or None; nothing is computed."""
        keys = _keys(scan, recipe)
        done, outcome = self._longest_known(keys)
        return outcome if done == len(keys) else None

    def _longest_known(self, keys: list) -> tuple[int, Outcome | None]:
        for number in range(len(keys), 0, -1):
            outcome = self._outcomes.get(keys[number - 1])
            if outcome is not None:
                return number, outcome
        return 0, None

    def _apply(self, step, prepared, before, watch, begin, end) -> Outcome:
        started = time.perf_counter()
        if isinstance(step, rcp.Partition):
            outcome = self._partition(step, prepared, before, watch, begin, end)
        elif isinstance(step, rcp.Mesh):
            outcome = _apply_mesh(step, prepared, before, watch, begin, end, self.threads)
        else:
            outcome = _APPLY[type(step)](step, prepared, before, watch, begin, end)
        seconds = time.perf_counter() - started
        numbers = {"step": step.kind, "seconds": seconds, **scan_numbers(prepared), **outcome.numbers}
        return replace(outcome, numbers=numbers)

    def _partition(self, step: rcp.Partition, prepared, before, watch, begin, end) -> Outcome:
        own = rcp.engine_options(step, PARTITION) | {"noise": None if step.noise < 0 else step.noise}
        own = {name: value for name, value in own.items() if name not in rcp.COUNTS or name == step.count_by}
        options = engine.PartitionOptions(**own, backend=self.backend, threads=self.threads)
        guides = _guides(step, prepared, before)
        made = engine.within.Made(options, guides, self._part(prepared, guides, step.leave_out))
        args = (prepared.mesh, options, guides, made.part)
        partition = _engine_call(watch, begin, end, "partitioning", _partition_guided, *args)
        names = ("rounds", "tolerance", "noise", "snapped", "distance_max", "warnings")
        numbers = {"asked": partition.proxies_asked} | {name: partition.report[name] for name in names}
        kept = None if before is None or guides.before is None else _carried_colors(before, partition)
        barriers = guides.arrays()["barriers"]
        if barriers is not None:
            inside = engine.guided.inside_regions(prepared.mesh, partition, barriers)
            numbers |= {"barriers": len(barriers), "barriers_inside": inside}
        return replace(_with_regions(prepared, partition, kept, numbers), made=made)

    def _part(self, prepared: Prepared, guides, leave_out: float):
        """The part of the mesh to split, kept so that another number is quick; None: all of it."""
        faces = engine.guided.open_faces(prepared.mesh, guides, leave_out)
        if faces is None:
            return None
        key = (prepared.scan.digest, faces.tobytes())
        if self._parts.get(key) is None:
            self._parts.put(key, engine.guided.part_of(prepared.mesh, faces), 1)
        return self._parts.get(key)


def _keys(scan: Scan, recipe: rcp.Recipe) -> list[tuple]:
    """The cache keys of the outcomes of the recipe's steps."""
    return [(scan.digest, scan.layers_digest, key) for key in recipe.prefix_keys()]


def _engine_call(watch: Watch, begin: float, end: float, stage: str, function, *args):
    """Calls the engine with a job of its own, so that its progress shows and it can be stopped."""
    with watch.part(stage, begin, end, engine.Job()) as job:
        try:
            return function(*args, job=job)
        except engine.Cancelled:
            raise Stopped from None


def _prepare(scan: Scan, watch: Watch, begin: float, end: float) -> Prepared:
    if len(scan.triangles) == 0:
        raise ValueError("The mesh has no faces: there is nothing to simplify.")
    middle = begin + 0.4 * (end - begin)
    mesh = _engine_call(watch, begin, middle, "reading the mesh", engine.clean, scan.vertices, scan.triangles)
    with watch.part("reading the mesh", middle, end):
        mesh_face = scan.triangle_face[mesh.source_face]
        scan.face_edges  # noqa: B018  (made here and kept)
        face_triangle = np.full(scan.face_count, -1, np.int32)
        triangle = np.arange(len(mesh_face), dtype=np.int32)
        face_triangle[mesh_face] = triangle
        if len(scan.triangles) == scan.face_count and np.array_equal(face_triangle[mesh_face], triangle):
            areas = None
        else:
            areas = face_areas(mesh)
            order = np.argsort(areas, kind="stable")
            face_triangle[mesh_face[order]] = order  # the last one written is the largest
        return Prepared(scan, mesh, mesh_face, face_triangle, areas)


def _needs_regions(before: Outcome | None) -> Outcome:
    if before is None:
        raise ValueError("there are no regions yet: a Partition step must come first.")
    return before


def _with_regions(prepared: Prepared, partition, kept: np.ndarray | None, numbers: dict) -> Outcome:
    """kept: (R,) the colour each region has already, -1 for a new one."""
    face_region = face_regions(prepared, partition)
    border = view.border_pairs(face_region, prepared.face_pairs)
    pairs = view.region_pairs(face_region, prepared.face_pairs[border])
    color = view.assign_colors(partition.region_count, pairs, kept)
    known = {"regions": partition.region_count, "error": partition.error, "left_out": int((face_region < 0).sum())}
    known["locked"] = int(np.count_nonzero(partition.region_locked))
    return Outcome(face_region, color, border, partition, numbers=known | numbers)


def _weights(step: rcp.Partition, prepared: Prepared) -> np.ndarray | None:
    """(F',) the factor of each face's area; a weight of 1 gives four times as many regions as one of 0."""
    if not step.weights:
        return None
    if step.weights not in prepared.layers:
        raise ValueError(f"there is no vertex group or numeric attribute '{step.weights}' for the weights.")
    painted = np.clip(np.nan_to_num(prepared.layers[step.weights].astype(np.float64)), 0.0, 1.0)
    return 16.0 ** (step.influence * painted[prepared.mesh_face])


def _barriers(step: rcp.Partition, prepared: Prepared) -> list[np.ndarray]:
    """Edges that no region crosses, as the step and the scan's marks say."""
    guides, mesh, found = engine.guides, prepared.mesh, []
    values = [prepared.layers.get(rcp.MARKS[name]) for name in ("materials", "face_sets") if getattr(step, name)]
    if step.borders:
        if step.borders not in prepared.layers:
            raise ValueError(f"there is no face attribute '{step.borders}' for the barriers.")
        values.append(prepared.layers[step.borders])
    of_faces = (each[prepared.mesh_face] for each in values if each is not None)
    found.extend(guides.attribute_borders(mesh, each) for each in of_faces)
    if step.angle < 180:
        found.append(guides.sharp_edges(mesh, np.radians(step.angle)))
    return found


def _guides(step: rcp.Partition, prepared: Prepared, before: Outcome | None):
    """The barriers, weights and locks of the step for the engine."""
    marked = [prepared.layers.get(rcp.MARKS[name]) for name in ("seams", "sharp") if getattr(step, name)]
    cuts = [engine.guides.marked_edges(prepared.mesh, edges) for edges in marked if edges is not None]
    barriers = _barriers(step, prepared)
    locked = before is not None and before.partition.region_locked.any()
    return engine.guided.Guides(
        weights=_weights(step, prepared),
        barriers=np.concatenate(barriers) if barriers else None,
        cuts=np.concatenate(cuts) if cuts else None,
        faces=triangles_at(prepared, step.faces) if step.faces else None,
        before=before.partition if before is not None and (locked or step.faces) else None,
    )


def _partition_guided(mesh, options, guides, part, job):
    return engine.guided.partition_guided(mesh, options, job, guides, part)


def _apply_add(step: rcp.AddProxy, prepared, before, watch, begin, end) -> Outcome:
    before, triangle = _needs_regions(before), triangle_at(prepared, step.face)
    args = (prepared.mesh, before.partition, triangle)
    partition = _engine_call(watch, begin, end, "adding a proxy", engine.add_proxy, *args)
    return _with_regions(prepared, partition, np.append(before.region_color, -1), {})


def _apply_delete(step: rcp.DeleteProxy, prepared, before, watch, begin, end) -> Outcome:
    before, triangle = _needs_regions(before), triangle_at(prepared, step.face)
    args = (prepared.mesh, before.partition, triangle)
    partition = _engine_call(watch, begin, end, "deleting a proxy", engine.delete_proxy, *args)
    gone = int(before.partition.face_region[triangle])  # regions above it move down by one
    return _with_regions(prepared, partition, np.delete(before.region_color, gone), {})


def flaws(report: dict) -> dict:
    """{kind of defect: polygons}, without pairs that intersect in the scan itself."""
    found = {}
    for entry in report.get("imperfect", ()):
        if entry["flaw"] != "excused":
            found.setdefault(entry["flaw"], set()).add(entry["polygon"])
    return {flaw: sorted(polygons) for flaw, polygons in found.items()}


def _carried_colors(before: Outcome, partition) -> np.ndarray:
    """(R,) the colour each region brings from before, -1 for a new one: colours go with the regions' seeds."""
    old, color = before.partition, before.region_color
    came, went = old.face_region[partition.region_seed], partition.face_region[old.region_seed]
    kept = np.full(partition.region_count, -1, color.dtype)
    for region in range(len(color) - 1, -1, -1):  # of several that became one the lowest
        if went[region] >= 0:
            kept[went[region]] = color[region]
    same = (came >= 0) & (went[came] == np.arange(len(came)))
    kept[same] = color[came[same]]
    return kept


def _apply_edit(step: rcp.Step, prepared, before, watch, begin, end) -> Outcome:
    before = _needs_regions(before)
    stage, function, arguments = _EDITS[type(step)]
    args = (prepared.mesh, before.partition, *arguments(step, prepared))
    partition = _engine_call(watch, begin, end, stage, getattr(engine, function), *args)
    return _with_regions(prepared, partition, _carried_colors(before, partition), {})


def _apply_merge(step: rcp.MergeRegions, prepared, before, watch, begin, end) -> Outcome:
    before, other = _needs_regions(before), triangle_at(prepared, step.other)
    args = (prepared.mesh, before.partition, triangle_at(prepared, step.face), other)
    partition = _engine_call(watch, begin, end, "merging", engine.merge_regions, *args)
    gone = int(before.partition.face_region[other])  # regions above it move down by one
    return _with_regions(prepared, partition, np.delete(before.region_color, gone), {})


def _apply_paint(step: rcp.PaintFaces, prepared, before, watch, begin, end) -> Outcome:
    before, faces = _needs_regions(before), triangles_at(prepared, step.faces)
    onto = None if step.onto < 0 else triangle_at(prepared, step.onto)
    args = (prepared.mesh, before.partition, faces, onto)
    partition = _engine_call(watch, begin, end, "painting", engine.paint_faces, *args)
    if step.lock:
        painted = partition.region_seed[-1] if onto is None else onto
        partition = engine.lock_regions(prepared.mesh, partition, np.array([painted]))
    return _with_regions(prepared, partition, _carried_colors(before, partition), {})


def _apply_erase(step: rcp.EraseFaces, prepared, before, watch, begin, end) -> Outcome:
    """Erasing by hand changes a locked region too."""
    before, faces = _needs_regions(before), triangles_at(prepared, step.faces)
    partition, region = before.partition, int(before.partition.face_region[faces[0]])
    locked = region >= 0 and bool(partition.region_locked[region])
    if locked:
        partition = engine.unlock_regions(prepared.mesh, partition, faces[:1])
    partition = _engine_call(watch, begin, end, "erasing", engine.erase_faces, prepared.mesh, partition, faces)
    if locked and partition.region_count == before.partition.region_count:  # else it is gone
        partition = engine.lock_regions(prepared.mesh, partition, np.flatnonzero(partition.face_region == region)[:1])
    return _with_regions(prepared, partition, _carried_colors(before, partition), {})


def _apply_smooth(step: rcp.SmoothFaces, prepared, before, watch, begin, end) -> Outcome:
    """Works on the user's faces: those that change their region are painted onto it, one region after the other.

    A stroke that begins in a locked region smooths that region too; other locked regions stay unchanged.
    """
    before, count = _needs_regions(before), prepared.scan.face_count
    triangles_at(prepared, step.faces)  # raises if there are no such faces
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
            wanted[label == region] = region  # a brush that covers all of it must not take it away
    for region in np.unique(wanted[wanted != label]):
        stays = int(np.flatnonzero((label == region) & (wanted == region))[0])
        now = face_regions(prepared, partition)
        moved = smoothing.reachable((wanted == region) & (now != now[stays]) & inside, now == now[stays], pairs)
        if moved.any():
            whole = with_split_faces(prepared, partition, moved, now == now[stays], pairs)
            faces = triangles_at(prepared, tuple(np.flatnonzero(whole).tolist()))
            args = (prepared.mesh, partition, faces, triangle_at(prepared, stays))
            partition = _engine_call(watch, begin, end, "smoothing", engine.paint_faces, *args)
    if locked:
        stays = int(np.flatnonzero((label == first) & (wanted == first))[0])
        partition = engine.lock_regions(prepared.mesh, partition, np.array([triangle_at(prepared, stays)]))
    return _with_regions(prepared, partition, _carried_colors(before, partition), {})


def _apply_lock(step: rcp.LockRegions, prepared, before, watch, begin, end) -> Outcome:
    before = _needs_regions(before)
    change = engine.unlock_regions if isinstance(step, rcp.UnlockRegions) else engine.lock_regions
    faces = np.array([triangle_at(prepared, face) for face in step.faces])
    partition = change(prepared.mesh, before.partition, faces)
    return _with_regions(prepared, partition, before.region_color, {})


def _cut_arguments(step: rcp.CutRegion, prepared) -> tuple:
    direction = np.array(step.direction, float) if step.direction else None
    return triangle_at(prepared, step.face), np.array(step.line, float), direction


def _at_face(step, prepared) -> tuple:
    return (triangle_at(prepared, step.face),)


def _at_face_by_rings(step, prepared) -> tuple:
    return triangle_at(prepared, step.face), step.rings


def _times(step, prepared) -> tuple:
    return (step.times,)


#: of each step: its name while it works, the engine's function, and that function's arguments
_EDITS = {
    rcp.SplitRegion: ("splitting", "split_region", _at_face),
    rcp.CutRegion: ("splitting", "split_along", _cut_arguments),
    rcp.GrowRegion: ("growing", "grow_region", _at_face_by_rings),
    rcp.ShrinkRegion: ("shrinking", "shrink_region", _at_face_by_rings),
    rcp.AddWorst: ("adding proxies", "add_worst", _times),
    rcp.DeleteLeast: ("deleting proxies", "delete_least", _times),
    rcp.MergeCheapest: ("merging", "merge_cheapest", _times),
    rcp.Improve: ("improving", "improve", lambda step, prepared: ()),
}


def _apply_mesh(step: rcp.Mesh, prepared, before, watch, begin, end, threads: int) -> Outcome:
    """If the polygons violate the bound, repartitions with a smaller one, unless the partition was edited."""
    before = _needs_regions(before)
    options = engine.MeshingOptions(**rcp.engine_options(step, MESHING), threads=threads)

    def job(of: float, to: float):
        return watch.part("meshing", begin + of * (end - begin), begin + to * (end - begin), engine.Job())

    args = (prepared.mesh, before.partition, options)
    try:
        found = engine.within.polygonize_within(*args, made=before.made, jobs=job)
    except engine.Cancelled:
        raise Stopped from None
    regions = before
    if found.partition is not before.partition:
        regions = _with_regions(prepared, found.partition, _carried_colors(before, found.partition), {})
    polygons, report = found.polygons, found.report
    names = ("regions", "error", "left_out")
    more = ("closed", "manifold", "planarity_max", "planarity_mean", "scan_distance", "scan_distance_allowed")
    numbers = {name: regions.numbers[name] for name in names} | {
        "regions_before": before.numbers["regions"],
        "polygons": len(polygons.loop_start),
        "corners": len(polygons.loops),
        "vertices": len(polygons.vertices),
        **{name: report[name] for name in more if name in report},
        "flaws": flaws(report),
    }
    return replace(regions, polygons=polygons, origin=prepared.mesh.origin, numbers=numbers)


#: relative time of a step, and of the preparation before the first
_TIMES = {rcp.Partition: 5.0, rcp.Mesh: 14.0}
_PREPARING = 3.0

_APPLY = {
    rcp.AddProxy: _apply_add,
    rcp.DeleteProxy: _apply_delete,
    rcp.MergeRegions: _apply_merge,
    rcp.PaintFaces: _apply_paint,
    rcp.EraseFaces: _apply_erase,
    rcp.SmoothFaces: _apply_smooth,
    rcp.LockRegions: _apply_lock,
    rcp.UnlockRegions: _apply_lock,
    **dict.fromkeys(_EDITS, _apply_edit),
}


def _size(outcome: Outcome, prepared: Prepared) -> int:
    size = (
        outcome.face_region.nbytes
        + outcome.border.nbytes
        + 4 * len(prepared.mesh_face)
        + 200 * len(outcome.region_color)
    )
    return size if outcome.polygons is None else size + 64 * len(outcome.polygons.loops)
