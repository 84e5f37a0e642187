"""Prints the effect of other values of each constant of native/src/curved, as a table of docs/constants.md.

    python -m bench.quality.curved_constants [--only kMost,kReach] [--scans can.ply,drill.ply] [--shapes post,tin]
        [--folder DIR] [--json OUT.json]
    python -m bench.quality.curved_constants --tables OUT.json

Needs the packages of bench.quality.constants. The tree is copied, and each constant of its native/src/curved becomes a
variable, so that one build and one process measure all values. The constants are read from the sources, with their
comments as meanings.

A value is halved and doubled; of shares and cosines from .6 to 1, and of factors from 1 to 1.5, the difference from 1.

Columns, for `turned_shape` of bench/generators/more_round_shapes.py and for the scans:
  found     change of the share of the truly curved area in curved patches, in percent of the area
  kinds     change of the number of true parts whose best patch is of their kind
  radius    change of the mean error of radii, in hundredths of a percent
  polygons  change in %, geometric mean
  distance  of the scan's vertices from the polygons, mean: change in %, geometric mean
  far       the same of the distance that 1 % exceed
  quads     change of the share of cells with four corners, in percent
  other     number of meshes with another result
  time      of the processor, partitions of all meshes: change in %
"""

from __future__ import annotations

import argparse
import ctypes
import json
import os
import re
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bench.quality.constants import ROOT, Build, cell

FOLDER = "native/src/curved"
COLUMNS = ("found", "kinds", "radius", "polygons", "distance", "far", "quads", "other", "time")
TIMES = 2  # partitions, of whose processor times the least counts
NOISES = (0.001, 0.003)
TYPES = {"double": "double", "int": "int", "std::int32_t": "int", "std::size_t": "std::size_t"}
# Limits of arithmetic and of the interface, units, and sizes of arrays.
NO_CHOICE = {
    *("kTiny", "kTurn", "kDegree", "kNever", "kFar", "kBins", "kSteps", "kBlock", "kDamping", "kShort", "kStraight"),
    *("kMostSegments", "kMostRings", "kMostStrips", "kMostOfPipe"),
}

NAME = "tuned"  # the name of two added sources
HEADER = """#pragma once
#include <cstddef>
bool registered(const char* name, double* place);
bool registered(const char* name, int* place);
bool registered(const char* name, std::size_t* place);
"""
SOURCE = """#include "HEADER"
#include <map>
#include <string>
#include <variant>
using Place = std::variant<double*, int*, std::size_t*>;
static std::map<std::string, Place>& all() {
  static std::map<std::string, Place> places;
  return places;
}
bool registered(const char* name, double* place) { return all().emplace(name, place).second; }
bool registered(const char* name, int* place) { return all().emplace(name, place).second; }
bool registered(const char* name, std::size_t* place) { return all().emplace(name, place).second; }
extern "C" __attribute__((visibility("default"))) double tuned_value(const char* name) {
  return std::visit([](auto* p) { return static_cast<double>(*p); }, all().at(name));
}
extern "C" __attribute__((visibility("default"))) void set_tuned(const char* name, double value) {
  std::visit([&](auto* p) { *p = static_cast<std::remove_reference_t<decltype(*p)>>(value); }, all().at(name));
}
"""


@dataclass(frozen=True)
class Constant:
    file: str
    name: str
    kind: str
    text: str  # as in the source
    meaning: str

    @property
    def key(self) -> str:
        return f"{self.file}:{self.name}"

    @property
    def place(self) -> str:
        return f"`{self.name}`, `src/curved/{self.file}`"


DECLARATION = re.compile(
    r"^(?:inline )?const(?:expr)? (double|int|std::int32_t|std::size_t)\s+(k[A-Z][^;{]*);[ \t]*"
    r"((?:///<[^\n]*(?:\n\s+///<[^\n]*)*)?)",
    re.M,
)


def constants_in(file: str, text: str) -> list[Constant]:
    found = []
    for at in DECLARATION.finditer(text):
        kind, body, note = at.groups()
        meaning = " ".join(note.replace("///<", " ").split())
        for one in re.split(r",\s*(?=k[A-Z])", body):
            name, value = (part.strip() for part in one.split("=", 1))
            if name not in NO_CHOICE:
                found.append(Constant(file, name, TYPES[kind], " ".join(value.split()), meaning))
    return found


def constants() -> list[Constant]:
    files = sorted((ROOT / FOLDER).glob("*.*"))
    return [c for file in files for c in constants_in(file.name, file.read_text())]


def with_variables(file: Path) -> None:
    """Makes the constants of a copied source variables."""
    text, is_header = file.read_text(), file.suffix == ".h"
    names = {c.name for c in constants_in(file.name, text)}
    if not names:
        return
    storage = "inline" if is_header else "static"

    def variables(at: re.Match[str]) -> str:
        lines = []
        for one in re.split(r",\s*(?=k[A-Z])", at.group(2)):
            name = one.split("=", 1)[0].strip()
            if name not in names:
                lines.append(f"{storage} const {at.group(1)} {one.strip()};")
                continue
            lines.append(f"{storage} {at.group(1)} {one.strip()};")
            lines.append(f'{storage} const bool is_{name} = registered("{file.name}:{name}", &{name});')
        return "\n".join(lines)

    changed = DECLARATION.sub(variables, text)
    first = "#pragma once\n" if is_header else ""
    file.write_text(f'{first}#include "{NAME}.h"\n{changed.removeprefix(first)}')


class Tunable(Build):
    """A build whose constants can be changed while it runs."""

    def _copy(self, path: Path) -> None:
        super()._copy(path)
        if path.name != "native":
            return
        folder = self.source / FOLDER
        for file in sorted(folder.glob("*.*")):
            with_variables(file)
        (folder / f"{NAME}.h").write_text(HEADER)
        (folder / f"{NAME}.cpp").write_text(SOURCE.replace("HEADER", f"{NAME}.h"))


def other_values(value: float, kind: str) -> list[float]:
    """Half and twice a value."""
    if kind != "double":
        return [v for v in (max(1, int(value) // 2), 2 * int(value)) if v != value]
    if 0.6 <= value < 1:
        return [1 - 2 * (1 - value), 1 - (1 - value) / 2]
    if 1 < value <= 1.5:
        return [1 + (value - 1) / 2, 1 + (value - 1) * 2]
    return [value / 2, value * 2]


class Meshes:
    """Meshes with their partitions at the values of now."""

    def __init__(self, scans: list[str], only: list[str]) -> None:
        import isimp_engine as engine
        from bench.generators.more_round_shapes import more_shapes, turned_shape
        from bench.generators.round_shapes import part_of_faces

        self.engine = engine
        self.all = {}
        for k, name in enumerate(more_shapes()):
            for noise in NOISES:
                if only and name not in only:
                    continue
                shape, clean, vertices, faces = turned_shape(name, 40 + k, noise)
                mesh = engine.clean(vertices, faces)
                truth = part_of_faces(shape, clean, faces)[np.asarray(mesh.source_face)]
                self.all[f"{name} {noise}"] = (mesh, shape, truth)
        for path in scans:
            self.all[Path(path).stem] = (engine.clean(*engine.read(path)[:2]), None, None)
        self.rows: dict[tuple[str, bytes], dict[str, float]] = {}

    def measured(self) -> dict[str, dict[str, float]]:
        return {name: self.row(name) for name in self.all}

    def row(self, name: str) -> dict[str, float]:
        mesh, shape, truth = self.all[name]
        seconds = []
        for _ in range(TIMES):
            started = time.process_time()
            part = self.engine.partition(mesh, self.engine.PartitionOptions(curved=True, threads=1))
            seconds.append(time.process_time() - started)
        key = (name, result_of(part))
        if key not in self.rows:
            self.rows[key] = self.of(mesh, part, shape, truth)
        return self.rows[key] | {"time": min(seconds)}

    def of(self, mesh, part, shape, truth) -> dict[str, float]:
        from bench.quality.curved import against_truth
        from isimp_engine.within import scan_distances

        poly = self.engine.polygonize(mesh, part)
        far = scan_distances(mesh, part, poly)
        far = far[np.isfinite(far)]
        row = {"polygons": len(poly.loop_start), "distance": far.mean(), "far": np.quantile(far, 0.99)}
        is_cell = np.zeros(part.region_count, bool)
        for p in part.curved:
            is_cell[np.asarray(p["regions"], int)] = True
        corners = np.diff(np.append(np.asarray(poly.loop_start), len(poly.loops)))[is_cell[poly.polygon_region]]
        row["quads"] = float((corners == 4).mean()) if len(corners) else 1.0
        row["parts"] = len(part.curved)
        if shape is not None:
            v = np.asarray(mesh.vertices)[np.asarray(mesh.triangles)]
            area = np.linalg.norm(np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0]), axis=1) / 2
            row |= against_truth(shape, part, truth, area)
            row["kinds"] = right_kinds(shape, part, truth, area)
        row["bits"] = hash(result_of(part))
        return {k: float(v) for k, v in row.items()}


def result_of(part) -> bytes:
    arrays = (part.face_region, part.region_normal, part.region_offset)
    return b"".join(np.ascontiguousarray(a).tobytes() for a in arrays)


def right_kinds(shape, part, truth, area) -> int:
    """The number of true parts whose best patch is of their kind."""
    patch = np.full(part.region_count, -1)
    for k, p in enumerate(part.curved):
        patch[np.asarray(p["regions"], int)] = k
    of_face = np.where(part.face_region >= 0, patch[part.face_region], -1)
    count = 0
    for k, true in enumerate(shape.parts):
        is_mine = (truth == k) & (of_face >= 0)
        if is_mine.any():
            best = int(np.bincount(of_face[is_mine], area[is_mine]).argmax())
            count += part.curved[best]["kind"] == true.kind
    return count


def compared(new: dict[str, dict], old: dict[str, dict]) -> dict[str, float]:
    def mean(column: str) -> float:
        return float(np.mean([new[m][column] - old[m][column] for m in old if column in old[m]] or [0]))

    def quotient(column: str) -> float:
        return 100 * (float(np.exp(np.mean([np.log(new[m][column] / old[m][column]) for m in old]))) - 1)

    radii = [new[m]["radius"] - old[m]["radius"] for m in old if "radius" in old[m]]
    return {
        "found": 100 * mean("found"),
        "kinds": sum(new[m]["kinds"] - old[m]["kinds"] for m in old if "kinds" in old[m]),
        "radius": 100 * float(np.nanmean(radii)),
        "polygons": quotient("polygons"),
        "distance": quotient("distance"),
        "far": quotient("far"),
        "quads": 100 * mean("quads"),
        "other": sum(new[m]["bits"] != old[m]["bits"] for m in old),
        "time": 100 * (sum(r["time"] for r in new.values()) / sum(r["time"] for r in old.values()) - 1),
    }


def measure(names: list[str], scans: list[str], only: list[str], out: Path) -> None:
    """Measures all constants, in the process of the engine with variables."""
    import isimp_engine

    library = ctypes.CDLL(isimp_engine._core.__file__)
    library.tuned_value.restype = ctypes.c_double
    library.set_tuned.argtypes = [ctypes.c_char_p, ctypes.c_double]
    meshes = Meshes(scans, only)
    base = meshes.measured()
    results = json.loads(out.read_text()) if out.exists() else {}
    results["base"] = base
    for constant in constants():
        if names and constant.name not in names and constant.key not in names:
            continue
        place = constant.key.encode()
        now = library.tuned_value(place)
        results[constant.key] = {"value": now, "rows": {}}
        for value in other_values(now, constant.kind):
            library.set_tuned(place, value)
            results[constant.key]["rows"][f"{value:.6g}"] = compared(meshes.measured(), base)
        library.set_tuned(place, now)
        out.write_text(json.dumps(results, indent=1))
        print(constant.key, results[constant.key]["rows"], file=sys.stderr, flush=True)


def text(column: str, change: float) -> str:
    if column in ("kinds", "time"):
        return f"{change:+.0f}" if round(change) else "0"
    return f"{change:.0f}" if column == "other" else cell(change)


def tables(results: dict[str, dict]) -> str:
    lines = [
        "| constant | value | meaning | to | " + " | ".join(COLUMNS) + " |",
        "|---" * 3 + "|---:" * (1 + len(COLUMNS)) + "|",
    ]
    for c in constants():
        result = results.get(c.key)
        head = f"| {c.place} | {c.text} | {c.meaning} |"
        for value, row in (result["rows"] if result else {"": None}).items():
            same = row and row["other"] == 0
            cells = ["=" if same and k != "time" else text(k, row[k]) if row else "" for k in COLUMNS]
            lines.append(f"{head} {value} | " + " | ".join(cells) + " |")
            head = "| | | |"
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="names")
    parser.add_argument("--scans", default="")
    parser.add_argument("--shapes", default="", help="names of shapes with commas between")
    parser.add_argument("--folder", type=Path, default=ROOT / "out" / "constants")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--json", type=Path, default=ROOT / "out" / "curved_constants.json")
    parser.add_argument("--tables", type=Path)
    parser.add_argument("--measure", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args()
    names, scans, only = ([n for n in t.split(",") if n] for t in (given.only, given.scans, given.shapes))
    if given.measure:
        measure(names, scans, only, given.json)
        return 0
    if given.tables:
        print(tables(json.loads(given.tables.read_text())))
        return 0
    build = Tunable(given.folder, given.jobs)
    given.json.parent.mkdir(parents=True, exist_ok=True)
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(build.base), str(ROOT)])}
    subprocess.run(
        [sys.executable, __file__, *sys.argv[1:], "--measure", "--json", str(given.json)], env=environment, check=True
    )
    print(tables(json.loads(given.json.read_text())))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
