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


def main(build: str, commit: str = "") -> None:
    for source in affected(ROOT / build, changed_since(commit)):
        if source.is_relative_to(ROOT / "native" / "src"):
            print(source)


if __name__ == "__main__":
    main(*sys.argv[1:])
