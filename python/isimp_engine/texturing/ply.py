"""Texture coordinates and colours of PLY files."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import FileError, Job, _read_columns, triangulate
from . import images, named
from .soup import TexturedSoup, corner_places

_UV_NAMES = (
    ("s", "t"),
    ("u", "v"),
    ("texture_u", "texture_v"),
    ("texture_s", "texture_t"),
    ("texcoord_u", "texcoord_v"),
)
_COLOR_NAMES = (("red", "green", "blue"), ("r", "g", "b"), ("diffuse_red", "diffuse_green", "diffuse_blue"))
_NAMES = [*(name for names in (*_UV_NAMES, *_COLOR_NAMES) for name in names), "alpha", "a", "texnumber"]

Columns = dict[str, NDArray[Any]]


def read(path: Path, job: Job | None, threads: int) -> TexturedSoup:
    vertices, loops, loop_start, vertex, face, uv, textures, _ = _read_columns(path, _NAMES, job, threads)
    triangles, polygon = triangulate(vertices, loops, loop_start, job)
    places = corner_places(loops, loop_start, triangles, polygon)
    for u, v in _UV_NAMES:
        if uv is None and u in vertex and v in vertex:
            uv = np.stack([vertex[u], vertex[v]], axis=1).astype(np.float64)[loops]
    root, loader = named.root_of(path), images.Pictures()
    files = [path.parent / name for name in textures]
    if uv is not None:
        files = [named.image(name, path.parent, root, str(path)) for name in textures]
    pictures = [loader.load(file, str(path)) for file in files] if uv is not None else []
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
    corner_uv = np.zeros((len(triangles), 3, 2)) if uv is None else uv[places]
    return TexturedSoup(vertices, triangles, corner_uv, material[polygon], pictures, colors, textures, files)


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
