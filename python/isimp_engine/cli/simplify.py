"""Turn a dense mesh into a clean polygon mesh: repair, split into near-planar regions, make a polygon of each."""

import argparse
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from .. import FileError, MeshingOptions, Partition, exporting, machine
from ..cache import Cache
from ..drafts import save_array
from ..pipeline import Model, has_texture, make_model, make_regions, require_texture
from ..recipes import RecipeLike
from ..repairs import Meshes
from ..settings import Settings, with_look
from ..source import Source, load
from ..texturing.writing import files_of
from . import closing, lods, texturing, words
from .errors import UsageError
from .files import STDOUT, Outputs, check_all, show
from .guiding import guide_files
from .options import settings_of
from .progress import Steps, wanted
from .task import Simplification


@dataclass(frozen=True, eq=False)
class Done:
    """The results of a run, for callers in the same process."""

    model: Model
    report: dict[str, Any]


def task_of(arguments: argparse.Namespace) -> Simplification:
    """The run that a command line describes."""
    settings = settings_for(arguments.output, vars(arguments), arguments.recipe)
    if arguments.lods is not None:
        lods.check(arguments)
    return Simplification(
        input=arguments.input,
        output=arguments.output,
        settings=settings,
        guides=guide_files(arguments),
        labels=arguments.labels,
        report=arguments.report,
        lods=arguments.lods,
        quiet=arguments.quiet,
    )


def settings_for(output: Path, options: Mapping[str, Any], recipe: RecipeLike | None) -> Settings:
    """The settings of options for a file that is to be written."""
    settings = settings_of(options, recipe)
    return with_look(settings, options.get("preset"), exporting.kind_of(output) in exporting.TEXTURED)


def run(task: Simplification) -> Done:
    levels = lods.levels(task)
    beside = [check_places(level) for level in levels]
    steps = Steps(wanted(task.quiet))
    done: list[Done] = []
    texture = task.settings.texture
    textured = texture is not None
    with steps("read") as job:
        source = load(task.input, job, task.settings.partition.threads, textured=textured)
    if texture is not None and not (texture.needed or has_texture(source)):
        textured = False
        levels = [replace(each, settings=replace(each.settings, texture=None)) for each in levels]
    if textured:
        texturing.check_source(source, [path for files in beside for path in files])
        require_texture(source)
    with Outputs() as outputs:
        meshes = Meshes(Cache(0, least=min(2, len(levels))))  # for all levels the mesh with its openings
        for number, each in enumerate(levels):
            level = each
            if number > 0 and textured:
                level = lods.with_halved_texture(level, done[0].report["texture"]["size"], number)
            done.append(_make(level, source, steps, outputs, meshes))
            steps = Steps(wanted(task.quiet))
        report = done[0].report
        if task.lods is not None:
            report = {**report, "lods": [level.report for level in done]}
        if task.report:
            outputs.write_text(task.report, json.dumps(report, indent=2, allow_nan=False) + "\n")
        outputs.commit()
    if not task.quiet:  # a report on stdout must be the only output there
        show("\n".join(summary(source, done)), beside=task.report == STDOUT)
    return done[0]


def _make(
    task: Simplification,
    source: Source,
    steps: Steps,
    outputs: Outputs,
    meshes: Meshes,
) -> Done:
    """Make and write one result; its files appear when `outputs` are committed."""
    settings, step = task.settings, None
    if is_step := exporting.kind_of(task.output) in exporting.STEP_KINDS:  # its faces are planes
        meshing = MeshingOptions(**settings.meshing.as_dict() | {"planar": True})
        settings = replace(settings, meshing=meshing)
    regions = make_regions(source, settings, steps, meshes, task.guides.marks(source))
    steps.say(f"expected: {words.expected(regions.expected)}")
    model = make_model(regions, steps)
    written = [task.output]
    with steps("write") as job:
        if model.texture is None:
            told = outputs.write(task.output, partial(model.write, job=job, like=task.output))
            step = told if is_step else None
        else:
            files = files_of(task.output, model.polygons, model.texture, job)
            texturing.check_source(source, list(files))  # names of tiles and materials are known only now
            for file, content in files.items():
                outputs.write(file, partial(Path.write_bytes, data=content))
            written = list(files)
        if isinstance(task.labels, Path):
            outputs.write(task.labels, lambda path: save_array(path, model.labels()))
    report = model.report(sizes=task.report is not None)
    report["options"]["guides"] |= task.guides.as_dict()
    report["output"] = {"path": str(task.output)} | report["output"]
    if model.texture is not None:
        report["texture"] = report["texture"] | {"files": [str(path) for path in written[1:]]}
    seconds = steps.seconds | {"clean": steps.seconds.get("clean", 0.0)}  # a level of detail may have a known mesh
    return Done(model, report | {"step": step, "seconds": seconds, "peak_mb": machine.peak_mb()})


def output_kinds(settings: Settings) -> tuple[str, ...]:
    """The allowed endings of OUTPUT, with these settings."""
    return exporting.PLAIN if settings.texture is None else exporting.TEXTURED


def check_places(task: Simplification) -> list[Path]:
    """Check the output paths before the computation; returns the files that can be written next to the output."""
    if not task.output.name.lower().endswith(kinds := output_kinds(task.settings)):
        more = "with a texture " if task.settings.texture is not None else ""
        raise UsageError(f"{task.output}: {more}OUTPUT must end in one of {', '.join(kinds)}")
    try:
        exporting.require(task.output)
    except FileError as error:
        raise UsageError(str(error)) from None
    beside = texturing.check_output(task)
    if task.labels == STDOUT:
        raise UsageError("--labels writes a binary file, which can't go to stdout; give ./- for a file called -")
    places = (task.output, *beside, task.labels, task.report)
    check_all([path for path in places if isinstance(path, Path)], [task.input])
    return beside


def summary(source: Source, done: list[Done]) -> Iterator[str]:
    yield f"{source.path}: {words.count(source.faces, 'face')}, {words.shape(done[0].report['mesh'])}"
    said: list[str] = []  # lines that hold for every level are printed once
    for level in done:
        for line in _summary(level.model.partition, level.report):
            if line not in said:
                yield line
            said.append(line)


def _summary(part: Partition, report: dict[str, Any]) -> Iterator[str]:
    mesh, out = report["mesh"], report["output"]
    for line in words.repairs(report["repair"], report["repaired_at"]):
        yield f"  repaired: {line}"
    yield from closing.lines(report["openings"], report["options"]["keep_openings"], report["closed_below"])
    yield from words.left_out(part.parts_left_out, part.area_left_out)
    yield from (f"  warning: {text}" for text in report["partition"]["warnings"])
    yield from words.clicks(report["clicks"])
    if report["partition"]["tolerance"] is not None:
        yield f"  {words.found(report['partition'])}"
    if report["options"]["triangles"] is None:  # else the search asked
        yield from words.more_proxies(part.region_count, part.proxies_asked)
    if report["options"]["curved"]:
        yield f"  {words.round_parts(report['curved'], out['regions'], report['not_round'])}"
    if report["scale"] is not None:
        yield f"  {words.scaled(report['scale'])}"
    if report["options"]["snap_sizes"]:
        yield from words.snapped(report["sizes"], report["options"]["snap_sizes"])
    yield words.polygons(out, out["regions"])
    yield words.flat(out, mesh["diagonal"], sum(report["seconds"].values()))
    if more := words.more_than_regions(out):
        yield f"  {more}"
    if many := words.clutter(report["clutter"], report["options"]["clutter"]):
        yield f"  {many}"
    if straight := words.rims(out, mesh["area"]):
        yield f"  {straight}"
    if report["texture"] is not None:
        yield from texturing.summary(report["texture"])
    if out.get("scan_distance") is not None:
        kept = "within" if out["scan_distance"] <= out["scan_distance_allowed"] else "NOT within"
        yield f"  the scan is at most {out['scan_distance']:.4g} off, {kept} {out['scan_distance_allowed']:.4g}"
    if report["step"] is not None:
        yield f"  {words.step(report['step'])}"
    elif exporting.kind_of(out["path"]) in exporting.BUILDING_KINDS:
        yield f"  {words.surfaces(report['validity'])}"
    yield from words.defects(out)
