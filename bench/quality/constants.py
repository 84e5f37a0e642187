"""Measures the effects of half and twice each tuned constant, and writes the table of docs/constants.md.

    python -m bench.quality.constants [--only kNu,curved/] [--folder DIR] [--jobs N] [--json OUT.json]
    python -m bench.quality.constants --table OUT.json       writes the table of an earlier run into docs/constants.md

Needs the tools that build the Python module, and pybind11 in this Python. The tree is copied into --folder
(out/constants). In the copy each tuned constant of native becomes a function that reads its value from a table, so one
build serves all values; its results have the bits of an ordinary build. Each value is measured by the runs of
small_runs.py that read the constant, in a forked process, so that a crash or endless work is a result too. With --json
a run that was cut off continues.

A comment begins with the kind of its constant (`KINDS`). Where it does not, the constant was tuned on the data that the
last line `// tuned DATA` above it names.

Lists of numbers have a kind and a row, but are not measured.

A value is halved and doubled; of shares and cosines from .6 to 1, and of factors from 1 to 1.5, the difference from 1.

A row has the number of tried runs and of runs with other bits, and the changes in % of the number of polygons and of
the mean distance of the scan's vertices from them, geometric means over the tried runs.
"""

import argparse
import ctypes
import json
import os
import re
import resource
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs/constants.md"
PARTS = ("CMakeLists.txt", "CMakePresets.json", "README.md", "cmake", "native", "cuda", "python", "third_party")

QUICKEST = 8  # runs that are tried for the table; the others only where none of these differs, up to one that does

KINDS = {
    "tuned": "chosen from data",
    "rounding": "far above the rounding of numbers, far below lengths that matter",
    "work": "blocks, threads and caches; changes no result",
    "limit": "an end for inputs that are larger or worse than others",
    "format": "of a file or an interface",
    "mark": "no number, but a label, a flag or infinity",
    "unit": "follows from its meaning",
}
# Defaults of options: the data that each was tuned on, and its meaning.
OPTIONS = {
    "smooth": ("shapes", "weight of borders relative to the error"),
    "chord_tolerance": ("shapes", "distance of a boundary from its chord"),
    "chord_area": ("castle", "area that chords leave out or add"),
    "join_junctions": ("shapes", "length of chords whose ends may become one"),
    "reach": ("places", "how far a corner may go"),
    "flatten": ("places", "rounds of placing corners"),
    "flatness": ("unrecorded", "bend beyond which a polygon is split"),
}
TYPES = "double|float|int|(?:std::)(?:u?int(?:8|32|64)_t|size_t|ptrdiff_t)"
LISTS = r"std::array(?:<[^;={]*>)?"
DECLARATION = re.compile(
    rf"^([ \t]*)((?:static |inline )*)(?:const|constexpr) ({TYPES}|{LISTS})\s+(k[A-Z]\w*(?:\[\w*\])?\s*(?:=|\{{)[^;]*);"
    r"([^\n]*(?:\n\1[ \t]+//[^\n]*(?=\n))*)",  # a comment that begins where the declaration does is of the next one
    re.M,
)
OF_NUMBERS = re.compile(r"[\s{},\d.e+-]*\}")
ANOTHER = re.compile(r",\s*(?=k[A-Z]\w*\s*(?:=|\{))")
ABOVE = re.compile(r"(?:^|(?<=\n))((?:[ \t]*//[^\n]*\n)+)$")
TAG = re.compile(rf"({'|'.join(KINDS)})(?: ([a-z]\w*))?(?:: (.*)|$)", re.S)
TUNED = re.compile(r"^[ \t]*// tuned (\w+)$", re.M)


@dataclass(frozen=True)
class Constant:
    file: str  # below native/
    name: str
    type: str
    value: str  # as in the source
    kind: str = ""
    data: str = ""
    meaning: str = ""
    is_list: bool = False

    @property
    def key(self) -> str:
        return f"{self.file}:{self.name}"


def text_of(comment: str) -> str:
    lines = [line.strip().lstrip("/<").strip() for line in comment.split("\n") if not TUNED.match(line)]
    return " ".join(lines).strip()


def declared(file: str, text: str) -> Iterator[tuple[re.Match[str], list[Constant]]]:
    """Each declaration of a source, with its constants."""
    end = 0
    for at in DECLARATION.finditer(text):
        before, between, end = text[: at.start()], text[end : at.start()], at.end()
        above = ABOVE.search(between)
        meaning = text_of(at.group(5)) or (text_of(above.group(1)) if above else "")
        data = (TUNED.findall(before) or [""])[-1]
        kind = "tuned" if data else ""
        if tag := TAG.match(meaning):
            kind, data, meaning = (group or "" for group in tag.groups())
        found = []
        for one in ANOTHER.split(re.sub(r"//[^\n]*", "", at.group(4))):
            name, size, value = re.match(r"(k\w+)(\[\w*\])?\s*(.*)", " ".join(one.split())).groups()
            value = value.removeprefix("= ")
            is_list = bool(size) or at.group(3).startswith("std::array")
            if is_list and not OF_NUMBERS.fullmatch(value):
                continue
            value = value[1:-1].strip() if value.startswith("{") else value
            found.append(Constant(file, name, at.group(3), value, kind, data, meaning.strip(), is_list))
        if found:
            yield at, found


def sources(root: Path = ROOT) -> dict[str, str]:
    files = sorted((root / "native").rglob("*"))
    return {str(p.relative_to(root / "native")): p.read_text() for p in files if p.suffix in (".h", ".cpp")}


def constants(root: Path = ROOT) -> list[Constant]:
    return [c for file, text in sources(root).items() for _, found in declared(file, text) for c in found]


def options() -> list[Constant]:
    """The defaults of `OPTIONS`."""
    from isimp_engine.recipe.engine_options import MESHING, PARTITION

    tables, found = PARTITION | MESHING, []
    for name, (data, meaning) in OPTIONS.items():
        kind = "int" if tables[name].kind == "int" else "double"
        found.append(Constant("option", name, kind, str(tables[name].default), "tuned", data, meaning))
    return found


LOOKUP = "isimp/core/lookup.h"
HEADER = """#pragma once
#include <type_traits>
namespace isimp {
extern double other_value[2048];
extern unsigned char lookup_state[2048];  // 1: was read, 2: has another value
template <typename T>
T looked_up(int place, T now) {
  if (lookup_state[place] & 2) return static_cast<T>(other_value[place]);
  if (!(lookup_state[place] & 1)) other_value[place] = static_cast<double>(now);
  if (!(lookup_state[place] & 1)) lookup_state[place] |= 1;
  return now;
}
}  // namespace isimp
#define ISIMP_LOOKUP(T, place, now) \\
  { return std::is_constant_evaluated() ? static_cast<T>(now) : isimp::looked_up<T>(place, static_cast<T>(now)); }
"""
SOURCE = f"""#include "{LOOKUP}"
namespace isimp {{
double other_value[2048];
unsigned char lookup_state[2048];
}}
extern "C" __attribute__((visibility("default"))) double* isimp_values() {{ return isimp::other_value; }}
extern "C" __attribute__((visibility("default"))) unsigned char* isimp_states() {{ return isimp::lookup_state; }}
"""


def looked_up(texts: dict[str, str], places: dict[str, int]) -> dict[str, str]:
    """Sources whose constants of `places` are functions. In constant expressions they have the value of the source."""
    names = {f: {n.split(":")[1] for n in places if n.startswith(f"{f}:")} for f in texts}
    headers = [f for f in texts if f.endswith(".h")]

    def included(file: str, seen: set[str]) -> set[str]:
        for name in re.findall(r'#include ["<]([^">]+\.h)[">]', texts[file]):
            for header in (h for h in headers if f"/{h}".endswith(f"/{name}")):
                if header not in seen:
                    seen.add(header)
                    included(header, seen)
        return seen

    result = {}
    for file, text in texts.items():
        own = names[file]
        mine = {c.name for _, found in declared(file, text) for c in found}  # they hide those of headers
        known = own.union(*(names[h] for h in included(file, set()))) - (mine - own)
        if not known:
            continue
        use = re.compile(r"(?<![\w.>])(" + "|".join(sorted(known)) + r")\b(?!\s*\()")
        parts, end = [], 0
        for at, found in declared(file, text):
            if found[0].is_list:
                continue
            indent, storage = at.group(1), at.group(2)
            parts.append(use.sub(r"\1()", text[end : at.start()]))
            end = at.end()
            for c in found:
                value = use.sub(r"\1()", c.value)
                if c.name not in own:
                    parts.append(f"{indent}{storage}constexpr {c.type} {c.name} = {value};\n")
                    continue
                body = f"ISIMP_LOOKUP({c.type}, {places[c.key]}, ({value}))"
                is_local = indent and "static" not in storage
                head = f"static constexpr auto {c.name} = []() -> {c.type} {body};"
                member = f"{'static ' if indent else '[[maybe_unused]] '}constexpr {c.type} {c.name}() {body}"
                parts.append(f"{indent}{head if is_local else member}\n")
        body = "".join(parts) + use.sub(r"\1()", text[end:])
        first = "#pragma once\n" if "#pragma once" in body else ""
        result[file] = f'{first}#include "{LOOKUP}"\n' + body.replace(first, "", 1)
    return result


def tuned() -> list[Constant]:
    return [c for c in constants() if c.kind == "tuned"]


def measured() -> list[Constant]:
    return [c for c in tuned() if not c.is_list]


def places_of(some: list[Constant]) -> dict[str, int]:
    return {c.key: k for k, c in enumerate(some)}


def build(folder: Path, jobs: int) -> Path:
    """Builds a copy of the tree. Unchanged files keep their times, so that ninja does not build them again."""
    changed = {f"native/{f}": t for f, t in looked_up(sources(), places_of(measured())).items()}
    changed |= {f"native/include/{LOOKUP}": HEADER, "native/src/core/lookup.cpp": SOURCE}
    for path in (p for part in PARTS for p in [ROOT / part, *(ROOT / part).rglob("*")] if p.is_file()):
        changed.setdefault(str(path.relative_to(ROOT)), "")
    for name, text in changed.items():
        new, to = text.encode() or (ROOT / name).read_bytes(), folder / "source" / name
        if not to.exists() or to.read_bytes() != new:
            to.parent.mkdir(parents=True, exist_ok=True)
            to.write_bytes(new)
    found = subprocess.run([sys.executable, "-m", "pybind11", "--cmakedir"], check=True, capture_output=True, text=True)
    tree, pybind = folder / "build", found.stdout.strip()
    flags = ["-DISIMP_THESIS=OFF", "-DISIMP_CUDA=OFF", "-DISIMP_PYTHON=ON", f"-DPython_EXECUTABLE={sys.executable}"]
    flags += [f"-Dpybind11_DIR={pybind}", *(["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else [])]
    subprocess.run(["cmake", "-S", folder / "source", "-B", tree, "-G", "Ninja", *flags], check=True)
    subprocess.run(["ninja", "-C", tree, f"-j{jobs}", "isimp_python"], check=True)
    return tree / "python"


def other_values(value: float, kind: str) -> list[float]:
    """Half and twice a value."""
    if kind not in ("double", "float"):
        return [max(1, int(value) // 2) if value > 1 else 0, 2 * int(value)]
    if 0.6 <= value < 1:
        return [1 - 2 * (1 - value), 1 - (1 - value) / 2]
    if 1 < value <= 1.5:
        return [1 + (value - 1) / 2, 1 + (value - 1) * 2]
    return [value / 2, value * 2]


Change = list[float] | None


class Engine:
    """The runs, with the engine of `build`."""

    def __init__(self, places: dict[str, int]) -> None:
        import isimp_engine
        from bench.quality import small_runs

        library = ctypes.CDLL(isimp_engine._core.__file__)
        library.isimp_values.restype = ctypes.POINTER(ctypes.c_double)
        library.isimp_states.restype = ctypes.POINTER(ctypes.c_ubyte)
        self.values, self.states = library.isimp_values(), library.isimp_states()
        self.places, self.runs, self.options = places, small_runs.RUNS, small_runs.OPTIONS
        self.base: dict[str, small_runs.Outcome] = {}
        self.reads: dict[str, list[int]] = {}
        self.seconds: dict[str, float] = {}
        for name, run in self.runs.items():
            run()  # makes the input
            for place in range(2048):
                self.states[place] = 0
            started = time.process_time()
            self.base[name] = run()
            self.seconds[name] = time.process_time() - started
            self.reads[name] = [place for place in range(2048) if self.states[place]]

    def value_of(self, c: Constant) -> float:
        return float(c.value) if c.file == "option" else self.values[self.places[c.key]]

    def readers(self, c: Constant) -> list[str]:
        """The runs that read a constant, the quickest first."""
        some = [name for name in self.runs if c.file == "option" or self.places[c.key] in self.reads[name]]
        return sorted(some, key=self.seconds.__getitem__)

    def tried(self, c: Constant, value: float) -> dict[str, Change]:
        """By tried run: polygons and distance where the bits are others, [] for the same bits, None for a failure."""
        runs = self.readers(c)
        seconds = int(5 + 4 * sum(self.seconds[name] for name in runs))
        end, write = os.pipe()
        child = os.fork()
        if child == 0:
            resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            if c.file == "option":
                self.options[c.name] = int(value) if c.type == "int" else value
            else:
                self.values[self.places[c.key]], self.states[self.places[c.key]] = value, 2
            differs = False
            for k, name in enumerate(runs):
                if differs and k >= QUICKEST:
                    break
                os.write(write, (json.dumps([name, None]) + "\n").encode())
                new = self.runs[name]()
                line = [name, [new.polygons, new.distance] if new.bits != self.base[name].bits else []]
                differs = differs or line[1] != []
                os.write(write, (json.dumps(line) + "\n").encode())
            os._exit(0)
        os.close(write)
        with os.fdopen(end) as pipe:
            rows = dict(json.loads(line) for line in pipe)
        os.waitpid(child, 0)
        return rows


def compared(base: dict[str, tuple[int, float]], rows: dict[str, Change]) -> list[float]:
    """The numbers of tried, differing and failed runs, and the changes of polygons and of the mean distance in %."""

    def change(column: int) -> float:
        pairs = [(row[column], base[name][column]) for name, row in rows.items() if row and row[column] > 0]
        return 100 * (float(np.exp(sum(np.log(a / b) for a, b in pairs if b > 0) / max(1, len(rows)))) - 1)

    others = [row for row in rows.values() if row != []]
    return [len(rows), len(others), others.count(None), change(0), change(1)]


def measure(only: list[str], out: Path) -> None:
    results = json.loads(out.read_text()) if out.exists() else {}
    engine = Engine(places_of(measured()))
    base = {name: (o.polygons, o.distance) for name, o in engine.base.items()}
    for c in measured() + options():
        is_wanted = not only or any(part in c.key for part in only)
        if not is_wanted or results.get(c.key, {}).get("value") == c.value:
            continue
        runs, rows = engine.readers(c), {}
        for value in other_values(engine.value_of(c), c.type) if runs else ():
            rows[f"{value:.4g}"] = compared(base, engine.tried(c, value))
        results[c.key] = {"value": c.value, "runs": len(runs), "rows": rows}
        out.write_text(json.dumps(results, indent=1))
        print(c.key, results[c.key], file=sys.stderr, flush=True)


def cell(change: float) -> str:
    return "0" if abs(change) < 0.05 else f"{change:+.1f}" if abs(change) < 10 else f"{change:+.0f}"


def head_of(c: Constant) -> str:
    place = c.file.removeprefix("src/").removeprefix("include/isimp/")
    meaning = c.meaning.replace("|", "\\|")
    return f"| `{c.name}`, `{place}` | {c.value} | {c.data} | {meaning} |"


def row_of(c: Constant, result: dict | None) -> str:
    """A line of the table: half and twice with the runs that differ, polygons and distance."""
    cells = []
    for value, (tried, other, failed, polygons, distance) in (result["rows"] if result else {}).items():
        change = f"{other} of {tried}: {cell(polygons)}, {cell(distance)}" if other else "="
        cells.append(f"{value}: {change}" + (f", {failed} fail" if failed else ""))
    cells += [""] * (2 - len(cells))
    return f"{head_of(c)} {result['runs'] if result else ''} | " + " | ".join(cells) + " |"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="parts of FILE:NAME")
    parser.add_argument("--folder", type=Path, default=ROOT / "out" / "constants")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--json", type=Path, default=ROOT / "out" / "constants.json")
    parser.add_argument("--table", type=Path)
    parser.add_argument("--measure", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.table:
        results = json.loads(given.table.read_text())
        head, _, _ = PAGE.read_text().partition("| constant |")
        lines = ["| constant | value | tuned on | meaning | runs | half | twice |", "|---|---|---|---|---:|---|---|"]
        lines += [row_of(c, results.get(c.key)) for c in tuned() + options()]
        PAGE.write_text(head + "\n".join(lines) + "\n")
        return 0
    if given.measure:
        measure([p for p in given.only.split(",") if p], given.json)
        return 0
    package = build(given.folder, given.jobs)
    given.json.parent.mkdir(parents=True, exist_ok=True)
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(package), str(ROOT)])}
    return subprocess.run([sys.executable, __file__, *sys.argv[1:], "--measure"], env=environment).returncode


if __name__ == "__main__":
    raise SystemExit(main())
