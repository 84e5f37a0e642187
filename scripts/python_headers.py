"""Fetches the headers of a Python that this machine lacks, to build a module for it.

    scripts/python_headers.py 3.14 FOLDER

Prints the value for ISIMP_OTHER_PYTHONS of native/bindings/CMakeLists.txt: the module's suffix and the folders. apt
brings them from Debian sid by the mirror that this machine uses, as in `scripts/headers.py`; for x86-64, without root.
Modules fit every patch of a Python, so Debian's signature is checked, and no checksum is fixed.
"""

import sys
from pathlib import Path

from headers import Apt, Missing, attempt, fetched, unpack

SUITE = "sid"  # the one Debian that has Python 3.14


def entry(version: str, folder: Path) -> str:
    """The suffix and the folders: Python's own, and the one from which it includes the machine's pyconfig.h."""
    python = f"python{version}"
    return f".cpython-{version.replace('.', '')}-x86_64-linux-gnu.so={folder / python},{folder}"


def bring(version: str, target: Path) -> None:
    def fill(scratch: Path, made: Path) -> None:
        (scratch / "files").mkdir()
        (file,) = Apt(scratch / "apt", SUITE).download_any(f"libpython{version}-dev", scratch / "files")
        headers = unpack(file, scratch / "unpacked") / "usr" / "include"
        if not (headers / f"python{version}" / "Python.h").exists():
            raise Missing(f"{file.name}: no Python.h in it")
        headers.rename(made)

    if not (target / f"python{version}" / "Python.h").exists():
        fetched(target, fill)
    print(entry(version, target))


def main(argv: list[str]) -> int:
    return attempt(lambda: bring(argv[0], Path(argv[1]).resolve()))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
