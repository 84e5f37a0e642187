"""Replays a recipe on arrays and returns arrays. Earlier results are cached."""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from . import recipe as rcp
from . import view
from .applying import (
    PREPARING,
    TIMES,
    Stages,
    apply_edit,
    apply_mesh,
    apply_texture,
    carried_colors,
    defects,
    engine_call,
    with_regions,
)
from .engine import ENGINE_PROBLEM, engine
from .language import said
from .outcome import Outcome, StepFailed
from .scan import Scan
from .task import Watch, shares

__all__ = ["ENGINE_PROBLEM", "Outcome", "Scan", "Session", "Shown", "StepFailed", "backends", "defects", "engine"]


def backends() -> list[str]:
    """Return the available back ends of parallel methods: "cpu", and "cuda" if a device is present."""
    return engine.backends() if engine else []


def with_places(scan: Scan, recipe: rcp.Recipe) -> rcp.Recipe:
    """Return the recipe with the places of the faces that it names, for other versions of the scan."""
    found = engine.replay.places_of(recipe, scan.source.surface)
    return recipe if found is None else replace(recipe, places=rcp.Places(*found))


def placed(scan: Scan, recipe: rcp.Recipe) -> tuple[rcp.Recipe, int]:
    """Return the recipe with the faces at its places, and how many steps are switched off, as they have none."""
    found, lost = engine.replay.placed(recipe, scan.source.surface)
    return found, len(lost)


@dataclass(frozen=True, eq=False)
class Shown:
    """The texture on the triangles of a scan."""

    uv: np.ndarray  #: (T, 3, 2) coordinates of each corner
    material: np.ndarray  #: (T,) index of the image
    images: list  #: (H, W, 4) uint8, row 0 at the top; a dict of arrays by number for UDIM tiles
    #: further layers, a list by material: an image, a number or None; see `engine.TextureLayer`
    layers: dict = field(default_factory=dict)
    strength: float = 1.0  #: strength of the emission
    names: tuple = ()  #: names of the materials
    uvs: dict = field(default_factory=dict)  #: (T, 3, 2) by layer, where they differ from those of the colours


class Session:
    """Replays recipes on scans, on one thread at a time.

    Meanwhile another thread may read cached results: locks guard the caches of meshes and outcomes, and one assignment
    replaces the fits. Both threads may compute a missing value.
    """

    def __init__(self, budget: int = 1 << 30, backend: str = "cpu", threads: int = 0):
        # Neither changes the result:
        self.backend = backend  #: one of backends(), for parallel methods
        self.threads = threads  #: number of threads; 0: one for each core
        # For one scan: the mesh with open and the one with closed openings.
        self._meshes = engine and engine.repairs.Meshes(engine.cache.Cache(budget, least=2))
        self._outcomes = engine and engine.cache.Cache(budget)
        self._fits: tuple = (None, ())  # the last partition and its fits

    def replay(self, scan: Scan, recipe: rcp.Recipe, watch: Watch | None = None) -> Outcome:
        """Return the outcome of the recipe on the scan.

        Raises StepFailed (which carries the last good outcome), ValueError (the scan itself can't be used) or Stopped.
        """
        watch = watch or Watch()
        steps, keys = recipe.active(), _keys(scan, recipe)
        done, outcome = self._outcomes.longest(keys)
        if done < len(steps):
            repair = outcome.repair if outcome else _first_repair(recipe)
            times = [0.0 if self.is_prepared(scan, repair) else PREPARING]
            ends = shares(times + [TIMES.get(type(step), 1.0) for _, step in steps[done:]])
            repaired = self.prepare(scan, watch, 0.0, ends[0], repair)
        for number in range(done, len(steps)):
            index, step = steps[number]
            begin, end = ends[number - done : number - done + 2]
            try:
                outcome = self._apply(step, scan, repaired, outcome, watch, begin, end)
                repaired = self.prepare(scan, repair=outcome.repair)
            except engine.InvalidInput as error:
                raise StepFailed(index, step, repaired.faces.named(str(error)), outcome) from error
            except (ValueError, RuntimeError) as error:  # a device may run out of memory, for example
                raise StepFailed(index, step, str(error), outcome) from error
            except MemoryError as error:
                raise StepFailed(index, step, said("there is not enough memory"), outcome) from error
            self._outcomes.put(keys[number], outcome, _size(outcome, repaired))
        if outcome is None:
            raise ValueError(said("The recipe has no active step: press Partition"))
        return outcome

    def prepare(self, scan: Scan, watch: Watch | None = None, begin: float = 0.0, end: float = 1.0, repair=None):
        """Return the repaired scan. Raises ValueError if it has no usable face.

        repair: the `engine.repairs.Repair` of an outcome; None: with its openings as they are.
        """
        if len(scan.triangles) == 0:
            raise ValueError(said("The mesh has no faces: there is nothing to simplify"))
        steps = Stages(watch or Watch(), begin, end)
        found = self._meshes.repaired(scan.source, repair or engine.repairs.Repair(), steps)
        found.faces.pairs, found.faces.face_triangle  # noqa: B018  (computed on this thread and cached)
        return found

    def is_scanned(self, scan: Scan) -> bool:
        """Return whether the scan has noise, which drawn models do not have. Raises ValueError as `prepare`."""
        return not engine.regions.is_drawn(self.prepare(scan).mesh)

    def openings(self, scan: Scan, outcome: Outcome) -> list[dict]:
        """Return the openings that were closed before the partition or kept open: `engine.Mesh.openings`."""
        found: list[dict] = self.prepare(scan, repair=outcome.repair).mesh.openings
        return found

    def triangulate(self, polygons) -> tuple[np.ndarray, np.ndarray]:
        """Return (T, 3) vertices and (T,) polygon of triangles that fill the polygons of an outcome."""
        args = (np.asarray(polygons.vertices), np.asarray(polygons.loops), np.asarray(polygons.loop_start))
        triangles, polygon = engine.regions.triangulate(*args)
        return np.asarray(triangles), np.asarray(polygon)

    def texture(self, scan: Scan, outcome: Outcome, shown: Shown, step: rcp.Texture, watch: Watch | None = None):
        """Return UVs and images of an outcome's polygons; see `engine.texture`. Raises ValueError or Stopped."""
        watch = watch or Watch()
        mesh = self.prepare(scan, watch, repair=outcome.repair).mesh
        layers = {
            name: engine.TextureLayer(images, shown.uvs.get(name), shown.strength if name == "emission" else 1.0)
            for name, images in shown.layers.items()
        }
        arrays = (scan.vertices, scan.triangles, shown.uv, shown.material, shown.images)
        soup = engine.TexturedSoup(*arrays, names=shown.names, layers=layers)
        options = engine.TextureOptions(**rcp.engine_options(step, rcp.TEXTURE), threads=self.threads)
        args = (mesh, outcome.partition, outcome.polygons, soup, options)
        return engine_call(watch, 0.0, 1.0, "making the texture", engine.texture, *args)

    def corner_sources(self, scan: Scan, outcome: Outcome, uv=None) -> tuple[np.ndarray, np.ndarray]:
        """Return (L,) triangle of the scan and (L, 3) weights of its corners, for each corner of an outcome's polygons.

        uv: (T, 3, 2) a UV map to transfer: each polygon then uses points of one island only.
        """
        islands = None if uv is None else engine.texturing.uv_islands(scan.triangles, uv)
        mesh = self.prepare(scan, repair=outcome.repair).mesh
        args = (mesh, outcome.partition, outcome.polygons, scan.vertices, scan.triangles)
        triangle, weights = engine.texturing.corner_sources(*args, islands=islands, threads=self.threads)
        return np.asarray(triangle), np.asarray(weights)

    def region_fits(self, scan: Scan, outcome: Outcome) -> tuple:
        """Return `engine.regions.region_fits` of an outcome; cached for the last one."""
        known = self._fits
        if known[0] is not outcome.partition:
            mesh = self.prepare(scan, repair=outcome.repair).mesh
            known = self._fits = outcome.partition, engine.regions.region_fits(mesh, outcome.partition)
        return known[1]

    def locked_regions(self, scan: Scan, recipe: rcp.Recipe, watch: Watch | None = None) -> np.ndarray:
        """Return the numbers of the regions that are locked after the recipe. Raises ValueError or Stopped."""
        if not any(isinstance(step, (rcp.LockRegions, rcp.PaintFaces)) for _, step in recipe.active()):
            return np.empty(0, np.int64)
        outcome = self._possible(scan, recipe, watch)
        return np.empty(0, np.int64) if outcome is None else np.flatnonzero(outcome.partition.region_locked)

    def neighbours(self, scan: Scan, recipe: rcp.Recipe, watch: Watch | None = None) -> np.ndarray:
        """Return (P, 2) faces that share an edge which is no barrier of the regions. Raises ValueError or Stopped."""
        pairs: np.ndarray = scan.face_edges[0]
        if not any(_has_barriers(step) for _, step in recipe.active() if isinstance(step, rcp.Partition)):
            return pairs
        outcome = self._possible(scan, recipe, watch)
        if outcome is None:
            return pairs
        repaired = self.prepare(scan, watch, repair=outcome.repair)
        joined: np.ndarray = repaired.faces.joined(engine.regions.barrier_faces(repaired.mesh, outcome.partition))
        return pairs[joined]

    def _possible(self, scan: Scan, recipe: rcp.Recipe, watch: Watch | None) -> Outcome | None:
        """Return the regions after the recipe, or after the steps before one that fails."""
        try:
            return self.replay(scan, recipe.without_mesh(), watch)
        except StepFailed as error:
            return error.outcome

    def known(self, scan: Scan, recipe: rcp.Recipe) -> Outcome | None:
        """Return the cached outcome of the recipe, or None. Nothing is computed."""
        keys = _keys(scan, recipe)
        done, outcome = self._outcomes.longest(keys)
        return outcome if done == len(keys) else None

    def repair_of(self, scan: Scan, recipe: rcp.Recipe):
        """Return the repair of the mesh with the regions of a recipe; if they are not cached, of its first step."""
        outcome = self.known(scan, recipe.without_mesh())
        return outcome.repair if outcome else _first_repair(recipe)

    def is_prepared(self, scan: Scan, repair=None) -> bool:
        """Return whether `prepare` of the scan is cached."""
        return self._meshes.known(scan.source, repair or engine.repairs.Repair())

    def _apply(self, step, scan, repaired, before, watch, begin, end) -> Outcome:
        started = time.perf_counter()
        if isinstance(step, rcp.Partition):
            outcome = self._partition(step, scan, repaired, before, watch, begin, end)
        elif isinstance(step, rcp.Mesh):
            outcome = apply_mesh(step, repaired, before, watch, begin, end, self.threads)
        elif isinstance(step, rcp.Texture):
            outcome = apply_texture(before)
        else:
            outcome = apply_edit(step, repaired, before, watch, begin, end)
        seconds = time.perf_counter() - started
        numbers = {"step": rcp.KINDS[type(step)], "seconds": seconds, "scan": scan.digest}
        opened = self.prepare(scan, repair=outcome.repair.opened).mesh.report
        numbers |= scan_numbers(scan, opened) | {"closed_below": outcome.repair.lengths.holes}
        mesh = self.prepare(scan, repair=outcome.repair).mesh
        numbers |= {"repairs": mesh.report["repairs"]}
        numbers |= {"kept_open": sum(opening["kept"] for opening in mesh.openings)}
        numbers |= outcome.numbers
        return replace(outcome, numbers=numbers)

    def _partition(self, step: rcp.Partition, scan, repaired, before, watch, begin, end) -> Outcome:
        own = {"backend": self.backend, "threads": self.threads}
        wanted = engine.states.split_of(step, partial(_guides, step, scan), engine.CleanOptions(), **own)
        state = before and engine.states.State(repaired, before.partition, before.made)
        state = engine.states.partitioned(wanted, scan.source, self._meshes, Stages(watch, begin, end), state)
        repaired, partition, made = state.repaired, state.partition, state.made
        names = ("rounds", "tolerance", "noise", "snapped", "distance_max", "warnings")
        numbers = {"asked": partition.proxies_asked, "expected": self._expected(repaired, partition, watch, end)} | {
            name: partition.report[name] for name in names
        }
        kept = None if made.guides.before is None else carried_colors(before, partition)
        barriers = made.guides.edges
        if barriers is not None:
            inside = engine.guided.inside_regions(repaired.mesh, partition, barriers)
            numbers |= {"barriers": len(barriers), "barriers_inside": inside}
        if wanted.options.curved and not partition.curved:
            numbers["not_round"] = engine.regions.why_not_round(repaired.mesh, partition)
        return replace(with_regions(repaired, partition, kept, numbers), made=made)

    def _expected(self, repaired, partition, watch, at: float) -> dict[str, int]:
        """Return estimated counts of polygons; empty if a component has no regions, for which Mesh raises an error."""
        args = (repaired.mesh, partition)
        try:
            return engine_call(watch, at, at, "counting polygons", engine.regions.expected_polygons, *args)
        except engine.InvalidInput:
            return {}


def _first_repair(recipe: rcp.Recipe):
    """Return the repair that a recipe's first step needs, before openings are closed for regions; None: any."""
    step = next((step for _, step in recipe.active()), None)
    return engine.states.repair_of(step, engine.CleanOptions()).opened if isinstance(step, rcp.Partition) else None


def _keys(scan: Scan, recipe: rcp.Recipe) -> list[tuple]:
    """Return the cache keys of the outcomes of the recipe's steps."""
    return [(scan.digest, scan.layers_digest, key) for key in recipe.prefix_keys()]


def scan_numbers(scan: Scan, report: dict) -> dict:
    """Return numbers of a scan. report: of its repaired mesh."""
    names = ("components", "border_loops", "closed", "diagonal", "repairs")
    return {"triangles": len(scan.triangles), "faces": scan.face_count} | {
        name: report[name] for name in names if name in report
    }


def _weights(step: rcp.Partition, scan: Scan) -> np.ndarray | None:
    """Return (faces,) the factor of each face's area. Weight 1 gives 4 times the regions of weight 0 at influence 1."""
    if not step.weights:
        return None
    if step.weights not in scan.layers:
        raise ValueError(
            said("there is no vertex group or numeric attribute '{name}' for the weights", name=step.weights)
        )
    painted = np.clip(np.nan_to_num(scan.layers[step.weights].astype(np.float64)), 0.0, 1.0)
    found: np.ndarray = 16.0 ** (step.influence * painted)
    return found


def _borders(step: rcp.Partition, scan: Scan) -> tuple[np.ndarray, ...]:
    """Return (faces,) the values of attribute, materials and face sets between which no region lies."""
    names = [rcp.MARKS[name] for name in ("materials", "face_sets") if getattr(step, name)]
    values = [scan.layers[name] for name in names if name in scan.layers]
    if step.borders:
        if step.borders not in scan.layers:
            raise ValueError(said("there is no face attribute '{name}' for the barriers", name=step.borders))
        values.append(scan.layers[step.borders])
    return tuple(values)


def _has_barriers(step: rcp.Partition) -> bool:
    return bool(step.borders) or step.angle < 180 or any(getattr(step, name) for name in rcp.MARKS)


def _guides(step: rcp.Partition, scan: Scan, repaired, job):
    """Return the barriers and weights of the step for the engine."""
    names = [rcp.MARKS[name] for name in ("seams", "sharp") if getattr(step, name)]
    cuts = [scan.layers[name] for name in names if name in scan.layers]
    marks = engine.marks.Marks(
        weights=_weights(step, scan), borders=_borders(step, scan), cuts=np.concatenate(cuts) if cuts else None
    )
    return engine.marks.guides_of(marks, step.angle if step.angle < 180 else None, repaired, job)


def joined_faces(repaired, faces: np.ndarray, start: int) -> np.ndarray:
    """Return the faces that are connected to `start` over shared edges of the engine's mesh.

    The repair may have changed edges of the user's mesh, for example flipped them. faces: in rising order.
    """
    inside = np.zeros(repaired.faces.count, bool)
    inside[faces] = True
    some = np.flatnonzero(inside[repaired.faces.mesh_face])
    beside, _ = engine.guides.shared_edges(np.asarray(repaired.mesh.triangles)[some])
    return view.connected(faces, repaired.faces.mesh_face[some[beside]], start)


def _size(outcome: Outcome, repaired) -> int:
    size = (
        outcome.face_region.nbytes
        + outcome.border.nbytes
        + 4 * len(repaired.faces.mesh_face)
        + 200 * len(outcome.region_color)
    )
    return size if outcome.polygons is None else size + 64 * len(outcome.polygons.loops)
