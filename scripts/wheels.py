"""Makes the wheels for people from the wheels of the build.

    scripts/wheels.py fatten WHEEL... --out FOLDER   one wheel for all Pythons of a platform: py3-none-PLATFORM
    scripts/wheels.py split WHEEL --out FOLDER       the opposite: one ordinary wheel for each Python
    scripts/wheels.py checksums FOLDER               FILE.sha256 next to each file

The fat wheel holds one _core for each Python side by side, and each Python loads the one with its own suffix.
Blender needs it: 4.2.0 ignores the Python tag and takes the highest file name.
"""

import argparse
import base64
import hashlib
import re
import sys
import zipfile
from collections.abc import Iterable
from pathlib import Path

EARLIEST = (1980, 1, 1, 0, 0, 0)  # the date of every file, so that the same input gives the same wheel
# isimp_engine/_core.cpython-311-x86_64-linux-gnu.so, isimp_engine/_core.cp311-win_amd64.pyd
MODULE = re.compile(r"isimp_engine/_core\.(?:cpython-|cp)(?P<python>[0-9]+)-.*\.(?:so|pyd)")

Files = dict[str, tuple[bytes, int]]  # content of a wheel: contents and permissions, by name


def read(wheel: Path) -> Files:
    with zipfile.ZipFile(wheel) as archive:
        entries = [entry for entry in archive.infolist() if not entry.is_dir()]
        return {
            entry.filename: (archive.read(entry), (entry.external_attr >> 16) & 0o777 or 0o644) for entry in entries
        }


def name_parts(wheel: Path) -> tuple[str, str, str]:
    """Distribution and version, and the two last tags: Python's ABI, and the platform."""
    name, version, _, abi, platform = wheel.name.removesuffix(".whl").split("-")
    return f"{name}-{version}", abi, platform


def write(folder: Path, stem: str, python: str, platform: str, files: Files) -> Path:
    """A wheel with these files and new tags and record."""
    info = f"{stem}.dist-info"
    about = re.sub(r"(?m)^Tag: .*\n?", "", files[f"{info}/WHEEL"][0].decode()).rstrip() + "\n"
    about += "".join(f"Tag: {python}-{part}\n" for part in platform.split("."))
    files = {name: data for name, data in files.items() if name != f"{info}/RECORD"}
    files[f"{info}/WHEEL"] = (about.encode(), 0o644)
    record = ""
    for name, (data, _) in sorted(files.items()):
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        record += f"{name},sha256={digest},{len(data)}\n"
    files[f"{info}/RECORD"] = (f"{record}{info}/RECORD,,\n".encode(), 0o644)
    folder.mkdir(parents=True, exist_ok=True)
    target = folder / f"{stem}-{python}-{platform}.whl"
    with zipfile.ZipFile(target, "w") as archive:
        for name, (data, mode) in sorted(files.items()):
            entry = zipfile.ZipInfo(name, EARLIEST)
            entry.external_attr = (0o100000 | mode) << 16
            archive.writestr(entry, data, zipfile.ZIP_DEFLATED, compresslevel=9)
    return target


def pythons(names: Iterable[str]) -> list[str]:
    """The Pythons that a wheel has a module for: 310, 311, ..."""
    found = {match["python"] for name in names if (match := MODULE.fullmatch(name))}
    return sorted(found, key=lambda python: (int(python[0]), int(python[1:])))


def fatten(wheels: list[Path], folder: Path) -> Path:
    stems, platforms = ({name_parts(wheel)[i] for wheel in wheels} for i in (0, 2))
    if len(stems) != 1 or len(platforms) != 1:
        raise SystemExit(f"wheels of one version and one platform are wanted, got {sorted(w.name for w in wheels)}")
    stem, platform, files = stems.pop(), platforms.pop(), {}
    for wheel in sorted(wheels):
        for name, (data, mode) in read(wheel).items():
            made_anew = name in (f"{stem}.dist-info/WHEEL", f"{stem}.dist-info/RECORD")
            made_anew |= name.endswith("/sboms/auditwheel.cdx.json")  # names its wheel; the first one's is kept
            if not made_anew and name in files and files[name][0] != data:
                raise SystemExit(f"{wheel.name}: {name} differs from that of another wheel")
            files.setdefault(name, (data, mode))
    if not pythons(files):
        raise SystemExit(f"no module isimp_engine/_core in {sorted(wheel.name for wheel in wheels)}")
    return write(folder, stem, "py3-none", platform, files)


def with_modules(files: Files, wanted: Iterable[str]) -> Files:
    """The files without the modules of other Pythons."""
    others = {name for name in files if (match := MODULE.fullmatch(name)) and match["python"] not in wanted}
    return {name: data for name, data in files.items() if name not in others}


def slim(wheel: Path, wanted: Iterable[str], folder: Path) -> Path:
    """A fat wheel with the modules of these Pythons alone; the same name."""
    (stem, _, platform), files = name_parts(wheel), read(wheel)
    return write(folder, stem, "py3-none", platform, with_modules(files, wanted))


def split(wheel: Path, folder: Path) -> list[Path]:
    (stem, _, platform), files = name_parts(wheel), read(wheel)
    made = [
        write(folder, stem, f"cp{python}-cp{python}", platform, with_modules(files, [python]))
        for python in pythons(files)
    ]
    if not made:
        raise SystemExit(f"{wheel.name}: no module isimp_engine/_core in it")
    return made


def checksums(folder: Path) -> list[Path]:
    """For `sha256sum -c`. Checksums of files that no longer exist are removed too."""
    for old in folder.glob("*.sha256"):
        old.unlink()
    made = []
    for path in sorted(path for path in folder.iterdir() if path.is_file()):
        target = path.with_name(path.name + ".sha256")
        target.write_text(f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n")
        made.append(target)
    return made


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    verbs = parser.add_subparsers(dest="verb", required=True)
    for name, count in (("fatten", "+"), ("split", 1)):
        verb = verbs.add_parser(name)
        verb.add_argument("wheels", type=Path, nargs=count)
        verb.add_argument("--out", type=Path, required=True)
    verbs.add_parser("checksums").add_argument("folder", type=Path)
    options = parser.parse_args(argv)
    if options.verb == "fatten":
        made = [fatten(options.wheels, options.out)]
    elif options.verb == "split":
        made = split(options.wheels[0], options.out)
    else:
        made = checksums(options.folder)
    print(*made, sep="\n")


if __name__ == "__main__":
    sys.exit(main())
