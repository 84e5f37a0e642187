"""Simplify many scans, each in a child process with limits on time and memory. A second run skips finished scans.

INPUT is a folder, a pattern, a list of paths in a text file, or scans. Results get the names and folders of the scans;
OUTPUT_FOLDER/results.jsonl has one row a scan, results.html shows them.
"""

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ..batch import BatchError, Children
from ..batch import run as run_batch
from ..batch.page import NAME, defects, in_order, totals
from ..batch.run import Outcome, State
from ..batch.table import NAME as ROWS
from ..children.clusters import KINDS, checked
from .ending import Terminated, deferrable
from .errors import INTERRUPTED, OK, SOME_FAILED, TERMINATED, UsageError
from .files import show
from .options import simplify_options
from .progress import Screen, wanted

_LINES = 20  # largest number of problems, and of results, in the summary; the page has all


def add_options(command: argparse.ArgumentParser) -> None:
    command.add_argument("inputs", nargs="+", metavar="INPUT", help="folder, pattern, list file, or scans")
    command.add_argument("output", type=Path, metavar="OUTPUT_FOLDER", help="made if it is not there")
    command.add_argument(
        "--format", default="obj", metavar="KIND", help="of results, as OUTPUT of simplify may end. Default: obj."
    )
    command.add_argument("--jobs", type=int, metavar="N", help="scans at once. Default: by cores and memory.")
    add_workers(command)
    command.add_argument("--time-limit", type=float, metavar="S", help="seconds a scan may take. Default: no limit.")
    command.add_argument(
        "--memory-limit", type=float, metavar="MB", help="MB a scan may take. Default: the free memory."
    )
    command.add_argument("--retry-failed", action="store_true", help="repeat the scans that failed in an earlier run")
    command.add_argument("--labels", action="store_true", help="write NAME.labels.npy next to each result")
    command.add_argument("--reports", action="store_true", help="write NAME.report.json next to each result")
    command.add_argument("--no-pictures", dest="pictures", action="store_false", help=f"no pictures in {NAME}")
    command.add_argument("--quiet", action="store_true", help="no progress, no summary")


def add_workers(command: argparse.ArgumentParser) -> None:
    """Adds the options for the place where children run."""
    command.add_argument("--dask", metavar="ADDRESS", help="scheduler of a cluster that does the work: tcp://HOST:PORT")
    started = f"start a cluster for this, of {', '.join(KINDS)}; needs isimp[cluster]"
    command.add_argument("--cluster", metavar="KIND", help=started)
    command.add_argument("--workers", type=int, metavar="N", help="jobs of --cluster. Default: 1.")
    command.add_argument(
        "--cluster-option",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="of --cluster: cores=16, memory=60GB, walltime=4:00:00, queue=Q, ...; ssh: hosts=A,B,C. May be repeated.",
    )


def children_of(arguments: argparse.Namespace) -> dict[str, Any]:
    """The place of children, as values of `Children`."""
    cluster = checked(arguments.cluster, arguments.workers, arguments.cluster_option)
    return {"jobs": arguments.jobs, "dask": arguments.dask, "cluster": cluster}


def run(arguments: argparse.Namespace) -> int:
    screen = Screen() if wanted(arguments.quiet) else None
    state = State(0, 0)  # replaced by the present state at each call of `watch`

    def watch(now: State) -> None:
        nonlocal state
        state = now
        interrupts.check()
        if screen is not None:
            screen.draw(lambda: progress(now))

    try:
        with deferrable() as interrupts:
            try:
                outcome = run_batch(
                    arguments.inputs,
                    arguments.output,
                    options=given_options(arguments),
                    recipe=arguments.recipe,
                    format=arguments.format,
                    children=Children(
                        **children_of(arguments),
                        time_limit=arguments.time_limit,
                        memory_limit=arguments.memory_limit,
                    ),
                    retry_failed=arguments.retry_failed,
                    labels=arguments.labels,
                    reports=arguments.reports,
                    pictures=arguments.pictures,
                    watch=watch,
                )
            finally:
                if screen is not None:
                    screen.clear()
    except BatchError as error:
        raise UsageError(str(error)) from None
    except KeyboardInterrupt as error:
        done = f"{state.before + state.done:,} of {state.scans:,} scans are done"
        print(f"isimp: interrupted, {done}; the same command does the others", file=sys.stderr)
        return TERMINATED if isinstance(error, Terminated) else INTERRUPTED
    if not arguments.quiet:
        show("\n".join(summary(outcome, arguments.output, arguments.retry_failed)))
    return SOME_FAILED if outcome.failed else OK


def given_options(arguments: argparse.Namespace) -> dict[str, Any]:
    """The options of `isimp simplify` that were given."""
    defaults = vars(simplify_options().parse_args([]))
    given = {name: getattr(arguments, name) for name in defaults if name != "recipe"}
    return {name: value for name, value in given.items() if value != defaults[name]}


def progress(state: State) -> str:
    """`37 of 120, 2 failed, 12.3 a minute, 6 min left: b/tower.ply, c.obj`."""
    text = f"{state.before + state.done:,} of {state.scans:,}"
    if state.failed:
        text += f", {state.failed:,} failed"
    if state.done and state.seconds > 0:
        text += f", {60 * state.done / state.seconds:,.1f} a minute"
        if 0 < state.share < 1:
            text += f", {duration(state.seconds * (1 - state.share) / state.share)} left"
    names = ", ".join(state.running)
    return f"{text}: {names}" if names else text


def duration(seconds: float) -> str:
    """`45 s`, `6 min`, `2 h 05 min`."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60:02} min"


def summary(outcome: Outcome, output: Path, retried: bool) -> Iterator[str]:
    """A table, problems first, and the totals. retried: the run did failed scans again."""
    rows = in_order(outcome.rows)
    problems = [row for row in rows if row["status"] != "ok"]
    good = [row for row in rows if row["status"] == "ok"]
    if outcome.cut_short:
        yield f"the last line of {ROWS} was cut short when an earlier run ended; that scan was done again"
    yield from (f"failed  {row['name']}: {row['why']}" for row in problems[:_LINES])
    if len(problems) > _LINES:
        yield f"        and {len(problems) - _LINES:,} more"
    if good:
        width = max(len(row["name"]) for row in good[:_LINES])
        yield f"{'':8}{'':{width}} {'faces':>11} {'regions':>8} {'polygons':>8} {'seconds':>8} {'peak MB':>8}"
        for row in good[:_LINES]:
            numbers = f"{row.get('faces', 0):11,} {row.get('regions', 0):8,} {row.get('polygons', 0):8,}"
            peak = "" if row["peak_mb"] is None else f"{row['peak_mb']:,.0f}"
            more = f"  {', '.join(found)}" if (found := defects(row)) else ""
            yield f"ok      {row['name']:{width}} {numbers} {row['seconds']:8.1f} {peak:>8}{more}"
        if len(good) > _LINES:
            yield f"        and {len(good) - _LINES:,} more"
    before = f" ({outcome.before:,} by earlier runs)" if outcome.before else ""
    yield f"{totals(outcome.rows)}{before}"
    if problems and not retried:
        yield "--retry-failed does the failed ones again"
    yield f"{output / NAME}"
