"""The folder of the meshes, files for other programs, and C++ programs, which are compiled where they are used."""

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
