"""Prints the effect of half and twice each tuned constant of the engine, as the tables of docs/constants.md.

    python -m bench.quality.constants [--data DIR] [--only kNu,kOfEdge] [--folder DIR] [--jobs N] [--json OUT.json]
    python -m bench.quality.constants --tables OUT.json [--no-times]

Needs the tools that build the Python module, and pybind11 in this Python. The tree is copied into --folder
(out/constants) and built there once. For each value one constant is changed in the copy, ninja compiles the files that
contain it and links the module, and a process of its own measures. The sources of the caller are only read. Runs with
the present value alternate with runs with the other one, and the least time counts; times on a machine that others use
mean nothing, and --no-times leaves them out. With --json a run that was cut off continues from its last result.
Defaults of options are changed without a build.

Columns, changes in % of the value of now, geometric means over the meshes of `MESHES`:
  distance    of the scan's vertices from the polygons, mean
  planarity   distance of corners from their polygon's plane, mean by area
  polygons    made from the requested regions
  concave     polygons with a corner above 190 degrees
  found       regions that `detail` finds at its default
  time        of the processor, partition and polygons together
= in all columns but the last: the results are the same, number by number.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
MESHES = {"scan/bunny_69k.ply": 300, "building/openmvs_castle_175k.ply": 300, "building/fandisk_13k.ply": 100}
TURNS, TIMES = 2, 2  # processes, and runs in each of them: the least time counts
COLUMNS = ("distance", "planarity", "polygons", "concave", "found", "time")
PARTS = ("CMakeLists.txt", "CMakePresets.json", "cmake", "native", "cuda", "python", "third_party")

PARTITION, MESHING = "native/src/partition/", "native/src/meshing/"
OPTIONS = {
    "partition": "native/include/isimp/partition/options.h",
    "meshing": "native/include/isimp/meshing/options.h",
}
UNKNOWN = "own trials, not recorded"
SHAPES = "own trials for short borders and convex polygons, trials.md"
JOINS = "six scans at 300 regions, thirteen others at 100, trials.md"
CURVED = "bench.quality.curved at noise .1 %, seeds 77 and 78"
NEEDLES = "four scans at 100, 300 and 1,000 regions, trials.md"
PLACES = "own trials of one energy of places (bench/quality/fit.py), trials.md"
REAL = "open buildings, cartons, chunks (bench/quality/real.py)"
HOUSES = "30 drawn houses (bench/quality/real.py --houses), known shapes"
FOUND = "own trials, numbers of regions of shapes that have a known one"


@dataclass(frozen=True)
class Tuned:
    """A number that trials gave."""

    file: str  # below the root; of an option the struct it is a default of
    name: str
    meaning: str
    source: str
    text: str = ""  # text before the number; else "name = "
    values: tuple[str, str] = ("", "")  # in place of half and twice, where these mean nothing
    smooth: float | None = None  # PartitionOptions.smooth, where the default makes no use of the number

    @property
    def path(self) -> str:
        return OPTIONS.get(self.file, self.file)

    @property
    def place(self) -> str:
        """Its name in the table."""
        used = "" if self.smooth is None else f", at smooth {self.smooth:g}"
        return f"`{self.name}`, `{Path(self.path).relative_to('native')}`{used}"

    @property
    def given(self) -> dict[str, dict[str, float]]:
        """Options to measure with."""
        return {} if self.smooth is None else {"partition": {"smooth": self.smooth}}

    @property
    def pattern(self) -> str:
        return r"(?<![\w.])" + re.escape(self.text or f"{self.name} = ") + r"(-?[0-9][0-9.]*(?:e-?[0-9]+)?)"

    def value(self, root: Path = ROOT) -> str:
        found = re.findall(self.pattern, (root / self.path).read_text())
        if len(found) != 1:
            raise SystemExit(f"{self.path}: {self.name} occurs {len(found)} times where once is expected")
        return found[0]

    def variants(self, root: Path = ROOT) -> list[str]:
        now = self.value(root)
        is_whole = re.fullmatch(r"-?[0-9]+", now) is not None
        scaled = [f"{max(1, int(int(now) * by))}" if is_whole else f"{float(now) * by:.6g}" for by in (0.5, 2)]
        fixed = [given or other for given, other in zip(self.values, scaled, strict=True)]
        return [v if is_whole or "." in v or "e" in v else f"{v}.0" for v in fixed]


TUNED = (
    Tuned(PARTITION + "borders/relax.h", "border_weight", "factor of the weight of borders for the least error",
          "D and borders of four scans at 100 to 2,000 regions (afdbf73)",
          "BorderWeight border_weight(double error) { return {std::min(", smooth=0.0),
    Tuned(PARTITION + "borders/relax.h", "border_weight, exponent", "of the error, in the same weight",
          "the same", "std::pow(error, ", smooth=0.0),
    Tuned(PARTITION + "borders/relax.h", "border_weight, most", "of the same weight",
          "the same", "std::pow(error, 1.35), ", smooth=0.0),
    Tuned(PARTITION + "borders/relax.h", "kNu", "weight of a border as long as a region is wide, relative to the error",
          SHAPES),
    Tuned(PARTITION + "borders/relax.h", "kMostError", "error from which borders weigh no more", SHAPES),
    Tuned(PARTITION + "borders/border_moves.h", "kOfVertex", "weight of two faces that share only a vertex, in edges",
          SHAPES),
    Tuned(PARTITION + "borders/distances.cpp", "kLength",
          "distance that counts as 60 degrees between normals, in sides of a mean region",
          "mean distance of five scans at 100, 300 and 1,000 regions, trials.md"),
    Tuned(PARTITION + "borders/relax.h", "kRounds", "rounds of relaxing by distances", "the same"),
    Tuned(PARTITION + "hierarchy/hierarchy.cpp", "kLargestPatch", "faces of a patch at most",
          "D, borders and time of four scans (afdbf73)"),
    Tuned(PARTITION + "hierarchy/hierarchy.cpp", "kPatchesARegion", "patches of the largest size to a region",
          "the same"),
    Tuned(PARTITION + "hierarchy/hierarchy.cpp", "kCrease", "cosine: neighbours beyond it are never in one patch",
          UNKNOWN, values=("0.8", "0.9875")),
    Tuned(PARTITION + "hierarchy/contraction.cpp", "kWideGate", "the gate where satellites join, times the other one",
          "eleven scans at 100, 300 and 1,000 regions, a street"),
    Tuned(PARTITION + "hierarchy/contraction.cpp", "kGate", "share of the nodes whose best price lets them merge",
          UNKNOWN, values=("0.35", "1.0")),
    Tuned(PARTITION + "hierarchy/optimise.cpp", "kSmoothSurplus", "regions before the last merging, of those wanted",
          SHAPES, values=("1.1", "4.4")),
    Tuned(PARTITION + "hierarchy/optimise.cpp", "kTries", "teleports in a row that do not pay", UNKNOWN),
    Tuned(PARTITION + "hierarchy/optimise.cpp", "kNodesOfRegion", "nodes a region of the level that is relaxed first",
          "borders of one scan with 1, 4 and 16 times the faces (291f5fe)"),
    Tuned(PARTITION + "hierarchy/detail_tree.cpp", "kBorder", "weight of an edge between regions, before the tree",
          FOUND),
    Tuned(PARTITION + "hierarchy/detail_tree.cpp", "kNoisyBorder", "weight that noise adds to `kBorder`", FOUND),
    Tuned(PARTITION + "hierarchy/detail_tree.cpp", "kFilterPasses", "of the filter of normals", FOUND),
    Tuned(PARTITION + "hierarchy/choose_cut.h", "kNoise", "deviations of the noise that are no detail", HOUSES),
    Tuned(PARTITION + "hierarchy/choose_cut.h", "kLeastNoise", "deviations at which the search for gaps begins", FOUND),
    Tuned(PARTITION + "hierarchy/features.cpp", "kSteep", "cosine of the angle at which a part stands on another",
          HOUSES, values=("0.2", "0.5")),
    Tuned(PARTITION + "hierarchy/features.cpp", "kFeature", "least cost of such a part, in limits", HOUSES),
    Tuned(PARTITION + "hierarchy/detail_tree.cpp", "kFaded", "of its cost that smooth borders may leave of a region",
          HOUSES),
    Tuned(PARTITION + "density/normal_filter.cpp", "kBlind", "range of normals that falls as they are filtered",
          HOUSES),
    Tuned(PARTITION + "hierarchy/choose_cut.cpp", "kWindow", "tolerances in which gaps count, times the least", FOUND),
    Tuned(PARTITION + "hierarchy/choose_cut.cpp", "kRatio", "of the costs at a gap, at least", FOUND),
    Tuned(PARTITION + "hierarchy/choose_cut.cpp", "kSlack", "a gap counts no further beyond the window, times the cost",
          "scanned cartons, 36 scans at three details, known shapes"),
    Tuned(PARTITION + "hierarchy/choose_cut.cpp", "kSurprise", "a gap is larger than chance makes it by", FOUND),
    Tuned(PARTITION + "hierarchy/choose_cut.cpp", "kSpread", "tolerances of which the number is a mean",
          "steps of the number when detail changes by 5 % (bench/quality/counts.py)", values=("1.1", "1.44")),
    Tuned("partition", "smooth", "weight of borders relative to the error", SHAPES, values=("0.25", "1.0")),
    Tuned("meshing", "chord_tolerance", "distance of a boundary from its chord",
          "12 scans at 100, 300, 1,000 regions and by detail, trials.md"),
    Tuned("meshing", "chord_area", "area that chords leave out or add",
          "corners of the castle against mean distance (8ffc6be)"),
    Tuned("meshing", "join_junctions", "length of chords whose ends may become one", SHAPES),
    Tuned("meshing", "reach", "how far a corner may go", PLACES),
    Tuned("meshing", "flatten", "rounds of placing corners", PLACES),
    Tuned("meshing", "flatness", "bend beyond which a polygon is split", UNKNOWN),
    Tuned(MESHING + "complex/state.cpp", "tolerance, most", "chords of few regions, of the diagonal", UNKNOWN,
          "t.most = std::min(tolerance, "),
    Tuned(MESHING + "complex/state.cpp", "least_sine", "how much less a chord counts between flat neighbours, at most",
          UNKNOWN, "t.least_sine = "),
    Tuned(MESHING + "complex/complex.cpp", "kOfTriangle", "area that the chords of a triangle may leave out",
          "windows of a street (bench/quality/street.py), corners of figures (bench/quality/shape.py)"),
    Tuned(MESHING + "complex/complex.cpp", "kOfThree", "the same, of one between three junctions", "the same"),
    Tuned(MESHING + "discs/polyline.cpp", "farthest", "points that are nearly farthest, of the square distance",
          UNKNOWN, "squared_distance(line[i], a, b) < ", ("0.9", "0.99")),
    Tuned(MESHING + "complex/flat_fit.h", "kOfEdge", "way of a corner, of its shortest edge", SHAPES),
    Tuned(MESHING + "complex/flat_fit.h", "bend", "weight of corners' distance from a plane; the chart's is 1", PLACES),
    Tuned(MESHING + "complex/flat_fit.h", "tie", "weight of corners off their vertices, of the same", PLACES),
    Tuned(MESHING + "judge/judge.h", "kFacingChart", "cosine up to which a polygon is flipped", UNKNOWN),
    Tuned(MESHING + "repair/repair.cpp", "kPull", "share of a corner's distance from its vertex that a pull leaves",
          UNKNOWN, values=("0.25", "0.75")),
    Tuned(MESHING + "repair/plans.h", "kAfterSplit", "index in its plan at which a chart continues after a split",
          "success of actions (plans.h)"),
    Tuned(MESHING + "repair/coarsen.cpp", "kError", "added deviation of a union of two regions, in mean errors",
          "15 meshes at 50 to 1,000 regions (9e9b5bb)", values=("0.5", "2")),
    Tuned(MESHING + "repair/coarsen.cpp", "kSquare", "the same, in square distances", "the same",
          values=("1.5", "6")),
    Tuned(MESHING + "repair/junctions.cpp", "kOfEdge", "price of an edge, in square deviations of the scan", JOINS),
    Tuned(MESHING + "repair/junctions.cpp", "kOfReflex", "price of a full turn of reflex corners, in edges", JOINS),
    Tuned(MESHING + "repair/junctions.cpp", "kOfSharp", "price of a full turn that sharp corners lack", JOINS),
    Tuned(MESHING + "repair/junctions.cpp", "kOfCell", "worth of an edge where round parts meet", CURVED),
    Tuned(MESHING + "repair/junctions.cpp", "kLeastSine", "least square sine at borders of long chords", JOINS),
    Tuned(MESHING + "repair/junctions.cpp", "kShort", "a short chord, of sqrt(area / charts)", JOINS),
    Tuned(MESHING + "repair/junctions.cpp", "kMisses", "miss of a plane at a joint vertex, in bounds of bends", JOINS),
    Tuned(MESHING + "complex/placement.cpp", "kJoined", "share of the tie at joint vertices", JOINS),
    Tuned(MESHING + "place/slide.cpp", "kFar", "way of a sliding corner, of sqrt(area / charts)", SHAPES),
    Tuned(MESHING + "place/slide.cpp", "kOff", "off the planes, in deviations of the scan", SHAPES),
    Tuned(MESHING + "place/slide.cpp", "kOfSharp", "reflex degrees that a degree too sharp counts as", NEEDLES),
    Tuned(MESHING + "place/slide.cpp", "kBend", "degrees that a bend counts as", NEEDLES),
    Tuned(MESHING + "discs/polyline.cpp", "kWithin", "share of a ragged border that is near its rim", REAL),
    Tuned(MESHING + "complex/raggedness.cpp", "kOfRagged",
          "how far a rim may leave a ragged border, times the raggedness", REAL),
    Tuned(MESHING + "complex/raggedness.cpp", "kRagged",
          "raggedness from which a rim is straight, in edges of the border", REAL),
    Tuned("native/src/simplify/sharp_edges.cpp", "kEdges", "width of a strip of an edge, in mean edges", REAL),
    Tuned("native/src/simplify/sharp_edges.cpp", "kMostAngle", "degrees of planes that meet at an edge, at most",
          HOUSES, values=("120.0", "170.0")),
    Tuned("native/src/simplify/sharp_edges.cpp", "kFlatFaces", "mean faces of a region on scans of planes", HOUSES,
          values=("50", "200")),
    Tuned("native/src/simplify/sharp_edges.cpp", "kZigzag", "length of a border along faces, over its line's length",
          REAL, values=("1.0", "1.6")),
    Tuned("native/src/mesh/cleaning/stitch.cpp", "kEdges", "gap of borders that are stitched, in mean edges", REAL),
    Tuned("native/src/mesh/cleaning/stitch.cpp", "kShare", "of the border that has another near, to be stitched", REAL),
    Tuned("native/src/mesh/cleaning/stitch.cpp", "kNearEnd", "of an edge: nearer vertices become one with its end",
          REAL, values=("0.2", "0.5")),
    Tuned("native/src/mesh/cleaning/close.cpp", "kOffPlane",
          "deviation of a hole in a wall from its plane, share of sqrt(its area)", REAL),
    Tuned("native/src/simplify/openings.cpp", "kFlat",
          "longest hole in a wall that is closed, in sqrt(area / regions)", REAL),
    Tuned("native/src/simplify/openings.cpp", "kMostPatch",
          "largest patch that draws no region, in mean regions", REAL),
)  # fmt: skip


def measure(data: Path, changed: dict[str, dict[str, float]], times: int) -> dict[str, dict[str, float]]:
    """The columns by mesh, of the engine that can be imported; no time where it is measured 0 times."""
    import isimp_engine as engine
    from bench.quality import shape

    partition, meshing = changed.get("partition", {}), changed.get("meshing", {})
    rows = {}
    for name, proxies in MESHES.items():
        mesh = engine.clean(*engine.read(data / name))
        row, _, _ = shape.run(mesh, proxies, partition, meshing)
        found = engine.partition(mesh, engine.PartitionOptions(**partition))
        seconds = []
        for _ in range(times):
            started = time.process_time()
            part = engine.partition(mesh, engine.PartitionOptions(proxies=proxies, **partition))
            engine.polygonize(mesh, part, engine.MeshingOptions(**meshing))
            seconds.append(time.process_time() - started)
        rows[name] = {
            "distance": row["mean"],
            "planarity": row["bend"],
            "polygons": row["polygons"],
            "concave": row["conc"],
            "found": found.region_count,
        } | ({"time": min(seconds)} if seconds else {})
    return rows


class Build:
    """A copy of the tree and its build."""

    def __init__(self, folder: Path, jobs: int) -> None:
        self.source = folder / "source"
        self.base = folder / "base"
        self.jobs = jobs
        self.tree = self.source / "build-dev"
        for part in PARTS:
            self._copy(ROOT / part)
        # With the dev preset's flags and these two, ccache knows the objects of an ordinary build.
        self.environment = os.environ | {"CCACHE_BASEDIR": str(self.source), "CCACHE_NOHASHDIR": "1"}
        pybind = self._run([sys.executable, "-m", "pybind11", "--cmakedir"]).strip()
        self._run(["cmake", "--preset", "dev", "-DISIMP_TESTS=OFF", "-DISIMP_BENCH=OFF", "-DISIMP_THESIS=OFF",
                   f"-DPython_EXECUTABLE={sys.executable}", f"-Dpybind11_DIR={pybind}"])  # fmt: skip
        self.make()
        shutil.rmtree(self.base, ignore_errors=True)
        shutil.copytree(self.tree / "python", self.base)

    def _copy(self, path: Path) -> None:
        """Unchanged files keep their times, so that ninja does not build their objects again."""
        files = [p for p in path.rglob("*") if p.is_file()] if path.is_dir() else [path] if path.exists() else []
        copied = self.source / path.relative_to(ROOT)
        for old in copied.rglob("*") if copied.is_dir() else ():
            if old.is_file() and not (ROOT / old.relative_to(self.source)).exists():
                old.unlink()
        for file in files:
            to = self.source / file.relative_to(ROOT)
            if to.exists() and to.read_bytes() == file.read_bytes():
                continue
            to.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, to)

    def _run(self, command: list[str]) -> str:
        done = subprocess.run(command, cwd=self.source, env=self.environment, capture_output=True, text=True)
        if done.returncode != 0:
            raise SystemExit(f"{' '.join(command)}\n{done.stdout[-4000:]}{done.stderr[-4000:]}")
        return done.stdout

    def make(self) -> None:
        self._run(["ninja", "-C", str(self.tree), f"-j{self.jobs}", "isimp_python"])

    def with_value(self, tuned: Tuned, value: str) -> Path:
        """The package of an engine with another value; the next call restores the files that this one has changed."""
        file = self.source / tuned.path
        text = file.read_text()
        at = re.search(tuned.pattern, text)
        assert at is not None
        file.write_text(text[: at.start(1)] + value + text[at.end(1) :])
        try:
            self.make()
        finally:
            file.write_text(text)
        return self.tree / "python"


def measured(package: Path, data: Path, changed: dict[str, dict[str, float]], times: int) -> dict:
    """The measurements of a process of its own with a package; empty where it fails."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(package), str(ROOT)])}
    command = [sys.executable, __file__, "--measure", json.dumps([changed, times]), "--data", str(data)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    if done.returncode == 0:
        return json.loads(done.stdout)
    print(done.stderr, file=sys.stderr)
    return {}


def in_turns(packages: list[Path], data: Path, options: list[dict], turns: int) -> list[dict]:
    """Measures some packages with options for each, one after the other and again; their shortest times."""
    rows: list[dict] = [{} for _ in packages]
    for _ in range(max(1, turns)):
        for k, (package, changed) in enumerate(zip(packages, options, strict=True)):
            new = measured(package, data, changed, TIMES if turns else 0)
            for mesh, row in new.items():
                if "time" in row and rows[k]:
                    row["time"] = min(row["time"], rows[k][mesh]["time"])
            rows[k] = new
    return rows


def changes(new: dict[str, dict[str, float]], old: dict[str, dict[str, float]]) -> dict[str, float]:
    """The change in %, as geometric mean over meshes."""
    return {
        column: 100 * (float(np.exp(np.mean([np.log(new[m][column] / old[m][column]) for m in old]))) - 1)
        for column in COLUMNS
        if all(column in row for rows in (new, old) for row in rows.values())
    }


def cell(change: float) -> str:
    return "0" if abs(change) < 0.05 else f"{change:+.1f}" if abs(change) < 10 else f"{change:+.0f}"


def tables(results: dict[str, dict], columns: Sequence[str] = COLUMNS) -> str:
    """The table of docs/constants.md."""
    lines = [
        "| constant | value | meaning | tuned on | to | " + " | ".join(columns) + " |",
        "|---" * 4 + "|---:" * (1 + len(columns)) + "|",
    ]
    for tuned in TUNED:
        result = results.get(f"{tuned.path} {tuned.name}")
        head = f"| {tuned.place} | {tuned.value()} | {tuned.meaning} | {tuned.source} |"
        variants = result["variants"] if result else dict.fromkeys(tuned.variants())
        for value, rows in variants.items():
            if rows is None:
                cells = ["not run"] * len(columns)
            elif not rows:
                cells = ["fails"] * len(columns)
            else:
                change = changes(rows, result["base"])
                same = all(rows[m][c] == result["base"][m][c] for m in rows for c in COLUMNS if c != "time")
                cells = ["=" if same and c != "time" else cell(change[c]) if c in change else "" for c in columns]
            lines.append(f"{head} {value} | " + " | ".join(cells) + " |")
            head = "| | | | |"
    return "\n".join(lines)


def result_of(tuned: Tuned, build: Build, data: Path, turns: int, bases: dict[str, dict]) -> dict:
    """The effect of half and twice a constant, compared with its present value.

    :param bases: by options, the figures that do not change without times
    """
    key = str(tuned.given)
    if turns == 0 and key not in bases:
        (bases[key],) = in_turns([build.base], data, [tuned.given], 0)
    variants: dict[str, dict] = {}
    for value in tuned.variants():
        is_option = tuned.file in OPTIONS
        package = build.base if is_option else build.with_value(tuned, value)
        changed = {tuned.file: {tuned.name: json.loads(value)}} if is_option else tuned.given
        if turns == 0:
            (variants[value],) = in_turns([package], data, [changed], 0)
        else:
            variants[value], bases[key] = in_turns([package, build.base], data, [changed, tuned.given], turns)
    return {"value": tuned.value(), "base": bases[key], "variants": variants}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=ROOT.parent / "shared" / "data")
    parser.add_argument("--only", default="", help="names")
    parser.add_argument("--folder", type=Path, default=ROOT / "out" / "constants")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--json", type=Path)
    parser.add_argument("--tables", type=Path, help="prints the table of an earlier run and ends")
    parser.add_argument("--no-times", action="store_true")
    parser.add_argument("--measure", type=json.loads, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.measure is not None:
        print(json.dumps(measure(given.data, *given.measure)))
        return 0
    columns = [c for c in COLUMNS if c != "time" or not given.no_times]
    if given.tables:
        print(tables(json.loads(given.tables.read_text()), columns))
        return 0
    wanted = given.only.split(",") if given.only else []
    # All are found before the first build; constants that need many compilations come last.
    some = sorted((t for t in TUNED if not wanted or t.name in wanted), key=lambda t: (t.path.endswith(".h"), t.path))
    some.sort(key=lambda t: t.file not in OPTIONS)
    for tuned in some:
        tuned.value()
    results = json.loads(given.json.read_text()) if given.json and given.json.exists() else {}
    build = Build(given.folder, given.jobs)
    bases: dict[str, dict] = {}
    for tuned in some:
        key = f"{tuned.path} {tuned.name}"
        if key in results and results[key]["value"] == tuned.value():
            continue
        started = time.monotonic()
        results[key] = result_of(tuned, build, given.data, 0 if given.no_times else TURNS, bases)
        print(f"{tuned.name}: {time.monotonic() - started:.0f} s", file=sys.stderr, flush=True)
        if given.json:
            given.json.write_text(json.dumps(results, indent=1))
    print(tables(results, columns))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
