"""Fetches the headers of a Python that this machine lacks, to build a module for it.

    scripts/python_headers.py 3.14 FOLDER

Prints the value for ISIMP_OTHER_PYTHONS of native/bindings/CMakeLists.txt: the module's suffix and the folders. apt
brings them from Debian sid by the mirror that this machine uses, as in `scripts/headers.py`; for x86-64, without root.
Modules fit every patch of a Python, so Debian's signature is checked, and no checksum is fixed.
"""

import shutil
import sys
import tempfile
from pathlib import Path

from headers import Apt, Missing, unpack

SUITE = "sid"  # the one Debian that has Python 3.14


def entry(version: str, folder: Path) -> str:
    """The suffix and the folders: Python's own, and the one from which it includes the machine's pyconfig.h."""
    python = f"python{version}"
    return f".cpython-{version.replace('.', '')}-x86_64-linux-gnu.so={folder / python},{folder}"


def fetch(version: str, target: Path) -> None:
    """Makes a new folder; it appears only when all of it is complete."""
    target.parent.mkdir(parents=True, exist_ok=True)
    name = f"libpython{version}-dev"
    with tempfile.TemporaryDirectory(dir=target.parent) as work:
        scratch = Path(work)
        files = scratch / "files"
        files.mkdir()
        (file,) = Apt(scratch / "apt", SUITE).download_any(name, files)
        tree = unpack(file, scratch / "unpacked")
        headers = tree / "usr" / "include"
        if not (headers / f"python{version}" / "Python.h").exists():
            raise Missing(f"{file.name}: no Python.h in it")
        shutil.rmtree(target, ignore_errors=True)
        headers.rename(target)


def main(argv: list[str]) -> int:
    version, target = argv[0], Path(argv[1]).resolve()
    try:
        if not (target / f"python{version}" / "Python.h").exists():
            fetch(version, target)
    except Missing as reason:
        print(reason, file=sys.stderr)
        return 1
    print(entry(version, target))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
