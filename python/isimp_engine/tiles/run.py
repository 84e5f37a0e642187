"""A run on a scan in tiles that may be larger than memory: each child process holds one tile at a time."""

import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..batch.scans import estimated_faces, needed_mb
from ..batch.table import Lock
from ..children.errors import BatchError
from ..children.process import Ending
from ..children.runner import Assignment, Children, clear, endings
from ..children.workers import Workers
from ..folders import NotOwn, Own
from .errors import TileFailed, TilesError
from .plan import PARTITION, Plan, options_of, plan_of
from .results import deliver, write_labels
from .store import MADE, of_tile, publish, values_of
from .work_folder import NAMES, PLAN, begin, damage_forgotten, key_of

TILE_FACES = 1_000_000  #: size of the tiles that a single scan is cut into
_SHARE = 1 / 8  # share of the faces that thinning leaves
_FEW, _OF_A_REGION = 1_000_000, 40  # but at least as many faces, and as many a region


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
    options: detail, tolerance, noise, snap, metric, smooth, leave_out and seed of PartitionOptions, planar of
             MeshingOptions.
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
        options_of(options, proxies, weld),
        tile_faces,
    )
    target = None if labels is None else _label_folder(Path(labels))
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
                outcome = _Run(plan, workers, watch, before).run()
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


def _label_folder(folder: Path) -> Path:
    if folder.exists() and not folder.is_dir():
        raise TilesError(f"{folder}: is a file; the labels need a folder, with a file for each tile")
    return folder


class _Run:
    """Runs the steps in their order, and skips steps that are done."""

    def __init__(self, plan: Plan, workers: Workers, watch: Callable[[State], None] | None, before: int) -> None:
        self._plan, self._workers = plan, workers
        self._watch = watch or (lambda state: None)
        self._state = State(before=before)
        self._begun = time.monotonic()
        self._faces: list[int] = [estimated_faces(path) for _, path in plan.inputs]
        self._sizes = [path.stat().st_size for _, path in plan.inputs]
        self._peaks: dict[str, float] = {}
        self._seconds: dict[str, float] = {}

    def run(self) -> Outcome:
        plan, options = self._plan, self._plan.options
        noise = self._prepared()
        present = [k for k, count in enumerate(self._faces) if count]
        whole = sum(self._faces)
        self._one("mend", {"weld": options["weld"], "diagonal": self._diagonal}, whole // 50)
        few = max(_FEW, _OF_A_REGION * options.get("proxies", 0))
        self._map("thin", present, {"share": min(1.0, max(_SHARE, few / whole))})
        for k in present:  # `mend` may have added vertices on borders, or welded all faces of a tile away
            self._faces[k] = values_of(of_tile(plan.work, "thin", k))["faces"]
        present = [k for k in present if self._faces[k]]
        if not present:
            raise TileFailed("no tile has a face with an area")
        given = {name: options[name] for name in PARTITION if name in options} | noise
        # Rims follow the border of the scan: how ragged it is, is not known where tiles do not fit.
        meshing = {"planar": options.get("planar", False), "straight_rims": 0}
        task = {"present": present, "partition": given, "meshing": meshing, "threads": 0}
        task["output"] = f"result{plan.output.suffix.lower()}"
        left = sum(values_of(of_tile(plan.work, "thin", k))["thinned_faces"] for k in present)
        return Outcome(plan.output, self._report(self._one("mesh", task, left)))

    def _prepared(self) -> dict[str, float]:
        """Cut the scan into tiles if it is one file, and prepare them; returns the noise if it counts."""
        plan, options = self._plan, self._plan.options
        measured = {"measured": "proxies" not in options and options.get("noise") is None}
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
        return {"noise": _median([each for each in found if each["faces"]])} if measured["measured"] else {}

    def _check_faces(self, faces: Sequence[int]) -> None:
        proxies = self._plan.options.get("proxies", 1)
        if not sum(faces):
            raise TileFailed("no tile has a face that can be used")
        if proxies > sum(faces):
            raise TilesError(f"{proxies:,} regions of {sum(faces):,} faces can't be made")

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

    def _report(self, last: dict[str, Any]) -> dict[str, Any]:
        mend = values_of(of_tile(self._plan.work, "mend", 0))
        edges = last["border_edges"]
        return {
            "tiles": len(self._faces),
            "file_faces": self._file_faces,
            "faces": sum(self._faces),
            "largest_tile": max(self._faces),
            "repair": self._repairs,
            "options": self._plan.options,
            "regions": last["regions"],
            "tolerance": last["tolerance"],
            "noise": last["noise"],
            "snapped": last["snapped"],
            "error": last["error"],
            "parts_left_out": last["parts_left_out"],
            "area_left_out": last["area_left_out"],
            "border_edges": edges,
            "unmatched_edges": edges - last["matched_edges"],
            "unmatched_share": (edges - last["matched_edges"]) / edges if edges else 0.0,
            "welded_vertices": mend["welded"],
            "t_junctions": mend["t_junctions"],
            "thinned_faces": last["thinned_faces"],
            "diagonal": last["diagonal"],
            "output": {"path": str(self._plan.output)} | last["output"],
            "peak_mb": self._peaks,
            "seconds": {name: round(seconds, 3) for name, seconds in self._seconds.items()},
        }


def _median(found: list[dict[str, Any]]) -> float:
    """Return the median of the tiles' noise, by area."""
    noise, area = (np.array([each[name] for each in found]) for name in ("noise", "area"))
    order = np.argsort(noise, kind="stable")
    half = np.searchsorted(np.cumsum(area[order]), area.sum() / 2)
    return float(noise[order[min(half, len(order) - 1)]])
