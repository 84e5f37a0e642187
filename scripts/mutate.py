"""Seeded faults: whether the tests find them. mutate.py [--only TEXT] [--core FILE] -> a line each, and the count.

Each row of mutations.tsv is FILE, OLD text, NEW text, TESTS. It is applied to a work tree of its own, whose tests are
then run. For a Python file TESTS are arguments of pytest (--core: the compiled module of the engine to use). For a file
of native/ they are a label of ctest, and its program is compiled first. Found: a test or the compiler fails.
"""

import argparse
import csv
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TABLE = Path(__file__).with_name("mutations.tsv")
LONGEST = 900.0  # seconds of tests; a mutant that takes longer counts as found
PYTEST = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-m", "not slow"]
CMAKE = ["cmake", "-S", ".", "-B", "build-mutate", "-G", "Ninja", "-DISIMP_TESTS=ON", "-DISIMP_CUDA=OFF",
         "-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"]  # fmt: skip
NINJA = ["ninja", "-C", "build-mutate", "-j1"]
CTEST = ["ctest", "--test-dir", "build-mutate", "-j1", "--stop-on-failure"]


def rows(only):
    with TABLE.open(newline="", encoding="utf-8") as file:
        for row in csv.reader(file, delimiter="\t", quoting=csv.QUOTE_NONE):
            if row and only in row[0]:
                yield row


def failure(command, tree, **options):
    """The test that fails, or the program; empty if all is well."""
    try:
        done = subprocess.run(command, cwd=tree, timeout=LONGEST, capture_output=True, text=True, **options)
    except subprocess.TimeoutExpired:
        return "timeout"
    named = re.search(r"(?m)^(?:FAILED|ERROR) (\S+)|\d+ - (\S+) \(Failed\)", done.stdout)
    return "" if done.returncode == 0 else (named[1] or named[2]) if named else command[0]


def commands(file, tests):
    """The commands that must pass, for one row."""
    if not file.startswith("native/"):
        return [[*PYTEST, *shlex.split(tests)]]
    return [[*NINJA, f"test_{tests}"], [*CTEST, "-L", f"^{tests}(-|$)", "-LE", "slow"]]


def found_by(tree, file, old, new, tests):
    """The test that fails with a fault; empty if none does."""
    path = tree / file
    text = path.read_text(encoding="utf-8")
    if text.count(old) != 1:
        sys.exit(f"{file}: '{old}' is there {text.count(old)} times")
    path.write_text(text.replace(old, new), encoding="utf-8")
    environment = os.environ | {"PYTHONPATH": str(tree / "python"), "PYTHONDONTWRITEBYTECODE": "1"}
    try:
        return next(filter(None, (failure(command, tree, env=environment) for command in commands(file, tests))), "")
    finally:
        path.write_text(text, encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="rows whose file has this text in its name")
    parser.add_argument("--core", type=Path, help="the compiled module, _core.*.so")
    asked = parser.parse_args()
    found = count = 0
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder, "tree")
        subprocess.run(["git", "worktree", "add", "--detach", tree, "HEAD"], cwd=ROOT, check=True, capture_output=True)
        try:
            if asked.core:
                shutil.copy(asked.core, tree / "python" / "isimp_engine")
            if "native" in asked.only:
                subprocess.run(CMAKE, cwd=tree, check=True, capture_output=True)
            for row in rows(asked.only):
                began = time.monotonic()
                by = found_by(tree, *row)
                count, found = count + 1, found + bool(by)
                print(by or "NOT FOUND", f"{time.monotonic() - began:.0f} s", *row[:3], sep="\t", flush=True)
        finally:
            subprocess.run(["git", "worktree", "remove", "--force", tree], cwd=ROOT, check=True)
    print(f"{found} of {count} found")


if __name__ == "__main__":
    main()
