"""Fetches the source that the engine is built upon: CGAL, Boost, Eigen, fast_float and OpenMesh.

    scripts/headers.py [FOLDER]    the default is third_party

CMake calls it where the system lacks them. `scripts/package.sh` calls it for the sdist, which then holds them. pip
brings Boost, Eigen and OpenMesh. apt brings CGAL and fast_float from the mirror of Debian that this machine uses, and
needs no root. A file with another SHA-256 than below is refused.
"""

import hashlib
import os
import shutil
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from collections.abc import Callable
from pathlib import Path, PurePosixPath

ROOT = Path(__file__).resolve().parent.parent
SUITE = "trixie"  # the Debian that has the packages below

# Name, version, SHA-256 of the file.
OF_PYPI = [
    ("boost-headers", "1.85.0.post1", "4510a571d3bf6c5e913b31d2a9b2441ee79f883ae42d42a5882dd1da46b35e7f"),
    ("cmeel-eigen", "3.4.1", "0ccd7b73fe8a72e2729784253c982e75d1790e0a8c71f302eb5a1fb1dd3a8a90"),
    ("openmesh", "1.2.1", "6fd3fa41a68148e4a7523f562426aa9758bf65ccc6642abcf79c37bae9c6af3c"),
]
OF_DEBIAN = [
    ("libcgal-dev", "6.0.1-1", "462110b9e0779ff7a214bb4c1048c0dee475c1522a0ba293d9fd6c7600ace777"),
    ("libfast-float-dev", "8.0.0-0.1", "db379bf3ebeff1796b746568d15b8a9557a8d2dc383e717a022144b42b368dd2"),
]

LICENCES = """\
Source of others that iSimp is built upon, unchanged. The folder licences has the texts.

| what | version | licence |
|---|---|---|
| CGAL | 6.0.1 | LGPL-3.0-or-later, and GPL-3.0-or-later for triangulate_hole |
| Boost | 1.85.0 | BSL-1.0 |
| Eigen | 3.4.1 | MPL-2.0 |
| fast_float | 8.0.0 | MIT, Apache-2.0 or BSL-1.0 |
| OpenMesh | 11 (of openmesh 1.2.1) | BSD-3-Clause |
"""


class Missing(Exception):
    """A requirement is missing; the message gives its name, the reason and the remedy."""


def checked(folder: Path, name: str, sha256: str) -> Path:
    """The one file in a folder, if it has this checksum."""
    files = list(folder.iterdir())
    if len(files) != 1:
        raise Missing(f"{name}: expected one file, got {[file.name for file in files]}")
    found = hashlib.sha256(files[0].read_bytes()).hexdigest()
    if found != sha256:
        raise Missing(f"{files[0].name}: its SHA-256 is {found}, not {sha256}, so it is not used")
    return files[0]


def run(command: list[str], what: str, **more: object) -> None:
    done = subprocess.run(command, capture_output=True, text=True, **more)
    if done.returncode:
        why = (done.stderr.strip() or done.stdout.strip() or f"exit {done.returncode}").splitlines()[-1]
        raise Missing(f"{what}: {command[0]} failed: {why}")


def from_pypi(name: str, version: str, sha256: str, folder: Path) -> Path:
    """The wheel or sdist. -I: also inside pip's own builds, whose Python hides pip."""
    kind = ["--no-binary=:all:"] if name == "openmesh" else ["--only-binary=:all:"]
    pip = [sys.executable, "-I", "-m", "pip", "download", "--quiet", "--disable-pip-version-check", "--no-deps"]
    run([*pip, *kind, "--dest", str(folder), f"{name}=={version}"], f"{name} {version}")
    return checked(folder, name, sha256)


class Apt:
    """apt with a list of its own, of the suite that has our versions; the machine's own list does not change."""

    def __init__(self, state: Path, suite: str = SUITE):
        if not shutil.which("apt-get") or not shutil.which("dpkg-deb"):
            raise Missing("CGAL is fetched by apt, which this system lacks")
        (state / "lists" / "partial").mkdir(parents=True)
        (state / "cache" / "archives" / "partial").mkdir(parents=True)
        asked = ["apt-get", "indextargets", "--format", "$(SITE)"]
        sites = subprocess.run(asked, capture_output=True, text=True).stdout.split()
        site = next((site for site in sites if site.endswith("/debian")), None)
        keys = Path("/usr/share/keyrings/debian-archive-keyring.gpg")
        if site is None or not keys.exists():
            raise Missing("CGAL is fetched from Debian, and this system's apt knows no mirror of Debian")
        (state / "sources.list").write_text(f"deb [signed-by={keys}] {site} {suite} main\n")
        settings = {
            "Dir::Etc::sourcelist": state / "sources.list",
            "Dir::Etc::sourceparts": "-",
            "Dir::State::lists": state / "lists",
            "Dir::State::status": "/dev/null",
            "Dir::Cache": state / "cache",
            "APT::Architecture": "amd64",  # headers alone: the same for all
            "APT::Architectures": "amd64",
        }
        if os.geteuid() == 0:
            settings["APT::Sandbox::User"] = "root"
        self._apt = ["apt-get", "-qq", *(f"-o{key}={value}" for key, value in settings.items())]
        run([*self._apt, "update"], f"the list of Debian {suite}")

    def download(self, name: str, version: str, sha256: str, folder: Path) -> Path:
        run([*self._apt, "download", f"{name}={version}"], f"{name} {version}", cwd=folder)
        return checked(folder, name, sha256)

    def download_any(self, name: str, folder: Path) -> list[Path]:
        """Downloads any version of the suite; apt checks that it is Debian's."""
        run([*self._apt, "download", name], name, cwd=folder)
        return list(folder.iterdir())


# The libraries of Boost, whole, that the files of CGAL in use need by the compiler's list of headers (g++ -M).
BOOST = [
    "algorithm", "any", "assert", "concept", "config", "container", "container_hash", "core", "describe",
    "detail", "dynamic_bitset", "exception", "functional", "fusion", "graph", "integer", "intrusive", "io",
    "iterator", "lexical_cast", "math", "move", "mp11", "mpl", "multi_index", "multiprecision", "optional",
    "parameter", "pending", "predef", "preprocessor", "property_map", "random", "range", "smart_ptr", "tuple",
    "type_index", "type_traits", "typeof", "unordered", "utility", "winapi"
]  # fmt: skip
OPENMESH = ("Core/", "Tools/Decimater/", "Tools/Utils/")

# The folder of each package's headers; the folders before the last name are left out.
FOLDERS = {
    "boost-headers": "boost_headers/include/boost",
    "cmeel-eigen": "cmeel.prefix/include/eigen3/Eigen",
    "openmesh": "openmesh-1.2.1/OpenMesh/src/OpenMesh",
    "libcgal-dev": "usr/include/CGAL",
    "libfast-float-dev": "usr/include/fast_float",
}


def wanted(name: str, path: PurePosixPath) -> bool:
    """Whether the engine needs this file, its path being relative to the folder above."""
    if name == "boost-headers":
        return len(path.parts) == 1 or path.parts[0] in BOOST
    if name == "openmesh":
        return path.as_posix().startswith(OPENMESH) and path.suffix in (".hh", ".cc", ".h")
    return True


def unpack(file: Path, scratch: Path) -> Path:
    scratch.mkdir()
    if file.suffix == ".whl":
        with zipfile.ZipFile(file) as archive:
            archive.extractall(scratch)  # noqa: S202 (its checksum was right)
    elif file.suffix == ".deb":
        run(["dpkg-deb", "-x", str(file), str(scratch)], file.name)
    else:
        with tarfile.open(file) as archive:
            more = {"filter": "data"} if hasattr(tarfile, "data_filter") else {}  # Python 3.11.2 lacks it
            archive.extractall(scratch, **more)  # noqa: S202 (its checksum was right)
    return scratch


def gather(name: str, tree: Path, target: Path) -> None:
    """Copies the headers of a package, and its licences."""
    top = tree / FOLDERS[name]
    files = [path for path in sorted(tree.rglob("*")) if path.is_file() and not path.is_symlink()]
    for source in files:
        place = None
        if source.is_relative_to(top):
            relative = source.relative_to(top)
            if wanted(name, PurePosixPath(relative.as_posix())):
                place = Path("include", top.name, relative)
        elif source.name.lower().startswith(("license", "copying", "copyright")) and source.suffix in ("", ".txt"):
            place = Path("licences", f"{name}-{source.name}")
        if place:
            (target / place).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, target / place)


def fetched(target: Path, fill: Callable[[Path, Path], None]) -> None:
    """Makes a new folder by `fill`, of a scratch folder and of its own; it appears only when all of it is complete."""
    target.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=target.parent) as work:
        fill(Path(work), Path(work) / "made")
        shutil.rmtree(target, ignore_errors=True)
        (Path(work) / "made").rename(target)


def fill(scratch: Path, made: Path) -> None:
    apt = Apt(scratch / "apt")
    sources = [(from_pypi, *row) for row in OF_PYPI] + [(apt.download, *row) for row in OF_DEBIAN]
    for bring, name, version, sha256 in sources:
        (scratch / name).mkdir()
        file = bring(name, version, sha256, scratch / name)
        gather(name, unpack(file, scratch / f"{name}-unpacked"), made)
    (made / "README.md").write_text(LICENCES)


def attempt(work: Callable[[], None], remedy: str = "") -> int:
    """The exit status of work that may lack a requirement, which is printed."""
    try:
        work()
    except Missing as reason:
        print(reason, *([remedy] if remedy else []), sep="\n", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if sys.argv[1:] else ROOT / "third_party"
    hint = "Install CGAL, Boost and Eigen yourself, or build from the sdist, which holds them."
    sys.exit(attempt(lambda: fetched(folder.resolve(), fill), hint))
