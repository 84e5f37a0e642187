"""Makes README.md and pyproject.toml of a copy of the source fit for the page of an index such as PyPI.

    scripts/index_page.py SOURCE [WEBSITE]

There, links relative to the repository lead nowhere. With the address of the project they become absolute, and the page
gets links to the project; without one their text stays, and pictures are left out. `scripts/package.sh` calls it.
"""

import re
import sys
from pathlib import Path

LINK = re.compile(r"(!?)\[([^\]]*)\]\((?!https?://|mailto:|#)([^)\s]+)\)")


def readme(text: str, website: str | None, version: str) -> str:
    """The text with absolute links, as GitHub has them, or without relative ones."""

    def changed(found: re.Match[str]) -> str:
        picture, words, target = found.groups()
        if website:
            return f"{picture}[{words}]({website}/{'raw' if picture else 'blob'}/v{version}/{target})"
        return "" if picture else words

    return LINK.sub(changed, text)


def project(text: str, website: str | None) -> str:
    """pyproject.toml with the addresses of the project."""
    if not website:
        return text
    urls = {"Homepage": website, "Issues": f"{website}/issues", "Changelog": f"{website}/blob/main/CHANGELOG.md"}
    lines = "".join(f'{name} = "{url}"\n' for name, url in urls.items())
    return text.replace("[project.scripts]\n", f"[project.urls]\n{lines}\n[project.scripts]\n")


def main(source: Path, website: str | None = None) -> None:
    website = website and website.rstrip("/")
    stated = re.search(r"project\(isimp VERSION ([0-9.]+)", (source / "CMakeLists.txt").read_text(encoding="utf-8"))
    for name, change in (
        ("README.md", lambda text: readme(text, website, stated[1])),
        ("pyproject.toml", lambda text: project(text, website)),
    ):
        place = source / name
        place.write_text(change(place.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    main(Path(sys.argv[1]), *sys.argv[2:])
