"""Prints the section of CHANGELOG.md of a version: scripts/release_notes.py 0.1.0."""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def section(changelog: str, version: str) -> str:
    """The text between the heading of the version and the next."""
    heading = re.search(rf"^## \[?{re.escape(version)}\]?(?![\w.]).*$", changelog, re.MULTILINE)
    if not heading:
        raise SystemExit(f"CHANGELOG.md has no section {version}: rename Unreleased to it")
    rest = changelog[heading.end() :]
    return re.split(r"^## ", rest, maxsplit=1, flags=re.MULTILINE)[0].strip()


if __name__ == "__main__":
    print(section((ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), sys.argv[1]))
