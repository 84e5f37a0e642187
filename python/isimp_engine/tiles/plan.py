"""The plan of a run over tiles: inputs, output and options."""

import hashlib
import json
import os
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .. import FileError, InvalidInput, PartitionOptions, __version__, exporting
from ..batch.scans import find_scans, states
from ..children.errors import BatchError
from ..cli.errors import flag
from ..cli.files import is_same
from ..reading import KINDS, kind_of
from ..settings import OptionError, check_ranges
from ..texturing.linked import buffers
from .errors import TileFailed, TilesError
from .tileset import Leaf, leaves, tileset_of

DETAIL = 0.005  #: if neither a number nor a tolerance is given; the same as for one piece
PARTITION = ("proxies", "detail", "tolerance", "noise", "snap", "metric", "smooth", "leave_out", "seed")


@dataclass(frozen=True)
class Plan:
    """The inputs, output and options of a run."""

    inputs: list[tuple[str, Path]]  # names and files
    is_single: bool  # one scan, which is cut into tiles first
    output: Path
    work: Path
    options: dict[str, Any]
    leaves: tuple[Leaf, ...] = ()  # leaves of a tileset, in the order of `inputs`

    def key(self) -> str:
        files = [(name, str(p), p.stat().st_size, p.stat().st_mtime_ns) for name, p in self.inputs]
        values = [
            files,
            self.is_single,
            self.output.name,
            self.options,
            __version__,
            [leaf[1:] for leaf in self.leaves],
        ]
        linked = {name: found for name, path in self.inputs if (found := states(path, buffers(path)))}
        said = json.dumps(values + ([linked] if linked else []))
        return hashlib.sha256(said.encode()).hexdigest()


def options_of(options: Mapping[str, Any] | None, proxies: int | None, weld: float) -> dict[str, Any]:
    given = dict(options or {}) | {"weld": weld} | ({} if proxies is None else {"proxies": proxies})
    if not any(name in given for name in ("proxies", "detail", "tolerance")):
        given["detail"] = DETAIL
    return given


def plan_of(source: Path, output: Path, work: Any, options: dict[str, Any], tile_faces: int) -> Plan:
    if output.suffix.lower() not in exporting.TILES:
        raise TilesError(f"{output}: OUTPUT must end in one of {', '.join(exporting.TILES)}")
    place = Path(os.path.abspath(output))  # noqa: PTH100  (links stay as they are)
    if not place.parent.is_dir():
        raise TilesError(f"{output}: there is no folder {output.parent} to write to")
    if place.is_dir():
        raise TilesError(f"{output}: is a folder; give the name of a file")
    folder = place.with_name(f".{place.name}.tiles") if work is None else Path(os.path.abspath(work))  # noqa: PTH100
    if not source.exists():
        raise TilesError(f"{source}: there is no such folder or scan")
    if folder.exists() and not folder.is_dir():
        raise TilesError(f"{folder}: the work folder is a file")
    _check(options)
    if (tileset := tileset_of(source)) is not None:
        return _plan_of_tileset(tileset, place, folder, options)
    try:
        scans = find_scans([source], output.suffix, besides=folder)
    except BatchError as error:
        raise TilesError(str(error)) from None
    earlier = place.parent.resolve() / place.name  # the result of an earlier run is no tile
    inputs = [(scan.name, scan.path) for scan in scans if scan.path.parent.resolve() / scan.path.name != earlier]
    inside = place.is_symlink() and place.resolve().is_relative_to(source.resolve())
    if inside or any(is_same(place, path) for _, path in inputs):
        raise TilesError(f"{output}: leads to the tile {place.resolve()}, which would be overwritten")
    if not inputs:
        raise TilesError(f"{source}: there is no tile in this folder")
    for _, path in inputs:
        if not path.is_file():  # reading a pipe could block, and a device has no end
            raise TileFailed(f"{path}: is no file" if path.exists() else f"{path}: there is no such file")
    if tile_faces < 1:
        raise TilesError(f"the number of faces of a tile must be at least 1, got {tile_faces}")
    single = source.is_file() and kind_of(source) in KINDS  # any other file is a list of tiles
    return Plan(inputs, single, place, folder, options | ({"tile_faces": tile_faces} if single else {}))


def _plan_of_tileset(tileset: Path, place: Path, folder: Path, options: dict[str, Any]) -> Plan:
    try:
        found = tuple(Leaf(Path(os.path.abspath(leaf.path)), *leaf[1:]) for leaf in leaves(tileset))  # noqa: PTH100
    except FileError as error:
        raise TileFailed(str(error)) from None
    if not found:
        raise TilesError(f"{tileset}: the tileset has no tile with a mesh")
    base, seen = Path(os.path.abspath(tileset.parent)), Counter[str]()  # noqa: PTH100
    inputs = []
    for leaf in found:
        name = Path(os.path.relpath(leaf.path, base)).as_posix().replace("../", "")
        seen[name] += 1
        inputs.append((name if seen[name] == 1 else f"{name}.{seen[name]}", leaf.path))
    return Plan(inputs, False, place, folder, options, found)


def _check(options: dict[str, Any]) -> None:
    known = {*PARTITION, "planar", "weld"}
    if unknown := sorted(options.keys() - known):
        raise TilesError(f"there is no option '{unknown[0]}'; there are {', '.join(sorted(known))}")
    try:
        check_ranges(PartitionOptions(**{name: options[name] for name in PARTITION if name in options}))
    except OptionError as error:
        raise TilesError(error.shown(flag)) from None
    except InvalidInput as error:
        raise TilesError(str(error)) from None
    if len(given := [name for name in ("proxies", "detail", "tolerance") if name in options]) > 1:
        raise TilesError(f"--{given[0]} and --{given[1]} contradict each other; give one of them")
    if not (0 <= options["weld"] < float("inf")):
        raise TilesError(f"the length to weld within must be at least 0, got {options['weld']}")
