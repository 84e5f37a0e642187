"""Cutting of a single scan into tiles. Binary PLY files are mapped; other files are read into memory."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..file_faces import cut
from ..reading import plain, read_polygons
from .store import save, tile_name

_CHUNK = 1 << 20  # faces that are processed together
_SAMPLE = 1 << 18  # faces from which the tree of boxes is made
_TYPES = {"float": "f4", "float32": "f4", "double": "f8", "float64": "f8", "int": "i4", "int32": "i4", "uint": "u4"}
_TYPES |= {"uint32": "u4", "uchar": "u1", "uint8": "u1", "char": "i1", "int8": "i1", "short": "i2", "int16": "i2"}
_TYPES |= {"ushort": "u2", "uint16": "u2"}

Chunk = tuple[NDArray[Any], NDArray[np.int32]]  # triangles, and the face of the file that each is part of


class Source:
    """The vertices of a scan, and its triangles in chunks."""

    def __init__(self, vertices: Any, triangles: Any, polygon: NDArray[np.int32] | None, faces: int) -> None:
        self._vertices, self._triangles, self._polygon, self.faces = vertices, triangles, polygon, faces

    @property
    def triangle_count(self) -> int:
        return len(self._triangles)

    def places(self, index: NDArray[Any]) -> NDArray[np.float64]:
        """Return the places (N, 3) of these vertices."""
        rows = self._vertices[index]
        if rows.dtype.names:
            return np.stack([rows[axis].astype(np.float64) for axis in "xyz"], -1)
        return np.asarray(rows, np.float64)

    def triangles(self, which: Any) -> NDArray[Any]:
        rows = self._triangles[which]
        return np.asarray(rows["v"] if rows.dtype.names else rows)

    def chunks(self) -> Iterator[Chunk]:
        for begin in range(0, self.triangle_count, _CHUNK):
            end = min(begin + _CHUNK, self.triangle_count)
            own = np.arange(begin, end, dtype=np.int32) if self._polygon is None else self._polygon[begin:end]
            yield self.triangles(slice(begin, end)), own


def open_scan(path: Path) -> Source:
    """Open a scan for cutting into tiles. Raises FileError."""
    mapped = _mapped_ply(path)
    if mapped is not None:
        return mapped
    vertices, loops, loop_start = read_polygons(path)
    triangles, polygon = cut(vertices, loops, loop_start)
    return Source(vertices, triangles, polygon, len(loop_start))


def _mapped_ply(path: Path) -> Source | None:
    """Map a binary PLY file whose faces are all triangles in rows of one size; None for any other file."""
    if path.suffix.lower() != ".ply" or not path.is_file():
        return None
    with path.open("rb") as file:
        head = file.read(1 << 16)
    end = re.search(rb"end_header\r?\n", head)
    if end is None or not re.search(rb"format\s+binary_little_endian", head[: end.start()]):
        return None
    elements = re.findall(rb"element\s+(\w+)\s+(\d+)((?:\s+(?:property\s+[^\n]+|comment[^\n]*))*)", head[: end.start()])
    if [name for name, _, _ in elements] != [b"vertex", b"face"]:
        return None
    vertex = [p.split() for p in re.findall(r"property\s+([^\n]+)", elements[0][2].decode())]
    face = re.findall(r"property\s+([^\n]+)", elements[1][2].decode())
    if any(len(p) != 2 or p[0] not in _TYPES for p in vertex) or not {"x", "y", "z"} <= {p[1] for p in vertex}:
        return None
    listed = re.fullmatch(r"list\s+u?(?:char|int8)\s+(\w+)\s+vertex_ind\w+\s*", face[0]) if len(face) == 1 else None
    if listed is None or _TYPES.get(listed[1]) not in ("i4", "u4"):
        return None
    row = np.dtype([(name, "<" + _TYPES[kind]) for kind, name in vertex])
    of_face = np.dtype([("n", "u1"), ("v", "<i4", 3)])
    count, faces = int(elements[0][1]), int(elements[1][1])
    if path.stat().st_size != end.end() + count * row.itemsize + faces * of_face.itemsize or not count or not faces:
        return None
    vertices = np.memmap(path, row, "r", end.end(), (count,))
    triangles = np.memmap(path, of_face, "r", end.end() + count * row.itemsize, (faces,))
    for begin in range(0, faces, _CHUNK):
        rows = triangles[begin : begin + _CHUNK]
        if (rows["n"] != 3).any() or rows["v"].min() < 0 or rows["v"].max() >= count:
            return None  # the engine's reader raises the error, or cuts the polygons
    return Source(vertices, triangles, None, faces)


class Boxes:
    """A tree of boxes with about equal numbers of faces, made from the middles of some of the faces."""

    def __init__(self, middles: NDArray[np.float64], leaves: int) -> None:
        self.leaves = 0
        self._root = self._split(middles, leaves)

    def _split(self, middles: NDArray[np.float64], leaves: int) -> Any:
        if leaves == 1 or len(middles) < 2:
            self.leaves += 1
            return self.leaves - 1
        axis = int(np.argmax(np.ptp(middles, axis=0)))
        lower = leaves // 2
        at = min(len(middles) * lower // leaves, len(middles) - 1)
        border = float(np.partition(middles[:, axis], at)[at])
        below = middles[:, axis] < border
        if not below.any():
            self.leaves += 1
            return self.leaves - 1
        return axis, border, self._split(middles[below], lower), self._split(middles[~below], leaves - lower)

    def find(self, middles: NDArray[np.float64]) -> NDArray[np.int32]:
        """Return the box (N,) of each place."""
        result = np.zeros(len(middles), np.int32)
        waiting = [(self._root, np.arange(len(middles)))]
        while waiting:
            node, rows = waiting.pop()
            if isinstance(node, int):
                result[rows] = node
                continue
            axis, border, lower, upper = node
            below = middles[rows, axis] < border
            waiting += [(lower, rows[below]), (upper, rows[~below])]
        return result


def middles_of(source: Source, triangles: NDArray[Any]) -> NDArray[np.float64]:
    with np.errstate(invalid="ignore", over="ignore"):
        middles = sum(source.places(triangles[:, k]) for k in range(3)) / 3
    return np.where(np.isfinite(middles), middles, 0.0)


def split_scan(path: Path, folder: Path, tile_faces: int) -> dict[str, int]:
    """Cut a scan into tiles of about `tile_faces` faces, each a folder of arrays: vertices, triangles, polygon."""
    folder.mkdir(parents=True, exist_ok=True)
    with plain(path, folder) as place:
        return _split(open_scan(place), folder, tile_faces)


def _split(source: Source, folder: Path, tile_faces: int) -> dict[str, int]:
    count = source.triangle_count
    leaves = max(1, -(-count // tile_faces))
    sample = np.arange(0, count, max(1, count // _SAMPLE))
    boxes = Boxes(middles_of(source, source.triangles(sample)), leaves) if count else None
    rows = np.dtype([("v", "<i4", 3), ("polygon", "<i4")])
    parts = [folder / f"{tile_name(tile)}.part" for tile in range(boxes.leaves if boxes else 0)]
    for part in parts:
        part.write_bytes(b"")
    for triangles, polygon in source.chunks():
        assert boxes is not None
        box = boxes.find(middles_of(source, triangles))
        order = np.argsort(box, kind="stable")
        ends = np.searchsorted(box[order], np.arange(len(parts) + 1))
        for k in np.flatnonzero(np.diff(ends)):
            chosen = order[ends[k] : ends[k + 1]]
            row = np.empty(len(chosen), rows)
            row["v"], row["polygon"] = triangles[chosen], polygon[chosen]
            with parts[k].open("ab") as file:  # one at a time: there may be more tiles than a process may open files
                file.write(row.tobytes())
    for tile, part in enumerate(parts):
        row = np.fromfile(part, rows)
        used, local = np.unique(row["v"], return_inverse=True)
        save(
            folder / tile_name(tile),
            vertices=source.places(used),
            triangles=local.reshape(-1, 3).astype(np.int32),
            polygon=row["polygon"],
        )
        part.unlink()
    return {"tiles": len(parts), "faces": source.faces}
