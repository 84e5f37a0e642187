"""Simplify one scan that is given as tiles, or too large for memory. An interrupted run continues.

INPUT is a folder of tiles (PLY, OBJ, STL, OFF, glTF, 3MF) in one system of coordinates, a tileset of 3D Tiles, or one
scan, which is cut into tiles. No polygon ends at a border of tiles, and the result is the same for any number of
workers.
"""

import argparse
import json
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from .. import CleanOptions, PartitionOptions
from ..batch import BatchError, Children
from ..recipe.engine_options import PARTITION
from ..tiles import TileFailed, TilesError
from ..tiles import run as run_tiles
from ..tiles.plan import DETAIL
from ..tiles.run import TILE_FACES, Outcome, State
from . import words
from .batch import add_workers, children_of
from .ending import Terminated, terminable
from .errors import BAD_INPUT, INTERRUPTED, OK, TERMINATED, UsageError
from .files import STDOUT, Outputs, check_all, place, show
from .options import take_limits
from .progress import Screen, wanted

_WORDS = {  # the names of steps for the user
    "split": "cutting",
    "prepare": "reading",
    "mend": "fitting borders",
    "thin": "thinning",
    "mesh": "meshing",
}


def add_options(command: argparse.ArgumentParser) -> None:
    command.add_argument("input", type=Path, metavar="INPUT", help="folder of tiles, tileset.json, or one scan")
    command.add_argument("output", type=Path, metavar="OUTPUT", help="PLY or OBJ")
    command.add_argument("--proxies", type=int, metavar="N", help="number of regions of all tiles")
    detail = f"as of simplify: find the number of regions; a share of the scan's size. Default: {DETAIL}."
    command.add_argument("--detail", type=float, metavar="X", help=detail)
    command.add_argument("--tolerance", type=float, metavar="T", help="as --detail, in scene units")
    command.add_argument("--noise", type=float, metavar="S", help="as of simplify. Default: estimated.")
    command.add_argument(
        "--weld",
        type=float,
        default=0.0,
        metavar="L",
        help="vertices on borders of tiles up to this far apart are one. Default: 0, only where they are equal.",
    )
    add_workers(command)
    command.add_argument(
        "--work", type=Path, metavar="FOLDER", help="for intermediate results; stays. Default: next to OUTPUT, removed."
    )
    command.add_argument(
        "--labels",
        type=Path,
        metavar="FOLDER",
        help="one int32 region per face of each tile's file, TILE.npy; -1: none",
    )
    command.add_argument("--jobs", type=int, metavar="N", help="tiles at once. Default: by cores and memory.")
    faces = f"faces of the tiles that one scan is cut into. Default: {TILE_FACES:,}."
    command.add_argument("--tile-faces", type=int, default=TILE_FACES, metavar="N", help=faces)
    metrics = PARTITION["metric"].choices
    command.add_argument("--metric", choices=metrics, help=f"as of simplify. Default: {metrics[0]}.")
    command.add_argument("--smooth", type=float, metavar="X", help="as of simplify. Default: 0.5.")
    command.add_argument("--leave-out", type=float, metavar="X", help="as of simplify. Default: 0.001.")
    command.add_argument("--seed", type=int, metavar="N", help="as of simplify; merging draws no random numbers")
    command.add_argument("--planar", action="store_true", default=None, help="make every polygon planar")
    command.add_argument("--report", type=place, metavar="R.json", help="the numbers of the result; -: to stdout")
    command.add_argument("--quiet", action="store_true", help="no progress, no summary")
    take_limits(command, PartitionOptions)
    take_limits(command, CleanOptions)


def run(arguments: argparse.Namespace) -> int:
    places = [path for path in (arguments.output, arguments.report) if isinstance(path, Path)]
    check_all(places, [arguments.input])
    screen = Screen() if wanted(arguments.quiet) else None
    state = State()
    told = arguments.quiet

    def watch(now: State) -> None:
        nonlocal state, told
        if now.before and not told:
            if screen is not None:
                screen.clear()
            print(f"isimp: continues an earlier run, which did {now.before:,} steps", file=sys.stderr)
        told, state = True, now
        if screen is not None:
            screen.draw(lambda: progress(now))

    names = ("detail", "tolerance", "noise", "metric", "smooth", "leave_out", "seed", "planar")
    given = {name: getattr(arguments, name) for name in names if getattr(arguments, name) is not None}
    begun = time.monotonic()
    try:
        with terminable(), Outputs() as outputs:
            try:
                outcome = run_tiles(
                    arguments.input,
                    arguments.output,
                    proxies=arguments.proxies,
                    weld=arguments.weld,
                    work=arguments.work,
                    labels=arguments.labels,
                    children=Children(**children_of(arguments)),
                    tile_faces=arguments.tile_faces,
                    options=given,
                    watch=watch,
                )
            finally:
                if screen is not None:
                    screen.clear()
            outcome.report["seconds"]["all"] = round(time.monotonic() - begun, 3)
            if arguments.report:
                text = json.dumps(outcome.report, indent=2, allow_nan=False) + "\n"
                outputs.write_text(arguments.report, text)
            outputs.commit()
    except (BatchError, TilesError) as error:
        raise UsageError(str(error)) from None
    except TileFailed as error:
        print("isimp:", " ".join(str(error).split()), file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt as error:
        said = f"interrupted while {_WORDS.get(state.step, 'starting')}; the same command continues from there"
        print(f"isimp: {said}", file=sys.stderr)
        return TERMINATED if isinstance(error, Terminated) else INTERRUPTED
    if not arguments.quiet:
        show("\n".join(summary(outcome, arguments.input, arguments.proxies)), beside=arguments.report == STDOUT)
    return OK


def progress(state: State) -> str:
    """`thinning: 3 of 16 tiles, 41 s`."""
    return f"{_WORDS.get(state.step, state.step)}: {state.done:,} of {state.tiles:,} tiles, {state.seconds:.0f} s"


def summary(outcome: Outcome, source: Path, proxies: int | None) -> Iterator[str]:
    report, out = outcome.report, outcome.report["output"]
    yield f"{source}: {words.count(report['faces'], 'face')} in {words.count(report['tiles'], 'tile')}"
    for name, count in report["repair"].items():
        yield f"  repaired: {count:,} {name.replace('_', ' ')}"
    if report["welded_vertices"]:
        yield f"  welded: {words.count(report['welded_vertices'], 'vertex')} on borders of tiles"
    if report["t_junctions"]:
        yield f"  split: borders at {words.count(report['t_junctions'], 'T-junction')}"
    edges, share = report["border_edges"], report["unmatched_share"]
    if report["tiles"] > 1:
        yield f"  borders of tiles: {edges:,} edges, {share:.1%} without a partner: rims of the scan, or gaps"
    yield from words.left_out(report["parts_left_out"], report["area_left_out"])
    if report["tolerance"] is not None:
        yield f"  {words.found(report)}"
    elif proxies is not None:
        yield from words.more_proxies(report["regions"], proxies)
    yield words.polygons(out, report["regions"])
    yield words.flat(out, report["diagonal"], report["seconds"]["all"])
    yield from words.defects(out)
