"""Counts mannered words in comments and docstrings, per thousand words, and fails above a limit.

    python scripts/plain_words.py [--worst N] [FOLDER ...]

It reads C++, CUDA, Python and shell files that git knows. LIMITS has the limit of each folder. With FOLDER arguments,
it prints the lines of these folders and checks nothing.
"""

import argparse
import ast
import io
import re
import subprocess
import sys
import tokenize
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
LIMIT = 1.2  # over all folders without a limit of their own
LIMITS = {  # folders that are plain and have to stay so
    "addon": 1.0,
    "bench": 1.0,
    "examples": 1.0,
    "python": 1.0,
    "scripts": 1.0,
    "tests/python": 1.0,
    "tests/shared": 1.0,
    "native/include/isimp/meshing": 0.5,
    "native/src/meshing": 0.5,
}
OF_C = {".h", ".cpp", ".cu", ".cuh", ".in"}

# A sentence that begins with one of these has no noun as its subject, or a module that speaks.
FIRST = re.compile(
    r"(that of|those|of|and|none (where|if)|nothing (where|if)|the same (for|of|as|with)|"
    r"gives?|takes?|lets?|looks?|hands?|has .* (looked|fetched|open))\b",
    re.IGNORECASE,
)
PHRASES = re.compile(
    r"\b("
    r"what|whoever|whatever|those (that|of|round|which|with|whose|who|in|on|at|from|to|by|where|beside|near)"
    r"|lets? go|letting go|goes|gone|went"
    r"|round (a|an|the|it|its|them|their|this|that|each|every|one|some|which|both|all|many|those)"
    r"|beside|anew|as it was|as they were|is so again|so far|at last|but for"
    r"|tells?|told|says?|said|asks|asked|nobody|somebody|looks? (at|for|up|whether)|looked (at|for|up)|be had|so many"
    r")\b",
    re.IGNORECASE,
)
SENTENCE = re.compile(r"(?<=[.:!?])\s+(?=[A-Z`\"(\\])")
WORD = re.compile(r"[A-Za-z]+(?:['-][A-Za-z]+)*")


class Block(NamedTuple):
    """The text of a comment or a docstring, with the line of each of its parts."""

    lines: list[tuple[int, str]]


class Finding(NamedTuple):
    path: str
    line: int
    words: list[str]
    text: str


def blocks(comments: list[tuple[int, bool, str]]) -> Iterator[Block]:
    """Joins comments of consecutive lines. A comment behind code begins a block, and lines below may continue it."""
    block: list[tuple[int, str]] = []
    for line, alone, text in comments:
        if block and not (alone and line == block[-1][0] + 1):
            yield Block(block)
            block = []
        block.append((line, text))
    if block:
        yield Block(block)


OF_CPP = re.compile(
    r'R"(?P<d>[^(\s]*)\((?:.|\n)*?\)(?P=d)"'  # raw string
    r'|"(?:\\.|[^"\\\n])*"'
    r"|(?<![0-9A-Fa-f])'(?:\\.|[^'\\\n])*'"
    r"|(?P<comment>//[^\n]*|/\*(?:.|\n)*?\*/)"
)


OF_TOOLS = re.compile(r"// (namespace\b|NOLINT)")


def cpp_comments(text: str) -> list[tuple[int, bool, str]]:
    found = []
    for match in OF_CPP.finditer(text):
        if not match["comment"] or OF_TOOLS.match(match["comment"]):
            continue
        line = text.count("\n", 0, match.start()) + 1
        alone = not text[text.rfind("\n", 0, match.start()) + 1 : match.start()].strip()
        for at, part in enumerate(match["comment"].split("\n")):
            found.append((line + at, alone or at > 0, part.strip(" /*<!\r")))
    return found


def python_comments(text: str) -> list[tuple[int, bool, str]]:
    found = []
    lines = text.split("\n")
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            alone = not lines[token.start[0] - 1][: token.start[1]].strip()
            found.append((token.start[0], alone, token.string.strip("#:! ")))
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef) and node.body:
            first = node.body[0]
            if ast.get_docstring(node) and isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant):
                parts = str(first.value.value).split("\n")
                found.extend((first.lineno + at, at > 0, part.strip()) for at, part in enumerate(parts))
    return sorted(found)


def shell_comments(text: str) -> list[tuple[int, bool, str]]:
    found = []
    for number, line in enumerate(text.split("\n"), 1):
        for match in re.finditer(r"(?:^|(?<=\s))#(?!!)(.*)$", line):
            code = line[: match.start()]
            if code.count('"') % 2 == code.count("'") % 2 == 0:
                found.append((number, not code.strip(), match[1].strip("# ")))
    return found


READERS = {".py": python_comments, ".pyi": python_comments, ".sh": shell_comments} | dict.fromkeys(OF_C, cpp_comments)


def findings(path: str, text: str) -> tuple[int, list[Finding]]:
    """The number of words in the comments of a file, and its mannered words by line."""
    total = 0
    found: dict[int, Finding] = {}
    for block in blocks(READERS[Path(path).suffix](text)):
        starts, joined = [], ""
        for line, part in block.lines:
            starts.append((len(joined), line, part))
            joined += part + ("\n\n" if not part else " ")
        total += len(WORD.findall(joined))
        hits = [(match.start(), match[0]) for match in PHRASES.finditer(joined)]
        begins = [0] + [match.end() for match in SENTENCE.finditer(joined)]
        begins += [match.end() for match in re.finditer(r"\n\n\s*|\s- ", joined)]
        for begin in sorted(set(begins)):
            lead = re.match(r"[\s(\"-]*(\\(param|return|throws|tparam|brief)\b(\[\w+\])?\s*)?", joined[begin:])
            at = begin + (lead.end() if lead else 0)
            first = FIRST.match(joined, at)
            if first and not any(start <= at < start + len(word) for start, word in hits):
                hits.append((at, first[0]))
        for at, word in sorted(hits):
            _, line, part = max(start for start in starts if start[0] <= at)
            found.setdefault(line, Finding(path, line, [], part)).words.append(word)
    return total, [found[line] for line in sorted(found)]


def listed(folders: list[str]) -> list[str]:
    names = subprocess.run(
        ["git", "ls-files", *folders], cwd=ROOT, check=True, capture_output=True, text=True
    ).stdout.splitlines()
    return [name for name in names if Path(name).suffix in READERS and (ROOT / name).is_file()]


def folder(path: str) -> str:
    """The folder that a file counts for: a module of the engine or of the package, or a folder of the top."""
    own = [name for name in LIMITS if path.startswith(f"{name}/")]
    if own:
        return own[0]
    parts = Path(path).parts[:-1]
    depth = {"native": 4 if parts[1:2] == ("include",) else 3, "python": 3, "tests": 2}.get(path.split("/")[0], 1)
    return "/".join(parts[:depth]) or "."


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("folders", nargs="*", help="print the lines of these folders, and check nothing")
    parser.add_argument("--worst", type=int, default=15, help="print so many lines")
    arguments = parser.parse_args()
    counts: dict[str, list[int]] = {}
    lines: dict[str, list[Finding]] = {}
    for path in listed(arguments.folders):
        words, found = findings(path, (ROOT / path).read_text(encoding="utf-8"))
        count = counts.setdefault(folder(path), [0, 0])
        count[0] += words
        count[1] += sum(len(each.words) for each in found)
        lines.setdefault(folder(path), []).extend(found)
    if arguments.folders:
        for each in (each for found in lines.values() for each in found):
            print(f"{each.path}:{each.line}: [{', '.join(each.words)}] {each.text}")
        sys.exit()
    rates = {name: 1000 * found / max(words, 1) for name, (words, found) in counts.items()}
    worst = [each for name in lines if name not in LIMITS or rates[name] > LIMITS[name] for each in lines[name]]
    worst.sort(key=lambda each: (-len(each.words), each.path, each.line))
    for each in worst[: arguments.worst]:
        print(f"{each.path}:{each.line}: {', '.join(each.words)}")
    failed = False
    rest = [0, 0]
    print(f"{'folder':36} {'words':>7} {'found':>6} {'per thousand':>13}")
    for name, (words, found) in sorted(counts.items()):
        limit = f"   limit {LIMITS[name]}" if name in LIMITS else ""
        print(f"{name:36} {words:7} {found:6} {rates[name]:13.1f}{limit}")
        if name in LIMITS:
            failed |= rates[name] > LIMITS[name]
        else:
            rest = [rest[0] + words, rest[1] + found]
    rate = 1000 * rest[1] / max(rest[0], 1)
    print(f"{'all without a limit of their own':36} {rest[0]:7} {rest[1]:6} {rate:13.1f}   limit {LIMIT}")
    if failed or rate > LIMIT:
        sys.exit("too many mannered words in comments: write a noun as the subject and a usual verb")


if __name__ == "__main__":
    main()
