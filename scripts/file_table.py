"""Writes docs/files.md and the end of bench/README.md: files by folder, with the first sentence of their comments.

    python scripts/file_table.py

A Python file and a script give the first sentence of their docstring or first comment, a Python file without a
docstring that of its first class. A C++ header and the source of its name share a row. Its sentence is the first one of
these: the comment above the first include, the comment of the declaration that is named like the file, the first
comment of a declaration. A test fails where the page is out of date or a file has no sentence.
"""

import ast
import re
import subprocess
from collections.abc import Iterable, Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "files.md"
BENCH = ROOT / "bench" / "README.md"
MARK = "<!-- Below this line: written by scripts/file_table.py. -->\n"
HEAD = """# Files

Written by `scripts/file_table.py` from the first sentences of comments and docstrings; do not edit.
[Architecture](architecture.md) explains how the parts work together. A bold name is a public header of the engine.
"""
PUBLIC = "native/include/isimp/"
CODE = {".h", ".cpp", ".cu", ".py", ".sh"}
TOPS = ("native", "cuda", "python", "addon", "scripts")
LONG = 160  # characters
LEFT_OUT = {"__init__.py", "__main__.py"}  # if they are empty


def listed(tops: Iterable[str]) -> Iterator[Path]:
    """The source files of some folders that git knows, uncommitted ones too."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "--", *tops]
    names = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout.splitlines()
    for name in sorted(set(names)):
        path = ROOT / name
        if path.suffix in CODE and path.is_file() and (path.name not in LEFT_OUT or path.read_text().strip()):
            yield path


def folder_of(path: Path) -> str:
    """The folder of a row: that of the sources, for a public header too."""
    folder = path.parent.relative_to(ROOT).as_posix()
    return folder.replace(PUBLIC, "native/src/")


def units(tops: Iterable[str]) -> dict[str, dict[str, list[Path]]]:
    """By folder and name: the files of each row, headers first."""
    found: dict[str, dict[str, list[Path]]] = {}
    for path in listed(tops):
        name = path.name if path.suffix in {".py", ".sh"} else path.stem
        found.setdefault(folder_of(path), {}).setdefault(name, []).append(path)
    for rows in found.values():
        for files in rows.values():
            files.sort(key=lambda path: (path.suffix != ".h", path.as_posix()))
    return found


def first_sentence(text: str) -> str:
    """The first sentence of a comment: up to a full stop, a blank or an indented line; if long, up to a colon."""
    paragraph = " ".join(re.split(r"\n\s*\n|\n\s{2,}", text.strip())[0].split())
    sentence = re.split(r"(?<!e\.g)(?<!i\.e)\.(?=\s|$)", paragraph)[0]
    if len(sentence) > LONG:
        sentence = re.split(r"[:;](?=\s)", sentence)[0]
    return sentence.rstrip(": ")


def comment_at(lines: list[str], start: int, mark: str) -> tuple[str, int]:
    """The text of the comment lines from `start` on, and the line after them."""
    end = start
    while end < len(lines) and lines[end].startswith(mark):
        end += 1
    text = "\n".join(re.sub(rf"^{mark}+<?\s?", "", line) for line in lines[start:end])
    return text.split("\\param")[0].split("\\throws")[0], end


def plain(name: str) -> str:
    return name.replace("_", "").lower()


def sentence_of_cpp(files: list[Path]) -> str:
    """The sentence of a header and its source; empty without a comment."""
    first = ""
    for path in files:
        lines = path.read_text().splitlines()
        if lines and lines[0].startswith("//"):
            return first_sentence(comment_at(lines, 0, "//")[0])
        at = 0
        while at < len(lines):
            if not lines[at].startswith("//"):
                at += 1
                continue
            text, at = comment_at(lines, at, "///" if lines[at].startswith("///") else "//")
            declaration = re.split(r"[({;=]", " ".join(lines[at : at + 2]))[0]
            words = re.findall(r"\w+", declaration)
            if first_sentence(text) and plain(path.stem) in {plain(word) for word in words}:
                return first_sentence(text)
            first = first or (first_sentence(text) if not text.startswith("NOLINT") else "")
    return first


def sentence_of(files: list[Path]) -> str:
    """The sentence of a row; empty if none of its files has one."""
    path = files[0]
    if path.suffix == ".py":
        tree = ast.parse(path.read_text())
        texts = [ast.get_docstring(node) for node in (tree, *tree.body) if isinstance(node, ast.Module | ast.ClassDef)]
        return first_sentence(next(filter(None, texts), ""))
    if path.suffix == ".sh":
        lines = [line for line in path.read_text().splitlines() if not line.startswith("#!")]
        return first_sentence(comment_at(lines, 0, "#")[0]) if lines else ""
    return sentence_of_cpp(files)


def name_of(name: str, files: list[Path]) -> str:
    """The first cell of a row."""
    shown = name if "." in name else name + (".h" if files[0].suffix == ".h" else files[0].suffix)
    public = files[0].relative_to(ROOT).as_posix().startswith(PUBLIC)
    return f"**`{shown}`**" if public else f"`{shown}`"


def tables(tops: Iterable[str]) -> str:
    """A table for each folder. Raises SystemExit if a file has no sentence."""
    parts, missing = [], []
    for folder, rows in sorted(units(tops).items()):
        parts.append(f"## {folder}\n\n| file | content |\n|---|---|")
        for name, files in sorted(rows.items()):
            sentence = sentence_of(files).replace("|", "\\|")
            if not sentence:
                missing += [str(path.relative_to(ROOT)) for path in files[:1]]
            parts.append(f"| {name_of(name, files)} | {sentence} |")
        parts.append("")
    if missing:
        raise SystemExit(f"no first sentence in: {', '.join(missing)}")
    return "\n".join(parts).rstrip() + "\n"


def page() -> str:
    """The whole of docs/files.md."""
    return f"{HEAD}\n{tables(TOPS)}"


def bench_page() -> str:
    """The whole of bench/README.md."""
    return f"{BENCH.read_text(encoding='utf-8').partition(MARK)[0]}{MARK}\n{tables(('bench', 'tests/shared'))}"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    BENCH.write_text(bench_page(), encoding="utf-8")
