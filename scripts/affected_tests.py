"""The tests that a change touches, by place: ctest|pytest BUILD_DIR COMMIT -> a pattern of labels, or paths.

native/src/MODULE, and files with its headers       tests/cpp/MODULE, tests/python/engine/test_{MODULE,FILE}.py
native/include, native/bindings                     tests/python/engine and project
python/isimp_engine/NAME                            tests/python/FOLDER for each folder of NAME in ROOMS
python/isimp_engine, other files                    tests/python/engine and command
addon/isimp, outside blender                        tests/python/addon
bench, tests/shared                                 the tests that import the file
docs, scripts, CMake and other files                tests/python/project
a test                                              itself
"""

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
EMPTY = "4b825dc642cb6eb9a060e54bf8d69288fbee4904"  # git's name of a tree without files
PYTHON = ROOT / "tests" / "python"
ROOMS = {
    "batch": ["batch"],
    "children": ["batch", "tiles"],
    "tiles": ["tiles"],
    "cli": ["command"],
    "exporting": ["command"],
    "recipe": ["addon", "command"],
    "replay": ["addon", "command", "engine"],
    "recipes": ["command"],
    "reports": ["command"],
}


def output(*command: str) -> str:
    return subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout


def changed_since(commit: str = "") -> set[Path]:
    """The files that differ from a commit, untracked ones too."""
    names = output("git", "diff", "--name-only", commit or EMPTY).splitlines()
    names += output("git", "ls-files", "--others", "--exclude-standard").splitlines()
    return {(ROOT / name).resolve() for name in names}


def read_by_source(build: Path) -> dict[Path, set[Path]]:
    """The inputs of each object in ninja's record: its source, and all files that this includes."""
    found: dict[Path, set[Path]] = {}
    source = None
    for line in output("ninja", "-C", str(build), "-t", "deps").splitlines():
        if not line.startswith(" "):
            source = None
            continue
        path = (build / line.strip()).resolve()
        if source is None:  # the first one listed is the source itself
            source = path
            found[source] = set()
        found[source].add(path)
    return found


def affected(build: Path, changed: set[Path]) -> list[Path]:
    """The compiled sources that read a changed file."""
    return sorted(source for source, files in read_by_source(build).items() if files & changed)


def labels(sources: list[Path]) -> str:
    """A pattern of the labels of C++ tests: the modules of compiled sources, and all of them for shared ones."""
    found = set()
    for source in sources:
        parts = source.relative_to(ROOT).parts
        if parts[:2] in (("native", "src"), ("tests", "cpp")) and len(parts) > 3:
            found.add(parts[2])
    if "shared" in found:
        return "."
    return f"^({'|'.join(sorted(found))})(-|$)" if found else ""


def importers(name: str) -> list[Path]:
    """The tests in Python that import a module of tests/shared or bench."""
    pattern = re.compile(rf"^(?:from|import) .*\b{name}\b", re.MULTILINE)
    return [path for path in PYTHON.glob("*/test_*.py") if pattern.search(path.read_text())]


def python_tests(path: Path) -> list[Path]:
    """The tests in Python that a changed file touches."""
    parts = path.relative_to(ROOT).parts
    if parts[:2] == ("tests", "python"):
        if path.name.startswith("test_"):
            return [] if parts[2] == "blender" or not path.exists() else [path]
        return [] if parts[2] == "blender" else [PYTHON / room for room in ("engine", "command", "batch", "tiles")]
    if parts[:2] == ("native", "src"):
        named = (PYTHON / "engine" / f"test_{name}.py" for name in (parts[2], path.stem))
        return [test for test in named if test.is_file()]
    if parts[0] == "native":
        return [PYTHON / "engine", PYTHON / "project"]
    if parts[:2] == ("python", "isimp_engine"):
        return [PYTHON / room for room in ROOMS.get(Path(parts[2]).stem, ["engine", "command"])]
    if parts[0] == "addon":
        return [] if parts[2:3] == ("blender",) else [PYTHON / "addon"]
    if parts[0] == "bench" or parts[:2] == ("tests", "shared"):
        return importers(path.stem)
    return [] if parts[0] == "tests" else [PYTHON / "project"]


def main(runner: str, build: str, commit: str = "") -> None:
    changed = changed_since(commit)
    if runner == "ctest":
        print(labels(affected(ROOT / build, changed)))
        return
    tests = {test for path in changed for test in python_tests(path)}
    for test in sorted(tests):
        if not any(parent in tests for parent in test.parents):
            print(test.relative_to(ROOT))


if __name__ == "__main__":
    main(*sys.argv[1:])
