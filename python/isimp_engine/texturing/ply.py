"""Texture coordinates and colours of PLY files."""

import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import Job, _read_columns, triangulate
from . import images, named
from .look import COLOR, Fault, Look, Material
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
    look, textures, files = _read(path, job, threads, named.refuse)
    triangles, polygon = triangulate(look.vertices, look.loops, look.loop_start, job=job)
    loader = images.Pictures()
    pictures = [loader.load(file, str(path)) for file in files] if look.uv is not None else []
    colors: NDArray[np.uint8] | None = None
    if look.colors is not None and look.colors_of_faces:
        colors = np.repeat(look.colors[polygon][:, None], 3, axis=1)
    elif look.colors is not None:
        colors = look.colors[triangles]
    corner_uv = np.zeros((len(triangles), 3, 2))
    if look.uv is not None:
        corner_uv = look.uv[corner_places(look.loops, look.loop_start, triangles, polygon)]
    return TexturedSoup(look.vertices, triangles, corner_uv, look.material[polygon], pictures, colors, textures, files)


def read_look(path: Path, stands: Path, job: Job | None, fault: Fault) -> Look:
    """As `reading.read_look`. stands: the path of the scan, if `path` is an unpacked copy of it."""
    found, _, files = _read(path, job, 0, fault, stands)
    if found.uv is not None:
        found.materials.extend(Material(file.stem, maps={COLOR: (file, str(stands))}) for file in files)
    return found


def linked(path: Path, lines: list[bytes]) -> list[Path]:
    """The images that some lines of a scan name."""
    words = [line.split(None, 2) for line in lines]
    names = [
        os.fsdecode(word[2].strip()) for word in words if len(word) == 3 and word[:2] == [b"comment", b"TextureFile"]
    ]
    return [named.image(name, path.parent, named.root_of(path), str(path)) for name in names]


def _read(
    path: Path, job: Job | None, threads: int, fault: Fault, stands: Path | None = None
) -> tuple[Look, list[str], list[Path]]:
    """Return the look without its materials, the names of the images, and their files."""
    vertices, loops, loop_start, vertex, face, uv, textures, _, skipped = _read_columns(path, _NAMES, job, threads)
    path = stands or path
    pairs = [pair for pair in _UV_NAMES if all(name in vertex for name in pair)]
    if uv is None and pairs:
        uv = np.stack([vertex[name] for name in pairs.pop(0)], axis=1).astype(np.float64)[loops]
    skipped += [name for pair in pairs for name in pair]
    root = named.root_of(path)
    files = [path.parent / name for name in textures]
    if uv is not None:
        with named.faults(fault):
            files = [named.image(name, path.parent, root, str(path)) for name in textures]
    pictures = len(files) if uv is not None else 0
    material = np.full(len(loop_start), 0 if pictures else -1, dtype=np.int32)
    if pictures and "texnumber" in face:
        material = face["texnumber"].astype(np.int32)
        wrong = (material < -1) | (material >= pictures)
        if wrong.any():
            fault(f"{path}: a face has texnumber {int(material[wrong].max())}, but it names {pictures} texture files")
            material = np.where(wrong, -1, material).astype(np.int32)
    colors = _colors(vertex)
    of_faces = colors is None and (colors := _colors(face)) is not None
    look = Look(vertices, loops, loop_start, uv, material, colors, colors_of_faces=of_faces, skipped=skipped)
    return look, textures, files


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
