"""The scans of a batch, the places of their results, and the memory that each may need."""

import glob
import hashlib
import json
import os
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath
from typing import Any

from .. import __version__
from ..children.errors import BatchError
from ..reading import KINDS, head_of, inner, is_compressed, kind_of
from ..texturing.linked import buffers, looks

_MB = 1 << 20
_BASE_MB = 60.0  # memory of an interpreter with numpy and the engine
_MB_PER_FACE = 260e-6  # measured peak of a run that finds the number of regions, with a margin
_RATIO = 6  # usual upper bound of the unpacked size over the compressed size
_BYTES_PER_FACE = {".ply": 15, ".obj": 30, ".stl": 50, ".off": 24}  # lower bounds


State = tuple[str, int, int]  # a file's path, its bytes and the time of its last change, ns


@dataclass(frozen=True)
class Scan:
    """An input file of a batch."""

    path: Path  #: absolute
    name: str  #: unique in the batch: the path below the input folder, with /
    size: int  #: bytes
    changed: int  #: time of the last change, ns
    output: str = ""  #: the path of the result below the output folder, with /
    linked: tuple[State, ...] = ()  #: the buffers, materials and images that the file names

    def key(self, recipe: dict[str, Any]) -> str:
        """Return an identifier of the work, from the state of the files, the recipe and the version of the engine."""
        values = [self.name, self.size, self.changed, self.output, recipe, __version__]
        values += [self.linked] if self.linked else []
        return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()[:32]


def find_scans(inputs: Any, suffix: str = ".obj", besides: Path | None = None) -> list[Scan]:
    """Return the scans that `inputs` names, sorted by name.

    inputs: a path or a pattern with `*`, `?`, `[...]` or `**`, or a list of them. A folder stands for all files of
            the kinds `reading.KINDS` in it and in its folders, without hidden ones. A file of another kind is a list:
            one path on each line, relative to the list's folder; `#` begins a comment. The name of a single file is its
            path below the last folder that all single files share.
    suffix: suffix of the results.
    besides: a folder that is not searched.

    Raises BatchError if no scan is found, or if two scans would have the same name.
    """
    texts = [inputs] if isinstance(inputs, (str, os.PathLike)) else list(inputs)
    alone = [path for text in texts if kind_of(path := _absolute(os.fspath(text))) in KINDS and path.is_file()]
    base = _common(alone) if alone else Path.cwd()
    pairs = [pair for text in texts for pair in _named(os.fspath(text), base, len(texts) > 1, besides)]
    found = _without_repeats(pairs)
    if not found:
        kinds = ", ".join(KINDS)
        raise BatchError(f"{', '.join(map(str, texts)) or 'no input'}: there is no scan ({kinds}) in it")
    scans = []
    for name, path in sorted(found.items()):
        try:
            state = path.stat()
        except OSError:  # its row gets the error: a missing scan must not stop the others
            scans.append(Scan(path, name, 0, 0))
            continue
        files = states(path, [*buffers(path), *looks(path)])
        scans.append(Scan(path, name, state.st_size, state.st_mtime_ns, linked=files))
    return _with_outputs(scans, suffix)


def states(path: Path, linked: Iterable[Path]) -> tuple[State, ...]:
    """Return the states of files that a scan names, with their paths from its folder; 0 for one that is missing."""
    found = set()
    for file in linked:
        name = os.path.relpath(file, path.parent)
        try:
            state = file.stat()
            found.add((name, state.st_size, state.st_mtime_ns))
        except (OSError, ValueError):  # ValueError: no system has such a name
            found.add((name, 0, 0))
    return tuple(sorted(found))


def _without_repeats(pairs: Sequence[tuple[str, Path]]) -> dict[str, Path]:
    """Return the paths by their names; each file appears once."""
    found: dict[str, Path] = {}
    seen: dict[str, str] = {}
    for name, path in pairs:
        real = os.path.realpath(path)
        if seen.setdefault(real, name) != name and name not in found:
            continue  # the same file under another name
        if found.setdefault(name, path) != path and os.path.realpath(found[name]) != real:
            raise BatchError(f"{found[name]} and {path} would both be '{name}': give the folder that holds both")
    return found


def _with_outputs(scans: Sequence[Scan], suffix: str) -> list[Scan]:
    """Set the paths of results after the scans' paths. The scan's suffix stays if two would else be equal."""
    short = [str(PurePosixPath(inner(scan.name)).with_suffix(suffix)) for scan in scans]
    times = Counter(name.casefold() for name in short)
    outputs = [
        name if times[name.casefold()] == 1 else scan.name + suffix for name, scan in zip(short, scans, strict=True)
    ]
    taken: dict[str, Scan] = {}
    for output, scan in zip(outputs, scans, strict=True):
        if other := taken.get(output.casefold()):
            raise BatchError(f"{other.path} and {scan.path} would both be written to '{output}': rename one")
        taken[output.casefold()] = scan
    return [replace(scan, output=output) for scan, output in zip(scans, outputs, strict=True)]


def _absolute(text: str) -> Path:
    return Path(os.path.abspath(text))  # noqa: PTH100  (links stay as they are)


def _common(paths: Sequence[Path]) -> Path:
    """Return the last folder that the paths share."""
    return Path(os.path.commonpath([path.parent for path in paths]))


def _named(text: str, base: Path, several: bool, besides: Path | None) -> Iterator[tuple[str, Path]]:
    """Yield names and paths of the scans of one argument. base: the folder where names of single files begin."""
    path = _absolute(text)
    if path.is_dir():
        before = f"{path.name}/" if several else ""
        yield from ((before + _below(path, each), each) for each in _in_folder(path, besides))
    elif path.exists():
        if kind_of(path) in KINDS:
            yield _below(base, path), path
        else:
            yield from _in_list(path)
    elif glob.has_magic(text):
        fixed = fixed_part(text)
        for each in sorted(glob.glob(text, recursive=True)):  # noqa: PTH207  (may be absolute)
            match = _absolute(each)
            if match.is_file() and kind_of(match) in KINDS and not _is_inside(match, besides):
                yield _below(fixed, match), match
    else:
        raise BatchError(f"{text}: there is no such file or folder")


def fixed_part(pattern: str) -> Path:
    """Return the folder of a pattern above its first wildcard."""
    parts = _absolute(pattern).parts
    fixed = [part for k, part in enumerate(parts[:-1]) if not any(map(glob.has_magic, parts[: k + 1]))]
    return Path(*fixed)


def _below(folder: Path, path: Path) -> str:
    return PurePosixPath(*path.relative_to(folder).parts).as_posix()


def _is_inside(path: Path, folder: Path | None) -> bool:
    return folder is not None and path.resolve().is_relative_to(folder.resolve())


def _in_folder(folder: Path, besides: Path | None) -> Iterator[Path]:
    """Yield the scans in a folder and its folders, also behind links. Each folder is visited once."""
    seen, waiting = set(), [folder]
    while waiting:
        place = waiting.pop()
        real = os.path.realpath(place)
        if real in seen or _is_inside(place, besides):
            continue
        seen.add(real)
        try:
            entries = sorted(os.scandir(place), key=lambda entry: entry.name)
        except OSError as error:
            raise BatchError(f"{place}: {error.strerror}") from None
        for entry in entries:
            if entry.name.startswith("."):
                continue
            if _is_folder(entry):
                waiting.append(Path(entry.path))
            elif kind_of(entry.name) in KINDS:  # also a pipe or a broken link, whose row gets the error
                yield Path(entry.path)


def _is_folder(entry: os.DirEntry[str]) -> bool:
    """Return whether an entry is a folder or a link to one. A link to itself is no folder."""
    try:
        return entry.is_dir()
    except OSError:
        return False


def _in_list(path: Path) -> Iterator[tuple[str, Path]]:
    try:
        lines = path.read_text(encoding="utf-8-sig", errors="surrogateescape").splitlines()
    except OSError as error:
        raise BatchError(f"{path}: {error.strerror}") from None
    if any("\0" in line for line in lines[:10]):
        raise BatchError(f"{path}: is neither a scan ({', '.join(KINDS)}) nor a list of scans")
    texts = [text for line in lines if (text := line.strip()) and not text.startswith("#")]
    paths = [_absolute(str(path.parent / text)) for text in texts]
    if paths:
        inside = all(each.is_relative_to(path.parent) for each in paths)
        base = path.parent if inside else _common(paths)
        yield from ((_below(base, each), each) for each in paths)


def estimated_faces(path: Path) -> int:
    """Estimate the number of faces of a file from its header and size. The size sets an upper bound."""
    try:
        if not path.is_file():  # a pipe can be read only once
            return 0
        size = path.stat().st_size
        head = head_of(path, 4096)
    except OSError:
        return 0
    kind = kind_of(path)
    if is_compressed(path):
        size *= _RATIO
    if kind == ".gltf":  # other files may have its numbers
        size += sum(more for _, more, _ in states(path, buffers(path)))
    most = size // _BYTES_PER_FACE.get(kind, 15)
    said = None
    if kind == ".ply" and (match := re.search(rb"element\s+face\s+(\d+)", head)):
        said = int(match[1])
    elif kind == ".stl" and len(head) >= 84:
        count = int.from_bytes(head[80:84], "little")
        said = count if size == 84 + 50 * count else size // 250  # otherwise it is a text file
    elif kind == ".off" and (match := re.match(rb"\s*\w*OFF\s+(?:#[^\n]*\n\s*)*(\d+)\s+(\d+)", head)):
        said = int(match[2])
    return most if said is None else min(said, most)


def needed_mb(faces: int, size: int) -> float:
    """Estimate the memory in MB for a run on `faces` faces in a file of `size` bytes."""
    return _BASE_MB + _MB_PER_FACE * faces + size / _MB
