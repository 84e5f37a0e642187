"""Fetches the C library of an older Debian to link with, so that a wheel built here runs on systems as old as that.

    scripts/sysroot.py FOLDER

The compiler stays this machine's. `scripts/package.sh` gives it the folder as --sysroot. Needs apt, x86-64 and a mirror
of Debian, as `scripts/headers.py` does, and no root. Files with another SHA-256 than below are refused.
"""

import shutil
import sys
from pathlib import Path

from headers import Apt, attempt, fetched, unpack

SUITE = "bullseye"  # glibc 2.31
PACKAGES = [
    ("libc6", "2.31-13+deb11u11", "05f7264da867b37f4c5ce49266b558ea1e81e05a9464f623152fca70f3550282"),
    ("libc6-dev", "2.31-13+deb11u11", "e7f7b45d9c5cfcf37609f0b6efd3c645272c812144703af89dfd32218fcb0fd3"),
    ("linux-libc-dev", "5.10.223-1", "e3be603bd12377bb90fcfb0f2048ca3a81c886e49d6f09945b82159d1c54f7b2"),
    ("libcrypt-dev", "1:4.4.18-4", "8b04bf00b8c43360d9ba3adec209db290168ba3526d4aef3175fb84372b1bebf"),
    ("libgcc-s1", "10.2.1-6", "e478f2709d8474165bb664de42e16950c391f30eaa55bc9b3573281d83a29daf"),
    ("libgomp1", "10.2.1-6", "4530c95aefa48e33fd8cf4acbe5c4b559dbe7bdf4c56469986c83a203982cef1"),
]


def fill(scratch: Path, made: Path) -> None:
    apt = Apt(scratch / "apt", SUITE)
    for name, version, sha256 in PACKAGES:
        (scratch / name).mkdir()
        file = apt.download(name, version, sha256, scratch / name)
        tree = unpack(file, scratch / f"{name}-unpacked")
        shutil.copytree(tree, made, symlinks=True, dirs_exist_ok=True)
    for link in made.rglob("*"):  # absolute links would lead to this machine's own libraries
        if link.is_symlink() and link.readlink().is_absolute():
            place = made / link.readlink().relative_to("/")
            link.unlink()
            if place.exists():
                shutil.copyfile(place, link)


if __name__ == "__main__":
    sys.exit(attempt(lambda: fetched(Path(sys.argv[1]).resolve(), fill)))
