"""Turn a dense mesh into a clean polygon mesh: repair, split into near-planar regions, make a polygon of each."""

import argparse
import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from .. import (
    CleanOptions,
    FileError,
    InvalidInput,
    Mesh,
    MeshingOptions,
    Partition,
    PolygonMesh,
    RegulariseOptions,
    __version__,
    expected_polygons,
    exporting,
    regularise,
)
from ..clutter import Clutter, clutter, without_clutter
from ..drafts import save_array
from ..guided import Guides, partition_guided
from ..nearer import Nearer, nearer_by_bound
from ..openings import Lengths
from ..texturing.writing import files_of
from ..within import Made, Within, polygonize_within
from . import closing, guiding, lods, texturing, words
from .errors import UsageError
from .files import STDOUT, Outputs, check_all, show
from .loading import Cleaned, Input, clean_mesh, close_mesh, facts, labels, load
from .options import BOX_CLUTTER, KEEP_CLUTTER, guide_files, recipe_of, settings_of
from .progress import Steps, wanted
from .settings import GuideFiles, Settings, Simplification

_NO_FILES = GuideFiles()


@dataclass(frozen=True)
class Done:
    """The results of a run, for callers in the same process."""

    source: Input
    partition: Partition
    polygons: PolygonMesh
    report: dict[str, Any]


def task_of(arguments: argparse.Namespace) -> Simplification:
    """The run that a command line describes."""
    settings = settings_of(arguments, recipe_of(arguments))
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


def run(task: Simplification) -> Done:
    levels = lods.levels(task)
    beside = [check_places(level) for level in levels]
    steps = Steps(wanted(task.quiet))
    done: list[Done] = []
    textured = task.settings.texture is not None
    with steps("read") as job:
        source = load(task.input, job, task.settings.partition.threads, textured=textured)
    if textured:
        texturing.check_source(source, [path for files in beside for path in files])
    with Outputs() as outputs:
        cleaned = None
        for number, each in enumerate(levels):
            level = each
            if number > 0 and textured:
                level = lods.with_halved_texture(level, done[0].report["texture"]["size"], number)
            if number == 0 and len(levels) > 1:
                with steps("clean") as job:
                    cleaned = clean_mesh(source, level.settings.clean, job, level.settings.kept_places)
            done.append(_make(level, source, steps, outputs, cleaned))
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


@dataclass(frozen=True)
class Regions:
    """The regions of a scan, and the inputs that they were made of."""

    mesh: Mesh
    partition: Partition
    guides: Guides
    repaired: dict[str, int]
    repaired_at: dict[str, list[int]]
    closed: CleanOptions | None  #: how openings were closed; None where none were
    expected: dict[str, int]  #: estimated counts of polygons: see `expected_polygons`
    meshing: MeshingOptions
    regular: RegulariseOptions | None
    made: Made | None  #: how the partition was made; None if it was edited since
    nearer: Nearer | None  #: a bound with regions nearer to a drawn model


@dataclass(frozen=True)
class Model(Regions):
    """The regions of a scan, as they are after meshing, and their polygons."""

    found: Within
    clutter: list[Clutter]  #: regions that took many polygons; with --clutter they are left out since


def make_regions(
    settings: Settings, source: Input, steps: Steps, cleaned: Cleaned | None = None, files: GuideFiles = _NO_FILES
) -> Regions:
    """Repair and partition, and estimate the number of polygons.

    cleaned: the repaired scan, if it is known already; a mesh caches data of a partition for the next one.
    """
    recipe, meshing, regular = settings.recipe, settings.meshing, settings.regularise
    count = settings.partition.proxies
    (mesh, repaired, repaired_at), closed, guides, part = _partition(settings, files, source, steps, cleaned, count)
    if recipe:
        with steps("partition") as job, refused(source):
            part = recipe.edited(mesh, part, job, regularised=regular is None)
    if regular is not None:
        with steps("regularise") as job:
            try:
                part = regularise(mesh, part, regular, job)
            except InvalidInput as error:
                raise UsageError(str(error).replace("angle must", "--regularise must")) from None
    elif recipe is not None and recipe.regular is not None:
        regular = recipe.regular
    # Another partition would lose edits and planes.
    edited = regular is not None or (recipe is not None and recipe.edits)
    made = None if edited else Made(settings.partition, guides)
    with steps("partition") as job:
        nearer = nearer_by_bound(mesh, part, made, job) if made else None
    with steps("mesh") as job:
        expected = expected_polygons(mesh, part, meshing, job)
    steps.say(f"expected: {words.expected(expected)}")
    return Regions(mesh, part, guides, repaired, repaired_at, closed, expected, meshing, regular, made, nearer)


def _partition(
    settings: Settings,
    files: GuideFiles,
    source: Input,
    steps: Steps,
    cleaned: Cleaned | None,
    regions: int | None,
) -> tuple[Cleaned, CleanOptions | None, Guides, Partition]:
    """Repair and partition. regions: the number for which openings are closed, where it is known."""
    options, keep, lengths, closed = settings.partition, settings.kept_places, Lengths(), None
    with steps("clean") as job:
        cleaned = cleaned or clean_mesh(source, settings.clean, job, keep)
        if closing.is_wanted(settings):
            with refused(source):
                lengths = closing.lengths_of(cleaned[0], options, regions, job)
            if lengths:
                closed = closing.closing_options(settings.clean, lengths)
                cleaned = close_mesh(source, cleaned, closed, lengths, job, keep)
    with steps("partition") as job, refused(source):
        guides = guiding.guides_of(files, settings.angle, source, cleaned[0], job)
        found = partition_guided(cleaned[0], options, job, guides)
    if lengths.hold_for(found.region_count):
        return cleaned, closed, guides, found
    regions = found.region_count
    del cleaned, guides, found  # their memory is needed
    return _partition(settings, files, source, steps, None, regions)


def make_model(
    settings: Settings, source: Input, steps: Steps, cleaned: Cleaned | None = None, files: GuideFiles = _NO_FILES
) -> Model:
    """Repair, partition and mesh. cleaned: see `make_regions`."""
    regions = make_regions(settings, source, steps, cleaned, files)
    with steps("mesh") as job:
        found = polygonize_within(regions.mesh, regions.partition, regions.meshing, job, regions.made)
    many = clutter(found.polygons)
    if many and settings.clutter != KEEP_CLUTTER:
        with steps("mesh") as job, refused(source):
            part = without_clutter(regions.mesh, found.partition, many, settings.clutter == BOX_CLUTTER)
            found = polygonize_within(regions.mesh, part, regions.meshing, job)
    return Model(**vars(regions) | {"partition": found.partition}, found=found, clutter=many)


def _make(
    task: Simplification,
    source: Input,
    steps: Steps,
    outputs: Outputs,
    cleaned: Cleaned | None,
) -> Done:
    """Make and write one result; its files appear when `outputs` are committed."""
    settings, step = task.settings, None
    if is_step := exporting.kind_of(task.output) in exporting.STEP_KINDS:  # its faces are planes
        meshing = MeshingOptions(**settings.meshing.as_dict() | {"planar": True})
        settings = replace(settings, meshing=meshing)
    recipe = settings.recipe
    model = make_model(settings, source, steps, cleaned, task.guides)
    mesh, part, poly, closed = model.mesh, model.partition, model.found.polygons, model.closed
    made, written, surfaces = None, [], exporting.surfaces_of(poly)
    if settings.texture is not None:
        with steps("texture") as job:
            made = texturing.make(settings.texture, source, mesh, part, poly, settings.partition.threads, job)
    with steps("write") as job:
        if made is None:
            of: dict[str, Any] = {"crs": settings.crs, "like": task.output, "surfaces": surfaces, "unit": settings.unit}
            of |= {"partition": part, "mesh": mesh}
            told = outputs.write(task.output, partial(exporting.write, polygons=poly, job=job, **of))
            step = told if is_step else None
        else:
            files = files_of(task.output, poly, made, job)
            texturing.check_source(source, list(files))  # names of tiles and materials are known only now
            for file, content in files.items():
                outputs.write(file, partial(Path.write_bytes, data=content))
                written.append(file)
        if isinstance(task.labels, Path):
            outputs.write(task.labels, lambda path: save_array(path, labels(source, mesh, part.face_region)))
    report = {
        "isimp": __version__,
        "input": {"path": str(source.path), "vertices": len(source.vertices), "faces": source.faces}
        | {"triangles": len(source.triangles)},
        "repair": model.repaired,
        "repaired_at": model.repaired_at,
        "closed_below": closed.fill_holes if closed else None,
        "openings": closing.told(mesh),
        "mesh": facts(mesh),
        "options": settings.partition.as_dict()
        | {
            "clean": (closed or settings.clean).as_dict(),
            "keep_openings": settings.kept_places,
            "clutter": settings.clutter,
            "meshing": model.meshing.as_dict(),
            "guides": guiding.as_dict(task),
            "recipe": recipe and recipe.values,
            "regularise": model.regular and model.regular.as_dict(),
        },
        "regions": part.region_count,
        "error": part.error,
        "history": part.history.tolist(),
        "partition": part.report | {"warnings": model.found.warnings},
        "curved": part.report["curved"],
        "expected": model.expected,
        "output": {"path": str(task.output)} | model.found.report,
        "nearer": model.nearer and model.nearer.as_dict(),
        "clutter": [each.as_dict() for each in model.clutter],
        "validity": exporting.validity(poly, surfaces=surfaces),
        "step": step,
        "texture": None if made is None else made.report | {"files": [str(path) for path in written[1:]]},
        "seconds": steps.seconds,
        "peak_mb": peak_mb(),
    }
    return Done(source, part, poly, report)


@contextmanager
def refused(source: Input) -> Iterator[None]:
    """Reports an error of the engine as an error of the options, since the mesh is sound at this point."""
    try:
        yield
    except InvalidInput as error:
        raise UsageError(f"{source.path}: {error}") from None


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


def peak_mb() -> float | None:
    """The peak memory of this process; None if the system has no such number."""
    try:
        import resource
    except ImportError:  # Windows
        return None
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return round(peak / (2**20 if sys.platform == "darwin" else 2**10), 1)


def summary(source: Input, done: list[Done]) -> Iterator[str]:
    yield f"{source.path}: {words.count(source.faces, 'face')}, {words.shape(done[0].report['mesh'])}"
    said: list[str] = []  # lines that hold for every level are printed once
    for level in done:
        for line in _summary(level.partition, level.report):
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
    if report["partition"]["tolerance"] is not None:
        yield f"  {words.found(report['partition'])}"
    if report["nearer"] is not None:
        yield f"  {words.nearer(report['nearer'])}"
    if report["options"]["triangles"] is None:  # else the search asked
        yield from words.more_proxies(part.region_count, part.proxies_asked)
    wanted, plane = report["options"]["symmetry"], report["partition"]["symmetry"]
    yield from words.symmetry(wanted, plane, part.region_count, out)
    if report["options"]["curved"]:
        yield f"  {words.round_parts(report['curved'])}"
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
    elif exporting.kind_of(out["path"]):
        yield f"  {words.surfaces(report['validity'])}"
    yield from words.defects(out)
