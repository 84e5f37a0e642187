"""The sources that clang-tidy checks after a change: COMMIT -> one path a line.

Each source of native/src whose code has changed since COMMIT, and one source for each header whose code has changed.
Comments, blank lines and includes are no code: clang-tidy finds nothing in them. Neither is it a change if names get
other names of the same style, each everywhere. A moved file is compared with the file that it was.
"""

import re
import subprocess
import sys
from pathlib import Path

from affected_tests import ROOT, output
from plain_words import OF_CPP

SUFFIXES = (".cpp", ".h", ".cu")
INSIDE = ROOT / "native" / "src"
INCLUDE = re.compile(r'^#include "([^"]+)"', re.M)
TOKEN = re.compile(r"(?:std|CGAL|Eigen)(?:::\w+)+|[A-Za-z_]\w*|\S")
WORDS = """
alignas auto bool break case catch char class concept const consteval constexpr constinit continue decltype default
delete do double else enum explicit extern false final float for friend if inline int long mutable namespace new
noexcept nullptr operator override private protected public requires return short signed sizeof static static_cast
struct switch template this throw true try typename union unsigned using virtual void volatile while
"""
KEYWORDS = frozenset(WORDS.split())


def code_of(text: str) -> list[str]:
    """The lines of a C++ file without comments, blank lines and includes."""
    bare = OF_CPP.sub(lambda found: " " if found["comment"] else found.group(), text)
    lines = (" ".join(line.split()) for line in bare.splitlines())
    return [line for line in lines if line and not line.startswith("#include")]


def style_of(name: str) -> str:
    """The parts of a name that the rules of names look at."""
    start = "k" if re.match("k[A-Z]", name) else "upper " if name[0].isupper() else "lower "
    return start + ("_" if name.endswith("_") else "")


def without_own_names(code: list[str]) -> list[str]:
    """The tokens of some code, with numbers for names that are neither keywords nor of a library."""
    numbers: dict[str, int] = {}

    def token(text: str) -> str:
        if text in KEYWORDS or "::" in text or not re.match(r"[A-Za-z_]", text):
            return text
        return f"{style_of(text)}{numbers.setdefault(text, len(numbers))}"

    return [token(text) for text in TOKEN.findall("\n".join(code))]


def at(commit: str, name: str) -> str:
    """A file's text at a commit; empty if it was not there."""
    found = subprocess.run(["git", "show", f"{commit}:{name}"], cwd=ROOT, capture_output=True, text=True)
    return found.stdout if found.returncode == 0 else ""


def with_changed_code(commit: str) -> set[Path]:
    """The C++ files whose code differs from that at a commit."""
    changed = set()
    for line in output("git", "diff", "--name-status", "-M", "-l0", commit).splitlines():
        status, *names = line.split("\t")
        if status != "D" and names[-1].endswith(SUFFIXES):
            now, before = (code_of(text) for text in ((ROOT / names[-1]).read_text(), at(commit, names[0])))
            if now != before and without_own_names(now) != without_own_names(before):
                changed.add((ROOT / names[-1]).resolve())
    return changed


def chosen(read: dict[Path, set[Path]], changed: set[Path]) -> list[Path]:
    """The changed sources, and sources that together read all changed headers: the one with the most left, in turn."""
    picked = {source for source in read if source in changed}
    left = {path for files in read.values() for path in files & changed}
    for source in picked:
        left -= read[source]
    while left:
        best = max(sorted(read), key=lambda source: len(read[source] & left))
        picked.add(best)
        left -= read[best]
    return sorted(picked)


def read_by(source: Path) -> set[Path]:
    """A source, and our own headers that it includes, directly or through others."""
    module = INSIDE / source.relative_to(INSIDE).parts[0]
    folders = [module, ROOT / "native" / "include", ROOT / "cuda", *sorted(INSIDE.iterdir())]
    read, todo = {source}, [source]
    while todo:
        for name in INCLUDE.findall(todo.pop().read_text()):
            path = next((folder / name for folder in folders if (folder / name).exists()), None)
            if path is not None and path not in read:
                read.add(path)
                todo.append(path)
    return read


def main(commit: str) -> None:
    for source in chosen({source: read_by(source) for source in INSIDE.rglob("*.cpp")}, with_changed_code(commit)):
        print(source)


if __name__ == "__main__":
    main(*sys.argv[1:])
