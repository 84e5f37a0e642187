"""Files that comments and pages name exist."""

import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
COMMENT = {".h": "//", ".cpp": "//", ".cu": "//", ".py": "#", ".md": ""}
MADE_UP = {"tests/python/project/test_tidy_sources.py"}  # its programs name files of their own
HISTORY = {"CHANGELOG.md"}  # it names removed files
NAME = re.compile(r"(?<![\w./<])((?:[a-z_]+/)*[a-z_]+\.(?:h|cpp|cu|py))\b")


def test_files_that_comments_name_exist() -> None:
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True)
    if listed.returncode:
        pytest.skip("this is no clone")
    files = listed.stdout.split()
    ends = {"/".join(Path(file).parts[-k:]) for file in files for k in range(1, len(Path(file).parts) + 1)}
    missing = []
    for file in set(files) - MADE_UP - HISTORY:
        mark = COMMENT.get(Path(file).suffix)
        if mark is None or not (ROOT / file).exists():
            continue
        for number, line in enumerate((ROOT / file).read_text(encoding="utf-8").splitlines(), 1):
            comment = line.partition(mark)[2] if mark else line
            missing += [f"{file}:{number}: {name}" for name in NAME.findall(comment) if name not in ends]
    assert not missing
