"""Texture coordinates and colours of PLY files."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import FileError, Job, read_polygons, triangulate
from . import images, named
from .soup import TexturedSoup, corner_places

_KINDS = {"char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2"}
_KINDS |= {"uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4"}
_KINDS |= {"double": "f8", "float64": "f8"}
_UV_NAMES = (
    ("s", "t"),
    ("u", "v"),
    ("texture_u", "texture_v"),
    ("texture_s", "texture_t"),
    ("texcoord_u", "texcoord_v"),
)
_COLOR_NAMES = (("red", "green", "blue"), ("r", "g", "b"), ("diffuse_red", "diffuse_green", "diffuse_blue"))

Columns = dict[str, NDArray[Any]]  # numbers: (n,); lists: (n,) objects, each an array


@dataclass
class _Element:
    name: str
    count: int
    numbers: dict[str, str] = field(default_factory=dict)  # property: its kind
    lists: dict[str, tuple[str, str]] = field(default_factory=dict)  # property: the kinds of its length and items
    order: list[str] = field(default_factory=list)


def read(path: Path, job: Job | None, threads: int) -> TexturedSoup:
    vertices, loops, loop_start = read_polygons(path, job, threads=threads)
    triangles, polygon = triangulate(vertices, loops, loop_start, job)
    places = corner_places(loops, loop_start, triangles, polygon)
    textures, elements = _read_columns(path)
    vertex, face = elements.get("vertex", {}), elements.get("face", {})
    if len(face) and len(next(iter(face.values()))) != len(loop_start):
        face = {}  # strips: the file has no data for their triangles
    uv, has_uv = _corner_uv(path, vertex, face, loops, loop_start)
    root, loader = named.root_of(path), images.Pictures()
    files = [path.parent / name for name in textures]
    if has_uv:
        files = [named.image(name, path.parent, root, str(path)) for name in textures]
    pictures = [loader.load(file, str(path)) for file in files] if has_uv else []
    material = np.full(len(loop_start), 0 if pictures else -1, dtype=np.int32)
    if pictures and "texnumber" in face:
        material = face["texnumber"].astype(np.int32)
        if len(material) and (material.min() < -1 or material.max() >= len(pictures)):
            worst = int(material.max())
            raise FileError(f"{path}: a face has texnumber {worst}, but it names {len(pictures)} texture files")
    colors: NDArray[np.uint8] | None = None
    if (rgba := _colors(vertex)) is not None:
        colors = rgba[triangles]
    elif (rgba := _colors(face)) is not None:
        colors = np.repeat(rgba[polygon][:, None], 3, axis=1)
    return TexturedSoup(vertices, triangles, uv[places], material[polygon], pictures, colors, textures, files)


def _corner_uv(
    path: Path, vertex: Columns, face: Columns, loops: NDArray[np.int32], loop_start: NDArray[np.int32]
) -> tuple[NDArray[np.float64], bool]:
    """(L, 2) of each corner, and whether the file has any."""
    if "texcoord" in face:
        sizes = np.diff(np.append(loop_start, len(loops)))
        lists = face["texcoord"]
        uv = np.zeros((len(loops), 2))
        given = np.array([len(row) for row in lists])
        whole = given == 2 * sizes
        if not (whole | (given == 0)).all():
            bad = int(np.flatnonzero(~(whole | (given == 0)))[0])
            raise FileError(f"{path}: face {bad} has {given[bad]} numbers in texcoord, not two for each corner")
        if whole.any():
            where = np.repeat(whole, sizes)
            uv[where] = np.concatenate([row for row, good in zip(lists, whole, strict=True) if good]).reshape(-1, 2)
        return uv, True
    for u, v in _UV_NAMES:
        if u in vertex and v in vertex:
            return np.stack([vertex[u], vertex[v]], axis=1).astype(np.float64)[loops], True
    return np.zeros((len(loops), 2)), False


def _colors(columns: Columns) -> NDArray[np.uint8] | None:
    for names in _COLOR_NAMES:
        if all(name in columns for name in names):
            channels = [columns[name] for name in names]
            channels.append(columns.get("alpha", columns.get("a", np.full(len(channels[0]), 255, dtype=np.uint8))))
            return np.stack([_byte(channel) for channel in channels], axis=1)
    return None


def _byte(channel: NDArray[Any]) -> NDArray[np.uint8]:
    if np.issubdtype(channel.dtype, np.floating):  # from 0 to 1
        channel = np.round(np.clip(np.nan_to_num(channel), 0, 1) * 255)
    elif channel.dtype == np.uint16:
        channel = channel // 257
    return np.asarray(np.clip(channel, 0, 255), dtype=np.uint8)


def _read_columns(path: Path) -> tuple[list[str], dict[str, Columns]]:
    """The texture files that comments name, and the properties of each element."""
    data = path.read_bytes()
    end = data.find(b"end_header")
    head = [line.decode("utf-8", errors="surrogateescape") for line in data[: max(end, 0)].splitlines()]
    begin = data.find(b"\n", end) + 1 if end >= 0 else 0
    textures, elements, kind = [], [], "ascii"
    for line in head:
        words = line.split()
        if len(words) > 2 and words[0] == "comment" and words[1].lower() == "texturefile":
            textures.append(line.split(None, 2)[2].strip())
        elif words[:1] == ["format"] and len(words) > 1:
            kind = words[1]
        elif words[:1] == ["element"]:
            elements.append(_Element(words[1], int(words[2])))
        elif words[:1] == ["property"] and elements:
            if words[1] == "list":
                elements[-1].lists[words[4]] = (_KINDS[words[2]], _KINDS[words[3]])
            else:
                elements[-1].numbers[words[2]] = _KINDS[words[1]]
            elements[-1].order.append(words[-1])
    reader = _ascii if kind == "ascii" else _binary
    try:
        return textures, dict(reader(data[begin:], elements, ">" if kind == "binary_big_endian" else "<"))
    except (ValueError, IndexError):
        raise FileError(f"{path}: its texture coordinates or colours can't be read; the file is damaged") from None


def _ascii(data: bytes, elements: list[_Element], _: str) -> Iterator[tuple[str, Columns]]:
    words, at = data.split(), 0
    for element in elements:
        if not element.lists:
            width = len(element.order)
            table = np.array(words[at : at + width * element.count], dtype=np.float64).reshape(element.count, width)
            at += width * element.count
            columns: Columns = {name: table[:, i].astype(element.numbers[name]) for i, name in enumerate(element.order)}
            yield element.name, columns
            continue
        rows: dict[str, list[Any]] = {name: [] for name in element.order}
        for _row in range(element.count):
            for name in element.order:
                size = int(words[at]) if name in element.lists else 1
                at += name in element.lists
                values = np.array(words[at : at + size], dtype=np.float64)
                rows[name].append(values if name in element.lists else values[0])
                at += size
        yield element.name, _columns(element, rows)


def _columns(element: _Element, rows: dict[str, list[Any]]) -> Columns:
    columns: Columns = {}
    for name, values in rows.items():
        if name in element.numbers:
            columns[name] = np.array(values).astype(element.numbers[name])
        else:
            columns[name] = np.empty(len(values), dtype=object)
            columns[name][:] = values
    return columns


def _binary(data: bytes, elements: list[_Element], order: str) -> Iterator[tuple[str, Columns]]:
    at = 0
    for element in elements:
        columns, size = _binary_rows(data, at, element, order)
        at += size
        yield element.name, columns


def _binary_rows(data: bytes, at: int, element: _Element, order: str) -> tuple[Columns, int]:
    """All rows at once if their lists are as long as the lists of the first one; else one by one."""
    sizes = _sizes_at(data, at, element, order) if element.count else dict.fromkeys(element.lists, 0)
    fields: list[Any] = []
    for name in element.order:
        if name in element.lists:
            length, item = element.lists[name]
            fields += [(f"{name} length", order + length), (name, order + item, (sizes[name],))]
        else:
            fields.append((name, order + element.numbers[name]))
    row = np.dtype(fields)
    if at + row.itemsize * element.count <= len(data):
        table = np.frombuffer(data, row, element.count, at)
        if all((table[f"{name} length"] == size).all() for name, size in sizes.items()):
            columns: Columns = {}
            for name in element.order:
                if name in element.lists:
                    columns[name] = np.empty(element.count, dtype=object)
                    columns[name][:] = list(table[name])
                else:
                    columns[name] = table[name].astype(element.numbers[name])
            return columns, row.itemsize * element.count
    begin = at
    rows: dict[str, list[Any]] = {name: [] for name in element.order}
    for _ in range(element.count):
        for name in element.order:
            kind, size = element.numbers.get(name, ""), 1
            if name in element.lists:
                length, kind = element.lists[name]
                size = int(np.frombuffer(data, order + length, 1, at)[0])
                at += np.dtype(length).itemsize
            values = np.frombuffer(data, order + kind, size, at)
            rows[name].append(values if name in element.lists else values[0])
            at += values.nbytes
    return _columns(element, rows), at - begin


def _sizes_at(data: bytes, at: int, element: _Element, order: str) -> dict[str, int]:
    """The lengths of the lists of the row that begins here."""
    sizes = {}
    for name in element.order:
        if name in element.lists:
            length, item = element.lists[name]
            sizes[name] = int(np.frombuffer(data, order + length, 1, at)[0])
            at += np.dtype(length).itemsize + sizes[name] * np.dtype(item).itemsize
        else:
            at += np.dtype(element.numbers[name]).itemsize
    return sizes
