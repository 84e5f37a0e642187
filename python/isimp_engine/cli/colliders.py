"""Make convex parts of a solid, for collisions in games and simulations: OBJ, GLB, USD or MuJoCo's XML.

A scan is simplified first, to exactly planar polygons and with all its openings, by the default options. A file with
polygons of five corners or more is taken as it is.
"""

import argparse
from functools import partial
from pathlib import Path

import numpy as np

from .. import Result, simplify
from ..convex import MOST_VERTICES, NAMES, convex_parts
from ..drafts import readable
from ..exporting import colliders
from ..source import Source, load
from . import words
from .errors import UsageError
from .files import Outputs, add_input, check_all, show
from .options import set_limits
from .progress import Steps, wanted

_MOST_OF_A_SCAN = 4  # corners of its faces


def add_options(command: argparse.ArgumentParser) -> None:
    add_input(command)
    command.add_argument(
        "output",
        type=Path,
        metavar="OUTPUT",
        help="OBJ (an object for each part), GLB (a node for each part), XML (MuJoCo's MJCF) or USDA (USD as text)",
    )
    command.add_argument(
        "--enclose",
        action="store_true",
        help="every vertex of INPUT is in a part: planes are pushed outwards for this, the least possible; else parts "
        "have the solid's true size",
    )
    parts = command.add_argument("--parts", type=int, metavar="N", help="the most parts; they may fill free space then")
    tolerance = command.add_argument(
        "--tolerance",
        type=float,
        metavar="L",
        help="how deep parts may fill free space, and the least thickness that matters, in scene units. Default: half "
        "a per cent of the diagonal",
    )
    corners = command.add_argument(
        "--max-vertices",
        type=int,
        default=MOST_VERTICES,
        metavar="N",
        help="of each part, at least 8. Default: %(default)s",
    )
    command.add_argument(
        "--names",
        choices=tuple(NAMES),
        default="plain",
        help="names of the parts: UCX_NAME_00 for Unreal, NAME_collider_00 for Unity, NAME_00-convcol for Godot, "
        "NAME_00 for plain; NAME is that of OUTPUT. Default: %(default)s",
    )
    thickness = command.add_argument(
        "--thickness",
        type=float,
        nargs="?",
        const=True,
        default=False,
        metavar="L",
        help="for open scans, such as rooms: each polygon becomes a slab behind it, or a few, at most L thick, in "
        "scene units. The two sides of a wall end at each other. Without L: two per cent of the diagonal",
    )
    command.add_argument("--quiet", action="store_true", help="no progress, no summary")
    set_limits(parts, {"least": 1})
    set_limits(corners, {"least": 8})
    for length in (tolerance, thickness):
        set_limits(length, {"least": 0.0, "above_least": True})


def run(arguments: argparse.Namespace) -> None:
    output: Path = arguments.output
    if output.suffix.lower() not in colliders.KINDS:
        raise UsageError(f"{output}: OUTPUT must end in one of {', '.join(colliders.KINDS)}")
    check_all([output], [arguments.input])
    steps = Steps(wanted(arguments.quiet))
    with steps("read") as job:
        source = load(arguments.input, job)
    solid: Source | Result = source
    if not _has_polygons(source):
        with steps("simplify") as job:
            solid = simplify((source.vertices, source.triangles), planar=True, keep_openings=True, job=job)
    with steps("parts") as job:
        parts = convex_parts(
            solid,
            enclose=arguments.enclose,
            tolerance=arguments.tolerance,
            parts=arguments.parts,
            most_vertices=arguments.max_vertices,
            thickness=arguments.thickness,
            job=job,
        )
    with Outputs() as outputs:
        write = partial(colliders.write, name=readable(output.stem), parts=parts, names=arguments.names, like=output)
        outputs.write(output, write)
        outputs.commit()
    if not arguments.quiet:
        triangles = sum(len(part.triangles) for part in parts)
        volume = sum(part.volume for part in parts)
        text = f"{words.count(len(parts), 'convex part')}, {words.count(triangles, 'triangle')}, volume {volume:.6g}"
        show(f"{source.path}: {words.count(source.faces, 'face')}\n  {text}")


def _has_polygons(source: Source) -> bool:
    """Whether a file has faces with more corners than faces of scans have."""
    return bool(len(source.polygon)) and int(np.bincount(source.polygon).max()) > _MOST_OF_A_SCAN - 2
