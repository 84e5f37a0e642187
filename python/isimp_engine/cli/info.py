"""Print the properties of a mesh, the repairs that it needs, and its number of polygons. Nothing is written."""

import argparse
import json
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from .. import Job
from ..pipeline import make_model, make_regions, openings_of
from ..repairs import Meshes, Repair
from ..settings import OptionError, Settings
from ..source import Source, facts, load
from . import words
from .errors import flag
from .files import show
from .options import settings_of
from .progress import Steps


def run(arguments: argparse.Namespace) -> None:
    settings = settings_of(vars(arguments), arguments.recipe)
    source = load(arguments.input, Job(), settings.clean.threads)
    meshes = Meshes()
    repaired = meshes.repaired(source, Repair.by(settings.clean, settings.kept_places), Steps(show=False))
    mesh = repaired.mesh
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    report = {
        **repaired.as_dict(),
        "mesh": facts(mesh) | {"box": [low.tolist(), high.tolist()]},
        "result": None if arguments.mesh_only else result(settings, source, meshes, arguments.estimate),
    }
    show(json.dumps(report, indent=2, allow_nan=False) if arguments.json else "\n".join(lines(report)))


def result(settings: Settings, source: Source, meshes: Meshes, estimate: bool) -> dict[str, Any]:
    """How many polygons `isimp simplify` would make, and why; or why it would refuse. estimate: without meshing."""
    steps = Steps(show=False)
    try:
        regions = make_regions(source, replace(settings, texture=None), steps, meshes)
        out: dict[str, Any] = regions.expected
        if not estimate:
            regions = model = make_model(regions, steps)
            out = model.found.report
    except OptionError as error:
        return {"refused": error.shown(flag)}
    closed = regions.repaired.closed
    counts = {key: value for key, value in out.items() if key in ("regions", "polygons") or key.startswith("split_for")}
    return counts | {
        "expected": regions.expected,
        "estimated": estimate,
        "closed_below": closed.fill_holes if closed else None,
        "filled_holes": regions.repaired.counts["filled_holes"],
        "cut_handles": regions.repaired.counts["cut_handles"],
        "openings": openings_of(regions.mesh),
        "partition": regions.partition.report,
    }


def lines(report: dict[str, Any]) -> Iterator[str]:
    source, mesh = report["input"], report["mesh"]
    cut = (
        "" if source["faces"] == source["triangles"] else f" (cut into {words.count(source['triangles'], 'triangle')})"
    )
    yield str(source["path"])
    yield f"  {words.count(source['faces'], 'face')}{cut}, {words.count(source['vertices'], 'vertex')}"
    yield f"  {words.shape(mesh)}, Euler characteristic {mesh['euler']}"
    sides = " x ".join(f"{high - low:.6g}" for low, high in zip(*mesh["box"], strict=True))
    yield f"  size {sides}, diagonal {mesh['diagonal']:.6g}, area {mesh['area']:.6g}"
    if mesh["zero_area_faces"]:
        yield f"  {words.count(mesh['zero_area_faces'], 'face')} without area"
    repairs = list(words.repairs(report["repair"], report["repaired_at"]))
    yield "  nothing to repair" if not repairs else "  to repair:"
    yield from (f"    {line}" for line in repairs)
    if report["result"] is not None:
        yield from result_lines(report["result"])


def result_lines(result: dict[str, Any]) -> Iterator[str]:
    if "refused" in result:
        yield f"  no polygons: {result['refused']}"
        return
    polygons, regions = words.count(result["polygons"], "polygon"), words.count(result["regions"], "region")
    yield f"  would become {'about ' if result['estimated'] else ''}{polygons} of {regions}"
    if more := words.more_than_regions(result):
        yield f"    {more}"
    if result["partition"]["tolerance"] is not None:
        yield f"    {words.found(result['partition'])}"
    if result["closed_below"] and (result["filled_holes"] or result["cut_handles"]):
        things = {"hole": result["filled_holes"], "handle": result["cut_handles"]}
        closed = " and ".join(words.count(number, thing) for thing, number in things.items() if number)
        yield f"    {closed} up to {result['closed_below']:.4g} long closed before; --keep-openings keeps them"
