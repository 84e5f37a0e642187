"""UDIM tiles: images of one material that lie side by side, ten in a row, from number 1001 on."""

import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._core import InvalidInput

if TYPE_CHECKING:
    from .layers import TextureLayer

FIRST, ROW = 1001, 10
Tiles = Mapping[int, Any]  # the image of each tile by its number
_MARK = re.compile(re.escape("<udim>"), re.IGNORECASE)


def is_pattern(path: Path) -> bool:
    """Whether a file's name stands for those of all tiles: `wall.<UDIM>.png`."""
    return _MARK.search(path.name) is not None


def files(path: Path) -> dict[int, Path]:
    """The files of a pattern that there are, by the number of their tile; of another path itself, as 1001."""
    if not is_pattern(path):
        return {FIRST: path}
    before, after = _MARK.split(path.name, maxsplit=1)
    form = re.compile(re.escape(before) + r"(\d{4})" + re.escape(after))
    found = {}
    for file in sorted(path.parent.iterdir()) if path.parent.is_dir() else ():
        match = form.fullmatch(file.name)
        if match and FIRST <= int(match[1]) < 2000:
            found[int(match[1])] = file
    return found


def exists(path: Path) -> bool:
    """Whether there is such a file, or one that a pattern stands for."""
    return any(file.is_file() for file in files(path).values())


def each(image: Any, change: Callable[[Any], Any]) -> Any:
    """An image, or each of its tiles, changed."""
    return {tile: change(one) for tile, one in image.items()} if isinstance(image, Mapping) else change(image)


def tile_of(uv: NDArray[np.float64]) -> NDArray[np.int64]:
    """(F,) the tile in which the middle of each triangle lies, from 1001 on."""
    at = np.floor(uv.mean(axis=1)).astype(np.int64)
    return np.asarray(FIRST + at[:, 0] + ROW * at[:, 1], dtype=np.int64)


def split(
    uv: NDArray[np.float64], material: NDArray[np.int32], images: list[Any], layers: Mapping[str, "TextureLayer"]
) -> tuple[NDArray[np.float64], NDArray[np.int32], list[Any], dict[str, "TextureLayer"], list[int]]:
    """Makes each tile of a material a material of its own, whose UVs are from 0 to 1.

    Returns uv, material, images and layers, and the material that each one was before.
    Raises InvalidInput where a face lies in a tile that its image does not have.
    """
    has_tiles = [any(isinstance(one, Mapping) for one in _shown(m, images, layers)) for m in range(len(images))]
    if not any(has_tiles):
        return uv, material, images, dict(layers), list(range(len(images)))
    for name, layer in layers.items():
        if layer.uv is not None and any(isinstance(image, Mapping) for image in layer.images):
            raise InvalidInput(f"layers[{name!r}] has tiles and UVs of its own; it must have those of the colours")
    uv, material = uv.copy(), material.copy()
    number, before = material.copy(), list[int]()
    tiles = list[int]()
    for m in range(len(images)):
        faces = np.flatnonzero(material == m)
        if not has_tiles[m]:
            number[faces] = len(before)
            before.append(m)
            tiles.append(0)
            continue
        of = tile_of(uv[faces])
        for tile in np.unique(of).tolist():
            here = faces[of == tile]
            if isinstance(images[m], Mapping) and tile not in images[m]:
                there = ", ".join(map(str, sorted(images[m])))
                raise InvalidInput(f"face {here[0]} lies in the UDIM tile {tile}, but its image has only {there}")
            uv[here] -= ((tile - FIRST) % ROW, (tile - FIRST) // ROW)
            number[here] = len(before)
            before.append(m)
            tiles.append(tile)
        if not len(of):  # a material without faces
            before.append(m)
            tiles.append(FIRST)

    def pick(all_images: Any) -> list[Any]:
        chosen = []
        for m, tile in zip(before, tiles, strict=True):
            image = all_images[m]
            chosen.append(image.get(tile) if isinstance(image, Mapping) else image)
        return chosen

    made = {name: replace(layer, images=pick(layer.images)) for name, layer in layers.items()}
    return uv, number, pick(images), made, before


def _shown(m: int, images: list[Any], layers: Mapping[str, "TextureLayer"]) -> list[Any]:
    return [images[m], *(layer.images[m] for layer in layers.values() if m < len(layer.images))]
