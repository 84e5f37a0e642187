"""The folder of the meshes, files for other programs, and C++ programs, which are compiled where they are used."""

import argparse
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]


def data_folder(given=None):
    """The folder of the meshes: as given, else ISIMP_DATA, else shared/data next to the checkout; None if nowhere."""
    candidates = [given] if given else [os.environ.get("ISIMP_DATA"), ROOT.parent / "shared" / "data"]
    return next((Path(c) for c in candidates if c and Path(c).is_dir()), None)


DATA = data_folder() or ROOT.parent / "shared" / "data"
FOLDERS = ("scan", "building", "nasty")


def scan_command(about, proxies, only=""):
    """A parser with the arguments of a run over scans: their folder, parts of their names, numbers of regions."""
    parser = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=DATA)
    parser.add_argument("--only", default=only, help="parts of names of scans, by commas")
    parser.add_argument("--proxies", default=",".join(map(str, proxies)))
    parser.add_argument("--json", type=Path)
    return parser


def scans(given, folders=FOLDERS):
    """The scans for such arguments."""
    paths = [path for folder in folders for path in sorted((given.data / folder).glob("*.ply"))]
    found = [path for path in paths if any(word in path.stem for word in given.only.split(","))]
    if not found:
        raise SystemExit(f"no meshes in {given.data}")
    return found


def around(vertices, triangles, face, most):
    """The faces that are nearest to one of them."""
    middle = np.nan_to_num(vertices[triangles].mean(axis=1))
    near = np.argsort(np.linalg.norm(middle - middle[face], axis=1), kind="stable")[:most]
    used, faces = np.unique(triangles[np.sort(near)], return_inverse=True)
    return vertices[used], faces.reshape(-1, 3).astype(np.int32)


def write_off(path, vertices, triangles):
    with path.open("w") as file:
        file.write(f"OFF\n{len(vertices)} {len(triangles)} 0\n")
        np.savetxt(file, vertices, fmt="%.17g")
        np.savetxt(file, np.column_stack([np.full(len(triangles), 3), triangles]), fmt="%d")


def write_ply(path, vertices, triangles):
    """Binary, with coordinates in double precision."""
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\n"
    head += "".join(f"property double {axis}\n" for axis in "xyz")
    head += f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    rows = np.empty(len(triangles), [("n", "u1"), ("i", "<i4", 3)])
    rows["n"], rows["i"] = 3, triangles
    with path.open("wb") as file:
        file.write(head.encode())
        np.asarray(vertices, "<f8").tofile(file)
        rows.tofile(file)


def headers_of_cgal(file: str) -> Path | None:
    """The folder of scripts/headers.py, or of the system, whose CGAL has this file."""
    cache = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
    kept = Path(os.environ.get("ISIMP_THIRD_PARTY", cache / "isimp" / "third_party"))
    folders = (folder / "include" for folder in (ROOT / "third_party", kept, Path("/usr")))
    return next((folder for folder in folders if (folder / "CGAL" / file).exists()), None)


def compiled(source: Path, *flags: str, cgal: str = "") -> Path:
    """The program or library of a source, in out/bench. cgal: a file that its CGAL has. Raises RuntimeError."""
    folder = ROOT / "out" / "bench"
    made, compiler, more = folder / source.stem, os.environ.get("CXX") or shutil.which("c++"), []
    if made.exists() and made.stat().st_mtime > source.stat().st_mtime:
        return made
    if compiler is None:
        raise RuntimeError("no C++ compiler")
    folder.mkdir(parents=True, exist_ok=True)
    if cgal:
        where = headers_of_cgal(cgal)
        if where is None:
            raise RuntimeError("no headers of CGAL: scripts/headers.py fetches them")
        only = folder / f"include-{source.stem}"  # CGAL alone: that folder has not all of Boost
        only.mkdir(exist_ok=True)
        if not (only / "CGAL").exists():
            (only / "CGAL").symlink_to(where / "CGAL")
        more = ["-I", str(only), "-I", "/usr/include/eigen3", "-lgmp", "-lmpfr"]
    command = [compiler, "-std=c++20", "-O3", "-DNDEBUG", "-w", *flags, str(source), "-o", str(made), *more]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{source.name} did not compile: {done.stderr.strip().splitlines()[-1]}")
    return made
