"""Replays a recipe on arrays and returns arrays. Earlier results are cached."""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from . import recipe as rcp
from .applying import (
    NEARER,
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
from .cache import Cache
from .engine import ENGINE_PROBLEM, engine
from .language import said
from .outcome import Outcome, StepFailed
from .prepared import (
    NONE_CLOSED,
    Closing,
    Prepared,
    prepared_of,
    scan_numbers,
)
from .scan import Scan
from .task import Watch, shares

__all__ = ["ENGINE_PROBLEM", "Outcome", "Scan", "Session", "Shown", "StepFailed", "backends", "defects", "engine"]


def backends() -> list[str]:
    """Return the available back ends of parallel methods: "cpu", and "cuda" if a device is present."""
    return engine.backends() if engine else []


def with_places(scan: Scan, recipe: rcp.Recipe) -> rcp.Recipe:
    """Return the recipe with the places of the faces that it names, for other versions of the scan."""
    found = engine.replay.places_of(recipe, scan.surface)
    return recipe if found is None else replace(recipe, places=rcp.Places(*found))


def placed(scan: Scan, recipe: rcp.Recipe) -> tuple[rcp.Recipe, int]:
    """Return the recipe with the faces at its places, and how many steps are switched off, as they have none."""
    found, lost = engine.replay.placed(recipe, scan.surface)
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


class Session:
    """Replays recipes on scans. Only one thread at a time may use a session."""

    def __init__(self, budget: int = 1 << 30, backend: str = "cpu", threads: int = 0):
        # Neither changes the result:
        self.backend = backend  #: one of backends(), for parallel methods
        self.threads = threads  #: number of threads; 0: one for each core
        self._meshes = Cache(budget, least=2)  # for one scan: the mesh with open and the one with closed openings
        self._outcomes = Cache(budget)
        self._parts = Cache(0)  # the last part only
        self._fits: tuple = (None, ())  # the last partition and its fits
        self._textures = Cache(0)  # the last texture by scan, whose unchanged parts are reused

    def replay(self, scan: Scan, recipe: rcp.Recipe, watch: Watch | None = None) -> Outcome:
        """Return the outcome of the recipe on the scan.

        Raises StepFailed (which carries the last good outcome), ValueError (the scan itself can't be used) or Stopped.
        """
        watch = watch or Watch()
        steps, keys = recipe.active(), _keys(scan, recipe)
        done, outcome = self._longest_known(keys)
        if done < len(steps):
            closing = outcome.closing if outcome else NONE_CLOSED
            times = [0.0 if self._meshes.get((scan.digest, closing)) else PREPARING]
            ends = shares(times + [TIMES.get(type(step), 1.0) for _, step in steps[done:]])
            prepared = replace(self.prepare(scan, watch, 0.0, ends[0], closing), layers=scan.layers)
        for number in range(done, len(steps)):
            index, step = steps[number]
            begin, end = ends[number - done : number - done + 2]
            try:
                outcome = self._apply(step, prepared, outcome, watch, begin, end)
                prepared = replace(self._prepared(scan, outcome), layers=scan.layers)
            except engine.InvalidInput as error:
                raise StepFailed(index, step, prepared.faces.named(str(error)), outcome) from error
            except (ValueError, RuntimeError) as error:  # a device may run out of memory, for example
                raise StepFailed(index, step, str(error), outcome) from error
            self._outcomes.put(keys[number], outcome, _size(outcome, prepared))
        if outcome is None:
            raise ValueError(said("The recipe has no active step: press Partition"))
        return outcome

    def prepare(
        self,
        scan: Scan,
        watch: Watch | None = None,
        begin: float = 0.0,
        end: float = 1.0,
        closing: Closing = NONE_CLOSED,
    ) -> Prepared:
        """Checks and repairs the scan. Raises ValueError if it has no usable face."""
        key = (scan.digest, closing)
        prepared = self._meshes.get(key)
        if prepared is None:
            opened = closing.opened
            plain = None if closing == opened else self.prepare(scan, watch, begin, begin, opened).mesh
            prepared = _prepare(scan, plain, closing, watch or Watch(), begin, end)
            # Adjacency, normals and other data of the engine: about 300 bytes for each face.
            self._meshes.put(key, prepared, 300 * len(scan.triangles))
        return prepared

    def is_scanned(self, scan: Scan) -> bool:
        """Return whether the scan has noise, which drawn models do not have. Raises ValueError as `prepare`."""
        return not engine.nearer.is_drawn(self.prepare(scan).mesh)

    def _prepared(self, scan: Scan, outcome: Outcome, watch: Watch | None = None) -> Prepared:
        """Return the repaired scan that an outcome's partition belongs to."""
        return self.prepare(scan, watch, closing=outcome.closing)

    def openings(self, scan: Scan, outcome: Outcome) -> list[dict]:
        """Return the openings that were closed before the partition or kept open: `engine.Mesh.openings`."""
        found: list[dict] = self._prepared(scan, outcome).mesh.openings
        return found

    def triangulate(self, polygons) -> tuple[np.ndarray, np.ndarray]:
        """Return (T, 3) vertices and (T,) polygon of triangles that fill the polygons of an outcome."""
        args = (np.asarray(polygons.vertices), np.asarray(polygons.loops), np.asarray(polygons.loop_start))
        triangles, polygon = engine.triangulate(*args)
        return np.asarray(triangles), np.asarray(polygon)

    def texture(self, scan: Scan, outcome: Outcome, shown: Shown, step: rcp.Texture, watch: Watch | None = None):
        """Return UVs and images of an outcome's polygons; see `engine.texture`. Raises ValueError or Stopped.

        Charts keep their places in the last texture of the scan, and only charts changed by an edit are baked again.
        """
        watch = watch or Watch()
        mesh = self._prepared(scan, outcome, watch).mesh
        layers = {
            name: engine.TextureLayer(images, strength=shown.strength if name == "emission" else 1.0)
            for name, images in shown.layers.items()
        }
        arrays = (scan.vertices, scan.triangles, shown.uv, shown.material, shown.images)
        soup = engine.TexturedSoup(*arrays, names=shown.names, layers=layers)
        options = engine.TextureOptions(**rcp.engine_options(step, rcp.TEXTURE), threads=self.threads)
        args = (mesh, outcome.partition, outcome.polygons, soup, options)
        make = partial(engine.texture, previous=self._textures.get(scan.digest))
        made = engine_call(watch, 0.0, 1.0, "making the texture", make, *args)
        self._textures.put(scan.digest, made, 1)
        return made

    def corner_sources(self, scan: Scan, outcome: Outcome, uv=None) -> tuple[np.ndarray, np.ndarray]:
        """Return (L,) triangle of the scan and (L, 3) weights of its corners, for each corner of an outcome's polygons.

        uv: (T, 3, 2) a UV map to transfer: each polygon then uses points of one island only.
        """
        islands = None if uv is None else engine.uv_islands(scan.triangles, uv)
        mesh = self._prepared(scan, outcome).mesh
        args = (mesh, outcome.partition, outcome.polygons, scan.vertices, scan.triangles)
        triangle, weights = engine.corner_sources(*args, islands=islands, threads=self.threads)
        return np.asarray(triangle), np.asarray(weights)

    def region_at(self, scan: Scan, outcome: Outcome, face: int) -> dict:
        """Return `engine.region_statistics` of the region of one of the user's faces.

        Raises ValueError if there is no such face, or it is in no region. Cost: linear in the size of the region.
        """
        prepared = self._prepared(scan, outcome)
        return engine.region_statistics(prepared.mesh, outcome.partition, prepared.faces.triangle_at(face))

    def region_fits(self, scan: Scan, outcome: Outcome) -> tuple:
        """Return `engine.region_fits` of an outcome; cached for the last one."""
        if self._fits[0] is not outcome.partition:
            self._fits = outcome.partition, engine.region_fits(self._prepared(scan, outcome).mesh, outcome.partition)
        return self._fits[1]

    def locked_regions(self, scan: Scan, recipe: rcp.Recipe, watch: Watch | None = None) -> np.ndarray:
        """Return the numbers of the regions that are locked after the recipe. Raises ValueError or Stopped."""
        if not any(isinstance(step, (rcp.LockRegions, rcp.PaintFaces)) for _, step in recipe.active()):
            return np.empty(0, np.int64)
        try:
            outcome = self.replay(scan, recipe.without_mesh(), watch)
        except StepFailed as error:
            outcome = error.outcome
        return np.empty(0, np.int64) if outcome is None else np.flatnonzero(outcome.partition.region_locked)

    def known(self, scan: Scan, recipe: rcp.Recipe) -> Outcome | None:
        """Return the cached outcome of the recipe, or None. Nothing is computed."""
        keys = _keys(scan, recipe)
        done, outcome = self._longest_known(keys)
        return outcome if done == len(keys) else None

    def is_prepared(self, scan: Scan) -> bool:
        """Return whether `prepare` of the scan is cached."""
        return self._meshes.get((scan.digest, NONE_CLOSED)) is not None

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
            outcome = apply_mesh(step, prepared, before, watch, begin, end, self.threads)
        elif isinstance(step, rcp.Texture):
            outcome = apply_texture(before)
        else:
            outcome = apply_edit(step, prepared, before, watch, begin, end)
        seconds = time.perf_counter() - started
        numbers = {"step": rcp.KINDS[type(step)], "seconds": seconds, "scan": prepared.scan.digest}
        numbers |= scan_numbers(self.prepare(prepared.scan)) | {"closed_below": outcome.closing.holes}
        mesh = self._prepared(prepared.scan, outcome).mesh
        numbers |= {"repairs": mesh.report["repairs"]}
        numbers |= {"kept_open": sum(opening["kept"] for opening in mesh.openings)}
        numbers |= outcome.numbers
        return replace(outcome, numbers=numbers)

    def _partition(self, step: rcp.Partition, prepared, before, watch, begin, end) -> Outcome:
        own = engine.recipes.partition_options(step)
        options = engine.PartitionOptions(**own, backend=self.backend, threads=self.threads)
        locked = before is not None and before.partition.region_locked.any()
        may_close = not (locked or step.faces)  # regions that stay belong to the mesh before a new closing
        closes = may_close and step.close_openings and step.count_by != "bound"
        meshes = _Meshes(self, step, prepared, watch, (begin, end)) if may_close else _Mesh(prepared)

        def guided(mesh, job):
            guides = _guides(step, meshes.prepared, before)
            return guides, self._part(meshes.prepared, guides, options)

        partition, made = engine.pipeline.split(meshes, options, closes, Stages(watch, begin, end), guided)
        prepared, guides = meshes.prepared, made.guides
        names = ("rounds", "tolerance", "noise", "snapped", "distance_max", "warnings")
        numbers = {"asked": partition.proxies_asked, "expected": self._expected(prepared, partition, watch, end)} | {
            name: partition.report[name] for name in names
        }
        if step.symmetry != "none" and partition.symmetry is None:
            numbers["symmetry"] = "none"
        kept = None if before is None or guides.before is None else carried_colors(before, partition)
        barriers = guides.arrays()["barriers"]
        if barriers is not None:
            inside = engine.guided.inside_regions(prepared.mesh, partition, barriers)
            numbers |= {"barriers": len(barriers), "barriers_inside": inside}
        args = (prepared.mesh, partition, made)
        nearer = engine_call(watch, end, end, "measuring", engine.nearer.nearer_by_bound, *args)
        if nearer is not None:
            numbers |= dict(zip(NEARER, (nearer.bound, nearer.regions, nearer.times), strict=True))
        return replace(with_regions(prepared, partition, kept, numbers), made=made)

    def _expected(self, prepared: Prepared, partition, watch, at: float) -> dict[str, int]:
        """Return estimated counts of polygons; empty if a component has no regions, for which Mesh raises an error."""
        args = (prepared.mesh, partition)
        try:
            return engine_call(watch, at, at, "counting polygons", engine.expected_polygons, *args)
        except engine.InvalidInput:
            return {}

    def _part(self, prepared: Prepared, guides, options):
        """Return the part of the mesh to split, or None for all of it. It is cached for other numbers of regions."""
        faces = engine.guided.open_faces(prepared.mesh, guides, options.leave_out, options.proxies)
        if faces is None:
            return None
        key = (prepared.scan.digest, prepared.closing, faces.tobytes())
        if self._parts.get(key) is None:
            self._parts.put(key, engine.guided.part_of(prepared.mesh, faces), 1)
        return self._parts.get(key)


@dataclass
class _Mesh:
    """The mesh of regions that stay, for `engine.pipeline.split`."""

    prepared: Prepared

    def opened(self):
        return self.prepared.mesh


class _Meshes:
    """The cached meshes of a scan, for `engine.pipeline.split`."""

    def __init__(self, session: Session, step: rcp.Partition, prepared: Prepared, watch: Watch, span: tuple):
        self._session, self._watch, self._span = session, watch, span
        self._opened, self._kept = Closing(**rcp.engine_options(step, rcp.CLEAN)), step.keep_openings
        self.prepared = prepared

    def opened(self):
        return self._prepare(self._opened)

    def closed(self, lengths):
        return self._prepare(self._opened.up_to(lengths, self._kept))

    def _prepare(self, closing: Closing):
        found = self._session.prepare(self.prepared.scan, self._watch, *self._span, closing)
        self.prepared = replace(found, layers=self.prepared.layers)
        return found.mesh


def _keys(scan: Scan, recipe: rcp.Recipe) -> list[tuple]:
    """Return the cache keys of the outcomes of the recipe's steps."""
    return [(scan.digest, scan.layers_digest, key) for key in recipe.prefix_keys()]


def _prepare(scan: Scan, plain, closing: Closing, watch: Watch, begin: float, end: float) -> Prepared:
    """Return the repaired scan. plain: its mesh with open openings, None if none are to be closed."""
    if len(scan.triangles) == 0:
        raise ValueError(said("The mesh has no faces: there is nothing to simplify"))
    middle = begin + 0.4 * (end - begin)
    options = engine.CleanOptions(
        cut_handles=closing.handles,
        fill_holes=closing.holes,
        fill_flat_holes=closing.flat_holes,
        stitch=closing.stitch,
        grid=closing.grid,
    )
    if plain is None:
        args = (engine.clean, scan.vertices, scan.triangles, options)
    else:
        keep = np.array(closing.kept, np.float64).reshape(-1, 3)
        args = (partial(engine.close_openings, keep=keep, left_out=closing.left_out), plain, options)
    mesh = engine_call(watch, begin, middle, "reading the mesh", *args)
    with watch.part("reading the mesh", middle, end):
        return prepared_of(scan, mesh, closing)


def _weights(step: rcp.Partition, prepared: Prepared) -> np.ndarray | None:
    """Return (F',) the factor of each face's area. Weight 1 gives four times the regions of weight 0 at influence 1."""
    if not step.weights:
        return None
    if step.weights not in prepared.layers:
        raise ValueError(
            said("there is no vertex group or numeric attribute '{name}' for the weights", name=step.weights)
        )
    painted = np.clip(np.nan_to_num(prepared.layers[step.weights].astype(np.float64)), 0.0, 1.0)
    return 16.0 ** (step.influence * painted[prepared.mesh_face])


def _barriers(step: rcp.Partition, prepared: Prepared) -> list[np.ndarray]:
    """Return edges that no region crosses, by attributes, materials and angle of the step."""
    guides, mesh, found = engine.guides, prepared.mesh, []
    values = [prepared.layers.get(rcp.MARKS[name]) for name in ("materials", "face_sets") if getattr(step, name)]
    if step.borders:
        if step.borders not in prepared.layers:
            raise ValueError(said("there is no face attribute '{name}' for the barriers", name=step.borders))
        values.append(prepared.layers[step.borders])
    of_faces = (each[prepared.mesh_face] for each in values if each is not None)
    found.extend(guides.attribute_borders(mesh, each) for each in of_faces)
    if step.angle < 180:
        found.append(guides.sharp_edges(mesh, np.radians(step.angle)))
    return found


def _guides(step: rcp.Partition, prepared: Prepared, before: Outcome | None):
    """Return the barriers, weights and locks of the step for the engine."""
    marked = [prepared.layers.get(rcp.MARKS[name]) for name in ("seams", "sharp") if getattr(step, name)]
    cuts = [engine.guides.marked_edges(prepared.mesh, edges) for edges in marked if edges is not None]
    barriers = _barriers(step, prepared)
    locked = before is not None and before.partition.region_locked.any()
    return engine.guided.Guides(
        weights=_weights(step, prepared),
        barriers=np.concatenate(barriers) if barriers else None,
        cuts=np.concatenate(cuts) if cuts else None,
        faces=prepared.faces.triangles_at(step.faces) if step.faces else None,
        before=before.partition if before is not None and (locked or step.faces) else None,
    )


def _size(outcome: Outcome, prepared: Prepared) -> int:
    size = (
        outcome.face_region.nbytes
        + outcome.border.nbytes
        + 4 * len(prepared.mesh_face)
        + 200 * len(outcome.region_color)
    )
    return size if outcome.polygons is None else size + 64 * len(outcome.polygons.loops)
