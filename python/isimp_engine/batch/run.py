"""Run of a batch, from scans to rows. Scans that are done are skipped. A result is on disk before its row."""

import datetime
import glob
import os
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from .. import FileError, __version__, exporting
from ..children.errors import BatchError
from ..children.process import SIMPLIFY, Ending
from ..children.runner import Assignment, Children, clear, endings
from ..children.workers import Workers
from ..cli.errors import UsageError
from ..cli.files import check
from ..cli.options import settings_of
from ..cli.simplify import output_kinds
from ..folders import WORK, discard
from ..settings import Settings, option_names, with_look, without_gone
from ..texturing.writing import companions
from . import page
from .scans import Scan, estimated_faces, find_scans, fixed_part, needed_mb
from .table import MADE, PICTURE, Lock, Row, Table, sync_folder

_FACES_OF_A_START = 20_000  # number of faces that take as long as a scan without faces
_SAME_RESULT = {"threads", "backend"}  # options that change no result, so a change of them repeats no work


@dataclass
class State:
    """The progress of a batch."""

    scans: int  #: number of scans in the batch
    before: int  #: number of scans that earlier runs did
    done: int = 0  #: number of scans that this run did, including failed ones
    failed: int = 0  #: number of failed scans of this run and earlier ones
    running: list[str] = field(default_factory=list)  #: names of the running scans
    seconds: float = 0.0  #: time since this run began
    share: float = 0.0  #: estimated share of this run's work that is done, in [0, 1]


@dataclass(frozen=True)
class Outcome:
    """The results of a batch after a run."""

    rows: list[Row]  #: the row of each scan that has one, in the order of the scans' names
    scans: int  #: number of scans in the batch
    before: int  #: number of scans that earlier runs did
    cut_short: bool  #: the last line of results.jsonl was incomplete, so its scan was done again

    @property
    def failed(self) -> list[Row]:
        return [row for row in self.rows if row["status"] != "ok"]


@dataclass(frozen=True)
class Plan:
    """The work on each scan, and the place of its result."""

    output: Path
    suffix: str
    options: dict[str, Any]
    recipe: dict[str, Any] | None
    labels: bool
    reports: bool
    pictures: bool
    textured: bool

    def key(self, scan: Scan) -> str:
        """Return an identifier of the work on a scan. Any change that affects the result changes it.

        Files that a scan names count if `linked` finds them.
        """
        options = {name: value for name, value in self.options.items() if name not in _SAME_RESULT}
        return scan.key({"options": options, "recipe": self.recipe, "labels": self.labels, "reports": self.reports})

    def task(self, scan: Scan, threads: int) -> dict[str, Any]:
        """Return the task for `work.simplify`."""
        return {
            "input": str(scan.path),
            "output": Path(scan.output).name,
            "options": {"threads": threads} | self.options,
            "recipe": self.recipe,
            "labels": self.labels,
            "reports": self.reports,
            "picture": self.pictures,
        }

    @property
    def parts(self) -> Path:
        return self.output / WORK / "parts"

    @property
    def pictures_folder(self) -> Path:
        return self.output / WORK / "pictures"


def run(
    inputs: Any,
    output: str | os.PathLike[str],
    *,
    options: Mapping[str, Any] | None = None,
    recipe: str | os.PathLike[str] | dict[str, Any] | None = None,
    format: str = "obj",  # noqa: A002  (named as the option of the command)
    children: Children | None = None,
    retry_failed: bool = False,
    labels: bool = False,
    reports: bool = False,
    pictures: bool = True,
    work: str = SIMPLIFY,
    watch: Callable[[State], None] | None = None,
) -> Outcome:
    """Simplify many scans, each in a child process. Scans that an earlier run did are skipped.

    inputs: a path or a pattern with `*`, `?`, `[...]` or `**`, or a list of them. A folder stands for all files in
            it and in its folders, without hidden ones. A file of another kind is a list: one path on each line.
    output: the folder for results.jsonl, results.html and the results, which have the scans' names and folders.
    options: options of `isimp simplify`, with _ in place of -: {"proxies": 500, "leave_out": 0.0}.
    recipe: the file or the values of a recipe. `options` have precedence.
    format: format of the results, such as "obj" or "ply".
    children: the number of scans at once, the place of the work and its limits; None: this machine, without limits.
    retry_failed: repeat scans that failed before.
    labels, reports: also write NAME.labels.npy and NAME.report.json, as `isimp simplify` does.
    pictures: draw each scan next to its result, for results.html.
    work: "module:function" in place of `work.simplify`, for the work on each scan.
    watch: called after each scan, and several times a second, with numbers of scans: `done`, `failed`, `scans`,
           `before` (done by earlier runs), the names of the `running` ones, `seconds` and the `share` that is done.

    Returns `rows`, a row for each scan, and `failed`, the rows of the scans that failed. A row is a dict, as in
    results.jsonl.
    Raises BatchError if the batch as a whole can't be run. KeyboardInterrupt
    passes through; rows that were written stay, and the next run continues from them.
    """
    children = children or Children()
    place = Path(os.path.abspath(output))  # noqa: PTH100  (links stay as they are)
    given = dict(options or {})
    settings = _checked_options(given, recipe)
    steps = None if recipe is None or settings.recipe is None else settings.recipe.to_values()  # a preset is an option
    suffix = _suffix(format, settings)
    textured = with_look(settings, given.get("preset"), suffix in exporting.TEXTURED).texture is not None
    plan = Plan(place, suffix, given, steps, labels, reports, pictures, textured)
    _check_place(inputs, place)
    scans = find_scans(inputs, plan.suffix, besides=place)
    _check_outputs(scans, plan)
    with Lock(place):
        clear(plan.parts)
        plan.pictures_folder.mkdir(exist_ok=True)
        with Table(place) as table:
            todo = [scan for scan in scans if _is_wanted(scan, plan, table, retry_failed)]
            outcome = Outcome([], len(scans), len(scans) - len(todo), bool(table.cut_short))
            state = _state(scans, todo, table)
            with _finished(outcome, scans, plan, table, state):
                if todo:
                    threads = plan.options.get("threads") or None
                    with children.workers(plan.parts, work, threads) as workers:
                        _Run(plan, table, workers, watch, todo, state).run()
            return outcome


@contextmanager
def _finished(outcome: Outcome, scans: list[Scan], plan: Plan, table: Table, state: State) -> Iterator[None]:
    """Write one row for each scan, in order, and the page, even if the block ends by an exception."""
    try:
        yield
    finally:
        state.done = table.added()  # an interrupt may have occurred between a row and its count
        table.tidy()
        outcome.rows.extend(table.rows[scan.name] for scan in scans if scan.name in table.rows)
        page.write(plan.output, outcome.rows, plan.pictures_folder)
        discard(plan.parts)


class _Run:
    """Runs scans in children, and keeps their results."""

    def __init__(
        self,
        plan: Plan,
        table: Table,
        workers: Workers,
        watch: Callable[[State], None] | None,
        todo: list[Scan],
        state: State,
    ) -> None:
        self._plan, self._table, self._workers, self._state = plan, table, workers, state
        self._watch = watch or (lambda state: None)
        self._faces = {scan: estimated_faces(scan.path) for scan in todo}
        self._begun, self._done = time.monotonic(), 0

    def run(self) -> None:
        self._watch(self._state)
        for scan, folder, ending in endings(self._workers, map(self._assignment, self._faces), self._show):
            self._keep(scan, folder, ending)
            self._done += self._share(scan)

    def _assignment(self, scan: Scan) -> Assignment[Scan]:
        task = partial(self._plan.task, scan)
        return Assignment(scan, needed_mb(self._faces[scan], scan.size), task)

    def _share(self, scan: Scan) -> int:
        return _FACES_OF_A_START + self._faces[scan]

    def _show(self, running: list[Scan]) -> None:
        self._state.running = [scan.name for scan in running]
        self._state.seconds = time.monotonic() - self._begun
        self._state.share = self._done / sum(map(self._share, self._faces))
        self._watch(self._state)

    def _keep(self, scan: Scan, folder: Path | None, ending: Ending) -> None:
        """Move the result to its place, then add its row."""
        target, files = None, self._earlier(scan)
        if folder is not None and not ending.why:
            try:
                target, files = self._published(scan, folder)
            except UsageError as error:
                ending = Ending(str(error), {}, ending.seconds)
            except OSError as error:
                ending = Ending(f"can't be written to {scan.output}: {error.strerror}", {}, ending.seconds)
        self._row(scan, ending, target, files)

    def _earlier(self, scan: Scan) -> list[str]:
        """Return the names of the files that earlier runs made of a scan. All of them begin with its name."""
        row, stem = self._table.rows.get(scan.name), Path(scan.name).name.partition(".")[0]
        return [] if row is None else [name for name in row["files"] if name.startswith(stem)]

    def _published(self, scan: Scan, folder: Path) -> tuple[Path, list[str]]:
        """Move the files to their places, the result last, and remove older ones; returns the result and the names.

        All of them are on disk before they get their names.
        """
        target = self._plan.output / scan.output
        target.parent.mkdir(parents=True, exist_ok=True)
        made = sorted((folder / MADE).iterdir(), key=lambda path: path.name == target.name)
        names = [path.name for path in made]
        old = sorted(set(self._earlier(scan)).difference(names))
        for name in names + old:
            check(target.parent / name)
        for path in made:
            handle = os.open(path, os.O_RDONLY)
            try:
                os.fsync(handle)
            finally:
                os.close(handle)
        for path in made:
            path.replace(target.parent / path.name)
        for name in old:
            (target.parent / name).unlink(missing_ok=True)
        sync_folder(target.parent)
        picture = folder / PICTURE
        if picture.exists():
            picture.replace(self._plan.pictures_folder / f"{self._plan.key(scan)}.png")
        return target, names

    def _row(self, scan: Scan, ending: Ending, target: Path | None, files: list[str]) -> None:
        row: Row = {
            "name": scan.name,
            "input": str(scan.path),
            "status": "failed" if ending.why else "ok",
            "why": ending.why or None,
            "output": None if target is None else str(target),
            "files": files,
            "seconds": ending.seconds,
            "peak_mb": ending.peak_mb,
            **ending.values,
            "isimp": __version__,
            "ended": datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds"),
            "key": self._plan.key(scan),
        }
        before = self._table.rows.get(scan.name)
        self._table.add(row)
        if before is not None and before.get("key") != row["key"]:
            (self._plan.pictures_folder / f"{before.get('key')}.png").unlink(missing_ok=True)
        self._state.done += 1
        self._state.failed += bool(ending.why)


def _is_wanted(scan: Scan, plan: Plan, table: Table, retry_failed: bool) -> bool:
    """Return whether a scan is to be done: no row for this work, no result, or a failure that is to be repeated."""
    row = table.rows.get(scan.name)
    if row is None or row.get("key") != plan.key(scan):
        return True
    return retry_failed if row["status"] != "ok" else not (plan.output / scan.output).is_file()


def _state(scans: list[Scan], todo: list[Scan], table: Table) -> State:
    later = {scan.name for scan in todo}
    before = [table.rows[scan.name] for scan in scans if scan.name not in later]
    return State(len(scans), len(before), failed=sum(row["status"] != "ok" for row in before))


def _suffix(kind: str, settings: Settings) -> str:
    """Return the suffix of a format. Raises BatchError if `isimp simplify` can't write it with these options."""
    kinds = output_kinds(settings)
    suffix = "." + kind.lower().removeprefix(".")
    if suffix not in kinds:
        known = ", ".join(each.removeprefix(".") for each in kinds)
        raise BatchError(f"the format '{kind}' can't be written with these options; these can: {known}")
    try:
        exporting.require("results" + suffix)
    except FileError as error:
        raise BatchError(str(error)) from None
    return suffix


def _checked_options(options: dict[str, Any], recipe: str | os.PathLike[str] | dict[str, Any] | None) -> Settings:
    """Return options and recipe in the form for the steps. Raises BatchError if they are wrong for all scans."""
    known, options = option_names(), without_gone(options)
    for name in options:
        if name not in known:
            raise BatchError(f"there is no option '{name}'; there are {', '.join(sorted(known))}")
    try:
        return settings_of(options, recipe)
    except (UsageError, ValueError, TypeError) as error:
        raise BatchError(str(error).splitlines()[0]) from None


def _check_place(inputs: Any, output: Path) -> None:
    """Raise BatchError if the output folder is an input folder: results would become scans."""
    if output.exists() and not output.is_dir():
        raise BatchError(f"{output}: is a file; results need a folder")
    for text in [inputs] if isinstance(inputs, (str, os.PathLike)) else inputs:
        folder = (
            Path(text) if Path(text).is_dir() or not glob.has_magic(os.fspath(text)) else fixed_part(os.fspath(text))
        )
        if folder.is_dir() and folder.resolve() == output.resolve():
            raise BatchError(f"{output}: is the folder of the scans; results need another one")


def _check_outputs(scans: list[Scan], plan: Plan) -> None:
    """Raise BatchError if a result would replace a scan, a file that a scan names, or another result."""
    inputs = {
        os.path.realpath(scan.path.parent / name): scan for scan in scans for name, size, _ in scan.linked if size
    }
    inputs |= {os.path.realpath(scan.path): scan for scan in scans}
    made: dict[str, Scan] = {}
    for scan in scans:
        place = plan.output / scan.output
        for file in [place, *companions(place)] if plan.textured else [place]:
            own = os.path.realpath(file)
            if other := inputs.get(own):
                of = "the scan" if own == os.path.realpath(other.path) else f"{file.name} of the scan"
                raise BatchError(
                    f"the result of {scan.path} would replace {of} {other.path}: give another output folder"
                )
            if (other := made.setdefault(str(file).casefold(), scan)) is not scan:
                raise BatchError(f"{other.path} and {scan.path} would both be written to {file}: rename one")
