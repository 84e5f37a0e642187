"""Lines of code by folder, and named constants of the engine, at some commits side by side.

python scripts/lines.py [COMMIT ...] -> a table; without a commit, of HEAD.
"""

import io
import re
import subprocess
import sys
import tarfile
from collections import Counter
from pathlib import PurePath

SOURCES = {".cpp", ".h", ".cu", ".cuh", ".py", ".sh"}
DEPTH = {"native": 3, "python": 2, "addon": 2, "tests": 2, "cuda": 1}  # folders of a path that name its row
CONSTANT = re.compile(rb"(?:constexpr\b.*?|^ +|, )\bk[A-Z]\w* = ")


def count(commit: str) -> Counter[str]:
    """Lines by row, and the constants in `native`."""
    archive = subprocess.run(["git", "archive", "--format=tar", commit], check=True, capture_output=True).stdout
    rows: Counter[str] = Counter()
    with tarfile.open(fileobj=io.BytesIO(archive)) as files:
        for member in files:
            path, file = PurePath(member.name), files.extractfile(member)
            if path.suffix not in SOURCES or file is None:
                continue
            text = file.read()
            top = path.parts[0]
            for row in {"/".join(path.parent.parts[: DEPTH.get(top, 1)]), f"{top}, all", "all"}:
                rows[row] += text.count(b"\n")
            if top == "native":
                rows["constants of native"] += sum(len(CONSTANT.findall(line)) for line in text.splitlines())
    return rows


def main() -> None:
    commits = sys.argv[1:] or ["HEAD"]
    counts = [count(commit) for commit in commits]
    print(f"{'':28}" + "".join(f"{commit:>12.10}" for commit in commits))
    for row in sorted({row for rows in counts for row in rows}):
        print(f"{row:28}" + "".join(f"{rows[row]:12}" for rows in counts))


if __name__ == "__main__":
    main()
