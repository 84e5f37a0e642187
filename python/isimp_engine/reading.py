"""Files of meshes, compressed ones too."""

import gzip
import importlib
import os
import shutil
import tempfile
import zlib
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from os import PathLike
from pathlib import Path
from types import ModuleType
from typing import IO

import numpy as np
from numpy.typing import NDArray

from . import _core, three_mf
from ._core import FileError, Job
from .file_errors import reader

GLTF = (".glb", ".gltf")
KINDS = (".obj", ".ply", *GLTF, ".stl", ".off", ".3mf")  #: kinds of files with faces
_POINTS = (".las", ".laz", ".e57", ".xyz", ".pcd", ".pts")
TO_A_MESH = "make a mesh of them first, for example by Poisson reconstruction in CloudCompare (docs/points.md)"
COMPRESSED = (".gz", ".zst")  #: may follow the kind of a file: scan.ply.gz
_BLOCK = 1 << 20
_PIECE = 1 << 11  # bytes of .zst that are decompressed at once: they give 64 MB at most
_ANY, _RATIO = 1 << 28, 200  # bytes that every file may become, and the multiple of its size that a larger one may
_FREE = 1 << 30  # bytes of a disk that stay free, or a twentieth of a small one


def inner(path: str | PathLike[str]) -> Path:
    """A name without the suffix of a compression: scan.ply for scan.ply.gz."""
    place = Path(path)
    return place.with_suffix("") if is_compressed(place) else place


def is_compressed(path: str | PathLike[str]) -> bool:
    return Path(path).suffix.lower() in COMPRESSED


def kind_of(path: str | PathLike[str]) -> str:
    """The suffix that determines the kind of a file, in lower case: .ply for scan.PLY.gz."""
    return inner(path).suffix.lower()


def check_kind(path: str | PathLike[str], kinds: Sequence[str] = KINDS) -> str:
    """The suffix of a file that can be read, as `kind_of` returns it. Raises FileError for others."""
    kind = kind_of(path)
    if kind in _POINTS:
        raise FileError(f"{path}: has points, not faces; {TO_A_MESH}")
    if kind not in kinds:
        raise FileError(f'{path}: the extension "{kind}" is not known; it can be {", ".join(kinds)}')
    return kind


def check_faces(path: Path, points: int, faces: int) -> None:
    """Raises FileError for a file of points without faces."""
    if points and not faces:
        raise FileError(f"{path}: has {points:,} points and no faces; {TO_A_MESH}")


def _zstd() -> ModuleType | None:
    """A module that reads .zst: Python 3.14 has one."""
    for name in ("compression.zstd", "zstandard"):
        try:
            return importlib.import_module(name)
        except ImportError:
            pass
    return None


def opened(path: Path) -> IO[bytes]:
    """A file's contents, out of their compression. Raises FileError for a missing package, OSError."""
    kind = path.suffix.lower()
    if kind == ".gz":
        return gzip.open(path, "rb")  # type: ignore[return-value, unused-ignore]
    if kind != ".zst":
        return path.open("rb")
    module = _zstd()
    if module is None:
        raise FileError(f"{path}: to read it the package zstandard is needed: pip install 'isimp[zstd]'")
    stream: IO[bytes] = module.open(path, "rb")
    return stream


def _blocks(path: Path) -> Iterator[bytes]:
    """All of a file, decompressed."""
    module = _zstd() if path.suffix.lower() == ".zst" else None
    if module is None or module.__name__ != "zstandard":
        with opened(path) as source:
            while block := source.read(_BLOCK):
                yield block
        return
    # The package's own stream takes a file that was cut short for whole.
    frame = module.ZstdDecompressor().decompressobj()
    with path.open("rb") as file:
        begun = False
        while data := file.read(_BLOCK):
            at = 0
            while at < len(data):
                if frame.eof:
                    frame = module.ZstdDecompressor().decompressobj()
                piece = data[at : at + _PIECE]
                yield frame.decompress(piece)
                at, begun = at + len(piece) - len(frame.unused_data if frame.eof else b""), True
    if begun and not frame.eof:
        raise EOFError("it ends within a frame")


def _damage() -> tuple[type[Exception], ...]:
    """The exceptions of the modules for a damaged file."""
    module = _zstd()
    return (EOFError, zlib.error, gzip.BadGzipFile) + (() if module is None else (module.ZstdError,))


def _most(path: Path) -> int:
    """The bytes that a compressed file may become."""
    return max(_ANY, _RATIO * path.stat().st_size)


def _limited(path: Path, place: Path) -> Iterator[bytes]:
    """As above, up to the size that a file of this size may have, and that the disk of `place` has room for."""
    most, made, looked = _most(path), 0, 0
    for block in _blocks(path):
        made += len(block)
        if made > most:
            much = f"more than {_RATIO} times its size, as no scan does"
            raise FileError(f"{path}: becomes {much}; if it is one all the same, decompress it first")
        if made - looked > _BLOCK << 6:
            looked, disk = made, shutil.disk_usage(place)
            if disk.free < min(_FREE, disk.total // 20):
                raise FileError(f"{path}: can't be decompressed, since the disk of {place} is nearly full")
        yield block


@contextmanager
def plain(path: Path, folder: Path | None = None, job: Job | None = None) -> Iterator[Path]:
    """The file itself, or an unpacked copy of it, which is removed when the block ends.

    folder: for the copy; None: the system's for such files. Raises FileError, which names `path`, and Cancelled.
    """
    if not is_compressed(path) or path.is_dir():
        yield path
        return
    with tempfile.TemporaryDirectory(prefix=".isimp", dir=folder) as place:
        copy = Path(place) / inner(path).name
        try:
            with copy.open("wb") as target:
                for block in _limited(path, Path(place)):
                    target.write(block)
                    if job is not None and job.cancelled:
                        raise _core.Cancelled("cancelled")
        except _damage() as error:
            raise FileError(f"{path}: its compression is damaged or cut short ({error})") from None
        except FileNotFoundError:
            raise FileError(f"{path}: there is no such file") from None
        except OSError as error:
            raise FileError(f"{path}: can't be decompressed to {place}: {error.strerror or error}") from None
        try:
            yield copy
        except FileError as error:
            raise FileError(str(error).replace(str(copy), str(path))) from None


def _named(path: str | PathLike[str], job: Job | None) -> AbstractContextManager[str | PathLike[str]]:
    """The path to read for a path; names that are of no compressed file stay as they are, bytes too."""
    if isinstance(path, (str, bytes, PathLike)) and is_compressed(os.fsdecode(path)):
        return plain(Path(os.fsdecode(path)), job=job)
    return nullcontext(path)


def _triangles(path: str | PathLike[str]) -> tuple[NDArray[np.float64], NDArray[np.int32]] | None:
    """Vertices and triangles of a kind that is read here; None for a kind that the engine reads."""
    if not isinstance(path, (str, bytes, PathLike)):
        return None  # refused by the engine
    place = Path(os.fsdecode(path))
    kind = check_kind(place)
    if kind == ".3mf":
        with reader(path, "is damaged, or not 3MF"):
            return three_mf.read(place, _most(place))
    if kind in GLTF:
        from .texturing import glb  # reads files by this module

        with reader(path, "is damaged, or not glTF 2.0"):
            return glb.shape(place)
    return None


def read(
    path: str | PathLike[str], *, job: Job | None = None, threads: int = 0
) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Read the triangles of a PLY, OBJ, STL, OFF, glTF or 3MF file; also .gz and .zst of them.

    Polygons are cut into triangles.

    Returns vertices (V, 3) and triangles (F, 3). Raises FileError, which names the fault and its place, or Cancelled.
    """
    with _named(path, job) as place:
        return _triangles(place) or _core.read(place, job=job, threads=threads)


def read_polygons(
    path: str | PathLike[str], job: Job | None = None, *, threads: int = 0
) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.int32]]:
    """Read the polygons of a PLY, OBJ, STL or OFF file, with any number of corners, or the triangles of glTF or 3MF.

    Also of .gz and .zst files of them.
    Returns vertices (V, 3), loops (L,) and loop_start (Q,). Raises FileError or Cancelled.
    """
    with _named(path, job) as place:
        if found := _triangles(place):
            vertices, triangles = found
            return vertices, triangles.ravel(), np.arange(0, triangles.size, 3, dtype=np.int32)
        return _core.read_polygons(place, job=job, threads=threads)


def unit_of(path: Path, job: Job | None = None) -> str | None:
    """The unit of a file's coordinates, if the file states it: 3MF does. Raises FileError or Cancelled."""
    if kind_of(path) != ".3mf":
        return None
    with plain(path, job=job) as place, reader(place, "is damaged, or not 3MF"):
        return three_mf.unit_of(place)


def head_of(path: Path, size: int) -> bytes:
    """The first bytes of a file, out of their compression; none where that can't be read."""
    try:
        with opened(path) as file:
            return bytes(file.read(size))
    except (OSError, FileError):
        return b""
    except _damage():
        return b""
