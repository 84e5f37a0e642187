"""The engine's sources that a change touches: BUILD_DIR COMMIT -> one path a line.

A source counts if it has changed since COMMIT by git, or if it includes a file that has changed, by ninja's record of
the compiler. Without COMMIT, all sources count.
"""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
EMPTY = "4b825dc642cb6eb9a060e54bf8d69288fbee4904"  # git's name of a tree without files


def output(*command: str) -> str:
    return subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout


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


def main(build: str, commit: str = "") -> None:
    ours = ROOT / "native" / "src"
    read = {source: files for source, files in read_by_source(ROOT / build).items() if source.is_relative_to(ours)}
    names = output("git", "diff", "--name-only", commit or EMPTY).splitlines()
    changed = {(ROOT / name).resolve() for name in names}
    for source in sorted(source for source, files in read.items() if files & changed):
        print(source)


if __name__ == "__main__":
    main(*sys.argv[1:])
