"""A run on a scan in tiles that may be larger than memory: each child process holds one tile at a time."""

import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from .. import PartitionOptions
from ..batch.scans import estimated_faces, needed_mb
from ..batch.table import Lock
from ..children.errors import BatchError
from ..children.process import Ending
from ..children.runner import Assignment, Children, clear, endings
from ..children.workers import Workers
from ..folders import NotOwn, Own, discard
from . import steps
from .errors import TileFailed, TilesError
from .grouped import GROUP, beside, groups_of, limit_of
from .plan import DETAIL, Plan, options_of, plan_of
from .results import deliver, write_labels
from .store import MADE, load, of_tile, publish, values_of
from .tasks import SURPLUS
from .work_folder import NAMES, PLAN, begin, damage_forgotten, key_of

TILE_FACES = 1_000_000  #: size of the tiles that a single scan is cut into
_PATCH, _PATCHES_A_REGION = 100, 6  # most faces of a patch; least mean number of patches of a region
_FIRST = (3, 3)  # most rounds before the last merging, and most sweeps of each
_FIRST_BY_DETAIL = (4, 8)  # with a tolerance
_LAST = (10, 8)  # most rounds after the last merging, and most sweeps of each
_OF_ONE_PIECE = 2.0  # its error before the last merging, as a multiple of that of tiles, which merge better patches
_LIGHT = 0.5  # share of the error that weighs borders in the first rounds with a tolerance
_FEW = 2e-5  # share of all faces: rounds end if at most this share moves


@dataclass
class State:
    """The progress of a run."""

    step: str = ""  #: name of the present step
    done: int = 0  #: tiles for which this step is done
    tiles: int = 0
    before: int = 0  #: number of steps of tiles that an earlier run did
    seconds: float = 0.0


@dataclass
class Outcome:
    """The result of a run."""

    output: Path
    report: dict[str, Any] = field(default_factory=dict)  #: the numbers; see docs/scale.md


def run(
    source: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    proxies: int | None = None,
    weld: float = 0.0,
    work: str | os.PathLike[str] | None = None,
    labels: str | os.PathLike[str] | None = None,
    children: Children | None = None,
    tile_faces: int = TILE_FACES,
    group: int = GROUP,
    options: Mapping[str, Any] | None = None,
    watch: Callable[[State], None] | None = None,
) -> Outcome:
    """Simplify one scan that is given as tiles to a polygon mesh; no polygon ends at a border of tiles.

    source: a folder of tiles in one system of coordinates (PLY, OBJ, STL, OFF, glTF, 3MF), a tileset.json of
            3D Tiles, or one scan, which is cut into tiles of about `tile_faces` faces.
    output: the polygon mesh, .obj or .ply.
    proxies: the number of regions; None: found by `options`.
    weld: largest distance at which vertices on borders of different tiles are joined; 0: only equal ones are.
    work: folder for intermediate results, on a disk that all workers share; it stays. None: a folder next to the
          output, which is removed at the end. An interrupted run continues from there.
    labels: folder for the labels: an int32 array for each tile, the region of each face of its file; -1: none.
    children: the number of tiles at once, the place of the work and the limits of each step of a tile; see
              batch.Children. None: this machine, without limits.
    group: largest number of tiles in a group. A scan of more tiles is merged by groups: no process has the whole graph.
    options: detail, tolerance, noise, snap, smooth, leave_out and seed of PartitionOptions, planar of MeshingOptions.
    watch: called after each step of a tile, and several times a second, with the name of the `step`, the tiles
           `done` of all `tiles`, and `seconds`.

    Returns `output` and `report`, the numbers that docs/scale.md describes.

    The result is the same, bit for bit, for any number of workers and after any number of interrupted runs.
    Raises TilesError (wrong usage) or TileFailed (a tile can't be read, too little memory). KeyboardInterrupt passes
    through.
    """
    plan = plan_of(
        Path(source),
        Path(output),
        work,
        options_of(options, proxies, weld) | {"group": group},
        tile_faces,
    )
    target = None if labels is None else _label_folder(Path(labels), plan)
    own = Own(plan.work, NAMES)
    try:
        children = children or Children()
        own.take(unmarked=work is None or key_of(plan.work) is not None)
        with Lock(plan.work) as lock:
            own.take(unmarked=True)  # a run that has just ended may have removed the mark
            before = begin(plan, own)
            parts, tasks = plan.work / "parts", f"{__package__}.tasks:run"
            clear(parts)
            with damage_forgotten(plan.work), children.workers(parts, tasks, 1) as workers:
                outcome = _Run(plan, workers, watch, before, target is not None).run()
            if target is not None:
                outcome.report["labels"] = write_labels(plan, target)
            deliver(plan)
            if work is None:
                own.clear(PLAN)
                lock.remove()
    except (BatchError, NotOwn) as error:
        raise TilesError(str(error).replace("OUTPUT_FOLDER", "the work folder")) from None
    if work is None:
        own.remove()
    return outcome


def _label_folder(folder: Path, plan: Plan) -> Path:
    if folder.exists() and not folder.is_dir():
        raise TilesError(f"{folder}: is a file; the labels need a folder, with a file for each tile")
    return folder


class _Run:
    """Runs the steps in their order, and skips steps that are done."""

    def __init__(
        self, plan: Plan, workers: Workers, watch: Callable[[State], None] | None, before: int, labels: bool
    ) -> None:
        self._plan, self._workers, self._labels = plan, workers, labels
        self._watch = watch or (lambda state: None)
        self._state = State(before=before)
        self._begun = time.monotonic()
        self._faces: list[int] = [estimated_faces(path) for _, path in plan.inputs]
        self._sizes = [path.stat().st_size for _, path in plan.inputs]
        self._tolerance: float | None = None  # scene units; None: the number of regions is given
        self._noise = 0.0
        self._groups: list[list[int]] = []  # tiles of each group; empty if there are few tiles
        self._beside: list[list[int]] = []
        self._peaks: dict[str, float] = {}
        self._seconds: dict[str, float] = {}

    def run(self) -> Outcome:
        plan, options = self._plan, self._plan.options
        self._prepared()
        present = [k for k, count in enumerate(self._faces) if count]
        whole = self._faces
        self._one("mend", {"weld": options["weld"], "diagonal": self._diagonal}, sum(whole) // 50)
        smooth = options.get("smooth", PartitionOptions().smooth)
        self._map("patches", present, self._fineness() | {"smooth": smooth})
        for k in present:  # `mend` may have added vertices on borders, or welded all faces of a tile away
            self._faces[k] = values_of(of_tile(plan.work, "patches", k))["faces"]
        present = [k for k in present if self._faces[k]]
        leave_out = options.get("leave_out", PartitionOptions().leave_out)
        patches = sum(values_of(of_tile(plan.work, "patches", k))["patches"] for k in present)
        left = self._gather(present, patches)
        merging = {"present": present, "groups": len(self._groups), "wanted": self._wanted(), "leave_out": leave_out}
        join = self._one("join", merging, 4 * left)
        if not join["area"] > 0:
            raise TileFailed("no tile has a face with an area")
        self._map("halo", present, {}, self._places(present, join["near"]))
        regions = join["wanted"]
        shared = {"area": join["area"], "faces": sum(whole), "regions": regions}
        light, price, weight = self._borders(smooth, join["area"])
        first = _FIRST if self._tolerance is None else _FIRST_BY_DETAIL
        labels, sums = self._rounds("first", present, ("halo", "join"), first, shared | light)
        self._map("touch", present, {"before": labels, "groups": len(self._groups)})
        merging = {
            "present": present,
            "groups": len(self._groups),
            "sums": sums,
            "area": join["area"],
            "target": regions,
            "cost": join["cost"],
        } | price
        if self._groups:
            share = {"share": regions / join["regions"]}
            faces = {k: 40 * join["regions"] // len(self._groups) for k in range(len(self._groups))}
            self._of_groups("regroup", merging | share, faces)
        merged = self._one("merge", merging, 40 * join["regions"])
        labels, sums = self._rounds("last", present, (labels, "merge"), _LAST, shared | weight, relabel="merge")
        self._map("thin", present, {"before": labels, "labels": self._labels})
        last = self._last(present)
        return Outcome(plan.output, self._report(join, merged, last, sums, present))

    def _gather(self, present: list[int], patches: int) -> int:
        """Merge inside groups of tiles, if there are many tiles; returns the number of patches that are left."""
        if len(present) <= self._plan.options["group"]:
            return patches
        work = self._plan.work
        found = [values_of(of_tile(work, "prepare", k)) for k in present]
        low, high = (np.array([values[name] for values in found]) for name in ("low", "high"))
        places = groups_of((low + high) / 2, self._plan.options["group"])
        off = 2 * self._plan.options["weld"] + 1e-6 * self._diagonal  # `mend` may have moved vertices on borders
        near = [beside(low, high, own, off) for own in places]
        self._groups = [[present[i] for i in own] for own in places]
        self._beside = [[present[i] for i in own] for own in near]
        wanted, count = self._wanted(), len(self._groups)
        limit = limit_of(wanted)
        target = int(SURPLUS * wanted.get("proxies", 0))
        shared = {"share": target / patches, "limit": limit}
        size = {
            g: 4 * sum(values_of(of_tile(work, "patches", k))["patches"] for k in own)
            for g, own in enumerate(self._groups)
        }
        self._of_groups("group", shared, size)
        if limit is None:
            self._one("level", {"groups": count, "nodes": patches, "target": target}, patches)
        self._of_groups("cut", {} if limit is None else {"limit": limit}, size)
        return sum(values_of(of_tile(work, "cut", g))["patches"] for g in range(count))

    def _of_groups(self, step: str, task: dict[str, Any], faces: dict[int, int]) -> None:
        """Run a step for each group of tiles."""
        own = {g: {"own": self._groups[g], "beside": self._beside[g]} for g in range(len(self._groups))}
        self._each(step, list(own), {"step": step} | task, own, lambda g: needed_mb(faces[g], 0))

    def _places(self, present: list[int], near: dict[str, list[int]]) -> dict[int, dict[str, Any]]:
        """Return for each tile where the regions of its patches are stored, and its neighbours."""
        first = load(of_tile(self._plan.work, "join", 0), "first").tolist()
        if not self._groups:
            return {k: {"first": first[i], "near": near[str(k)]} for i, k in enumerate(present)}
        own: dict[int, dict[str, Any]] = {}
        for g, tiles in enumerate(self._groups):
            at = load(of_tile(self._plan.work, "group", g), "first").tolist()
            own |= {k: {"first": first[g], "group": g, "at": at[i], "near": near[str(k)]} for i, k in enumerate(tiles)}
        return own

    def _fineness(self) -> dict[str, Any]:
        """Return the options that set the size of patches."""
        if self._tolerance is not None:
            return {"tolerance": self._tolerance, "noise": self._noise}
        return {"size": max(1, min(_PATCH, sum(self._faces) // (_PATCHES_A_REGION * self._plan.options["proxies"])))}

    def _borders(self, smooth: float, area: float) -> tuple[dict[str, float], dict[str, float], dict[str, float]]:
        """Return the weights of borders in the first rounds, the last merging and the last rounds, as for one piece.

        One piece weighs borders by the error of its regions before the last merging. With a tolerance, their weight is
        low in the first rounds, and merging depends on the error alone.
        """
        error = steps.error_of(load(of_tile(self._plan.work, "join", 0), "sums")) / area
        if self._tolerance is None:
            each = {"smooth": smooth, "error": _OF_ONE_PIECE * error}
            return each, each, each
        plain = {"smooth": 0.0, "error": _LIGHT * error}
        return plain, plain, {"smooth": smooth, "error": error}

    def _wanted(self) -> dict[str, Any]:
        """Return the options that set the number of regions."""
        options = self._plan.options
        if self._tolerance is None:
            return {"proxies": options["proxies"]}
        snap = options.get("snap", PartitionOptions().snap)
        return {"tolerance": self._tolerance, "noise": self._noise, "snap": snap}

    def _measure(self, found: list[dict[str, Any]]) -> None:
        """Set the tolerance (scene units, from the size of the scan) and the noise, from the tiles that have faces."""
        options = self._plan.options
        size, noise = steps.size_and_noise([steps.Extent(**each["extent"]) for each in found if each["faces"]])
        self._tolerance = options.get("tolerance", options.get("detail", DETAIL) * (size or self._diagonal))
        self._noise = options["noise"] if options.get("noise") is not None else noise

    def _prepared(self) -> None:
        plan, measured = self._plan, {"measured": "proxies" not in self._plan.options}
        if plan.is_single:
            task = {"input": str(plan.inputs[0][1]), "tile_faces": plan.options["tile_faces"]}
            tiles = self._one("split", task, 0, self._sizes[0] / 2**20)["tiles"]
            if not tiles:
                raise TileFailed(f"{plan.inputs[0][1]}: has no faces")
            self._faces = [-(-self._faces[0] // tiles)] * tiles
            self._sizes = [36 * self._faces[0]] * tiles
            self._map("prepare", list(range(tiles)), measured)
        else:
            names: dict[int, dict[str, Any]] = {}
            for k, (_, path) in enumerate(plan.inputs):
                names[k] = {"input": str(path)}
            for k, leaf in enumerate(plan.leaves):
                names[k] |= {"place": leaf.place, "up": leaf.up}
            self._map("prepare", list(names), measured, names)
        found = [values_of(of_tile(plan.work, "prepare", k)) for k in range(len(self._faces))]
        self._faces = [values["faces"] for values in found]
        self._file_faces = sum(values["file_faces"] for values in found)
        self._sizes = [0] * len(found)
        self._repairs: dict[str, int] = {}
        for values in found:
            for name, count in values["repairs"].items():
                self._repairs[name] = self._repairs.get(name, 0) + count
        boxes = [(values["low"], values["high"]) for values in found if values["faces"]]
        low, high = np.min([b[0] for b in boxes] or [[0.0]], 0), np.max([b[1] for b in boxes] or [[0.0]], 0)
        self._diagonal = float(np.linalg.norm(high - low))
        self._check_faces(self._faces)
        if "proxies" not in plan.options:
            self._measure(found)

    def _check_faces(self, faces: Sequence[int]) -> None:
        proxies = self._plan.options.get("proxies", 1)
        if not sum(faces):
            raise TileFailed("no tile has a face that can be used")
        if proxies > sum(faces):
            raise TilesError(f"{proxies:,} regions of {sum(faces):,} faces can't be made")

    def _rounds(
        self,
        name: str,
        present: list[int],
        begin: tuple[str, str],
        extent: tuple[int, int],
        shared: dict[str, Any],
        relabel: str | None = None,
    ) -> tuple[str, str]:
        """Relax until few faces move; returns the names of the steps with the labels and the sums."""
        labels, sums = begin
        for number in range(extent[0]):
            step, added = f"{name}-{number:02d}", f"{name}-{number:02d}-sums"
            if number + 1 < extent[0] and (self._plan.work / f"{name}-{number + 1:02d}-sums").exists():
                labels, sums = step, added  # done, and its labels may be removed already
                continue
            task = {"step": "relax", "before": labels, "sums": sums, "round": number + 100 * len(name)}
            task["whole"] = shared | {"sweeps": extent[1]}
            if relabel is not None and number == 0:
                task["relabel"] = relabel
            self._map(step, present, task)
            self._one(added, {"step": "sum", "present": present, "after": step, "sums": sums}, 0)
            if number > 0:
                discard(self._plan.work / labels)
            labels, sums = step, added
            moves = sum(values_of(of_tile(self._plan.work, step, k))["moves"] for k in present)
            if moves <= _FEW * shared["faces"]:
                break
        return labels, sums

    def _last(self, present: list[int]) -> dict[str, Any]:
        options, name = self._plan.options, f"result{self._plan.output.suffix.lower()}"
        thinned = {k: values_of(of_tile(self._plan.work, "thin", k))["faces"] for k in present}
        # Rims follow the border: how ragged it is, no group of tiles knows of the whole.
        meshing = {"planar": options.get("planar", False), "straight_rims": 0, "threads": 0}
        task = {"present": present, "output": name, "meshing": meshing, "threads": 0}
        return self._one("mesh", task, 3 * sum(thinned.values()))

    def _one(self, step: str, task: dict[str, Any], faces: int, mb: float = 0.0) -> dict[str, Any]:
        """Run a step for all tiles together."""
        self._each(step, [0], {"step": step} | task, {}, lambda tile: needed_mb(faces, 0) + mb)
        return values_of(of_tile(self._plan.work, step, 0))

    def _map(
        self, step: str, tiles: list[int], task: dict[str, Any], own: Mapping[int, dict[str, Any]] | None = None
    ) -> None:
        """Run a step for each of some tiles."""
        need = lambda tile: needed_mb(self._faces[tile], self._sizes[tile])  # noqa: E731
        self._each(step, tiles, {"step": step} | task, own or {}, need)

    def _each(
        self,
        step: str,
        tiles: list[int],
        task: dict[str, Any],
        own: Mapping[int, dict[str, Any]],
        need: Callable[[int], float],
    ) -> None:
        work = self._plan.work
        waiting = [k for k in sorted(tiles) if not (of_tile(work, step, k) / "values.json").exists()]
        shared = task | {"tiles": len(self._faces), "work": str(work)}
        self._state.step, self._state.tiles, self._state.done = task["step"], len(tiles), len(tiles) - len(waiting)
        begun = time.monotonic()
        self._tell()

        def assignment(tile: int) -> Assignment[int]:
            return Assignment(tile, need(tile), lambda threads: shared | own.get(tile, {}) | {"tile": tile})

        for tile, folder, ending in endings(self._workers, map(assignment, waiting), lambda running: self._tell()):
            self._keep(step, tile, folder, ending)
        self._seconds[task["step"]] = self._seconds.get(task["step"], 0.0) + time.monotonic() - begun

    def _keep(self, step: str, tile: int, folder: Path | None, ending: Ending) -> None:
        if folder is None or ending.why:
            before = f"{self._name(step, tile)}: "
            raise TileFailed(before + ending.why.removeprefix(before))
        if ending.peak_mb is not None:
            name = self._state.step
            self._peaks[name] = max(self._peaks.get(name, 0.0), ending.peak_mb)
        publish(folder / MADE, of_tile(self._plan.work, step, tile))
        self._state.done += 1

    def _name(self, step: str, tile: int) -> str:
        if step == "prepare" and not self._plan.is_single:
            return str(self._plan.inputs[tile][1])
        if step in ("split", "prepare"):
            return str(self._plan.inputs[0][1])
        return f"{step} of tile {tile}"

    def _tell(self) -> None:
        self._state.seconds = time.monotonic() - self._begun
        self._watch(self._state)

    def _report(
        self, join: dict[str, Any], merged: dict[str, Any], last: dict[str, Any], sums: str, present: list[int]
    ) -> dict[str, Any]:
        work, mend = self._plan.work, values_of(of_tile(self._plan.work, "mend", 0))
        edges = join["border_edges"]
        return {
            "tiles": len(self._faces),
            "file_faces": self._file_faces,
            "faces": sum(self._faces),
            "largest_tile": max(self._faces),
            "repair": self._repairs,
            "options": self._plan.options,
            "regions": merged["regions"],
            "regions_needed": join["needed"],
            "tolerance": self._tolerance,
            "noise": None if self._tolerance is None else self._noise,
            "snapped": join["snapped"],
            "error": steps.error_of(load(of_tile(work, sums, 0), "sums")),
            "border_length": sum(values_of(of_tile(work, "thin", k))["borders"] for k in present),
            "parts_left_out": join["left_out"],
            "area_left_out": join["area_left_out"],
            "border_edges": edges,
            "unmatched_edges": edges - join["matched_edges"],
            "unmatched_share": (edges - join["matched_edges"]) / edges if edges else 0.0,
            "welded_vertices": mend["welded"],
            "t_junctions": mend["t_junctions"],
            "patches": join["patches"],
            "groups": len(self._groups),
            "regions_joined": merged["joined"],
            "graph_bytes": join["graph_bytes"],
            "thinned_faces": last["thinned_faces"],
            "diagonal": last["diagonal"],
            "output": {"path": str(self._plan.output)} | last["output"],
            "peak_mb": self._peaks,
            "seconds": {name: round(seconds, 3) for name, seconds in self._seconds.items()},
        }
